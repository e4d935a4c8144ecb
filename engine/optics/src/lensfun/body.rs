//! Camera bodies of a lensfun database.

use super::calibrated_lens::full_name;

/// A camera body.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// The maker.
    pub maker: String,
    /// The model; its English name where there are several.
    pub model: String,
    /// [`super::FULL_DIAGONAL_MM`] over the sensor's diagonal.
    pub crop_factor: f64,
}

impl Body {
    /// Maker and model; the maker only once.
    pub fn name(&self) -> String {
        full_name(&self.maker, &self.model)
    }
}
