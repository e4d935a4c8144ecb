//! Units of the measures of effects.

/// A unit of the measures of effects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Pixels of this picture by which light is moved.
    Pixels,
    /// Powers of two of brightness.
    Stops,
    /// Light added, as a part of the picture's mean brightness.
    Exposure,
}

impl Unit {
    /// The text of the unit behind a number.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pixels => "px",
            Self::Stops => "stops",
            Self::Exposure => "of exposure",
        }
    }

    /// The tolerance below which effects are left out, at quality 1: half a pixel, a fiftieth of a stop, a 255th of the exposure.
    pub fn tolerance(self, quality: f64) -> f64 {
        let coarse = match self {
            Self::Pixels => 0.5,
            Self::Stops => 0.02,
            Self::Exposure => 1.0 / 255.0,
        };
        coarse / quality
    }
}
