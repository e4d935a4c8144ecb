//! The closures of a program, and the shader nodes that they are.

use super::Operand;

/// The kind of a layer's closure. Inputs and options have Blender's names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "named after Blender's nodes")]
pub enum LayerKind {
    Principled,
    Diffuse,
    Glossy,
    Metallic,
    Glass,
    Refraction,
    Transparent,
    Translucent,
    Emission,
    Background,
    Sheen,
    Toon,
    Hair,
    PrincipledHair,
    Subsurface,
    Holdout,
    RayPortal,
    PrincipledVolume,
    VolumeScatter,
    VolumeAbsorption,
    VolumeCoefficients,
}

impl LayerKind {
    /// The closure of a shader node.
    pub(crate) fn of_node(node: &str) -> Option<Self> {
        Some(match node {
            "ShaderNodeBsdfPrincipled" => Self::Principled,
            "ShaderNodeBsdfDiffuse" => Self::Diffuse,
            "ShaderNodeBsdfGlossy" | "ShaderNodeBsdfAnisotropic" => Self::Glossy,
            "ShaderNodeBsdfMetallic" => Self::Metallic,
            "ShaderNodeBsdfGlass" => Self::Glass,
            "ShaderNodeBsdfRefraction" => Self::Refraction,
            "ShaderNodeBsdfTransparent" => Self::Transparent,
            "ShaderNodeBsdfTranslucent" => Self::Translucent,
            "ShaderNodeEmission" => Self::Emission,
            "ShaderNodeBackground" => Self::Background,
            "ShaderNodeBsdfSheen" | "ShaderNodeBsdfVelvet" => Self::Sheen,
            "ShaderNodeBsdfToon" => Self::Toon,
            "ShaderNodeBsdfHair" => Self::Hair,
            "ShaderNodeBsdfHairPrincipled" => Self::PrincipledHair,
            "ShaderNodeSubsurfaceScattering" => Self::Subsurface,
            "ShaderNodeHoldout" => Self::Holdout,
            "ShaderNodeBsdfRayPortal" => Self::RayPortal,
            "ShaderNodeVolumePrincipled" => Self::PrincipledVolume,
            "ShaderNodeVolumeScatter" => Self::VolumeScatter,
            "ShaderNodeVolumeAbsorption" => Self::VolumeAbsorption,
            "ShaderNodeVolumeCoefficients" => Self::VolumeCoefficients,
            _ => return None,
        })
    }
}

/// One closure of a surface or volume. Layers add up.
#[derive(Clone, Debug)]
pub struct Layer {
    /// The kind of the closure.
    pub kind: LayerKind,
    /// The layer's share: the factors of all Mix Shaders above it, multiplied.
    pub weight: Operand,
    /// Inputs by socket identifier. A normal or tangent that is not here is the surface's own.
    pub inputs: Vec<(String, Operand)>,
    /// Options that are words, such as `distribution`.
    pub options: Vec<(String, String)>,
    /// True of the emission of a colour that is plugged in where a shader belongs.
    pub is_bare_colour: bool,
}

impl Layer {
    /// An input by its socket's identifier.
    pub fn input(&self, identifier: &str) -> Option<Operand> {
        self.inputs.iter().find(|(name, _)| name == identifier).map(|(_, operand)| *operand)
    }

    /// An option by name.
    pub fn option(&self, name: &str) -> Option<&str> {
        self.options.iter().find(|(own, _)| own == name).map(|(_, word)| word.as_str())
    }
}
