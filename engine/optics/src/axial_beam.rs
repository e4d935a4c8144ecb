//! Width of the beam from an infinitely far point on the axis that a lens lets through.
//!
//! The f-number of first-order optics is that of the diaphragm alone. Where the rim of a glass is narrower than the diaphragm when
//! fully open, the lens is as fast as that rim allows, and makers engrave that f-number.

use glam::DVec3;

use crate::paraxial::Paraxial;
use crate::system::System;
use crate::trace::{Ray, Tracer};

/// Heights at which rays are tried, from the rim inwards, until one passes.
const LOOKS: u32 = 512;
/// Halvings between that ray and the next one outside.
const HALVINGS: u32 = 40;

/// The beam of rays parallel to the axis that comes through the lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxialBeam {
    /// Twice the largest height of a ray along the axis, in the y-z plane, that comes through; mm, by exact rays.
    pub diameter_mm: f64,
    /// Index of the surface that stops the next ray outside; `None`: all that hits the first surface comes through.
    pub ended_by: Option<usize>,
}

impl AxialBeam {
    /// The beam at a vacuum wavelength in nm; `None`: nothing comes through.
    ///
    /// A dark middle does not count: a central obstruction makes a beam darker, not narrower.
    pub fn new(system: &System, wavelength_nm: f64) -> Option<Self> {
        let tracer: Tracer = system.at_wavelength(wavelength_nm);
        let widest = system.surfaces().first()?.semi_diameter_mm;
        let end = |height: f64| {
            let ray = Ray { origin: DVec3::new(0.0, height, 0.0), direction: DVec3::Z };
            tracer.from_scene(ray).err().map(|lost| lost.surface)
        };
        let height = |i: u32| widest * f64::from(i) / f64::from(LOOKS);
        let inside = (0..=LOOKS).rev().find(|&i| end(height(i)).is_none())?;
        let (mut low, mut high) = (height(inside), height((inside + 1).min(LOOKS)));
        let mut ended_by = end(high);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            match end(middle) {
                None => low = middle,
                surface => (high, ended_by) = (middle, surface),
            }
        }
        (low > 0.0).then_some(Self { diameter_mm: 2.0 * low, ended_by })
    }
}

/// The f-number of the lens with its present opening. If the diaphragm ends the beam, it is the focal length over the diameter of the
/// entrance pupil, to first order, as designers count it; if a rim does, it is the focal length over the diameter of the beam. `None`: the
/// lens has no focal length, or is dark.
///
/// The focal length is that on the side of the scene, which differs from the other in an eye.
pub fn f_number(system: &System, wavelength_nm: f64) -> Option<f64> {
    let p = Paraxial::new(system, wavelength_nm);
    let beam = AxialBeam::new(system, wavelength_nm)?;
    let diaphragm_mm = p.entrance_pupil.diameter_mm.filter(|_| beam.ended_by == Some(system.stop()));
    front_focal_length_mm(system, wavelength_nm).map(|focal| focal.abs() / diaphragm_mm.unwrap_or(beam.diameter_mm))
}

/// The focal length on the side of the scene, mm: one over the power, whatever medium the film is in.
pub fn front_focal_length_mm(system: &System, wavelength_nm: f64) -> Option<f64> {
    let p = Paraxial::new(system, wavelength_nm);
    Some(p.object_principal_plane_mm? - p.object_focal_plane_mm?)
}

#[cfg(test)]
mod tests {
    use super::{AxialBeam, f_number};
    use crate::formats::lens::parse;
    use crate::glass::{Catalogue, line_nm};
    use crate::system::{LensSettings, System};

    fn system(text: &str, f_number: Option<f64>) -> System {
        let lens = parse(text, "test", Catalogue::shipped()).unwrap();
        System::new(&lens, &LensSettings { f_number, ..LensSettings::default() }).unwrap()
    }

    #[test]
    fn the_narrowest_rim_counts() {
        // A paraboloid of 200 mm diameter whose light goes through a hole of 150 mm just before it.
        let mirror = "0 100 air 150 0 0\n-2000 -1000 mirror 200 -1 1";
        let open = system(mirror, None);
        assert_eq!(AxialBeam::new(&open, line_nm::D), Some(AxialBeam { diameter_mm: 150.0, ended_by: None }));
        assert!((f_number(&open, line_nm::D).unwrap() - 1000.0 / 150.0).abs() < 1e-9);
        // Closed further than that, the diaphragm counts.
        let closed = system(mirror, Some(10.0));
        assert_eq!(AxialBeam::new(&closed, line_nm::D).unwrap().ended_by, Some(1));
        assert!((f_number(&closed, line_nm::D).unwrap() - 10.0).abs() < 1e-9);
    }

    #[test]
    fn what_is_dark_in_the_middle_does_not_count() {
        let text = "#radius thickness glass diameter conic isstop obstruction\n-2000 -1000 mirror 200 -1 1 60";
        assert_eq!(AxialBeam::new(&system(text, None), line_nm::D).unwrap().diameter_mm, 200.0);
        let dark = "0 10 air 20 0 0 0\n0 10 air 40 0 1 30";
        let dark = format!("#radius thickness glass diameter conic isstop obstruction\n{dark}");
        assert_eq!(AxialBeam::new(&system(&dark, None), line_nm::D), None);
    }
}
