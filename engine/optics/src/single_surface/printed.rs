//! The equations of Wu et al. 2011, §3.2.1, as a reader of the paper would program them.
//!
//! Equations 3 to 5, in the form with the radius r and the squared eccentricity e² = −k, with the letters set right
//! where the print slips (docs/references.md): in f64, without carrying the ray, without a second form of the root,
//! with Snell's law as textbooks have it. The choice between the two roots is the tracer's, so that the difference is
//! numerics alone.

use glam::DVec3;

use super::{Hit, Outcome, SingleSurface};
use crate::surface::{Conic, Failure};

pub(super) fn trace(surface: &SingleSurface, conic: &Conic, origin: DVec3, direction: DVec3) -> Outcome {
    let d = direction.normalize();
    let hit = match meet(conic, origin, d, surface.side) {
        Ok(hit) => hit,
        Err(reason) => return Outcome::lost(reason),
    };
    let direction = surface.let_through(hit.point.truncate().length_squared()).and_then(|()| {
        let cosine = hit.normal.dot(d);
        match (surface.is_mirror, surface.from == surface.to) {
            (true, _) => Ok(d - 2.0 * cosine * hit.normal),
            (_, true) => Ok(d),
            _ => refract(surface.from / surface.to, d, hit.normal, cosine, surface.side),
        }
    });
    Outcome { hit: Some(hit), direction }
}

/// Equations 3 to 5.
fn meet(conic: &Conic, p: DVec3, d: DVec3, side: f64) -> Result<Hit, Failure> {
    let (r, e2) = (1.0 / conic.curvature, -conic.conic);
    let (t_mm, point, normal) = if conic.curvature == 0.0 {
        // The form with r has no planes; a reader treats them apart.
        let t = -p.z / d.z;
        (t, p + d * t, DVec3::Z)
    } else {
        let a = 1.0 - e2 * d.z * d.z;
        let b = d.dot(p) - r * d.z - e2 * p.z * d.z;
        let c = p.dot(p) - 2.0 * r * p.z - e2 * p.z * p.z;
        let discriminant = b * b - a * c;
        if discriminant < 0.0 {
            return Err(Failure::Missed);
        }
        let t = (-b - side * r.signum() * discriminant.sqrt()) / a;
        let point = p + d * t;
        let upward = DVec3::new(-point.x, -point.y, r - (1.0 - e2) * point.z) * r.signum();
        let length = (r * r + e2 * (point.x * point.x + point.y * point.y)).sqrt();
        (t, point, upward / length)
    };
    if !(t_mm.is_finite() && point.is_finite() && normal.is_finite()) {
        return Err(Failure::Missed);
    }
    if normal.z < 0.0 {
        return Err(Failure::WrongSheet);
    }
    if conic.curvature == 0.0 && normal.dot(d) * side < 0.0 {
        return Err(Failure::Missed);
    }
    Ok(Hit { t_mm, point, normal })
}

/// Snell's law in vector form: D′ = m D + (s √(1 − m² (1 − cos² i)) − m cos i) N, m = n / n′.
fn refract(m: f64, d: DVec3, normal: DVec3, cosine: f64, side: f64) -> Result<DVec3, Failure> {
    let radicand = 1.0 - m * m * (1.0 - cosine * cosine);
    if !(radicand >= 0.0) {
        return Err(Failure::TotalInternalReflection);
    }
    Ok(m * d + (side * radicand.sqrt() - m * cosine) * normal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::Shape;

    fn surface(radius: f64, k: f64) -> SingleSurface {
        SingleSurface {
            shape: Shape::conic(radius, k),
            side: 1.0,
            from: 1.0,
            to: 1.5,
            is_mirror: false,
            semi_diameter_mm: f64::INFINITY,
            obstruction_mm: 0.0,
        }
    }

    /// Point and direction by both, and their differences.
    fn difference(surface: &SingleSurface, origin: DVec3, direction: DVec3) -> f64 {
        let (a, b) = (surface.trace::<f64>(origin, direction), surface.trace_as_printed(origin, direction).unwrap());
        let (Some(x), Some(y)) = (a.hit, b.hit) else { return f64::INFINITY };
        (x.point - y.point).length()
            + (x.normal - y.normal).length()
            + (a.direction.unwrap() - b.direction.unwrap()).length()
    }

    #[test]
    fn it_agrees_where_nothing_is_hard() {
        for (radius, k) in [(50.0, 0.0), (-50.0, 0.0), (40.0, 0.7), (-60.0, -0.5), (30.0, -2.5), (0.0, 0.0)] {
            let origin = DVec3::new(4.0, -7.0, -20.0);
            let error = difference(&surface(radius, k), origin, DVec3::new(0.1, 0.2, 1.0));
            assert!(error < 1e-12, "{radius} {k}: {error:e}");
        }
        let mirror = SingleSurface { is_mirror: true, ..surface(-80.0, -1.0) };
        assert!(difference(&mirror, DVec3::new(3.0, 1.0, -30.0), DVec3::new(-0.1, 0.05, 1.0)) < 1e-12);
    }

    #[test]
    fn it_fails_where_design_says() {
        // Along the axis of a paraboloid A is 0; from far away and at a huge radius digits go.
        let paraboloid = difference(&surface(50.0, -1.0), DVec3::new(5.0, 0.0, -20.0), DVec3::Z);
        let far = difference(&surface(50.0, 0.0), DVec3::new(3.0, 0.0, -1e9), DVec3::new(0.0, 1e-9, 1.0));
        let flat = difference(&surface(1e13, 0.0), DVec3::new(3.0, 0.0, -20.0), DVec3::new(0.1, 0.0, 1.0));
        assert!(paraboloid == f64::INFINITY && far > 1e-3 && flat > 1e-4, "{paraboloid:e} {far:e} {flat:e}");
    }
}
