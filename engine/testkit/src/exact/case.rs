//! A ray and a surface as plain numbers.

/// A profile of revolution: z = c r² / (1 + √(1 − (1 + k) c² r²)) + Σ aₚ rᵖ.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Profile {
    /// Curvature c in 1/mm; 0 is flat, positive has its centre on the +z side.
    pub curvature: f64,
    /// Conic constant k = −e².
    pub conic: f64,
    /// Power p, 2 to 20, and coefficient aₚ in mm^(1 − p).
    pub terms: Vec<(u32, f64)>,
}

/// The shape of a surface, its vertex at the origin.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// c (x² + y² + (1 + k) z²) − 2 z = 0.
    Conic {
        /// Curvature c in 1/mm; 0 is a plane, positive has its centre on the +z side.
        curvature: f64,
        /// Conic constant k = −e².
        conic: f64,
    },
    /// A profile turned about the z-axis.
    Asphere(Profile),
    /// A profile z = g(|y|) turned about the line x = 0, z = 1 / c with c the curvature in the x-z plane:
    /// z − g − c (x² + z² − g²) / 2 = 0. A cylinder if c is 0 or the profile is flat.
    Toroid {
        /// The profile g, z by |y|.
        profile: Profile,
        /// Curvature c in the x-z plane, 1/mm.
        curvature_x: f64,
    },
}

impl Shape {
    /// The profile: of a conic, one without terms.
    pub fn profile(&self) -> Profile {
        match self {
            Self::Conic { curvature, conic } => Profile { curvature: *curvature, conic: *conic, terms: Vec::new() },
            Self::Asphere(profile) | Self::Toroid { profile, .. } => profile.clone(),
        }
    }
}

/// A ray that hits a surface, exact as given. Lengths in mm, in the frame of the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The surface that the ray hits.
    pub shape: Shape,
    /// A point on the ray.
    pub origin: [f64; 3],
    /// Direction of the ray; of any length but 0. The exact direction is this one divided by its exact length.
    pub direction: [f64; 3],
    /// sign(N · D) of the crossing that is meant, N towards +z at the vertex: +1 or −1.
    pub side: f64,
    /// Refractive index of the medium that the ray comes from.
    pub n1: f64,
    /// Refractive index of the medium behind the surface; of no account for a mirror.
    pub n2: f64,
    /// True if the surface reflects.
    pub mirror: bool,
    /// Half of the clear diameter. A ray at exactly this distance from the axis passes.
    pub semi_diameter: Option<f64>,
    /// Half of the diameter of a central obstruction, or 0. A ray at exactly this distance passes.
    pub obstruction: f64,
}

impl Case {
    /// This case with every number rounded to `f32`: the exact input of a tracer in single precision.
    pub fn as_f32(&self) -> Self {
        let mut case = self.clone();
        case.for_each_number(|x| *x = f64::from(*x as f32));
        case
    }

    /// True if no number of the case is infinite or NaN.
    pub fn is_finite(&self) -> bool {
        let mut is_finite = true;
        self.clone().for_each_number(|x| is_finite &= x.is_finite());
        is_finite
    }

    /// Every number in a fixed order: origin, direction, curvature, conic constant, terms, curvature across, n1, n2,
    /// then semi-diameter, obstruction and side, which do not move the ray.
    pub(crate) fn for_each_number(&mut self, mut f: impl FnMut(&mut f64)) {
        self.origin.iter_mut().for_each(&mut f);
        self.direction.iter_mut().for_each(&mut f);
        match &mut self.shape {
            Shape::Conic { curvature, conic } => {
                f(curvature);
                f(conic);
            }
            Shape::Asphere(profile) | Shape::Toroid { profile, .. } => {
                f(&mut profile.curvature);
                f(&mut profile.conic);
                profile.terms.iter_mut().for_each(|(_, coefficient)| f(coefficient));
            }
        }
        if let Shape::Toroid { curvature_x, .. } = &mut self.shape {
            f(curvature_x);
        }
        f(&mut self.n1);
        f(&mut self.n2);
        self.semi_diameter.iter_mut().for_each(&mut f);
        f(&mut self.obstruction);
        f(&mut self.side);
    }
}
