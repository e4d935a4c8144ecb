//! A lens as it was published: one row a surface, checked, each row with its place in the file.

mod metadata;
pub mod moving;

use thiserror::Error;

use crate::coating::{ASSUMED, Coating, parts_glass_from_air};
use crate::glass::{Medium, VISIBLE_NM};
use crate::surface::{Pose, Section, Shape};

use moving::MovingParts;

pub use metadata::{LensGroup, Metadata};

/// The medium or mirror behind a surface.
#[derive(Clone, Debug, PartialEq)]
pub enum NextMedium {
    /// The surface refracts into this medium.
    Medium(Medium),
    /// The surface reflects; the medium stays the same.
    Mirror,
}

/// The place of a row in its file, counted from 1. Row and column 0: not from a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Line in the file.
    pub line: usize,
    /// Column in the line, counted in characters.
    pub column: usize,
}

/// One surface of a prescription. Lengths in mm.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceRow {
    /// Shape of the surface.
    pub shape: Shape,
    /// The pose of the surface at its place on the axis: decentred and tilted, if at all.
    pub pose: Pose,
    /// Distance along the axis to the next vertex, the last to the film; negative after one reflection.
    pub thickness_mm: f64,
    /// The medium or mirror behind the surface.
    pub behind: NextMedium,
    /// Half of the clear diameter. A ray at exactly this distance from the axis passes.
    pub semi_diameter_mm: f64,
    /// Half of the diameter of a central obstruction, or 0.
    pub obstruction_mm: f64,
    /// Thin films on the surface; `None`: it is not known whether there are any.
    pub coating: Option<Coating>,
    /// The beginning of the row in its file.
    pub place: Place,
}

/// The column of a row that a problem is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// Radius of curvature.
    Radius,
    /// Thickness.
    Thickness,
    /// The medium behind the surface.
    Glass,
    /// Clear diameter.
    Diameter,
    /// Conic constant.
    Conic,
    /// Diameter of the central obstruction.
    Obstruction,
    /// Radius of curvature in the x-z plane.
    RadiusX,
    /// Coefficient of this power of the distance from the axis.
    Term(u32),
    /// Decentre or tilt of the surface.
    Pose,
}

/// An error by which a row or a list of rows makes no lens.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PrescriptionError {
    /// A number is infinite or none.
    #[error("{column:?} of surface {surface} is not finite; give a number")]
    NotFinite {
        /// Index of the surface, from 0.
        surface: usize,
        /// The column of the row that holds the number.
        column: Column,
    },
    /// A clear aperture is not positive.
    #[error("the clear diameter of surface {surface} is {diameter_mm} mm; it must be larger than 0")]
    NoAperture {
        /// Index of the surface.
        surface: usize,
        /// Clear diameter that the row gives.
        diameter_mm: f64,
    },
    /// The obstruction is negative or covers the clear aperture.
    #[error(
        "the obstruction of surface {surface} is {diameter_mm} mm; it must be at least 0 and less than the clear diameter"
    )]
    Obstruction {
        /// Index of the surface.
        surface: usize,
        /// Diameter of the obstruction that the row gives.
        diameter_mm: f64,
    },
    /// The surface ends before its clear aperture does.
    #[error(
        "surface {surface} reaches only {reach_mm} mm from the axis, but its clear diameter asks for {semi_diameter_mm} mm; check its radius and diameter"
    )]
    Unreachable {
        /// Index of the surface.
        surface: usize,
        /// Largest distance from the axis that a point of the surface has.
        reach_mm: f64,
        /// Half of the clear diameter.
        semi_diameter_mm: f64,
    },
    /// There is no surface.
    #[error("there is no surface; give at least one row")]
    Empty,
    /// The stop is not one of the surfaces.
    #[error("surface {stop} is marked as the stop, but there are {surfaces}; mark one of them")]
    NoSuchStop {
        /// Index of the stop.
        stop: usize,
        /// Number of surfaces of the prescription.
        surfaces: usize,
    },
    /// The film lies in a gradient, where rays are not followed.
    #[error("the medium before the film, behind surface {surface}, has a gradient; give it a surface to end at")]
    GradientAtFilm {
        /// Index of the last surface.
        surface: usize,
    },
    /// The film's radius of curvature is 0, infinite or none.
    #[error("the film's radius is {radius_mm} mm; give a number other than 0")]
    FilmRadius {
        /// Radius of curvature that the prescription gives its film.
        radius_mm: f64,
    },
}

impl PrescriptionError {
    /// The surface and column it is about, if it is about one.
    pub fn cell(&self) -> Option<(usize, Column)> {
        match *self {
            Self::NotFinite { surface, column } => Some((surface, column)),
            Self::NoAperture { surface, .. } | Self::Unreachable { surface, .. } => Some((surface, Column::Diameter)),
            Self::Obstruction { surface, .. } => Some((surface, Column::Obstruction)),
            Self::GradientAtFilm { surface } => Some((surface, Column::Glass)),
            Self::Empty | Self::NoSuchStop { .. } | Self::FilmRadius { .. } => None,
        }
    }
}

/// A checked lens as published. The medium before the first surface is air.
///
/// A stop wider than the glass beside it is no error: that glass then limits the beam, as it does in a real lens,
/// and exact tracing shows it.
#[derive(Clone, Debug, PartialEq)]
pub struct Prescription {
    /// Name of the lens.
    pub name: String,
    /// The surfaces, scene side first.
    pub surfaces: Vec<SurfaceRow>,
    /// Index of the surface that carries the diaphragm.
    pub stop: usize,
    /// Data from the header.
    pub metadata: Metadata,
    /// Radius of curvature of the film (a retina) in mm, signed as a surface's; `None`: plane.
    pub film_radius_mm: Option<f64>,
    /// The parts that change with zoom and focus, if there are any; the surfaces have them as in the first position.
    pub moving: Option<MovingParts>,
    /// The file it was read from, as it was named.
    pub source_file: String,
}

/// Relative amount by which a surface may fall short of its rim: rounding of published tables.
const RIM_ROUNDING: f64 = 1e-9;

impl SurfaceRow {
    /// Checks the row, which has index `surface`; the error names its fault.
    pub fn check(&self, surface: usize) -> Result<(), PrescriptionError> {
        let profile = self.shape.profile();
        let mut numbers = vec![
            (Column::Radius, profile.base.curvature),
            (Column::Thickness, self.thickness_mm),
            (Column::Diameter, self.semi_diameter_mm),
            (Column::Conic, profile.base.conic),
            (Column::Obstruction, self.obstruction_mm),
            (Column::RadiusX, self.shape.curvature_at_vertex(Section::X)),
        ];
        numbers.extend(profile.terms().into_iter().map(|(power, a)| (Column::Term(power), a)));
        if let Some(&(column, _)) = numbers.iter().find(|(_, x)| !x.is_finite()) {
            return Err(PrescriptionError::NotFinite { surface, column });
        }
        if !self.pose.is_finite() {
            return Err(PrescriptionError::NotFinite { surface, column: Column::Pose });
        }
        let semi = self.semi_diameter_mm;
        if semi <= 0.0 {
            return Err(PrescriptionError::NoAperture { surface, diameter_mm: 2.0 * semi });
        }
        if self.obstruction_mm < 0.0 || self.obstruction_mm >= semi {
            return Err(PrescriptionError::Obstruction { surface, diameter_mm: 2.0 * self.obstruction_mm });
        }
        let reach_mm = self.shape.reach_mm();
        if semi > reach_mm * (1.0 + RIM_ROUNDING) {
            return Err(PrescriptionError::Unreachable { surface, reach_mm, semi_diameter_mm: semi });
        }
        Ok(())
    }
}

impl Prescription {
    /// The lens with its moving groups at a zoom (nominal focal length, mm) and a travel of the focus, as
    /// [`MovingParts::values`] has them; from then on they stand still.
    pub fn at_position(&self, zoom_mm: f64, travel: f64) -> Self {
        let mut fixed = self.clone();
        if let Some(moving) = fixed.moving.take() {
            moving.place(&mut fixed.surfaces, zoom_mm, travel);
        }
        fixed
    }

    /// The lens with its moving parts at `values`, as a position of the table has them; from then on they stand still.
    pub fn with_parts(&self, values: &[f64]) -> Self {
        let mut fixed = self.clone();
        if let Some(moving) = fixed.moving.take() {
            moving.set(&mut fixed.surfaces, values);
        }
        fixed
    }

    /// The lens `factor` times as large, with all lengths of its surfaces, its film's radius and its moving parts. Its header stays.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let row = |row: &SurfaceRow| SurfaceRow {
            shape: row.shape.scaled(factor),
            pose: row.pose.scaled(factor),
            thickness_mm: row.thickness_mm * factor,
            semi_diameter_mm: row.semi_diameter_mm * factor,
            obstruction_mm: row.obstruction_mm * factor,
            behind: match &row.behind {
                NextMedium::Medium(medium) => NextMedium::Medium(medium.scaled(factor)),
                NextMedium::Mirror => NextMedium::Mirror,
            },
            ..row.clone()
        };
        Self {
            surfaces: self.surfaces.iter().map(row).collect(),
            film_radius_mm: self.film_radius_mm.map(|radius| radius * factor),
            moving: self.moving.as_ref().map(|moving| moving.scaled(factor)),
            ..self.clone()
        }
    }

    /// This lens with its surfaces in the first position of its moving parts.
    pub fn in_first_position(self) -> Self {
        let published = self.moving.as_ref().map(|moving| moving.first_zoom_mm());
        let surfaces = published.map(|zoom_mm| self.at_position(zoom_mm, 0.0).surfaces);
        Self { surfaces: surfaces.unwrap_or_else(|| self.surfaces.clone()), ..self }
    }

    /// Everything that decides where the lens sends light and how much of it, as text: the rows, and of each medium its indices,
    /// transmittances and gradient, whatever files they came from. Two lenses of one text are one lens.
    pub fn identity(&self) -> String {
        let mut text = format!("{:?} {} {:?} {:?}", self.surfaces, self.stop, self.film_radius_mm, self.moving);
        for row in &self.surfaces {
            if let NextMedium::Medium(medium) = &row.behind {
                let step_nm = 10.0;
                for nm in (0..=40).map(|i| VISIBLE_NM[0] + step_nm * f64::from(i)) {
                    text += &format!(" {:?} {:?}", medium.index(nm), medium.internal_transmittance(nm, 10.0));
                }
                text += &format!(" {:?}", medium.gradient());
            }
        }
        text
    }

    /// The media whose index is not known everywhere between two wavelengths, each once; beyond its range a medium keeps the index
    /// that it has at the end.
    pub fn media_beyond(&self, shortest_nm: f64, longest_nm: f64) -> Vec<&Medium> {
        let mut beyond: Vec<&Medium> = Vec::new();
        for row in &self.surfaces {
            if let NextMedium::Medium(medium) = &row.behind
                && !medium.is_known_between(shortest_nm, longest_nm)
                && !beyond.contains(&medium)
            {
                beyond.push(medium);
            }
        }
        beyond
    }

    /// Coats every surface of which nothing is known where glass meets air.
    pub(crate) fn coat(&mut self, coating: &Coating) {
        for i in self.in_air() {
            self.surfaces[i].coating.get_or_insert_with(|| coating.clone());
        }
    }

    /// The surfaces where glass meets air.
    pub(crate) fn in_air(&self) -> Vec<usize> {
        let mut before = Medium::air();
        let mut found = Vec::new();
        for (i, row) in self.surfaces.iter().enumerate() {
            if let NextMedium::Medium(behind) = &row.behind {
                if parts_glass_from_air(&before, behind) {
                    found.push(i);
                }
                before = behind.clone();
            }
        }
        found
    }

    /// The coating that is assumed where glass meets air and nothing is stated: none for an eye, for a lens the one that most have had
    /// since 1945.
    pub(crate) fn assumed_coating(&self) -> Coating {
        let name = if self.metadata.group == Some(LensGroup::Eye) { "none" } else { ASSUMED };
        Coating::parse(name).unwrap_or_default()
    }

    /// True if nothing is known of the coating of some surface where glass meets air, so that one is assumed.
    pub fn assumes_coatings(&self) -> bool {
        self.metadata.group != Some(LensGroup::Eye)
            && self.in_air().into_iter().any(|i| self.surfaces[i].coating.is_none())
    }

    /// Checks the lens; the error names its fault. Readers of files call it last.
    pub fn check(&self) -> Result<(), PrescriptionError> {
        if self.surfaces.is_empty() {
            return Err(PrescriptionError::Empty);
        }
        for (i, row) in self.surfaces.iter().enumerate() {
            row.check(i)?;
        }
        let surfaces = self.surfaces.len();
        if self.stop >= surfaces {
            return Err(PrescriptionError::NoSuchStop { stop: self.stop, surfaces });
        }
        let mut media = self.surfaces.iter().filter_map(|row| match &row.behind {
            NextMedium::Medium(medium) => Some(medium),
            NextMedium::Mirror => None,
        });
        if media.next_back().is_some_and(|medium| medium.gradient().is_some()) {
            return Err(PrescriptionError::GradientAtFilm { surface: surfaces - 1 });
        }
        match self.film_radius_mm {
            Some(radius_mm) if radius_mm == 0.0 || !radius_mm.is_finite() => {
                Err(PrescriptionError::FilmRadius { radius_mm })
            }
            _ => Ok(()),
        }
    }
}
