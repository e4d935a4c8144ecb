//! Third-order aberrations and first-order colour, surface by surface (Welford 1986, §8 and §10).

use std::iter::Sum;

use crate::first_order::ParaxialSurface;
use crate::glass::line_nm;
use crate::paraxial::Paraxial;
use crate::system::System;

/// Sums are taken at the design's half field, but no farther out than this: beyond, a third-order sum means little.
const WIDEST_FIELD_DEG: f64 = 30.0;
/// The field where a lens file does not say its own.
const USUAL_FIELD_DEG: f64 = 20.0;

/// The aberrations of one surface, or of the whole lens. In mm.
///
/// With the marginal ray's slope n′u′ behind the lens, a ray through the pupil at (ρ, φ) of its radius, φ from the
/// meridian, misses the Gaussian image by (1 / n′u′) ∂W/∂(ρ cos φ) along the meridian,
/// W = S_I ρ⁴/8 + S_II ρ³ cos φ/2 + S_III ρ² cos² φ/2 + (S_III + S_IV) ρ²/4 + S_V ρ cos φ/2. Undercorrected spherical
/// aberration has S_I > 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// S_I to S_V: spherical aberration, coma, astigmatism, field curvature, distortion.
    pub seidel: [f64; 5],
    /// C_L and C_T: axial and lateral colour. Light of F focuses C_L / (n′u′²) nearer to the lens than light of C, and
    /// images the edge of the field C_T / n′u′ higher.
    pub chromatic: [f64; 2],
}

impl Sum for Sums {
    fn sum<I: Iterator<Item = Self>>(sums: I) -> Self {
        sums.fold(Self::default(), |mut total, one| {
            let [seidel, chromatic] = [&mut total.seidel[..], &mut total.chromatic[..]];
            seidel.iter_mut().zip(one.seidel).for_each(|(sum, part)| *sum += part);
            chromatic.iter_mut().zip(one.chromatic).for_each(|(sum, part)| *sum += part);
            total
        })
    }
}

/// The Seidel and chromatic sums of a lens at one wavelength, for the marginal ray of the present opening and the chief
/// ray of one field.
///
/// Surfaces count by their curvature at the vertex and the fourth power of their sag; of an anamorphic lens the y-z
/// section. Decentres and tilts, and odd powers of aspheres, have no place in a third order and are left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Seidel {
    /// Angle of the chief ray before the lens, in degrees.
    pub field_deg: f64,
    /// The sums of each surface.
    pub by_surface: Vec<Sums>,
}

impl Seidel {
    /// The sums at a vacuum wavelength in nm, for an object plane at `object_z_mm` (`None`: at infinity), at the half
    /// field of the design where the lens file tells it, but no farther out than 30 degrees; else at 20.
    ///
    /// `None` if the entrance pupil is at infinity, the object in it, an index is not finite, or a medium has a
    /// gradient: the way between two surfaces then has its own share, which is not worked out here.
    pub fn new(system: &System, wavelength_nm: f64, object_z_mm: Option<f64>) -> Option<Self> {
        let half_field = system.half_field_deg().filter(|d| *d > 0.0).unwrap_or(USUAL_FIELD_DEG);
        Self::at_field(system, wavelength_nm, object_z_mm, half_field.min(WIDEST_FIELD_DEG))
    }

    /// [`Self::new`] for the chief ray from `field_deg` degrees beside the axis.
    pub fn at_field(system: &System, wavelength_nm: f64, object_z_mm: Option<f64>, field_deg: f64) -> Option<Self> {
        if system.has_gradients() {
            return None;
        }
        let rays = MarginalAndChief::at_first_vertex(system, wavelength_nm, object_z_mm, field_deg.to_radians())?;
        let by_surface = by_surface(system, wavelength_nm, rays);
        let total: Sums = by_surface.iter().copied().sum();
        let is_finite = total.seidel.iter().chain(&total.chromatic).all(|x| x.is_finite());
        is_finite.then_some(Self { field_deg, by_surface })
    }

    /// The sums of the whole lens.
    pub fn total(&self) -> Sums {
        self.by_surface.iter().copied().sum()
    }
}

/// Height in mm and reduced slope n u of the marginal and the chief ray.
#[derive(Clone, Copy)]
struct MarginalAndChief {
    marginal: [f64; 2],
    chief: [f64; 2],
}

impl MarginalAndChief {
    /// The rays from the axial point of the object past the rim, and from the object's edge through the centre, of the
    /// entrance pupil.
    fn at_first_vertex(system: &System, wavelength_nm: f64, object_z_mm: Option<f64>, field_rad: f64) -> Option<Self> {
        let pupil = Paraxial::new(system, wavelength_nm).entrance_pupil;
        let (pupil_z, radius) = (pupil.z_mm?, pupil.diameter_mm? / 2.0);
        let index = system.thin(wavelength_nm).first().map_or(1.0, |s| s.from);
        let marginal = match object_z_mm {
            None => [radius, 0.0],
            Some(object_z) => {
                let slope = radius / (pupil_z - object_z);
                [-object_z * slope, index * slope]
            }
        };
        let slope = field_rad.tan();
        Some(Self { marginal, chief: [-pupil_z * slope, index * slope] })
    }

    fn map(self, change: impl Fn([f64; 2]) -> [f64; 2]) -> Self {
        Self { marginal: change(self.marginal), chief: change(self.chief) }
    }
}

fn by_surface(system: &System, wavelength_nm: f64, mut rays: MarginalAndChief) -> Vec<Sums> {
    let surfaces = system.thin(wavelength_nm);
    let (blue, red) = (system.thin(line_nm::F), system.thin(line_nm::C));
    let lagrange = rays.chief[0] * rays.marginal[1] - rays.chief[1] * rays.marginal[0];
    let mut sums = Vec::with_capacity(surfaces.len());
    for (i, s) in surfaces.iter().enumerate() {
        let refracted = rays.map(|[y, nu]| [y, nu - y * s.curvature * (s.to - s.from)]);
        let asphericity = system.surfaces()[i].shape.asphericity();
        let spread = (blue[i].to - red[i].to) / s.to - (blue[i].from - red[i].from) / s.from;
        sums.push(Sums {
            seidel: seidel_terms(s, asphericity, rays, refracted.marginal, lagrange),
            chromatic: invariants(s, rays).map(|a| a * rays.marginal[0] * spread),
        });
        rays = refracted.map(|[y, nu]| s.onward.apply(y, nu));
    }
    sums
}

/// Snell's invariants n i of the marginal and the chief ray.
fn invariants(s: &ParaxialSurface, rays: MarginalAndChief) -> [f64; 2] {
    [rays.marginal, rays.chief].map(|[y, nu]| nu + s.from * s.curvature * y)
}

/// S_I to S_V of one surface. `rays` are those before it, `after` is the marginal ray behind it, `asphericity` as
/// [`crate::surface::Shape::asphericity`] has it.
fn seidel_terms(
    s: &ParaxialSurface,
    asphericity: f64,
    rays: MarginalAndChief,
    after: [f64; 2],
    lagrange: f64,
) -> [f64; 5] {
    let (n, n2, c) = (s.from, s.to, s.curvature);
    let ([y, nu], [yc, _]) = (rays.marginal, rays.chief);
    let [a, ac] = invariants(s, rays);
    let delta = after[1] / (n2 * n2) - nu / (n * n);
    let inverse = 1.0 / n2 - 1.0 / n;
    let inverse_square = 1.0 / (n2 * n2) - 1.0 / (n * n);
    let asphere = asphericity * (n2 - n);
    [
        -a * a * y * delta + asphere * y.powi(4),
        -a * ac * y * delta + asphere * y.powi(3) * yc,
        -ac * ac * y * delta + asphere * y * y * yc * yc,
        -lagrange * lagrange * c * inverse,
        // The form without a division by A, which is 0 where the marginal ray hits the surface at right angles.
        -ac * (ac * ac * inverse_square * y - (ac * y - lagrange) * yc * c * inverse) + asphere * y * yc.powi(3),
    ]
}
