//! Names of the parts of light that a render keeps.

use crate::error::{Error, refused};
use petzval_render::integrator::path::parts::{LobeKind, Part};

const LOBES: [(&str, LobeKind); 3] =
    [("DIFFUSE", LobeKind::Diffuse), ("GLOSSY", LobeKind::Glossy), ("TRANSMISSION", LobeKind::Transmission)];

/// The part of that name: a kind of lobe or VOLUME with _DIRECT or _INDIRECT, a kind of lobe with _COLOR, EMISSION, ENVIRONMENT,
/// DENOISING_ALBEDO, DENOISING_NORMAL, DENOISING_DEPTH, UV, MIST, or AOV_ and AOV_ALPHA_ with a number.
pub(crate) fn part(name: &str) -> Result<Part, Error> {
    if let Some(number) = name.strip_prefix("AOV_").and_then(|number| number.parse().ok()) {
        return Ok(Part::Aov(number));
    }
    if let Some(number) = name.strip_prefix("AOV_ALPHA_").and_then(|number| number.parse().ok()) {
        return Ok(Part::AovAlpha(number));
    }
    for (lobe, kind) in LOBES {
        match name.strip_prefix(lobe) {
            Some("_DIRECT") => return Ok(Part::Light(kind, true)),
            Some("_INDIRECT") => return Ok(Part::Light(kind, false)),
            Some("_COLOR") => return Ok(Part::Colour(kind)),
            _ => {}
        }
    }
    Ok(match name {
        "VOLUME_DIRECT" => Part::Volume(true),
        "VOLUME_INDIRECT" => Part::Volume(false),
        "EMISSION" => Part::Emission,
        "ENVIRONMENT" => Part::Environment,
        "DENOISING_ALBEDO" => Part::DenoisingAlbedo,
        "DENOISING_NORMAL" => Part::DenoisingNormal,
        "DENOISING_DEPTH" => Part::DenoisingDepth,
        "UV" => Part::Uv,
        "MIST" => Part::Mist,
        other => return Err(refused(format!("there is no part of light '{other}'"))),
    })
}
