//! One ray from the scene at several wavelengths at a time, one in each lane.
//!
//! What a path found along a ray holds for every wavelength; where each leaves the lens is the work of one packet.

use std::sync::Arc;

use glam::DVec3;

use super::bundle::{Block, Losses};
use super::step::{Action, Step};
use super::{Lost, Ray, Tracer, Way};
use crate::diaphragm::Diaphragm;
use crate::interface::Interface;
use crate::lane::{Lane, LaneKernel, Level, Real};

/// Wavelengths in a packet: a multiple of the numbers in the widest register.
pub const LINES: usize = 8;

/// A lens at [`LINES`] wavelengths, for rays from the scene.
#[derive(Clone, Debug)]
pub struct SpectralTracer {
    way: Way<f64>,
    diaphragm: Arc<Diaphragm>,
    /// Ratios and excesses by step.
    interfaces: Arc<[[[f64; LINES]; 2]]>,
}

impl SpectralTracer {
    /// Of the tracers of one lens.
    pub fn new(lines: [&Tracer; LINES]) -> Self {
        let first = lines[0];
        let mut steps: Vec<Step> = first.from_scene.steps.to_vec();
        let mut interfaces = Vec::with_capacity(steps.len());
        for (i, step) in steps.iter_mut().enumerate() {
            let at = lines.map(|line| match line.from_scene.steps[i].action {
                Action::Refract(interface) => interface,
                Action::Pass | Action::Reflect => Interface { ratio: 1.0, excess: 0.0 },
            });
            // Two media may agree at one wavelength.
            let bends = lines.iter().map(|line| line.from_scene.steps[i].action);
            if let Some(action) = { bends }.find(|action| matches!(action, Action::Refract(_))) {
                step.action = action;
            }
            interfaces.push([at.map(|interface| interface.ratio), at.map(|interface| interface.excess)]);
        }
        let Way { travel, start_z, end_z, .. } = first.from_scene;
        Self {
            way: Way { steps: steps.into(), travel, start_z, end_z },
            diaphragm: first.diaphragm.clone(),
            interfaces: interfaces.into(),
        }
    }

    /// As [`Tracer::from_scene`] of each wavelength, to the last bit.
    #[inline]
    pub fn from_scene(&self, ray: Ray) -> [Result<Ray, Lost>; LINES] {
        f64::run_wide(Level::new(), Packet { tracer: self, ray })
    }
}

struct Packet<'a> {
    tracer: &'a SpectralTracer,
    ray: Ray,
}

impl LaneKernel<f64> for Packet<'_> {
    type Output = [Result<Ray, Lost>; LINES];

    #[inline(always)]
    fn run<L: Lane<Real = f64>>(self, zero: L) -> Self::Output {
        let SpectralTracer { way, diaphragm, interfaces } = self.tracer;
        let (p, d) = way.enter(self.ray);
        let [mut x, mut y, mut z, mut dx, mut dy, mut dz] = [p.x, p.y, p.z, d.x, d.y, d.z].map(|n| [n; LINES]);
        let mut block = Block { x: &mut x, y: &mut y, z: &mut z, dx: &mut dx, dy: &mut dy, dz: &mut dz };
        let mut reasons = [None; LINES];
        let mut lost = Losses { lost: &mut reasons, surface: 0 };
        for (i, (step, [ratio, excess])) in way.steps.iter().zip(interfaces.iter()).enumerate() {
            lost.surface = i;
            let lanes: Option<[&[f64]; 2]> = Some([ratio, excess]);
            if let Some(plain) = step.plain(false) {
                block.pass(zero, &plain, lanes, diaphragm, &mut lost);
            } else {
                block.pass(zero, step, lanes, diaphragm, &mut lost);
            }
        }
        std::array::from_fn(|i| match reasons[i] {
            Some(lost) => Err(lost),
            None => Ok(way.leave(DVec3::new(x[i], y[i], z[i]), DVec3::new(dx[i], dy[i], dz[i]))),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::lens;
    use crate::glass::Catalogue;
    use crate::system::{System, SystemSettings};

    /// Rays to all places of the front glass, some beyond the rims, of lenses with spheres, aspheres, toroids, mirrors
    /// and blades.
    #[test]
    fn each_wavelength_is_traced_as_alone() {
        let folder = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../lenses"));
        let mut passed = 0;
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let Ok(prescription) = lens::read(&path, Catalogue::shipped()) else { continue };
            let settings = SystemSettings { blades: 6, ..SystemSettings::default() };
            let system = System::new(&prescription, &settings).unwrap();
            let lines: [Tracer; LINES] = std::array::from_fn(|i| system.at_wavelength(400.0 + 40.0 * i as f64));
            let together = SpectralTracer::new(lines.each_ref());
            let semi = system.surfaces()[0].semi_diameter_mm;
            for i in 0..200 {
                let (a, b) = (f64::from(i) * 0.618_034, f64::from(i) / 200.0);
                let at = DVec3::new((a * 6.3).cos(), (a * 6.3).sin(), 0.0) * semi * b.sqrt();
                let tilt = DVec3::new((a * 1.7).sin() * 0.3, (a * 2.9).cos() * 0.3, 1.0).normalize();
                let ray = Ray { origin: at - tilt * 500.0, direction: tilt };
                for (line, result) in lines.iter().zip(together.from_scene(ray)) {
                    assert_eq!(result, line.from_scene(ray), "{}", path.display());
                    passed += usize::from(result.is_ok());
                }
            }
        }
        assert!(passed > 5000, "{passed}");
    }
}
