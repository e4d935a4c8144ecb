//! Distortions of the plane, with their derivatives.

use super::radial::Radial;
use super::st_map::StMap;
use glam::{DMat2, DVec2};
use std::sync::Arc;

/// A smooth map of a plane to itself that leaves the origin where it is, unless it is an ST map.
#[derive(Clone, Debug)]
pub(super) enum Distortion {
    /// A distortion by the distance from the origin alone.
    Radial(Radial),
    /// Brown's model and its extensions.
    Brown(Brown),
    /// 3DEqualizer's "Radial - Standard, Degree 4".
    TdeRadial(TdeRadial),
    /// 3DEqualizer's "Anamorphic - Standard, Degree 4".
    TdeAnamorphic(TdeAnamorphic),
    /// A table.
    StMap(Arc<StMap>),
}

impl Distortion {
    /// The distorted point and the derivative, its columns by x and y. Where there is no value, the derivative's determinant is not positive.
    pub(super) fn at(&self, q: DVec2) -> (DVec2, DMat2) {
        match self {
            Self::Radial(radial) => radial.of_point(q),
            Self::Brown(brown) => brown.at(q),
            Self::TdeRadial(tde) => tde.at(q),
            Self::TdeAnamorphic(tde) => tde.at(q),
            Self::StMap(map) => map.at(q),
        }
    }

    /// True if every point stays on its ray from the origin.
    pub(super) fn radial(&self) -> Option<&Radial> {
        match self {
            Self::Radial(radial) => Some(radial),
            _ => None,
        }
    }
}

/// Radial, decentring ("tangential") and thin-prism distortion, one added to the other (Brown 1966; Weng, Cohen and Herniou 1992), in the
/// form of OpenCV's `projectPoints`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Brown {
    /// The radial map that is applied first.
    pub(super) first: Radial,
    /// The radial map that the other terms are added to.
    pub(super) radial: Radial,
    /// `x += 2 p1 x y + p2 (r^2 + 2 x^2)`, `y += p1 (r^2 + 2 y^2) + 2 p2 x y`.
    pub(super) tangential: [f64; 2],
    /// `x += s1 r^2 + s2 r^4`, `y += s3 r^2 + s4 r^4`.
    pub(super) prism: [f64; 4],
}

impl Brown {
    /// The simplest distortion that this is.
    pub(super) fn simplest(self) -> Distortion {
        let plain = self.tangential == [0.0; 2] && self.prism == [0.0; 4];
        match self.first {
            Radial::Identity if plain => Distortion::Radial(self.radial),
            _ if plain && self.radial == Radial::Identity => Distortion::Radial(self.first),
            _ => Distortion::Brown(self),
        }
    }

    fn at(&self, q: DVec2) -> (DVec2, DMat2) {
        if self.first == Radial::Identity {
            return self.second(q);
        }
        let (inner, by_q) = self.first.of_point(q);
        let (outer, by_inner) = self.second(inner);
        // Two folds would look like none.
        let slope = if by_q.determinant() > 0.0 { by_inner * by_q } else { DMat2::ZERO };
        (outer, slope)
    }

    fn second(&self, q: DVec2) -> (DVec2, DMat2) {
        let (mut value, mut slope) = self.radial.of_point(q);
        let ([p1, p2], [s1, s2, s3, s4]) = (self.tangential, self.prism);
        let DVec2 { x, y } = q;
        let r2 = q.length_squared();
        value += DVec2::new(
            2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x) + (s1 + s2 * r2) * r2,
            p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y + (s3 + s4 * r2) * r2,
        );
        let across = 2.0 * (p1 * x + p2 * y);
        let prism = DVec2::new(s1 + 2.0 * s2 * r2, s3 + 2.0 * s4 * r2) * 2.0;
        slope.x_axis += DVec2::new(2.0 * p1 * y + 6.0 * p2 * x, across) + prism * x;
        slope.y_axis += DVec2::new(across, 6.0 * p1 * y + 2.0 * p2 * x) + prism * y;
        (value, slope)
    }
}

/// 3DEqualizer's "Radial - Standard, Degree 4": from the distorted to the undistorted point, both over half of the film back's diagonal, y up
/// (Science-D-Visions, Lens Distortion Plugin Kit: `ldpk_radial_decentered_distortion.h`, `ldpk_cylindric_extender.h`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TdeRadial {
    /// Radial coefficients of degree 2 and 4.
    pub(super) c: [f64; 2],
    /// Decentring to the right, of degree 2 and 4.
    pub(super) u: [f64; 2],
    /// Decentring up, of degree 2 and 4.
    pub(super) v: [f64; 2],
    /// The cylindric bending.
    pub(super) bending: DMat2,
}

impl TdeRadial {
    /// The bending of a beam splitter: longer by the root of `1 + b` in the direction `phi`, shorter by as much across.
    pub(super) fn bending(phi_rad: f64, b: f64) -> DMat2 {
        let q = (1.0 + b).sqrt();
        let (sin, cos) = phi_rad.sin_cos();
        let across = (q - 1.0 / q) * cos * sin;
        DMat2::from_cols(
            DVec2::new(cos * cos * q + sin * sin / q, across),
            DVec2::new(across, cos * cos / q + sin * sin * q),
        )
    }

    /// The distortion with y down in both planes, the second one `stretch` times larger.
    pub(super) fn seen_from_ahead(self, stretch: f64) -> Self {
        // Decentring up is down then, and a turn goes the other way.
        let bending = DMat2::from_cols(
            DVec2::new(self.bending.x_axis.x, -self.bending.x_axis.y),
            DVec2::new(-self.bending.y_axis.x, self.bending.y_axis.y),
        );
        Self { v: self.v.map(|v| -v), bending: bending * stretch, ..self }
    }

    fn at(&self, q: DVec2) -> (DVec2, DMat2) {
        let DVec2 { x, y } = q;
        let r2 = q.length_squared();
        let radial = 1.0 + self.c[0] * r2 + self.c[1] * r2 * r2;
        let radial_slope = self.c[0] + 2.0 * self.c[1] * r2;
        let (u, v) = (self.u[0] + self.u[1] * r2, self.v[0] + self.v[1] * r2);
        let value = DVec2::new(
            x * radial + (r2 + 2.0 * x * x) * u + 2.0 * x * y * v,
            y * radial + (r2 + 2.0 * y * y) * v + 2.0 * x * y * u,
        );
        // By r^2, then by x and y where they stand alone.
        let by_r2 = DVec2::new(
            x * radial_slope + u + (r2 + 2.0 * x * x) * self.u[1] + 2.0 * x * y * self.v[1],
            y * radial_slope + v + (r2 + 2.0 * y * y) * self.v[1] + 2.0 * x * y * self.u[1],
        );
        let by_x = DVec2::new(radial + 4.0 * x * u + 2.0 * y * v, 2.0 * y * u) + by_r2 * (2.0 * x);
        let by_y = DVec2::new(2.0 * x * v, radial + 4.0 * y * v + 2.0 * x * u) + by_r2 * (2.0 * y);
        (self.bending * value, self.bending * DMat2::from_cols(by_x, by_y))
    }
}

/// 3DEqualizer's "Anamorphic - Standard, Degree 4", likewise (`ldpk_generic_anamorphic_distortion.h`,
/// `tde4_ldp_anamorphic_standard_degree_4.h`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TdeAnamorphic {
    /// Coefficients by `r^2`, `r^2 cos 2 phi`, `r^4`, `r^4 cos 2 phi`, `r^4 cos 4 phi`, of x and of y.
    pub(super) coefficients: [[f64; 5]; 2],
    /// The map to the lens's own axes: it undoes the lens's rotation and the pixels' shape.
    pub(super) before: DMat2,
    /// Back: rotation, squeezes, the pixels' shape.
    pub(super) after: DMat2,
}

impl TdeAnamorphic {
    fn at(&self, q: DVec2) -> (DVec2, DMat2) {
        let p = self.before * q;
        let [x, y] = self.coefficients.map(|c| factor(&c, p));
        let value = DVec2::new(p.x * x.0, p.y * y.0);
        let by_x = DVec2::new(x.0 + p.x * x.1.x, p.y * y.1.x);
        let by_y = DVec2::new(p.x * x.1.y, y.0 + p.y * y.1.y);
        (self.after * value, self.after * DMat2::from_cols(by_x, by_y) * self.before)
    }
}

/// A factor of a coordinate, and its gradient.
fn factor(c: &[f64; 5], p: DVec2) -> (f64, DVec2) {
    let [c02, c22, c04, c24, c44] = *c;
    // r^2 cos 2 phi = x^2 - y^2; r^4 cos 4 phi = x^4 - 6 x^2 y^2 + y^4
    let (x2, y2) = (p.x * p.x, p.y * p.y);
    let [xx, yy] = [c02 + c22, c02 - c22];
    let [xxxx, xxyy, yyyy] = [c04 + c24 + c44, 2.0 * c04 - 6.0 * c44, c04 - c24 + c44];
    let value = 1.0 + xx * x2 + yy * y2 + xxxx * x2 * x2 + xxyy * x2 * y2 + yyyy * y2 * y2;
    let by_x = 2.0 * p.x * (xx + 2.0 * xxxx * x2 + xxyy * y2);
    let by_y = 2.0 * p.y * (yy + 2.0 * yyyy * y2 + xxyy * x2);
    (value, DVec2::new(by_x, by_y))
}
