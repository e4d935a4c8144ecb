//! Names of the parts of light that a render keeps.

use crate::error::{Error, invalid};
use petzval_render::integrator::path::parts::{LightPass, LobeKind};

const LOBES: [(&str, LobeKind); 3] =
    [("DIFFUSE", LobeKind::Diffuse), ("GLOSSY", LobeKind::Glossy), ("TRANSMISSION", LobeKind::Transmission)];

/// The part of that name: a kind of lobe or VOLUME with _DIRECT or _INDIRECT, a kind of lobe with _COLOR, EMISSION, ENVIRONMENT, AMBIENT_OCCLUSION,
/// DENOISING_ALBEDO, DENOISING_NORMAL, DENOISING_DEPTH, UV, MIST, or AOV_ and AOV_ALPHA_ with a number.
pub(crate) fn part(name: &str) -> Result<LightPass, Error> {
    if let Some(number) = name.strip_prefix("AOV_").and_then(|number| number.parse().ok()) {
        return Ok(LightPass::Aov(number));
    }
    if let Some(number) = name.strip_prefix("AOV_ALPHA_").and_then(|number| number.parse().ok()) {
        return Ok(LightPass::AovAlpha(number));
    }
    for (lobe, kind) in LOBES {
        match name.strip_prefix(lobe) {
            Some("_DIRECT") => return Ok(LightPass::Light(kind, true)),
            Some("_INDIRECT") => return Ok(LightPass::Light(kind, false)),
            Some("_COLOR") => return Ok(LightPass::Colour(kind)),
            _ => {}
        }
    }
    Ok(match name {
        "VOLUME_DIRECT" => LightPass::Volume(true),
        "VOLUME_INDIRECT" => LightPass::Volume(false),
        "EMISSION" => LightPass::Emission,
        "ENVIRONMENT" => LightPass::Environment,
        "AMBIENT_OCCLUSION" => LightPass::Occlusion,
        "DENOISING_ALBEDO" => LightPass::DenoisingAlbedo,
        "DENOISING_NORMAL" => LightPass::DenoisingNormal,
        "DENOISING_DEPTH" => LightPass::DenoisingDepth,
        "UV" => LightPass::Uv,
        "MIST" => LightPass::Mist,
        other => return Err(invalid(format!("there is no part of light '{other}'"))),
    })
}
