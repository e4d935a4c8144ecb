//! Several rays at a time, one in each lane.
//!
//! One ray waits at every surface for a square root and a division; several share the wait. The lanes take the usual
//! path only, without a branch. Whatever is unusual (a ray is lost, digits would cancel) is left to the scalar tracer,
//! whose word is the truth.

use super::{Action, Lost, Ray, Step, Tracer};
use crate::interface::NEAR_CRITICAL;
use crate::surface::CANCELLED;
use glam::DVec3;

/// Points, directions and what a surface did to them, by coordinate and lane.
struct Lanes<const N: usize> {
    point: [[f64; N]; 3],
    direction: [[f64; N]; 3],
    normal: [[f64; N]; 3],
    cosine_squared: [f64; N],
    normal_squared: [f64; N],
    /// True while the lane is on the usual path.
    usual: [bool; N],
}

impl Tracer {
    /// As [`Self::from_film`] for `N` rays at once; 4 or 8 lanes cost least for each.
    pub fn from_film_packet<const N: usize>(&self, rays: &[Ray; N]) -> [Result<Ray, Lost>; N] {
        let mut lanes = Lanes::new(rays);
        lanes.point[2].iter_mut().for_each(|z| *z -= self.last_z);
        for step in self.from_film.iter() {
            lanes.meet(step);
            if step.is_stop && self.diaphragm.blades() > 0 {
                for i in 0..N {
                    lanes.usual[i] &= self.diaphragm.is_open(lanes.point[0][i], lanes.point[1][i]);
                }
            }
            lanes.act(step);
        }
        std::array::from_fn(|i| if lanes.usual[i] { Ok(lanes.ray(i)) } else { self.from_film(rays[i]) })
    }
}

impl<const N: usize> Lanes<N> {
    fn new(rays: &[Ray; N]) -> Self {
        let split = |v: fn(&Ray) -> DVec3| [0, 1, 2].map(|axis| std::array::from_fn(|i| v(&rays[i])[axis]));
        Self {
            point: split(|ray| ray.origin),
            direction: split(|ray| ray.direction),
            normal: [[0.0; N]; 3],
            cosine_squared: [1.0; N],
            normal_squared: [1.0; N],
            usual: [true; N],
        }
    }

    fn ray(&self, i: usize) -> Ray {
        let at = |v: &[[f64; N]; 3]| DVec3::new(v[0][i], v[1][i], v[2][i]);
        let direction = at(&self.direction);
        Ray { origin: at(&self.point), direction: direction * (1.5 - 0.5 * direction.length_squared()) }
    }

    /// [`crate::surface::Conic::intersect`] and the round apertures, lane by lane.
    #[inline(always)]
    fn meet(&mut self, step: &Step) {
        let (c, k, side) = (step.shape.curvature, step.shape.conic, step.side);
        let clear = step.clear_squared.min(step.round_stop_squared);
        for i in 0..N {
            let [dx, dy, dz] = [self.direction[0][i], self.direction[1][i], self.direction[2][i]];
            let [mut px, mut py, mut pz] = [self.point[0][i], self.point[1][i], self.point[2][i] + step.to_here];
            if step.is_far {
                let carried = -(px * dx + py * dy + pz * dz);
                px += carried * dx;
                py += carried * dy;
                pz += carried * dz;
            }
            let along = px * dx + py * dy + pz * dz + k * pz * dz;
            let a = c * (1.0 + k * dz * dz);
            let b = c * along - dz;
            let cc = c * (px * px + py * py + pz * pz + k * pz * pz) - 2.0 * pz;
            let q = b * b - a * cc;
            let t = cc / (side * q.sqrt() - b);
            let [x, y, z] = [px + t * dx, py + t * dy, pz + t * dz];
            let (nx, ny, nz) = (-c * x, -c * y, 1.0 - (1.0 + k) * c * z);
            let squared = x * x + y * y;
            // Each comparison fails for NaN. -b and s √q must have one sign.
            self.usual[i] &= (q >= CANCELLED * b * b)
                & (b * side < 0.0)
                & (nz >= 0.0)
                & (squared <= clear)
                & (squared >= step.obstruction_squared);
            self.normal_squared[i] = if k == 0.0 { 1.0 } else { nx * nx + ny * ny + nz * nz };
            self.cosine_squared[i] = q;
            (self.point[0][i], self.point[1][i], self.point[2][i]) = (x, y, z);
            (self.normal[0][i], self.normal[1][i], self.normal[2][i]) = (nx, ny, nz);
        }
    }

    /// [`crate::interface`], lane by lane.
    #[inline(always)]
    fn act(&mut self, step: &Step) {
        let side = step.side;
        match step.action {
            Action::Pass => {}
            Action::Refract(interface) => {
                let m = interface.ratio;
                for i in 0..N {
                    let incident_squared = m * m * self.cosine_squared[i];
                    let radicand = incident_squared - interface.excess * self.normal_squared[i];
                    self.usual[i] &= radicand >= NEAR_CRITICAL * incident_squared;
                    let bend = side * interface.excess / (radicand.sqrt() + m * self.cosine_squared[i].sqrt());
                    for (d, n) in self.direction.iter_mut().zip(&self.normal) {
                        d[i] = d[i] * m - n[i] * bend;
                    }
                }
            }
            Action::Reflect => {
                for i in 0..N {
                    let twice = 2.0 * side * self.cosine_squared[i].sqrt() / self.normal_squared[i];
                    for (d, n) in self.direction.iter_mut().zip(&self.normal) {
                        d[i] -= n[i] * twice;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::lens;
    use crate::glass::Catalogue;
    use crate::system::{System, SystemSettings};

    #[test]
    fn a_packet_is_its_rays() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/reference/lenses");
        let mut passed = 0;
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let Ok(prescription) = lens::read(&path, Catalogue::shipped()) else { continue };
            for blades in [0, 5] {
                let settings = SystemSettings { blades, ..SystemSettings::default() };
                let system = System::new(&prescription, &settings).unwrap();
                let tracer = system.at_wavelength(550.0);
                let film = system.film_z_published_mm();
                let semi = system.rear_radius_mm();
                for j in 0..200u32 {
                    let at = |i: u32, by: u32| f64::from((i + 8 * j) * by % 101) / 50.0 - 1.0;
                    let rays: [Ray; 8] = std::array::from_fn(|i| {
                        let i = i as u32;
                        let origin = DVec3::new(at(i, 17) * semi * 0.3, at(i, 29) * semi * 0.3, film);
                        let target = DVec3::new(at(i, 41) * semi, at(i, 59) * semi, system.last_vertex_z_mm());
                        Ray { origin, direction: (target - origin).normalize() }
                    });
                    for (packet, ray) in tracer.from_film_packet(&rays).iter().zip(rays) {
                        match (packet, tracer.from_film(ray)) {
                            (Ok(a), Ok(b)) => {
                                assert!((a.origin - b.origin).length() < 1e-12 * (1.0 + b.origin.length()));
                                assert!((a.direction - b.direction).length() < 1e-12);
                                passed += 1;
                            }
                            (a, b) => assert_eq!(*a, b),
                        }
                    }
                }
            }
        }
        assert!(passed > 5000, "{passed}");
    }
}
