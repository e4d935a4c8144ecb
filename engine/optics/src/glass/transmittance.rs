//! Internal transmittance of glasses, without the losses at their surfaces.

/// Internal transmittance by wavelength, as catalogues list it: for a plate of some thickness.
#[derive(Clone, Debug, PartialEq)]
pub struct InternalTransmittance {
    /// (wavelength in nm, transmittance from 0 to 1, thickness in mm), by rising wavelength.
    points: Vec<[f64; 3]>,
}

/// The transmittance that is taken for a 0 of a table, which stands for less than the table can print.
const NOTHING: f64 = 1e-6;

impl InternalTransmittance {
    /// The transmittance of points (wavelength in nm, transmittance, thickness in mm), in any order; points that make no sense are left
    /// out. `None` if none is left.
    pub fn new(mut points: Vec<[f64; 3]>) -> Option<Self> {
        points.retain(|&[nm, part, mm]| {
            nm > 0.0 && (0.0..=1.0).contains(&part) && mm > 0.0 && nm.is_finite() && mm.is_finite()
        });
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        points.dedup_by_key(|point| point[0]);
        (!points.is_empty()).then_some(Self { points })
    }

    /// (wavelength in nm, transmittance, thickness in mm), by rising wavelength.
    pub fn points(&self) -> &[[f64; 3]] {
        &self.points
    }

    /// The part of the light that is left after `thickness_mm`: Bouguer's law, the absorption per millimetre straight between
    /// the wavelengths of the table and still beyond them.
    pub fn at(&self, wavelength_nm: f64, thickness_mm: f64) -> f64 {
        let absorption = |point: &[f64; 3]| -point[1].max(NOTHING).ln() / point[2];
        let after = self.points.partition_point(|point| point[0] <= wavelength_nm);
        let per_mm = match (after.checked_sub(1).map(|i| &self.points[i]), self.points.get(after)) {
            (Some(before), Some(next)) => {
                let t = (wavelength_nm - before[0]) / (next[0] - before[0]);
                absorption(before) * (1.0 - t) + absorption(next) * t
            }
            (Some(only), None) | (None, Some(only)) => absorption(only),
            (None, None) => 0.0,
        };
        (-per_mm * thickness_mm.abs()).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thickness_multiplies() {
        let known = InternalTransmittance::new(vec![[500.0, 0.98, 10.0], [400.0, 0.9, 5.0], [0.0, 0.5, 1.0]]).unwrap();
        assert!((known.at(500.0, 10.0) - 0.98).abs() < 1e-12);
        assert!((known.at(500.0, 20.0) - 0.98 * 0.98).abs() < 1e-12);
        assert!((known.at(400.0, 5.0) - 0.9).abs() < 1e-12);
        assert!((known.at(300.0, 5.0) - 0.9).abs() < 1e-12);
        assert!((known.at(450.0, 10.0) - (0.98f64 * 0.81).sqrt()).abs() < 1e-12);
        assert_eq!(known.at(450.0, 0.0), 1.0);
        assert_eq!(InternalTransmittance::new(vec![[500.0, 1.5, 10.0]]), None);
    }
}
