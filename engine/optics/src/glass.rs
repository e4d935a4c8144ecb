//! Refractive index by wavelength, and the names under which lens files know it.
//!
//! Catalogue indices are relative to air, whose index is 1 exactly. Nothing here knows of surfaces.

mod catalogue;
mod dispersion;
mod gradient;
mod medium;
mod transmittance;

pub use catalogue::{Catalogue, GlassError};
pub use dispersion::{Dispersion, HERZBERGER};
pub use gradient::{Gradient, GradientTerm, LAST_GRADIENT_POWER};
pub use medium::{AIR_NAME, Medium, VISIBLE_NM, line_nm};
pub use transmittance::InternalTransmittance;
