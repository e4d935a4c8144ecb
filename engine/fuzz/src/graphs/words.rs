//! Names of Blender's nodes, of their sockets and of their options, all that the compiler of graphs knows.

/// Nodes, after `ShaderNode`.
pub(super) const KINDS: [&str; 94] = [
    "AddShader", "AmbientOcclusion", "Attribute", "Background", "Bevel", "Blackbody", "BrightContrast",
    "BsdfAnisotropic", "BsdfDiffuse", "BsdfGlass", "BsdfGlossy", "BsdfHair", "BsdfHairPrincipled", "BsdfMetallic",
    "BsdfPrincipled", "BsdfRayPortal", "BsdfRefraction", "BsdfSheen", "BsdfToon", "BsdfTranslucent",
    "BsdfTransparent", "BsdfVelvet", "Bump", "CameraData", "Clamp", "CombineColor", "CombineHSV", "CombineRGB",
    "CombineXYZ", "Displacement", "Emission", "FloatCurve", "Fresnel", "Gamma", "HairInfo", "Holdout",
    "HueSaturation", "Invert", "LayerWeight", "LightFalloff", "LightPath", "MapRange", "Mapping", "Math", "Mix",
    "MixRGB", "MixShader", "NewGeometry", "Normal", "NormalMap", "ObjectInfo", "ParticleInfo", "PointInfo", "RGB",
    "RGBCurve", "RGBToBW", "RadialTiling", "Raycast", "SeparateColor", "SeparateHSV", "SeparateRGB", "SeparateXYZ",
    "SubsurfaceScattering", "Tangent", "TexBrick", "TexChecker", "TexCoord", "TexEnvironment", "TexGabor",
    "TexGradient", "TexIES", "TexImage", "TexMagic", "TexNoise", "TexSky", "TexVoronoi", "TexWave", "TexWhiteNoise",
    "UVMap", "ValToRGB", "Value", "VectorCurve", "VectorDisplacement", "VectorMath", "VectorRotate",
    "VectorTransform", "VertexColor", "VolumeAbsorption", "VolumeCoefficients", "VolumeInfo", "VolumePrincipled",
    "VolumeScatter", "Wavelength", "Wireframe",
];

/// Sockets of inputs, of all nodes.
pub(super) const INPUTS: [&str; 124] = [
    "A_Color", "A_Float", "A_Vector", "Alpha", "Angle", "Anisotropic", "Anisotropic Rotation", "Anisotropy",
    "Aspect Ratio", "Axis", "B_Color", "B_Float", "B_Vector", "Base Color", "Bias", "Blend", "Brick Width", "Bright",
    "Center", "Coat", "Coat IOR", "Coat Roughness", "Coat Tint", "Coat Weight", "Color", "Color1", "Color2",
    "Contrast", "Detail", "Detail Roughness", "Detail Scale", "Diffuse Roughness", "Direction", "Distance",
    "Distortion", "Emission Color", "Emission Strength", "Exponent", "Fac", "Factor", "Factor_Float", "Factor_Vector",
    "Filter Width", "Frequency", "From Max", "From Min", "From_Max_FLOAT3", "From_Min_FLOAT3", "Gain", "Gamma",
    "Height", "Hue", "IOR", "Image", "Lacunarity", "Length", "Location", "Max", "Melanin", "Melanin Redness",
    "Metallic", "Midlevel", "Min", "Mortar", "Mortar Size", "Mortar Smooth", "Normal", "Offset", "Orientation 2D",
    "Orientation 3D", "Phase Offset", "Position", "R lobe", "Radial Roughness", "Radius", "Random", "Random Color",
    "Random Roughness", "Randomness", "Rotation", "Roughness", "RoughnessU", "RoughnessV", "Roundness", "Row Height",
    "Saturation", "Scale", "Shader", "Shader_001", "Sheen Roughness", "Sheen Tint", "Sheen Weight", "Sides", "Size",
    "Smooth", "Smoothness", "Specular IOR Level", "Specular Tint", "Steps", "Steps_FLOAT3", "Strength",
    "Subsurface Anisotropy", "Subsurface IOR", "Subsurface Radius", "Subsurface Scale", "Subsurface Weight",
    "TRT lobe", "TT lobe", "Temperature", "Thin Film IOR", "Thin Film Thickness", "To Max", "To Min", "To_Max_FLOAT3",
    "To_Min_FLOAT3", "Transmission Weight", "Value", "Value_001", "Value_002", "Vector", "Vector_001", "Vector_002",
    "W", "Wavelength",
];

/// Sockets of outputs, of all nodes.
pub(super) const OUTPUTS: [&str; 144] = [
    "AO", "A_Color", "A_Float", "A_Vector", "Age", "Alpha", "Angle", "Angular Velocity", "Anisotropy", "Axis", "BSDF",
    "BSSRDF", "B_Color", "B_Float", "B_Vector", "Backfacing", "Bias", "Blend", "Brick Width", "Bright", "Camera",
    "Center", "Color", "Color1", "Color2", "Contrast", "Density", "Detail", "Detail Roughness", "Detail Scale",
    "Displacement", "Distance", "Distortion", "Dot", "Emission", "Exponent", "Fac", "Facing", "Factor",
    "Factor_Float", "Factor_Vector", "Flame", "Frequency", "Fresnel", "Gain", "Gamma", "Generated", "Height",
    "Hit Distance", "Hit Normal", "Hit Position", "Hue", "IOR", "Image", "Incoming", "Index", "Intensity",
    "Intercept", "Is Hit", "Is Strand", "Lacunarity", "Length", "Lifetime", "Location", "Material Index", "Max",
    "Midlevel", "Min", "Mortar", "Mortar Size", "Mortar Smooth", "Normal", "Object", "Object Index", "Offset",
    "Orientation 2D", "Orientation 3D", "Parametric", "Phase", "Phase Offset", "Pointiness", "Position", "Radius",
    "Random", "Random Per Island", "Randomness", "Reflection", "Result", "Result_Color", "Result_Float",
    "Result_Vector", "Rotation", "Roughness", "Roundness", "Row Height", "Saturation", "Scale", "Segment Coordinates",
    "Segment ID", "Segment Rotation", "Segment Width", "Self Hit", "Shader", "Sides", "Size", "Smooth", "Smoothness",
    "Strength", "Tangent", "Tangent Normal", "Temperature", "Thickness", "True Normal", "UV", "Val", "Value",
    "Value_001", "Value_002", "Vector", "Vector_001", "Vector_002", "Velocity", "View Distance", "View Vector",
    "View Z Depth", "Volume", "W", "Wavelength", "Window", "aerosol_density", "air_density", "altitude",
    "dust_density", "ground_albedo", "offset", "ozone_density", "projection_blend", "squash", "sun_elevation",
    "sun_intensity", "sun_rotation", "sun_size", "turbidity", "value",
];

/// Options that are words, of all nodes, each with the words that a node knows.
pub(super) const OPTIONS: [(&str, &[&str]); 56] = [
    ("alpha_is_transparency", &["false", "true"]), ("attribute_name", &["UVMap", "colour", "density"]),
    ("attribute_type", &["GEOMETRY", "INSTANCER", "OBJECT", "VIEW_LAYER"]), ("axis", &["X", "Y", "Z"]),
    ("blend_type", &["ADD", "BURN", "COLOR", "DARKEN", "DIFFERENCE", "DIVIDE", "DODGE", "EXCLUSION", "HUE", "LIGHTEN", "LINEAR_LIGHT", "MIX", "MULTIPLY", "OVERLAY", "SATURATION", "SCREEN", "SOFT_LIGHT", "SUBTRACT", "VALUE"]),
    ("cell_hash", &["LOOKUP3", "PCG"]), ("clamp", &["false", "true"]), ("clamp_factor", &["false", "true"]),
    ("clamp_result", &["false", "true"]), ("clamp_type", &["RANGE", "UVMap"]),
    ("component", &["Reflection", "Transmission"]), ("convention", &["DIRECTX", "UVMap"]),
    ("convert_from", &["CAMERA", "OBJECT", "WORLD"]), ("convert_to", &["CAMERA", "OBJECT", "WORLD"]),
    ("data_type", &["FLOAT", "FLOAT_VECTOR", "RGBA", "UVMap", "VECTOR"]), ("direction_type", &["UVMap", "UV_MAP"]),
    ("distance", &["CHEBYCHEV", "EUCLIDEAN", "MANHATTAN", "MINKOWSKI"]),
    ("distribution", &["ASHIKHMIN_SHIRLEY", "BECKMANN", "GGX", "MULTI_GGX", "SHARP"]),
    ("extension", &["CLIP", "EXTEND", "MIRROR", "REPEAT"]), ("extrapolate", &["false", "true"]),
    ("factor_mode", &["NON_UNIFORM", "UVMap"]),
    ("falloff", &["BURLEY", "RANDOM_WALK", "RANDOM_WALK_LEGACY", "RANDOM_WALK_SKIN"]),
    ("feature", &["DISTANCE_TO_EDGE", "F1", "F2", "N_SPHERE_RADIUS", "SMOOTH_F1"]),
    ("fresnel_type", &["F82", "PHYSICAL_CONDUCTOR"]), ("from_instancer", &["false", "true"]),
    ("gabor_type", &["2D", "3D"]),
    ("gradient_type", &["DIAGONAL", "EASING", "LINEAR", "QUADRATIC", "QUADRATIC_SPHERE", "RADIAL", "SPHERICAL"]),
    ("ies_text", &["TILT=NONE\n1 1 1 3 1 1 2 0 0 0 1 1 1 0 45 90 0 3 2 1"]), ("inside", &["false", "true"]),
    ("interpolate", &["false", "true"]), ("interpolation", &["Closest", "Cubic", "Linear"]),
    ("interpolation_type", &["LINEAR", "SMOOTHERSTEP", "SMOOTHSTEP", "STEPPED"]), ("invert", &["false", "true"]),
    ("layer_name", &["UVMap"]), ("mode", &["HSL", "HSV", "RGB"]), ("model", &["CHIANG", "HUANG"]),
    ("noise_dimensions", &["1D", "2D", "3D", "4D"]),
    ("noise_type", &["FBM", "HETERO_TERRAIN", "HYBRID_MULTIFRACTAL", "MULTIFRACTAL", "RIDGED_MULTIFRACTAL"]),
    ("normalize", &["false", "true"]), ("only_local", &["false", "true"]),
    ("operation", &["ABSOLUTE", "ADD", "ARCCOSINE", "ARCSINE", "ARCTAN2", "ARCTANGENT", "CEIL", "COMPARE", "COSH", "COSINE", "CROSS_PRODUCT", "DEGREES", "DISTANCE", "DIVIDE", "DOT_PRODUCT", "EXPONENT", "FACEFORWARD", "FLOOR", "FLOORED_MODULO", "FRACT", "FRACTION", "GREATER_THAN", "INVERSE_SQRT", "LENGTH", "LESS_THAN", "LOGARITHM", "MAXIMUM", "MINIMUM", "MODULO", "MULTIPLY", "MULTIPLY_ADD", "NORMALIZE", "PINGPONG", "POWER", "PROJECT", "RADIANS", "REFLECT", "REFRACT", "ROUND", "SCALE", "SIGN", "SINE", "SINH", "SMOOTH_MAX", "SMOOTH_MIN", "SNAP", "SQRT", "SUBTRACT", "TANGENT", "TANH", "TRUNC", "WRAP"]),
    ("parametrization", &["ABSORPTION", "COLOR", "MELANIN"]),
    ("phase", &["DRAINE", "FOURNIER_FORAND", "HENYEY_GREENSTEIN", "MIE", "RAYLEIGH"]),
    ("projection", &["BOX", "EQUIRECTANGULAR", "FLAT", "MIRROR_BALL", "SPHERE", "TUBE"]),
    ("rotation_type", &["AXIS_ANGLE", "EULER_XYZ", "X_AXIS", "Y_AXIS", "Z_AXIS"]),
    ("sky_type", &["HOSEK_WILKIE", "MULTIPLE_SCATTERING", "NISHITA", "PREETHAM", "SINGLE_SCATTERING", "UVMap"]),
    ("space", &["BLENDER_OBJECT", "BLENDER_WORLD", "CAMERA", "OBJECT", "TANGENT", "WORLD"]),
    ("subsurface_method", &["BURLEY", "RANDOM_WALK", "RANDOM_WALK_LEGACY", "RANDOM_WALK_SKIN"]),
    ("sun_disc", &["false", "true"]), ("use_clamp", &["false", "true"]), ("use_pixel_size", &["false", "true"]),
    ("uv_map", &["UVMap"]), ("vector_type", &["NORMAL", "POINT", "TEXTURE", "VECTOR"]),
    ("voronoi_dimensions", &["1D", "2D", "3D", "4D"]), ("wave_profile", &["SAW", "SIN", "TRI"]),
    ("wave_type", &["BANDS", "RINGS"]),
];

/// Options that are numbers, or lists of them.
pub(super) const NUMBERS: [&str; 22] = [
    "aerosol_density", "air_density", "altitude", "dust_density", "ground_albedo", "image", "object_matrix", "offset",
    "ozone_density", "projection_blend", "range", "samples", "squash", "sun_direction", "sun_elevation",
    "sun_intensity", "sun_rotation", "sun_size", "table", "turbidity", "turbulence_depth", "value",
];
