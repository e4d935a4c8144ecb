//! Transmission of a lens along one ray: reflection and absorption at its surfaces, and absorption in its glasses.
//!
//! Light that is reflected twice is not counted here: it is a ghost. Between two surfaces the planes of incidence turn, so the light
//! that one has polarised hits the next in another way: amplitudes go on along s and p of each surface in turn (Chipman, *Opt. Eng.*
//! 34, 1636, 1995), without the phases by which films delay one against the other, since those change only the joint effect of two
//! surfaces' differences between s and p.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use crate::system::{Element, System};
use crate::trace::{Ray, ReflectedTracer, Tracer};

/// Rings of the beam in the film's middle, as wide as each other in sin².
const RINGS: u32 = 16;
/// Meridians of a lens that is not symmetric.
const MERIDIANS: u32 = 16;

/// The sine of a bend that is rounding: such a ray goes on straight, or comes at right angles, and has no plane of incidence.
const STRAIGHT: f64 = 1e-7;

/// One ray through a lens, with the numbers that its losses depend on.
#[derive(Clone, Debug, PartialEq)]
pub struct Passage {
    met: Vec<CrossedSurface>,
}

/// A surface on the way.
#[derive(Clone, Copy, Debug, PartialEq)]
struct CrossedSurface {
    surface: usize,
    cos: f64,
    /// Length of the way through the medium before.
    length_mm: f64,
    /// Cosine and sine of the turn from the plane of incidence before to this.
    turn: [f64; 2],
}

/// Rays through a lens. Their ways are those of one wavelength: others differ by too little to lose more or less.
pub struct Passages<'a> {
    system: &'a System,
    tracer: Tracer,
    straight: Option<ReflectedTracer>,
}

impl<'a> Passages<'a> {
    /// The passages of a lens at a vacuum wavelength, nm.
    pub fn new(system: &'a System, wavelength_nm: f64) -> Self {
        let tracer = system.at_wavelength(wavelength_nm);
        let straight = tracer.reflected(&[]);
        Self { system, tracer, straight }
    }

    /// The passage of a ray which starts at the film; `None` where it is lost.
    pub fn from_film(&self, ray: Ray) -> Option<Passage> {
        let out = self.tracer.from_film(ray).ok()?;
        self.from_scene(Ray { origin: out.origin, direction: -out.direction })
    }

    /// The passage of a ray which comes from the scene; `None` where it is lost.
    pub fn from_scene(&self, ray: Ray) -> Option<Passage> {
        let (out, hits) = self.tracer.path_from_scene(ray).ok()?;
        let mut met: Vec<CrossedSurface> = Vec::with_capacity(hits.len());
        self.straight
            .as_ref()?
            .from_scene(ray, &mut |incidence| {
                let (surface, length_mm) = (incidence.meeting.surface, incidence.length_mm);
                met.push(CrossedSurface { surface, cos: incidence.cos, length_mm, turn: [1.0, 0.0] });
            })
            .ok()?;
        // Across the planes of incidence; where there is none, any does.
        let towards = |i: usize| hits.get(i + 1).map_or(out.direction, |next| (*next - hits[i]).normalize_or(DVec3::Z));
        let mut before: Option<DVec3> = None;
        let mut arriving = ray.direction;
        for (i, met) in met.iter_mut().enumerate().take(hits.len()) {
            let leaving = towards(i);
            let bent = arriving.cross(leaving);
            if bent.length() > STRAIGHT {
                let across = bent.normalize();
                if let Some(before) = before {
                    // What was across before, by what is across and along the plane now.
                    let along = arriving.cross(across);
                    met.turn = [before.dot(across), before.dot(along)];
                }
                before = Some(across);
            }
            arriving = leaving;
        }
        Some(Passage { met })
    }

    /// The part of unpolarised light of a wavelength that passes.
    pub fn part(&self, passage: &Passage, wavelength_nm: f64) -> f64 {
        // Two fields at right angles, by their parts across and along the plane of incidence.
        let mut fields = [[1.0, 0.0], [0.0, 1.0]];
        let mut absorbed = 1.0;
        for met in &passage.met {
            let surface = &self.system.surfaces()[met.surface];
            let split = surface.split(wavelength_nm, met.cos, true);
            let (amplitudes, before) = match &surface.element {
                Element::Refract { from, .. } => (split.transmitted.map(f64::sqrt), from),
                // Light that turns round has its directions across and along exchanged in sign.
                Element::Reflect { medium } => {
                    let [s, p] = split.reflected.map(f64::sqrt);
                    ([-s, p], medium)
                }
            };
            absorbed *= before.internal_transmittance(wavelength_nm, met.length_mm).unwrap_or(1.0);
            let [c, s] = met.turn;
            for field in &mut fields {
                let [across, along] = *field;
                *field = [amplitudes[0] * (c * across - s * along), amplitudes[1] * (s * across + c * along)];
            }
        }
        let power: f64 = fields.as_flattened().iter().map(|e| e * e).sum();
        0.5 * power * absorbed
    }

    /// The part of unpolarised light of a wavelength that passes if the light is taken as unpolarised before each surface.
    pub fn part_unpolarised(&self, passage: &Passage, wavelength_nm: f64) -> f64 {
        let one = |met: &CrossedSurface| {
            let surface = &self.system.surfaces()[met.surface];
            let split = surface.split(wavelength_nm, met.cos, true);
            let (part, before) = match &surface.element {
                Element::Refract { from, .. } => (split.mean_transmitted(), from),
                Element::Reflect { medium } => (split.mean_reflected(), medium),
            };
            part * before.internal_transmittance(wavelength_nm, met.length_mm).unwrap_or(1.0)
        };
        passage.met.iter().map(one).product()
    }

    /// The part of the light of a uniform world that arrives in the middle of an upright film, by wavelength: over the light that would
    /// arrive if nothing were lost. `None` where nothing arrives at all.
    pub fn in_the_middle(&self, film_z_mm: f64, wavelengths_nm: &[f64]) -> Option<Vec<f64>> {
        let passages = self.beam_of_the_middle(film_z_mm);
        if passages.is_empty() {
            return None;
        }
        let mean =
            |nm: &f64| passages.iter().map(|passage| self.part(passage, *nm)).sum::<f64>() / passages.len() as f64;
        Some(wavelengths_nm.iter().map(mean).collect())
    }

    /// Rays of the light in the film's middle, each for as much irradiance as another.
    fn beam_of_the_middle(&self, film_z_mm: f64) -> Vec<Passage> {
        let rear = &self.system.surfaces()[self.system.surface_count() - 1];
        let to_rear = rear.z_mm - film_z_mm;
        let sag = rear.shape.rim_sag_mm(rear.semi_diameter_mm).unwrap_or(0.0);
        let widest = rear.semi_diameter_mm.atan2(to_rear.abs().min((to_rear + sag).abs()));
        let is_round = self.system.is_rotationally_symmetric() && !self.system.diaphragm().is_masked();
        let meridians = if is_round { 1 } else { MERIDIANS };
        let origin = DVec3::new(0.0, 0.0, film_z_mm);
        // A pupil may be a small part of the rear glass: rings where it is.
        let mut end = widest.sin().powi(2);
        loop {
            let ray = |i: u32| {
                let (ring, meridian) = (i / meridians, i % meridians);
                let sine = (end * (f64::from(ring) + 0.5) / f64::from(RINGS)).sqrt();
                let about = DVec2::from_angle(0.5 * PI + 2.0 * PI * f64::from(meridian) / f64::from(meridians));
                let direction = (about * sine).extend(to_rear.signum() * (1.0 - sine * sine).sqrt());
                self.from_film(Ray { origin, direction })
            };
            let found: Vec<Passage> = (0..RINGS * meridians).filter_map(ray).collect();
            if found.len() as u32 * 4 >= RINGS * meridians || end < 1e-9 {
                return found;
            }
            end *= 0.25;
        }
    }

    /// The part of the light of a wavelength that passes along the axis, or would without a central obstruction.
    pub fn on_axis(&self, wavelength_nm: f64) -> f64 {
        let mut arriving_mm = 0.0;
        let one = |surface: &crate::system::Surface| {
            let split = surface.split(wavelength_nm, 1.0, true);
            let (part, before) = match &surface.element {
                Element::Refract { from, .. } => (split.mean_transmitted(), from),
                Element::Reflect { medium } => (split.mean_reflected(), medium),
            };
            let inside = before.internal_transmittance(wavelength_nm, arriving_mm).unwrap_or(1.0);
            arriving_mm = surface.thickness_mm;
            part * inside
        };
        self.system.surfaces().iter().map(one).product()
    }
}

impl System {
    /// Glasses whose absorption is not known: they count as clear.
    pub fn glasses_of_unknown_absorption(&self) -> Vec<&str> {
        let mut found: Vec<&str> = Vec::new();
        for surface in self.surfaces() {
            let medium = surface.element.behind();
            let is_glass = medium.base_index(crate::glass::line_nm::D) > 1.01;
            if is_glass && medium.transmittance().is_none() && !found.contains(&medium.name()) {
                found.push(medium.name());
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coating::Coating;
    use crate::formats::lens;
    use crate::glass::Catalogue;
    use crate::system::LensSettings;

    fn system(text: &str) -> System {
        System::new(&lens::parse(text, "test.lens", Catalogue::shipped()).unwrap(), &LensSettings::default()).unwrap()
    }

    fn on_axis(text: &str, nm: f64) -> f64 {
        Passages::new(&system(text), nm).on_axis(nm)
    }

    /// Two bare surfaces of index 1.5 pass 0.96 each; cement between like glasses takes nothing; glass absorbs by its table.
    #[test]
    fn surfaces_and_glass_multiply() {
        let bare = "# coating: none\n";
        assert!((on_axis(&format!("{bare}60 6 1.5 30 0 1\n-60 55 air 30 0 0"), 500.0) - 0.96 * 0.96).abs() < 1e-12);
        let cemented = format!("{bare}60 6 1.5 30 0 1\n100 6 1.5 30 0 0\n-60 55 air 30 0 0");
        assert!((on_axis(&cemented, 500.0) - 0.96 * 0.96).abs() < 1e-12);
        let tinted = "# coating: none\n# glass: DARK constant 300-900 1.5\n# transmittance: DARK 400:0.8@10 700:0.9@10\n60 5 DARK 30 0 1\n-60 55 air 30 0 0";
        for (nm, part) in [(400.0, 0.8f64), (700.0, 0.9)] {
            assert!((on_axis(tinted, nm) - 0.96 * 0.96 * part.sqrt()).abs() < 1e-12);
        }
        // A quarter of a wave, twice: ((1.5 - n²) / (1.5 + n²))².
        let n: f64 = 1.378_505_714_877_262_4;
        let coated = on_axis("60 6 1.5 30 0 1\n-60 55 air 30 0 0", 550.0);
        let left = ((1.5 - n * n) / (1.5 + n * n)).powi(2);
        assert!((coated - (1.0 - left).powi(2)).abs() < 1e-9, "{coated}");
        let mirror = "#radius thickness glass diameter conic isstop coating\n-200 -100 mirror 50 -1 1 protected-silver";
        assert!((on_axis(mirror, 550.0) - 0.98).abs() < 0.01);
    }

    /// Rays in a plane that holds the axis have one plane of incidence: s and p each go their own way, and the parts of the two have a
    /// mean. The effect of polarisation is then (∏Ts + ∏Tp) / 2 against ∏(Ts + Tp) / 2.
    #[test]
    fn rays_in_one_plane_keep_s_and_p() {
        let text = "# coating: none\n40 6 1.7 40 0 0\n400 8 air 40 0 0\n-60 2 1.6 30 0 0\n50 4 air 30 0 1\n90 6 1.7 30 0 0\n-45 60 air 30 0 0";
        let system = system(text);
        let all = Passages::new(&system, 550.0);
        let ray = Ray { origin: DVec3::new(0.0, 9.0, -10.0), direction: DVec3::new(0.0, -0.35, 1.0).normalize() };
        let passage = all.from_scene(ray).unwrap();
        let mut both = [1.0, 1.0];
        for met in &passage.met {
            let split = system.surfaces()[met.surface].split(550.0, met.cos, true);
            both = [both[0] * split.transmitted[0], both[1] * split.transmitted[1]];
        }
        let expected = 0.5 * (both[0] + both[1]);
        assert!((all.part(&passage, 550.0) - expected).abs() < 1e-12);
        assert!(both[0] < both[1] - 0.01 && all.part_unpolarised(&passage, 550.0) < expected);
        // As light comes, so it goes.
        let out = all.tracer.from_scene(ray).unwrap();
        let back = all.from_film(Ray { origin: out.origin, direction: -out.direction }).unwrap();
        assert!((all.part(&back, 550.0) - expected).abs() < 1e-10);
    }

    /// A stop bends nothing and turns nothing, nor does a surface that is hit at right angles.
    #[test]
    fn turns_are_turns() {
        let text = "# coating: none\n40 6 1.7 40 0 0\n400 8 air 40 0 0\n-60 2 1.6 30 0 0\n50 4 air 30 0 0\n0 3 air 20 0 1\n90 6 1.7 30 0 0\n-45 60 air 30 0 0";
        let system = system(text);
        let all = Passages::new(&system, 550.0);
        for [x, y, slope] in [[0.0, 0.0, 0.0], [5.0, 3.0, 0.0], [2.0, -4.0, 0.2], [-3.0, 1e-7, 1e-8], [6.0, 6.0, -0.25]]
        {
            let ray = Ray { origin: DVec3::new(x, y, -10.0), direction: DVec3::new(slope, 0.0, 1.0).normalize() };
            let passage = all.from_scene(ray).unwrap();
            assert!(passage.met.iter().all(|met| (met.turn[0].hypot(met.turn[1]) - 1.0).abs() < 1e-6), "{passage:?}");
            let (part, without) = (all.part(&passage, 550.0), all.part_unpolarised(&passage, 550.0));
            assert!((part / without - 1.0).abs() < 0.02, "{part} {without}");
        }
    }

    /// A surface that all light hits at normal incidence is the same to the whole beam, wherever the film is.
    #[test]
    fn the_middle_of_the_film_sees_a_mean() {
        let text = "# coating: none\n50 6 1.5168/64.17 25 0 1\n-50 46 air 25 0 0";
        let system = system(text);
        let all = Passages::new(&system, 550.0);
        let film = system.film_z_published_mm();
        let mean = all.in_the_middle(film, &[550.0]).unwrap()[0];
        let axis = all.on_axis(550.0);
        // Wider angles reflect as much on the whole until far out: the fourth order of the angle.
        assert!((mean / axis - 1.0).abs() < 2e-3, "{mean} {axis}");
        let clear = system.clone().coated(&Coating::parse("V-coat").unwrap());
        assert!(Passages::new(&clear, 550.0).in_the_middle(film, &[550.0]).unwrap()[0] > 0.99);
    }
}
