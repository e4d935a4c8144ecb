//! Planes, spheres and conicoids of revolution: c (x² + y² + (1 + k) z²) − 2 z = 0.

use glam::DVec3;

use super::Failure;

/// A conicoid of revolution in vertex form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conic {
    /// Curvature c = 1 / R in 1/mm; 0 is a plane, positive has its centre on the +z side.
    pub curvature: f64,
    /// Conic constant k = −e²: 0 a sphere, −1 a paraboloid, below −1 a hyperboloid, above 0 oblate.
    pub conic: f64,
}

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Distance along the ray from the origin that was given, in mm; negative if it lies behind.
    pub t: f64,
    /// The hit, in mm from the vertex.
    pub point: DVec3,
    /// N = (−c x, −c y, 1 − (1 + k) c z): towards +z at the vertex, not of unit length.
    pub normal: DVec3,
    /// |N|² = 1 − k c² (x² + y²).
    pub normal_squared: f64,
    /// (N · D)², from the discriminant: exact where N · D itself would cancel.
    pub cosine_squared: f64,
}

/// Below this part of B², the discriminant B² − A C is formed again without the rounding of its products.
/// Larger costs time, smaller loses digits at grazing incidence.
pub(crate) const CANCELLED: f64 = 1e-2;

impl Conic {
    /// A conicoid of curvature 1 / `radius_mm` (radius 0 or infinite: a plane) and conic constant `conic`.
    pub fn new(radius_mm: f64, conic: f64) -> Self {
        let curvature = if radius_mm == 0.0 { 0.0 } else { 1.0 / radius_mm };
        Self { curvature, conic }
    }

    /// Sag z in mm at `radius_mm` from the axis; `None` where the surface does not reach.
    pub fn sag_mm(&self, radius_mm: f64) -> Option<f64> {
        let c = self.curvature;
        let inside = 1.0 - (1.0 + self.conic) * c * c * radius_mm * radius_mm;
        (inside >= 0.0).then(|| c * radius_mm * radius_mm / (1.0 + inside.sqrt()))
    }

    /// The hit of the ray `origin` + t `direction` (unit) with sign(N · D) = `side`.
    ///
    /// `side` is +1 while light goes from the scene to the film, −1 on the way back, flipped by each mirror; it is
    /// not the sign of D's z. Negative t is right where the previous vertex lies behind. The origin is first
    /// carried to its point nearest the vertex, which keeps the digits of far sources.
    pub fn intersect(&self, origin: DVec3, direction: DVec3, side: f64) -> Result<Hit, Failure> {
        let carried = -origin.dot(direction);
        let mut hit = self.intersect_near(origin + direction * carried, direction, side)?;
        hit.t += carried;
        Ok(hit)
    }

    /// As [`Self::intersect`], without carrying the origin: for rays that start near the vertex, measured in radii.
    ///
    /// With A = c (1 + k Dz²), B = c (P·D + k Pz Dz) − Dz, C = c (P·P + k Pz²) − 2 Pz and q = B² − A C, the
    /// crossing with N · D = s √q is t = C / (−B + s √q) = (−B − s √q) / A; of the two forms the one whose terms
    /// do not cancel is taken. The first serves planes and paraboloids along the axis, where A = 0; the second
    /// the rear face of a ball, where the first is 0 / 0.
    #[inline(always)]
    pub(crate) fn intersect_near(&self, p: DVec3, d: DVec3, side: f64) -> Result<Hit, Failure> {
        let (c, k) = (self.curvature, self.conic);
        let along = p.dot(d) + k * p.z * d.z;
        let a = c * (1.0 + k * d.z * d.z);
        let b = c * along - d.z;
        let cc = c * (p.length_squared() + k * p.z * p.z) - 2.0 * p.z;
        let mut q = b * b - a * cc;
        if q < CANCELLED * b * b {
            q = difference_of_products(b, b, a, cc);
        }
        // Written so that NaN, too, is a miss.
        if !(q >= 0.0) {
            return Err(Failure::Missed);
        }
        let root = side * q.sqrt();
        let agree = -b * side > 0.0;
        let (over, under) = if agree { (cc, root - b) } else { (-b - root, a) };
        let t = over / under;
        if !t.is_finite() {
            return Err(Failure::Missed);
        }
        let point = p + d * t;
        let vertex_side = 1.0 - (1.0 + k) * c * point.z;
        if vertex_side < 0.0 {
            return Err(Failure::WrongSheet);
        }
        let normal = DVec3::new(-c * point.x, -c * point.y, vertex_side);
        // 1 − k c² r² is the same and loses its digits at the rim of a huge conic.
        let normal_squared = if k == 0.0 { 1.0 } else { normal.length_squared() };
        Ok(Hit { t, point, normal, normal_squared, cosine_squared: q })
    }
}

/// a b − c d with the error of one rounding (Kahan).
#[cold]
fn difference_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let product = c * d;
    let lost = (-c).mul_add(d, product);
    a.mul_add(b, -product) + lost
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALONG: DVec3 = DVec3::Z;

    #[test]
    fn a_sphere_is_hit_on_its_near_side() {
        let hit = Conic::new(50.0, 0.0).intersect(DVec3::new(30.0, 0.0, -100.0), ALONG, 1.0).unwrap();
        assert!((hit.point.z - 10.0).abs() < 1e-14);
        assert!((hit.cosine_squared - 0.64).abs() < 1e-15);
    }

    #[test]
    fn the_sag_is_where_the_ray_lands() {
        for (radius, conic) in [(50.0, 0.0), (-30.0, -1.0), (12.0, -4.0), (80.0, 2.0), (0.0, 0.0)] {
            let surface = Conic::new(radius, conic);
            let hit = surface.intersect(DVec3::new(0.0, 7.0, -20.0), ALONG, 1.0).unwrap();
            assert!((hit.point.z - surface.sag_mm(7.0).unwrap()).abs() < 1e-14);
        }
        assert_eq!(Conic::new(5.0, 0.0).sag_mm(6.0), None);
    }

    #[test]
    fn the_rear_of_a_ball_is_found_from_its_own_surface() {
        let hit = Conic::new(-5.0, 0.0).intersect(DVec3::new(0.0, 0.0, -10.0), ALONG, 1.0).unwrap();
        assert!(hit.point.length() < 1e-15);
    }

    #[test]
    fn no_ray_yields_a_number_that_is_none() {
        let bad = [f64::NAN, f64::INFINITY, 0.0, 1e300, -1e-300];
        for x in bad {
            for z in bad {
                if let Ok(hit) = Conic::new(10.0, 0.3).intersect(DVec3::new(x, 0.0, z), ALONG, 1.0) {
                    assert!(hit.point.is_finite() && hit.normal.is_finite());
                }
            }
        }
    }
}
