//! Transmission of the lens in each colour, on the axis and at fields off it.

use serde::Serialize;

use super::Analysis;
use crate::transmission::{Passage, Passages};

/// Rays of a beam, along a side.
const MESH: usize = 15;

/// The transmission of a field.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FieldTransmission {
    /// The field's angle to the axis.
    pub angle_deg: f64,
    /// The part of the light that passes, by wavelength, of light that no rim stops: the mean of the beam; `None` where nothing comes
    /// through.
    pub parts: Option<Vec<f64>>,
}

impl Analysis<'_> {
    /// The parts of light of these vacuum wavelengths that pass, by field. The beam is that of the main wavelength.
    pub fn transmission(&self, angles_deg: &[f64], wavelengths_nm: &[f64]) -> Vec<FieldTransmission> {
        let passages = Passages::new(self.system, self.lines[self.main].wavelength_nm);
        let of_field = |&angle_deg: &f64| {
            let beam = self.passing(angle_deg, &passages);
            let all: f64 = beam.iter().map(|(_, weight)| weight).sum();
            let mean = |nm: &f64| beam.iter().map(|(one, w)| w * passages.part(one, *nm)).sum::<f64>() / all;
            let parts = (all > 0.0).then(|| wavelengths_nm.iter().map(mean).collect());
            FieldTransmission { angle_deg, parts }
        };
        angles_deg.iter().map(of_field).collect()
    }

    /// Rays of a field that come through, and the light that each stands for.
    fn passing(&self, angle_deg: f64, passages: &Passages<'_>) -> Vec<(Passage, f64)> {
        let Some(view) = self.view(angle_deg) else { return Vec::new() };
        let origin = &self.lines[self.main].probe.origin;
        let ray = |i: usize| {
            let ray = origin.ray(&view.field, view.place([i % MESH, i / MESH], MESH));
            Some((passages.from_scene(ray)?, super::weight(origin, &view.field, &ray)))
        };
        (0..MESH * MESH).filter_map(ray).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::focus::Focus;
    use crate::formats::lens;
    use crate::glass::{Catalogue, line_nm};
    use crate::system::{LensSettings, System};

    /// A thin slow lens has on the axis the transmittance of two bare surfaces; a field outside of the lens has none.
    #[test]
    fn the_axis_is_fresnels() {
        let text = "# coating: none\n300 2 1.5 12 0 0\n-300 3 air 12 0 0\n0 290 air 8 0 1";
        let lens = lens::parse(text, "test.lens", Catalogue::shipped()).unwrap();
        let system = System::new(&lens, &LensSettings::default()).unwrap();
        let focus = Focus::at_infinity(&system, line_nm::D);
        let analysis = Analysis::new(&system, focus, &[line_nm::D], 0, 0.0).unwrap();
        let found = analysis.transmission(&[0.0, 10.0, 89.0], &[500.0, 600.0]);
        let axis = found[0].parts.as_ref().unwrap();
        assert!(axis.iter().all(|part| (part - 0.96 * 0.96).abs() < 1e-5), "{axis:?}");
        assert!(found[1].parts.as_ref().unwrap()[0] < 0.9217 && found[2].parts.is_none());
    }
}
