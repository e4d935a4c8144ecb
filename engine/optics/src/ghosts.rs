//! Light that is reflected twice inside of a lens.
//!
//! Here to first order: the brightness of the disc that it makes of a far source. [`packet`] traces it exactly, [`ranking`] says how bright
//! each is, [`brute`] finds all of them without looking.
//!
//! The reflectance of a surface near the axis is that of its coating. A path that is reflected at surface j and then at i < j goes through
//! all surfaces up to j, back to i, and on to the film: its matrix says how wide the beam is there, and at every surface on its way whose
//! rim may narrow it. A parallel beam of radius h that fills a disc of radius r is h² / r² times as bright there, times both reflectances.

pub mod beam;
pub mod brute;
mod edges;
pub mod packet;
pub mod power;
pub mod ranking;

use crate::first_order::{Matrix, ParaxialSurface};
use crate::surface::Section;
use crate::system::System;

/// A path with two reflections.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ghost {
    /// The surfaces that reflect, the earlier on the lens first; light hits the later one first.
    pub surfaces: [usize; 2],
    /// The product of both reflectances.
    pub reflectance: f64,
    /// Radius on the film of the ghost of a far point on the axis, mm.
    pub radius_mm: f64,
    /// Irradiance of that disc for one of the parallel light before the lens.
    pub irradiance: f64,
}

/// All paths with two reflections, of light that is parallel to the axis, the brightest first.
/// `least_radius_mm` is the smallest disc that is told apart from a point.
pub fn all(system: &System, wavelength_nm: f64, film_z_mm: f64, least_radius_mm: f64) -> Vec<Ghost> {
    let surfaces = system.thin_in(Section::Y, wavelength_nm);
    let reflectance = |i: usize| match surfaces[i].from == surfaces[i].to {
        true => 0.0,
        false => system.surfaces()[i].split(wavelength_nm, 1.0, true).mean_reflected(),
    };
    let to_film = film_z_mm - system.last_vertex_z_mm();
    let mut found = Vec::new();
    for later in 1..surfaces.len() {
        for earlier in 0..later {
            let product = reflectance(earlier) * reflectance(later);
            // A mirror is no ghost, and a stop reflects nothing.
            let is_mirror = |s: &ParaxialSurface| s.from * s.to < 0.0;
            if product == 0.0 || is_mirror(&surfaces[earlier]) || is_mirror(&surfaces[later]) {
                continue;
            }
            let path = BeamPath::new(system, &surfaces, [earlier, later], to_film);
            let radius_mm = (path.at_film * path.beam).abs().max(least_radius_mm);
            let irradiance = product * (path.beam / radius_mm).powi(2);
            if irradiance.is_finite() {
                found.push(Ghost { surfaces: [earlier, later], reflectance: product, radius_mm, irradiance });
            }
        }
    }
    found.sort_by(|a, b| b.irradiance.total_cmp(&a.irradiance));
    found
}

/// A beam on its way.
struct BeamPath {
    /// Height on the film for height 1 before the lens.
    at_film: f64,
    /// The largest height before the lens that passes all rims.
    beam: f64,
}

impl BeamPath {
    fn new(system: &System, surfaces: &[ParaxialSurface], [earlier, later]: [usize; 2], to_film: f64) -> Self {
        let mut walk = GhostWalk { system, ray: [1.0, 0.0], beam: f64::INFINITY };
        let mirror = |curvature: f64, index: f64| Matrix::surface(curvature, index, -index);
        // There.
        for (k, s) in surfaces[..later].iter().enumerate() {
            walk.meet(k, Matrix::surface(s.curvature, s.from, s.to));
            walk.go(s.onward);
        }
        let s = &surfaces[later];
        walk.meet(later, mirror(s.curvature, s.from));
        // Back: indices and ways turned round.
        for k in (earlier + 1..later).rev() {
            let s = &surfaces[k];
            walk.go(s.onward.reversed());
            walk.meet(k, Matrix::surface(s.curvature, -s.to, -s.from));
        }
        let s = &surfaces[earlier];
        walk.go(s.onward.reversed());
        walk.meet(earlier, mirror(s.curvature, -s.to));
        // And on.
        for (k, s) in surfaces.iter().enumerate().skip(earlier) {
            if k > earlier {
                walk.meet(k, Matrix::surface(s.curvature, s.from, s.to));
            }
            walk.go(if k + 1 < surfaces.len() { s.onward } else { Matrix::travel(to_film, s.to) });
        }
        Self { at_film: walk.ray[0], beam: walk.beam }
    }
}

/// A ray, and the beam that the rims so far let through.
struct GhostWalk<'a> {
    system: &'a System,
    ray: [f64; 2],
    beam: f64,
}

impl GhostWalk<'_> {
    fn meet(&mut self, surface: usize, matrix: Matrix) {
        let semi = match surface == self.system.stop() {
            true => self.system.stop_semi_diameter_mm(),
            false => self.system.surfaces()[surface].semi_diameter_mm,
        };
        self.beam = self.beam.min(semi / self.ray[0].abs().max(f64::MIN_POSITIVE));
        self.ray = matrix.apply(self.ray[0], self.ray[1]);
    }

    fn go(&mut self, way: Matrix) {
        self.ray = way.apply(self.ray[0], self.ray[1]);
    }
}

#[cfg(test)]
mod against_brute;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coating::Coating;
    use crate::formats::lens;
    use crate::glass::Catalogue;
    use crate::system::LensSettings;

    fn system(text: &str) -> System {
        let lens = lens::parse(text, "test.lens", Catalogue::shipped()).unwrap();
        System::new(&lens, &LensSettings::default()).unwrap().coated(&Coating::BARE)
    }

    /// A plate: light reflected at its back and then at its front goes on parallel, as wide as it was.
    #[test]
    fn a_plate_keeps_the_beam() {
        let plate = system("0 5 1.5 20 0 1\n0 50 air 30 0 0");
        let ghosts = all(&plate, 550.0, 55.0, 1e-3);
        assert_eq!(ghosts.len(), 1);
        assert_eq!(ghosts[0].surfaces, [0, 1]);
        assert!((ghosts[0].reflectance - 0.0016).abs() < 1e-12);
        assert!((ghosts[0].radius_mm - 10.0).abs() < 1e-9);
        assert!((ghosts[0].irradiance - 0.0016).abs() < 1e-12);
    }

    /// A thin biconvex lens of index n and power φ = (n − 1) (c₁ − c₂): light reflected twice inside has the power
    /// φ (3n − 1) / (n − 1) (two reflections of power 2 n c each side beside both refractions).
    #[test]
    fn a_thin_lens_focuses_its_ghost_nearer() {
        let (n, f) = (1.5, 100.0);
        let thin = system(&format!("{f} 1e-6 {n} 20 0 1\n-{f} 100 air 20 0 0"));
        let focus = f * (n - 1.0) / (3.0 * n - 1.0);
        for film in [0.5 * focus, 2.0 * focus] {
            let ghost = all(&thin, 550.0, film, 1e-9)[0];
            let expected = 10.0 * (1.0 - film / focus).abs();
            assert!((ghost.radius_mm / expected - 1.0).abs() < 1e-6, "{} {expected}", ghost.radius_mm);
        }
    }

    /// The exact disc on the axis of a lens that is stopped down is that of first order: the twice-reflected light of a triplet, brightest
    /// first alike.
    #[test]
    fn discs_are_those_of_the_exact_trace() {
        let text = "40.1 6 SK4 34 0 0\n-537 10 air 34 0 0\n-47 1 SF2 26 0 0\n40 1 air 26 0 0\n0 9.8 air 25 0 1\n234.5 6 SK4 28 0 0\n-37.9 85 air 28 0 0";
        let settings = LensSettings { f_number: Some(90.0), ..LensSettings::default() };
        let triplet = System::new(&lens::parse(text, "test.lens", Catalogue::shipped()).unwrap(), &settings).unwrap();
        let film = crate::focus::FilmPlane::upright(110.0).frame();
        let beam = beam::Beam::new(&triplet, beam::Source::Far(glam::DVec3::NEG_Z)).unwrap();
        let tracer = triplet.at_wavelength(587.6);
        let exact = ranking::ranked(&triplet, &tracer, &beam, (&film, |_| true), 2, 0.03, 1e-3);
        for first_order in all(&triplet, 587.6, 110.0, 1e-3) {
            let [earlier, later] = first_order.surfaces;
            let same = exact.iter().find(|ghost| ghost.turns == [later, earlier]).unwrap();
            assert!(same.centre_mm.length() < 1e-3, "{same:?}");
            // Beams of a ghost are wider than the picture's: what is left of third order at f/90 is some per cent.
            let ratio = same.radius_mm / first_order.radius_mm;
            assert!((ratio - 1.0).abs() < 0.06, "{same:?} {first_order:?}");
            // Transmission, which first order leaves out, takes about 2 % at each of up to eighteen surfaces.
            let brightness =
                same.irradiance * same.radius_mm.powi(2) / (first_order.irradiance * first_order.radius_mm.powi(2));
            assert!(brightness > 0.66 && brightness < 1.0, "{same:?} {first_order:?}");
        }
    }

    /// Every pair of surfaces that bend light, none of the stop, and finite.
    #[test]
    fn a_real_lens_has_all_pairs() {
        let triplet = system(
            "40.1 6 SK4 34 0 0\n-537 10 air 34 0 0\n-47 1 SF2 26 0 0\n40 1 air 26 0 0\n0 9.8 air 25 0 1\n234.5 6 SK4 28 0 0\n-37.9 85 air 28 0 0",
        );
        let ghosts = all(&triplet, 587.6, 110.0, 1e-3);
        assert_eq!(ghosts.len(), 15);
        assert!(ghosts.windows(2).all(|two| two[0].irradiance >= two[1].irradiance));
        assert!(ghosts.iter().all(|g| g.irradiance > 0.0 && !g.surfaces.contains(&4)));
    }
}
