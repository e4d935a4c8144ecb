//! The part of a ray's power that is left along its way.

use crate::system::{Element, System};
use crate::trace::{Incidence, Ray, ReflectedTracer};

/// The parts of unpolarised light that a surface reflects and lets through: \[reflected, transmitted\]. A mirror's reflected light
/// counts as going on.
pub fn parts(system: &System, wavelength_nm: f64, incidence: &Incidence) -> [f64; 2] {
    let Incidence { meeting, cos, .. } = *incidence;
    let surface = &system.surfaces()[meeting.surface];
    if let Element::Reflect { .. } = surface.element {
        return [0.0, 1.0];
    }
    let split = surface.split(wavelength_nm, cos, meeting.towards_film);
    [split.mean_reflected(), split.mean_transmitted()]
}

/// The part of the light that the medium before a surface lets through on the way to it; glasses of which it is not known are clear.
pub fn on_the_way(system: &System, wavelength_nm: f64, incidence: &Incidence) -> f64 {
    let Incidence { meeting, length_mm, .. } = *incidence;
    let before = match (&system.surfaces()[meeting.surface].element, meeting.towards_film) {
        (Element::Refract { from, .. }, true) => from,
        (Element::Refract { to, .. }, false) => to,
        (Element::Reflect { medium }, _) => medium,
    };
    before.internal_transmittance(wavelength_nm, length_mm).unwrap_or(1.0)
}

/// The part of a ray's power that goes along a path to its end, and the ray that leaves; `None` where rims are in the way.
pub fn along(system: &System, path: &ReflectedTracer, ray: Ray) -> Option<(Ray, f64)> {
    let wavelength_nm = path.tracer().wavelength_nm();
    let mut left = 1.0;
    let out = path.from_scene(ray, &mut |incidence| {
        let [reflected, transmitted] = parts(system, wavelength_nm, &incidence);
        left *= if incidence.meeting.turns { reflected } else { transmitted };
        left *= on_the_way(system, wavelength_nm, &incidence);
    });
    out.ok().map(|ray| (ray, left))
}
