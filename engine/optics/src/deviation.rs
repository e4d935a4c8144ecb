//! Deviations of a lens from its prescription, as making and mounting it leaves them.
//!
//! An element is a run of surfaces with glass between them, cemented ones together, or a mirror. It deviates in the radius of each
//! surface, each thickness of glass, each index, and as a whole by a decentre and a tilt about the vertex of its first surface; the gap
//! in air behind it deviates too, but for the last one, to the film. Tilts and decentres of a surface that parts two cemented glasses are
//! left out.

use crate::prescription::{NextMedium, Prescription};
use crate::surface::{Conic, Pose};
use serde::Serialize;

/// The kind of a deviation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DeviationKind {
    /// The radius of curvature of a surface, as a part of it.
    Radius,
    /// A thickness or gap, mm.
    Thickness,
    /// The index of a glass, the same at all wavelengths.
    Index,
    /// The place of an element to the right, mm.
    DecenterX,
    /// The place of an element up, mm.
    DecenterY,
    /// The turn of an element about its horizontal axis, degrees.
    TiltX,
    /// The turn of an element about its vertical axis, degrees.
    TiltY,
}

/// Something of a lens that may deviate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Deviation {
    /// The kind of the deviation.
    pub kind: DeviationKind,
    /// Index of the first surface that deviates.
    pub first: usize,
    /// Index of the last surface that deviates; of a thickness or an index that before it.
    pub last: usize,
}

impl Prescription {
    /// Everything of the lens that may deviate, from the scene to the film.
    pub fn deviations(&self) -> Vec<Deviation> {
        let mut found = Vec::new();
        let last = self.surfaces.len() - 1;
        for (i, row) in self.surfaces.iter().enumerate() {
            let one = |kind| Deviation { kind, first: i, last: i };
            let is_curved = row.shape.profile().base.curvature != 0.0;
            if is_curved && self.is_optical(i) {
                found.push(one(DeviationKind::Radius));
            }
            if i < last {
                found.push(one(DeviationKind::Thickness));
            }
            if self.is_glass_behind(i) {
                found.push(one(DeviationKind::Index));
            }
        }
        for [first, last] in self.elements() {
            let kinds =
                [DeviationKind::DecenterX, DeviationKind::DecenterY, DeviationKind::TiltX, DeviationKind::TiltY];
            found.extend(kinds.map(|kind| Deviation { kind, first, last }));
        }
        found
    }

    /// The first and last surfaces of the elements: runs of surfaces with glass between them, and mirrors.
    pub fn elements(&self) -> Vec<[usize; 2]> {
        let mut found = Vec::new();
        let mut begun = None;
        for (i, row) in self.surfaces.iter().enumerate() {
            match (&row.behind, begun) {
                (NextMedium::Mirror, None) => found.push([i, i]),
                // A mirror on glass, and light on its way back through the glass.
                (NextMedium::Mirror, Some(_)) => {}
                (NextMedium::Medium(_), _) if self.is_glass_behind(i) => begun = begun.or(Some(i)),
                (NextMedium::Medium(_), Some(first)) => {
                    found.push([first, i]);
                    begun = None;
                }
                (NextMedium::Medium(_), None) => {}
            }
        }
        found.extend(begun.map(|first| [first, self.surfaces.len() - 1]));
        found
    }

    /// The lens with deviations of these sizes, in the units of their kinds; lengths are those of the lens as published.
    pub fn deviated(&self, by: &[(Deviation, f64)]) -> Self {
        let mut lens = self.clone();
        for &(Deviation { kind, first, last }, size) in by {
            let rows = &mut lens.surfaces[first..=last];
            match kind {
                DeviationKind::Radius => {
                    let base = rows[0].shape.profile().base;
                    let curvature = base.curvature / (1.0 + size);
                    rows[0].shape = rows[0].shape.with_base(Conic { curvature, ..base });
                }
                DeviationKind::Thickness => rows[0].thickness_mm += size,
                DeviationKind::Index => {
                    if let NextMedium::Medium(medium) = &mut rows[0].behind {
                        *medium = medium.with_index_shift(size);
                    }
                }
                DeviationKind::DecenterX => pose(rows, Pose::misaligned([size, 0.0], [0.0; 3])),
                DeviationKind::DecenterY => pose(rows, Pose::misaligned([0.0, size], [0.0; 3])),
                DeviationKind::TiltX => pose(rows, Pose::misaligned([0.0; 2], [size.to_radians(), 0.0, 0.0])),
                DeviationKind::TiltY => pose(rows, Pose::misaligned([0.0; 2], [0.0, size.to_radians(), 0.0])),
            }
        }
        lens
    }

    /// True if the surface reflects, or parts media.
    fn is_optical(&self, surface: usize) -> bool {
        match &self.surfaces[surface].behind {
            NextMedium::Mirror => true,
            NextMedium::Medium(_) => {
                self.is_glass_behind(surface) || (surface > 0 && self.is_glass_behind(surface - 1))
            }
        }
    }

    /// True if there is glass, or anything but air, behind the surface.
    fn is_glass_behind(&self, surface: usize) -> bool {
        // A mirror leaves the medium that is before it.
        let medium = self.surfaces[..=surface].iter().rev().find_map(|row| match &row.behind {
            NextMedium::Medium(medium) => Some(medium),
            NextMedium::Mirror => None,
        });
        medium.is_some_and(|medium| medium.as_defined().index(crate::glass::line_nm::D) != 1.0)
            && matches!(self.surfaces[surface].behind, NextMedium::Medium(_))
    }
}

/// Poses an element about the vertex of its first surface.
fn pose(rows: &mut [crate::prescription::SurfaceRow], pose: Pose) {
    let mut behind_mm = 0.0;
    for row in rows {
        row.pose = pose.of_element(behind_mm) * row.pose;
        behind_mm += row.thickness_mm;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::lens;
    use crate::glass::Catalogue;
    use crate::system::{LensSettings, System};
    use crate::trace::Ray;
    use glam::DVec3;

    /// A cemented pair, a stop in air, a single lens.
    const LENS: &str = "#radius thickness glass diameter conic isstop
        60 6 N-BK7 20 0 0
        -50 2 SF2 20 0 0
        -200 5 air 20 0 0
        0 5 air 12 0 1
        80 4 N-BK7 20 0 0
        0 60 air 20 0 0";

    fn read(text: &str) -> Prescription {
        lens::parse(text, "test.lens", Catalogue::shipped()).unwrap()
    }

    #[test]
    fn elements_are_runs_of_glass() {
        let lens = read(LENS);
        assert_eq!(lens.elements(), [[0, 2], [4, 5]]);
        let count = |kind| lens.deviations().iter().filter(|one| one.kind == kind).count();
        // The plane has no radius, the last gap is the film's.
        assert_eq!([DeviationKind::Radius, DeviationKind::Thickness, DeviationKind::Index].map(count), [4, 5, 3]);
        assert_eq!(count(DeviationKind::TiltX), 2);
    }

    #[test]
    fn a_deviated_lens_is_the_one_that_a_file_would_have() {
        let cases = [
            (DeviationKind::Radius, 0, 0, 0.01, LENS.replace("60 6", "60.6 6")),
            (DeviationKind::Thickness, 2, 2, 0.3, LENS.replace("-200 5 air", "-200 5.3 air")),
            (DeviationKind::DecenterY, 0, 2, 0.2, format!("# element: 0-2 decenter_y=0.2\n{LENS}")),
            (DeviationKind::TiltX, 4, 5, 0.5, format!("# element: 4-5 tilt_x=0.5\n{LENS}")),
        ];
        let land = |lens: &Prescription| {
            let system = System::new(lens, &LensSettings::default()).unwrap();
            let ray = Ray { origin: DVec3::new(1.0, 2.0, -10.0), direction: DVec3::Z };
            let out = system.at_wavelength(587.5618).from_scene(ray).unwrap();
            (out.origin, out.direction)
        };
        for (kind, first, last, size, text) in cases {
            let deviated = read(LENS).deviated(&[(Deviation { kind, first, last }, size)]);
            let (at, direction) = land(&deviated);
            let (expected, towards) = land(&read(&text));
            assert!(at.distance(expected) < 1e-9 && direction.distance(towards) < 1e-12, "{kind:?}");
        }
        let index = Deviation { kind: DeviationKind::Index, first: 0, last: 0 };
        let deviated = read(LENS).deviated(&[(index, 1e-3)]);
        let NextMedium::Medium(medium) = &deviated.surfaces[0].behind else { panic!("glass") };
        let catalogue = Catalogue::shipped().medium("N-BK7").unwrap();
        assert!((medium.index(500.0) - catalogue.index(500.0) - 1e-3).abs() < 1e-12);
    }
}
