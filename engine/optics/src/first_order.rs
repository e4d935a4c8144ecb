//! Gaussian optics: the effect of a row of surfaces on rays close to the axis.
//!
//! A ray is (y, ν) with height y in mm and ν = n u, the reduced slope; light that has hit an odd number of mirrors
//! travels in a medium of negative index, so that u stays dy/dz (Welford, *Aberrations of Optical Systems*, §3).

use std::ops::Mul;

/// The 2 × 2 matrix that takes (y, ν) on one plane to (y′, ν′) on another. Its determinant is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matrix {
    /// Derivative of y′ by y.
    pub a: f64,
    /// Derivative of y′ by ν, in mm.
    pub b: f64,
    /// Derivative of ν′ by y, in 1/mm: minus the power.
    pub c: f64,
    /// Derivative of ν′ by ν.
    pub d: f64,
}

impl Matrix {
    /// The identity: the ray stays (y, ν).
    pub const IDENTITY: Self = Self { a: 1.0, b: 0.0, c: 0.0, d: 1.0 };

    /// A surface of `curvature` (1/mm) from signed index `from` to signed index `to`.
    pub fn surface(curvature: f64, from: f64, to: f64) -> Self {
        Self { c: -curvature * (to - from), ..Self::IDENTITY }
    }

    /// Travel by `thickness_mm` (signed) in a medium of signed `index`.
    pub fn travel(thickness_mm: f64, index: f64) -> Self {
        Self { b: thickness_mm / index, ..Self::IDENTITY }
    }

    /// The matrix of the way back: light comes from the other side, and the order of the surfaces is reversed.
    pub fn reversed(&self) -> Self {
        Self { a: self.d, d: self.a, ..*self }
    }

    /// The ray (y′, ν′).
    pub fn apply(&self, y: f64, nu: f64) -> [f64; 2] {
        [self.a * y + self.b * nu, self.c * y + self.d * nu]
    }
}

impl Mul for Matrix {
    type Output = Self;

    /// The effect of `first` and then `self`.
    fn mul(self, first: Self) -> Self {
        Self {
            a: self.a * first.a + self.b * first.c,
            b: self.a * first.b + self.b * first.d,
            c: self.c * first.a + self.d * first.c,
            d: self.c * first.b + self.d * first.d,
        }
    }
}

/// One surface as Gaussian optics sees it.
#[derive(Clone, Copy, Debug)]
pub struct ParaxialSurface {
    /// Curvature of the surface, 1/mm.
    pub curvature: f64,
    /// Signed index before the surface.
    pub from: f64,
    /// Signed index after the surface.
    pub to: f64,
    /// The way to the next vertex; behind the last surface as far as the film is published.
    pub onward: Matrix,
    /// The part of the Petzval sum by that way, 1/mm: 0, but in a gradient.
    pub petzval_onward: f64,
}

/// The matrix from the first vertex to the last: every surface, and the travel between them.
pub fn between_vertices(surfaces: &[ParaxialSurface]) -> Matrix {
    let mut matrix = Matrix::IDENTITY;
    for (i, s) in surfaces.iter().enumerate() {
        if i > 0 {
            matrix = surfaces[i - 1].onward * matrix;
        }
        matrix = Matrix::surface(s.curvature, s.from, s.to) * matrix;
    }
    matrix
}

/// The matrix from the first vertex to the vertex plane of `stop`, before that surface acts.
pub fn front_of(surfaces: &[ParaxialSurface], stop: usize) -> Matrix {
    match stop.checked_sub(1) {
        None => Matrix::IDENTITY,
        Some(last) => surfaces[last].onward * between_vertices(&surfaces[..stop]),
    }
}

/// The matrix from the vertex plane of `stop`, after that surface has acted, to the last vertex.
pub fn rear_of(surfaces: &[ParaxialSurface], stop: usize) -> Matrix {
    if stop + 1 == surfaces.len() {
        return Matrix::IDENTITY;
    }
    between_vertices(&surfaces[stop + 1..]) * surfaces[stop].onward
}
