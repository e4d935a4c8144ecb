//! The place on the film of light that a surface scatters by a small angle, to first order.
//!
//! A surface that changes the direction of a ray by a small angle moves the place where it hits the film by the angle times the element
//! B of the matrix from the surface to the film (Peterson, "Analytic expressions for in-field scattered light distributions", Proc.
//! SPIE 5178, 2004). Angles here are changes of the direction's sine times the index, which refraction keeps: of a
//! grating of f lines per mm, λ f.

use crate::first_order::Matrix;
use crate::surface::Section;
use crate::system::System;

/// A surface that scatters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatterer {
    /// Number of the surface in the lens.
    pub surface: usize,
    /// Path difference through a bump of height one: the step of the index; of a mirror twice the index.
    pub path_per_height: f64,
    /// Displacement of the light on the film, for one of the angle; mm.
    pub reach_mm: f64,
    /// True if dust can lie on the surface: there is air on a side.
    pub is_open: bool,
}

/// The scattering of all surfaces that refract or reflect light, scene side first, at a vacuum wavelength in nm.
pub fn scatterers(system: &System, wavelength_nm: f64, film_z_mm: f64) -> Vec<Scatterer> {
    let surfaces = system.thin_in(Section::Y, wavelength_nm);
    let to_film = film_z_mm - system.last_vertex_z_mm();
    let mut found = Vec::new();
    for (i, s) in surfaces.iter().enumerate() {
        let path_per_height = (s.to - s.from).abs();
        if path_per_height == 0.0 {
            continue;
        }
        let mut ray = [0.0, 1.0];
        let mut go = |matrix: Matrix| ray = matrix.apply(ray[0], ray[1]);
        for (k, next) in surfaces.iter().enumerate().skip(i) {
            if k > i {
                go(Matrix::surface(next.curvature, next.from, next.to));
            }
            go(if k + 1 < surfaces.len() { next.onward } else { Matrix::travel(to_film, next.to) });
        }
        let is_air = |index: f64| (index.abs() - 1.0).abs() < 1e-3;
        let reach_mm = ray[0].abs();
        if reach_mm.is_finite() && reach_mm > 0.0 {
            let is_open = is_air(s.from) || is_air(s.to);
            found.push(Scatterer { surface: i, path_per_height, reach_mm, is_open });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::lens;
    use crate::glass::Catalogue;
    use crate::system::LensSettings;

    /// Both sides of a thin lens reach as far as the film is away; so does a mirror, and it doubles the effect of its bumps.
    #[test]
    fn a_thin_lens_reaches_as_far_as_the_film() {
        let system = |text: &str| {
            let prescription = lens::parse(text, "test.lens", Catalogue::shipped()).unwrap();
            System::new(&prescription, &LensSettings::default()).unwrap()
        };
        let thin = scatterers(&system("100 1e-6 1.5 20 0 1\n-100 100 air 20 0 0"), 550.0, 100.0);
        assert_eq!(thin.len(), 2);
        assert!(thin.iter().all(|s| (s.reach_mm - 100.0).abs() < 1e-3 && s.is_open));
        assert!(thin.iter().all(|s| (s.path_per_height - 0.5).abs() < 1e-12));
        let mirror = scatterers(&system("-2000 -1000 mirror 200 -1 1"), 550.0, -1000.0);
        assert!((mirror[0].reach_mm - 1000.0).abs() < 1e-9 && mirror[0].path_per_height == 2.0);
    }
}
