//! Spots: where the rays of a field hit the film.

use glam::DVec2;

use serde::Serialize;

use super::{AnalysedWavelength, Analysis, centroid};

/// The spot of a field. Places are [sagittal, tangential], mm.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spot {
    /// Angle of the field from the axis, counted at the entrance pupil.
    pub angle_deg: f64,
    /// The spot of each wavelength.
    pub lines: Vec<SpotLine>,
    /// The middle of all light, on the film, from its middle.
    pub centroid_mm: [f64; 2],
    /// The ray of the main wavelength through the middle of the stop, from the centroid; `None`: there is none.
    pub chief_mm: Option<[f64; 2]>,
    /// Root of the mean square distance from the centroid, all wavelengths together.
    pub rms_mm: f64,
    /// Distance of the farthest ray from the centroid.
    pub largest_mm: f64,
}

/// The spot of one wavelength.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpotLine {
    /// The wavelength in vacuum.
    pub wavelength_nm: f64,
    /// Points from the centroid of all wavelengths.
    pub points_mm: Vec<[f64; 2]>,
    /// The centroid of this wavelength, from that of all.
    pub centroid_mm: [f64; 2],
    /// Root mean square radius about the centroid of this wavelength.
    pub rms_mm: f64,
}

impl Analysis<'_> {
    /// The spot of a field, of rays that lie evenly in the beam: a square grid with `side` rays over its width and height.
    ///
    /// `None`: nothing comes through from there to the film.
    pub fn spot(&self, angle_deg: f64, side: usize) -> Option<Spot> {
        let view = self.view(angle_deg)?;
        let by_line: Vec<Vec<(DVec2, f64)>> = (0..self.lines.len())
            .map(|line| self.landings(line, &view, side).iter().map(|l| (self.turned(l.film), l.weight)).collect())
            .collect();
        // Each wavelength counts as much as another, however many of its rays were lost.
        let middles: Vec<_> = by_line.iter().map(|line| centroid(line.iter().copied())).collect();
        let lit = middles.iter().filter(|(sum, _)| *sum > 0.0);
        let (count, sum) = lit.fold((0.0, DVec2::ZERO), |(count, sum), (_, middle)| (count + 1.0, sum + *middle));
        if count == 0.0 {
            return None;
        }
        let middle = sum / count;
        let squares = |line: &[(DVec2, f64)], about: DVec2| {
            let (sum, squares) = line
                .iter()
                .fold((0.0, 0.0), |(sum, squares), (at, w)| (sum + w, squares + w * (*at - about).length_squared()));
            if sum > 0.0 { squares / sum } else { 0.0 }
        };
        let all = by_line.iter().map(|line| squares(line, middle)).sum::<f64>() / count;
        let largest = by_line.iter().flatten().map(|(at, _)| (*at - middle).length()).fold(0.0, f64::max);
        let chief = self.chief_out(self.main, &view).and_then(|out| self.film.frame().meet(&out));
        let lines =
            by_line.iter().zip(&middles).zip(self.wavelengths_nm()).map(|((line, (_, own)), wavelength_nm)| SpotLine {
                wavelength_nm,
                points_mm: line.iter().map(|(at, _)| (*at - middle).to_array()).collect(),
                centroid_mm: (*own - middle).to_array(),
                rms_mm: squares(line, *own).sqrt(),
            });
        Some(Spot {
            angle_deg,
            lines: lines.collect(),
            centroid_mm: middle.to_array(),
            chief_mm: chief.map(|at| (self.turned(DVec2::from(at)) - middle).to_array()),
            rms_mm: all.sqrt(),
            largest_mm: largest,
        })
    }

    /// The points on the film of rays of the main wavelength that hit the stop at these places, in radii of its opening: sagittal and
    /// tangential, mm from the film's middle. `None`: a rim or a surface keeps that ray.
    pub fn through_stop(&self, angle_deg: f64, stops: &[[f64; 2]]) -> Vec<Option<[f64; 2]>> {
        let Some(view) = self.view(angle_deg) else { return vec![None; stops.len()] };
        let AnalysedWavelength { tracer, probe, .. } = &self.lines[self.main];
        let land = |stop: &[f64; 2]| {
            let target = self.sagittal() * stop[0] + self.azimuth * stop[1];
            let at = probe.aim(&view.field, target, view.window.centre).ok()?;
            let out = tracer.from_scene(probe.origin.ray(&view.field, at)).ok()?;
            Some(self.turned(DVec2::from(self.film.frame().meet(&out)?)).to_array())
        };
        stops.iter().map(land).collect()
    }
}
