# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes with every option that they have, for the comparison with Cycles: plain lists, no bpy.

An input is a number, a tuple, or the name of something that varies over the surface: `local` (a vector from -1 to 1),
`colour` (from 0 to 1), `wide` (from -1.5 to 1.9), `x`, `y`, `z` (parts of `local`), `x01` (x from 0 to 1), `tilted` (a
normal that leans), `bumped` (one that Bump gives), `noise`, `noise generated`, `noise object`, `noise uv` (the Noise
texture over such coordinates).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import product
from typing import Any


@dataclass(frozen=True)
class Case:
    """One output of one node, set as the options and inputs say."""

    kind: str
    output: str
    options: dict[str, Any] = field(default_factory=dict)
    inputs: dict[str, Any] = field(default_factory=dict)
    #: Of the values; smooth arithmetic in single precision keeps 1e-4.
    tolerance: float = 1e-4
    #: The share of points that may lie on the other side of a jump: where two programs round differently.
    jumps: float = 0.0
    #: What is set in the node's curves, ramp or sidebar: a name that the stage knows.
    curves: str = ""

    @property
    def name(self) -> str:
        """For the test's name."""
        parts = [str(value) for value in self.options.values()]
        parts += [f"{key}={value}" for key, value in self.inputs.items() if key != "Vector"]
        return "-".join([self.kind.removeprefix("ShaderNode"), self.output, self.curves, *parts]).replace(" ", "")


def _words(text: str) -> list[str]:
    return text.split()


MATH = _words("""ADD SUBTRACT MULTIPLY DIVIDE MULTIPLY_ADD POWER LOGARITHM SQRT INVERSE_SQRT ABSOLUTE EXPONENT MINIMUM MAXIMUM
LESS_THAN GREATER_THAN SIGN COMPARE SMOOTH_MIN SMOOTH_MAX ROUND FLOOR CEIL TRUNC FRACT MODULO FLOORED_MODULO WRAP SNAP
PINGPONG SINE COSINE TANGENT ARCSINE ARCCOSINE ARCTANGENT ARCTAN2 SINH COSH TANH RADIANS DEGREES""")
VECTOR_MATH = _words("""ADD SUBTRACT MULTIPLY DIVIDE MULTIPLY_ADD CROSS_PRODUCT PROJECT REFLECT REFRACT FACEFORWARD DOT_PRODUCT
DISTANCE LENGTH SCALE NORMALIZE ABSOLUTE POWER SIGN MINIMUM MAXIMUM ROUND FLOOR CEIL FRACTION MODULO WRAP SNAP SINE COSINE
TANGENT""")
BLENDS = _words("""MIX DARKEN MULTIPLY BURN LIGHTEN SCREEN DODGE ADD OVERLAY SOFT_LIGHT LINEAR_LIGHT DIFFERENCE EXCLUSION SUBTRACT
DIVIDE HUE SATURATION COLOR VALUE""")
STEPPED = {"ROUND", "FLOOR", "CEIL", "TRUNC", "FRACT", "FRACTION", "MODULO", "FLOORED_MODULO", "WRAP", "SNAP"}


def maths() -> list[Case]:
    cases = []
    for operation in MATH:
        # Where tiny differences decide a step, a point in fifty may fall otherwise.
        jumps = 0.02 if operation in STEPPED else 0.0
        for second, third in ((0.37, 0.2), ("y", "z")):
            inputs = {"Value": "x", "Value_001": second, "Value_002": third}
            cases.append(Case("ShaderNodeMath", "Value", {"operation": operation}, inputs, jumps=jumps))
    cases.append(Case("ShaderNodeMath", "Value", {"operation": "ADD", "use_clamp": True}, {"Value": "x"}))
    for operation in VECTOR_MATH:
        output = "Value" if operation in {"DOT_PRODUCT", "DISTANCE", "LENGTH"} else "Vector"
        inputs = {"Vector": "local", "Vector_001": "colour", "Vector_002": (0.3, -0.4, 0.5), "Scale": 0.7}
        jumps = 0.02 if operation in STEPPED else 0.0
        cases.append(Case("ShaderNodeVectorMath", output, {"operation": operation}, inputs, jumps=jumps))
    for kind, clamp in product(("LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP"), (True, False)):
        options = {"data_type": "FLOAT", "interpolation_type": kind, "clamp": clamp}
        for low, high in ((-0.5, 0.4), (0.6, -0.3), (0.2, 0.2)):
            inputs = {"Value": "x", "From Min": low, "From Max": high, "To Min": 2.0, "To Max": -1.0, "Steps": 3.0}
            cases.append(Case("ShaderNodeMapRange", "Result", options, inputs, jumps=0.02))
        options = {**options, "data_type": "FLOAT_VECTOR"}
        inputs = {
            "Vector": "local",
            "From_Min_FLOAT3": (-0.5, 0.6, 0.2),
            "From_Max_FLOAT3": (0.4, -0.3, 0.2),
            "To_Min_FLOAT3": (2.0, 1.0, 0.5),
            "To_Max_FLOAT3": (-1.0, 3.0, 0.7),
            "Steps_FLOAT3": (3.0, 2.0, 4.0),
        }
        cases.append(Case("ShaderNodeMapRange", "Vector", options, inputs, jumps=0.02))
    for kind in ("MINMAX", "RANGE"):
        for low, high in ((-0.2, 0.5), (0.5, -0.2)):
            inputs = {"Value": "x", "Min": low, "Max": high}
            cases.append(Case("ShaderNodeClamp", "Result", {"clamp_type": kind}, inputs))
    for kind in ("POINT", "TEXTURE", "VECTOR", "NORMAL"):
        inputs = {
            "Vector": "local",
            "Location": (0.3, -1.0, 2.0),
            "Rotation": (0.4, 0.9, -1.3),
            "Scale": (2.0, 0.5, -1.5),
        }
        cases.append(Case("ShaderNodeMapping", "Vector", {"vector_type": kind}, inputs))
    for kind, invert in product(("AXIS_ANGLE", "X_AXIS", "Y_AXIS", "Z_AXIS", "EULER_XYZ"), (False, True)):
        inputs = {
            "Vector": "local",
            "Center": (0.2, 0.1, -0.4),
            "Axis": (1.0, 2.0, -0.5),
            "Angle": 0.8,
            "Rotation": (0.4, 0.9, -1.3),
        }
        cases.append(Case("ShaderNodeVectorRotate", "Vector", {"rotation_type": kind, "invert": invert}, inputs))
    for kind, pair in product(
        ("POINT", "VECTOR", "NORMAL"), (("WORLD", "OBJECT"), ("OBJECT", "CAMERA"), ("CAMERA", "WORLD"))
    ):
        options = {"vector_type": kind, "convert_from": pair[0], "convert_to": pair[1]}
        cases.append(Case("ShaderNodeVectorTransform", "Vector", options, {"Vector": "local"}))
    cases += [Case("ShaderNodeNormal", output, {}, {"Normal": "local"}) for output in ("Normal", "Dot")]
    cases += [Case("ShaderNodeSeparateXYZ", output, {}, {"Vector": "local"}) for output in "XYZ"]
    cases.append(Case("ShaderNodeCombineXYZ", "Vector", {}, {"X": "y", "Y": 0.5, "Z": "local"}))
    return cases


def colours() -> list[Case]:
    cases = []
    for blend in BLENDS:
        inputs = {"Factor_Float": "x01", "A_Color": "colour", "B_Color": (0.7, 0.25, 0.4, 1.0)}
        options = {"data_type": "RGBA", "blend_type": blend}
        cases.append(Case("ShaderNodeMix", "Result_Color", options, inputs))
        inputs = {"Factor_Float": 0.8, "A_Color": (0.3, 0.6, 0.1, 1.0), "B_Color": "colour"}
        cases.append(Case("ShaderNodeMix", "Result_Color", {**options, "clamp_result": True}, inputs))
        inputs = {"Factor_Float": 0.6, "A_Color": "wide", "B_Color": (0.7, 0.0, 1.6, 1.0)}
        cases.append(Case("ShaderNodeMix", "Result_Color", options, inputs))
    for clamp in (True, False):
        inputs = {"Factor_Float": "x", "A_Float": 0.3, "B_Float": "y"}
        cases.append(Case("ShaderNodeMix", "Result_Float", {"data_type": "FLOAT", "clamp_factor": clamp}, inputs))
        inputs = {"Factor_Float": "x", "Factor_Vector": "wide", "A_Vector": "local", "B_Vector": (1.0, 2.0, 3.0)}
        for mode in ("UNIFORM", "NON_UNIFORM"):
            options = {"data_type": "VECTOR", "factor_mode": mode, "clamp_factor": clamp}
            cases.append(Case("ShaderNodeMix", "Result_Vector", options, inputs))
    inputs = {"Fac": "x", "Color1": "colour", "Color2": (0.2, 0.9, 0.4, 1.0)}
    cases.append(Case("ShaderNodeMixRGB", "Color", {"blend_type": "OVERLAY", "use_clamp": True}, inputs))
    for output in ("Color", "Alpha"):
        for ramp in ("linear", "constant", "ease", "cardinal", "b_spline", "hsv_near", "hsv_far", "hsl_cw", "hsl_ccw"):
            cases.append(Case("ShaderNodeValToRGB", output, {}, {"Fac": "x"}, jumps=0.02, curves=ramp))
    for curves in ("straight", "bent", "bent_ends"):
        cases.append(Case("ShaderNodeRGBCurve", "Color", {}, {"Fac": 0.8, "Color": "wide"}, curves=curves))
        cases.append(Case("ShaderNodeVectorCurve", "Vector", {}, {"Fac": 0.8, "Vector": "wide"}, curves=curves))
        cases.append(Case("ShaderNodeFloatCurve", "Value", {}, {"Factor": 0.8, "Value": "x"}, curves=curves))
    for colour in ("colour", "wide"):
        inputs = {"Hue": 0.7, "Saturation": 1.3, "Value": 0.9, "Fac": 0.8, "Color": colour}
        cases.append(Case("ShaderNodeHueSaturation", "Color", {}, inputs))
        cases.append(Case("ShaderNodeBrightContrast", "Color", {}, {"Color": colour, "Bright": 0.2, "Contrast": 0.6}))
        cases.append(Case("ShaderNodeGamma", "Color", {}, {"Color": colour, "Gamma": 2.2}))
        cases.append(Case("ShaderNodeInvert", "Color", {}, {"Color": colour, "Fac": 0.7}))
        cases.append(Case("ShaderNodeRGBToBW", "Val", {}, {"Color": colour}))
        for model in ("RGB", "HSV", "HSL"):
            for output in ("Red", "Green", "Blue"):
                cases.append(Case("ShaderNodeSeparateColor", output, {"mode": model}, {"Color": colour}))
    for model in ("RGB", "HSV", "HSL"):
        inputs = {"Red": "x01", "Green": 0.7, "Blue": 0.4}
        cases.append(Case("ShaderNodeCombineColor", "Color", {"mode": model}, inputs))
    # The same physics by another sum: Cycles fits Planck's law by parts, and the observer's table is rounded.
    for kelvin in (900.0, 1500.0, 2500.0, 4000.0, 6500.0, 11000.0, 20000.0):
        cases.append(Case("ShaderNodeBlackbody", "Color", {}, {"Temperature": kelvin}, tolerance=2e-3))
    for nm in (350.0, 400.0, 450.0, 520.0, 589.0, 650.0, 700.0):
        cases.append(Case("ShaderNodeWavelength", "Color", {}, {"Wavelength": nm}, tolerance=2e-4))
    return cases


def noises() -> list[Case]:
    cases = []
    fractals = ("FBM", "MULTIFRACTAL", "RIDGED_MULTIFRACTAL", "HYBRID_MULTIFRACTAL", "HETERO_TERRAIN")
    for dimensions, fractal in product(("1D", "2D", "3D", "4D"), fractals):
        inputs = {"Vector": "local", "W": "x", "Scale": 2.3, "Detail": 2.6, "Roughness": 0.6, "Lacunarity": 2.1}
        inputs |= {"Offset": 0.4, "Gain": 1.3}
        for normalize in (True, False) if fractal == "FBM" else (False,):
            options = {"noise_dimensions": dimensions, "noise_type": fractal, "normalize": normalize}
            cases.append(Case("ShaderNodeTexNoise", "Fac", options, inputs))
            # Places some hundred units off lose two digits, and four octaves magnify that.
            distorted = {**inputs, "Distortion": 0.8, "Detail": 3.0}
            cases.append(Case("ShaderNodeTexNoise", "Color", options, distorted, tolerance=5e-4))
    for dimensions in ("1D", "2D", "3D", "4D"):
        # Far out, where Blender folds the coordinates: single precision keeps two digits there.
        inputs = {"Vector": "local", "W": "x", "Scale": 3e5, "Detail": 0.0}
        cases.append(Case("ShaderNodeTexNoise", "Fac", {"noise_dimensions": dimensions}, inputs, tolerance=0.02))
        for output in ("Value", "Color"):
            inputs = {"Vector": "local", "W": "y"}
            cases.append(Case("ShaderNodeTexWhiteNoise", output, {"noise_dimensions": dimensions}, inputs))
    return cases


def voronois() -> list[Case]:
    cases = []
    base = {
        "Vector": "local",
        "W": "x",
        "Scale": 2.3,
        "Roughness": 0.6,
        "Lacunarity": 2.1,
        "Smoothness": 0.7,
        "Exponent": 1.7,
    }
    for dimensions, feature, normalize in product(
        ("1D", "2D", "3D", "4D"), ("F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE", "N_SPHERE_RADIUS"), (False, True)
    ):
        metrics = ("EUCLIDEAN", "MANHATTAN", "CHEBYCHEV", "MINKOWSKI")
        plain = feature in {"DISTANCE_TO_EDGE", "N_SPHERE_RADIUS"} or dimensions == "1D"
        for metric in metrics[:1] if plain else metrics:
            options = {
                "voronoi_dimensions": dimensions,
                "feature": feature,
                "distance": metric,
                "normalize": normalize,
            }
            outputs = ["Distance"]
            if feature == "N_SPHERE_RADIUS":
                outputs = ["Radius"]
            elif feature != "DISTANCE_TO_EDGE":
                outputs += ["Color"]
                outputs += ["Position"] if dimensions != "1D" else []
                outputs += ["W"] if dimensions in {"1D", "4D"} else []
            for output in outputs:
                for detail, randomness in ((0.0, 1.0), (1.6, 0.8)):
                    inputs = {**base, "Detail": detail, "Randomness": randomness}
                    # A point as near to two others as can be told may take either.
                    cases.append(Case("ShaderNodeTexVoronoi", output, options, inputs, jumps=0.02))
    return cases


def patterns() -> list[Case]:
    cases = []
    wave = {
        "Vector": "local",
        "Scale": 1.3,
        "Distortion": 0.0,
        "Detail": 1.5,
        "Detail Scale": 1.2,
        "Detail Roughness": 0.4,
    }
    wave["Phase Offset"] = 0.7
    for profile, distortion in product(("SIN", "SAW", "TRI"), (0.0, 1.5)):
        inputs = {**wave, "Distortion": distortion}
        for kind, word, axes in (("BANDS", "bands_direction", "DIAGONAL"), ("RINGS", "rings_direction", "SPHERICAL")):
            for axis in ("X", "Y", "Z", axes):
                options = {"wave_type": kind, word: axis, "wave_profile": profile}
                cases.append(Case("ShaderNodeTexWave", "Color", options, inputs, tolerance=3e-4, jumps=0.02))
    for depth in range(11):
        inputs = {"Vector": "local", "Scale": 1.4, "Distortion": 0.8}
        # Each further turn feeds the rounding of the one before through sines of five times its size.
        cases.append(Case("ShaderNodeTexMagic", "Color", {"turbulence_depth": depth}, inputs, tolerance=1e-3))
    cases.append(Case("ShaderNodeTexMagic", "Fac", {}, {"Vector": "local", "Scale": 1.4, "Distortion": 0.0}))
    for kind in ("LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "RADIAL", "QUADRATIC_SPHERE", "SPHERICAL"):
        cases.append(Case("ShaderNodeTexGradient", "Fac", {"gradient_type": kind}, {"Vector": "local"}))
    for output in ("Color", "Fac"):
        inputs = {"Vector": "local", "Scale": 3.3, "Color1": (0.1, 0.2, 0.3, 1.0), "Color2": "colour"}
        cases.append(Case("ShaderNodeTexChecker", output, {}, inputs, jumps=0.02))
        for smooth, frequency in product((0.0, 0.4), (1, 2, 3)):
            inputs = {
                "Vector": "local",
                "Color1": (0.8, 0.2, 0.3, 1.0),
                "Color2": "colour",
                "Mortar": (0.0, 0.1, 0.0, 1.0),
                "Scale": 5.3,
                "Mortar Size": 0.05,
                "Mortar Smooth": smooth,
                "Bias": 0.2,
                "Brick Width": 0.6,
                "Row Height": 0.3,
            }
            options = {"offset": 0.4, "squash": 0.7, "offset_frequency": frequency, "squash_frequency": 4 - frequency}
            cases.append(Case("ShaderNodeTexBrick", output, options, inputs, tolerance=2e-4, jumps=0.02))
    return cases


def skies() -> list[Case]:
    cases = []
    for kind, anisotropy, output in product(("2D", "3D"), (1.0, 0.4), ("Value", "Phase", "Intensity")):
        inputs = {"Vector": "local", "Scale": 2.3, "Frequency": 1.7, "Anisotropy": anisotropy}
        inputs["Orientation 2D" if kind == "2D" else "Orientation 3D"] = 0.6 if kind == "2D" else (0.5, 0.7, 0.4)
        cases.append(Case("ShaderNodeTexGabor", output, {"gabor_type": kind}, inputs, jumps=0.02))
    tiled = ("Segment Coordinates", "Segment ID", "Segment Width", "Segment Rotation")
    # Whole numbers of sides, others, whose last segment is narrower, and a half plane.
    for sides, roundness in product((2.0, 3.0, 5.0, 2.4, 5.7), (0.0, 0.35, 1.0)):
        # Of two sides the corners are infinitely far away, where single precision has no numbers.
        if sides == 2.0 and roundness == 0.35:
            continue
        for output, normalize in product(tiled, (False, True)):
            inputs = {"Vector": "local", "Sides": sides, "Roundness": roundness}
            cases.append(Case("ShaderNodeRadialTiling", output, {"normalize": normalize}, inputs, jumps=0.02))
    for sides, roundness in (("wide", 0.3), (4.3, "x01")):
        inputs = {"Vector": "local", "Sides": sides, "Roundness": roundness}
        cases.append(Case("ShaderNodeRadialTiling", tiled[0], {"normalize": True}, inputs, jumps=0.02))
    for sun in ((0.3, -0.4, 0.866), (0.0, 0.9, 0.436)):
        for turbidity in (2.2, 6.0):
            options = {"sky_type": "PREETHAM", "sun_direction": sun, "turbidity": turbidity}
            # Before 5.0 Blender's white was rounded otherwise, by about this.
            cases.append(Case("ShaderNodeTexSky", "Color", options, {"Vector": "tilted"}, tolerance=5e-4))
            options = {**options, "sky_type": "HOSEK_WILKIE", "ground_albedo": 0.3}
            cases.append(Case("ShaderNodeTexSky", "Color", options, {"Vector": "tilted"}, tolerance=5e-4))
    # Blender 4 has the first, 5 the others.
    scattered = ("NISHITA", "SINGLE_SCATTERING", "MULTIPLE_SCATTERING")
    for kind, elevation, altitude in product(scattered, (0.05, 0.7, -0.03, 2.0), (0.0, 8000.0)):
        dust = "dust_density" if kind == "NISHITA" else "aerosol_density"
        options = {
            "sky_type": kind, "sun_disc": False, "sun_elevation": elevation, "sun_rotation": 0.9, "altitude": altitude,
            "air_density": 1.2, dust: 0.7, "ozone_density": 1.5,
        }  # fmt: skip
        # A sky with a sun's disc takes no coordinates: test_worlds.py has it.
        cases.append(Case("ShaderNodeTexSky", "Color", options, {"Vector": "tilted"}, tolerance=1e-3))
    return cases


def images() -> list[Case]:
    cases = []
    for projection in ("FLAT", "BOX", "SPHERE", "TUBE"):
        for extension, interpolation in product(("REPEAT", "EXTEND", "CLIP", "MIRROR"), ("Linear", "Closest", "Cubic")):
            options = {"projection": projection, "extension": extension, "interpolation": interpolation}
            for output in ("Color", "Alpha"):
                cases.append(Case("ShaderNodeTexImage", output, options, {"Vector": "wide"}, jumps=0.02))
    cases.append(
        Case("ShaderNodeTexImage", "Color", {"projection": "BOX", "projection_blend": 0.4}, {"Vector": "wide"})
    )
    cases.append(Case("ShaderNodeTexImage", "Color", {}, {}))
    for projection, interpolation in product(("EQUIRECTANGULAR", "MIRROR_BALL"), ("Linear", "Closest")):
        options = {"projection": projection, "interpolation": interpolation}
        cases.append(Case("ShaderNodeTexEnvironment", "Color", options, {"Vector": "wide"}, jumps=0.02))
    return cases


def surfaces() -> list[Case]:
    outputs = {
        "ShaderNodeNewGeometry": ("Position", "Normal", "Tangent", "True Normal", "Incoming", "Backfacing"),
        "ShaderNodeTexCoord": ("Generated", "Normal", "UV", "Object", "Camera", "Window", "Reflection"),
        "ShaderNodeObjectInfo": ("Location", "Color", "Alpha", "Object Index", "Material Index"),
        "ShaderNodeCameraData": ("View Vector", "View Z Depth", "View Distance"),
        "ShaderNodeLightPath": ("Is Camera Ray", "Is Shadow Ray", "Is Diffuse Ray", "Ray Length", "Ray Depth"),
        "ShaderNodeUVMap": ("UV",),
        "ShaderNodeRGB": ("Color",),
        "ShaderNodeValue": ("Value",),
    }
    cases = [Case("ShaderNodeTexCoord", "Object", curves="camera")]
    cases += [Case(kind, output) for kind, names in outputs.items() for output in names]
    for output in ("Color", "Alpha"):
        cases.append(Case("ShaderNodeVertexColor", output, {"layer_name": "Paint"}))
    for output in ("Color", "Vector", "Fac", "Alpha"):
        cases.append(Case("ShaderNodeAttribute", output, {"attribute_name": "Paint"}))
        cases.append(Case("ShaderNodeAttribute", output, {"attribute_name": "lone"}))
    cases += [Case("ShaderNodeTangent", "Tangent", {"direction_type": "RADIAL", "axis": axis}) for axis in "XYZ"]
    cases.append(Case("ShaderNodeTangent", "Tangent", {"direction_type": "UV_MAP"}))
    for ior in (1.45, 0.7):
        cases.append(Case("ShaderNodeFresnel", "Fac", {}, {"IOR": ior}))
        cases.append(Case("ShaderNodeFresnel", "Fac", {}, {"IOR": ior, "Normal": "tilted"}))
    for blend, output in product((0.2, 0.5, 0.8, 1.0), ("Fresnel", "Facing")):
        cases.append(Case("ShaderNodeLayerWeight", output, {}, {"Blend": blend, "Normal": "tilted"}))
    for output in ("Quadratic", "Linear", "Constant"):
        cases.append(Case("ShaderNodeLightFalloff", output, {}, {"Strength": 2.0, "Smooth": 3.0}))
    for space, strength in product(("TANGENT", "OBJECT", "WORLD", "BLENDER_OBJECT", "BLENDER_WORLD"), (1.0, 0.6)):
        cases.append(Case("ShaderNodeNormalMap", "Normal", {"space": space}, {"Strength": strength, "Color": "colour"}))
    for space in ("TANGENT", "WORLD"):
        options = {"space": space, "convention": "DIRECTX"}
        cases.append(Case("ShaderNodeNormalMap", "Normal", options, {"Strength": 1.0, "Color": "colour"}))
    for in_pixels, size in ((False, 0.3), (False, 0.9), (True, 1.0), (True, 2.5)):
        cases.append(Case("ShaderNodeWireframe", "Fac", {"use_pixel_size": in_pixels}, {"Size": size}, jumps=0.02))
    for noise in ("noise", "noise generated", "noise object", "noise uv"):
        for invert, inputs in product((False, True), ({}, {"Strength": 0.4, "Distance": 0.3}, {"Normal": "tilted"})):
            given = {"Height": noise, **inputs}
            # The slope is a difference of heights over a tenth of a pixel: their rounding, magnified.
            cases.append(Case("ShaderNodeBump", "Normal", {"invert": invert}, given, tolerance=5e-4))
    cases.append(Case("ShaderNodeBump", "Normal", {}, {"Height": "noise uv", "Normal": "bumped"}, tolerance=5e-4))
    cases.append(Case("ShaderNodeBump", "Normal", {}, {"Height": 0.3}))
    cases.append(Case("ShaderNodeFresnel", "Fac", {}, {"IOR": 1.45, "Normal": "bumped"}, tolerance=5e-4))
    cases.append(Case("ShaderNodeUVMap", "UV", {"uv_map": "UVMap"}))
    for space in ("OBJECT", "WORLD"):
        inputs = {"Height": "x", "Midlevel": 0.2, "Scale": 1.4}
        cases.append(Case("ShaderNodeDisplacement", "Displacement", {"space": space}, inputs))
        cases.append(Case("ShaderNodeDisplacement", "Displacement", {"space": space}, {**inputs, "Normal": "tilted"}))
    for space in ("TANGENT", "OBJECT", "WORLD"):
        inputs = {"Vector": "colour", "Midlevel": 0.2, "Scale": 1.4}
        cases.append(Case("ShaderNodeVectorDisplacement", "Displacement", {"space": space}, inputs))
    for kind in ("POINT", "TEXTURE", "VECTOR", "NORMAL"):
        for inputs in ({}, {"Vector": "wide"}):
            cases.append(Case("ShaderNodeTexGradient", "Color", {}, inputs, curves=kind))
            cases.append(Case("ShaderNodeTexImage", "Color", {"interpolation": "Linear"}, inputs, curves=kind))
            cases.append(Case("ShaderNodeTexEnvironment", "Color", {}, inputs, curves=kind, jumps=0.02))
    # What textures take where nothing is linked.
    cases.append(Case("ShaderNodeTexNoise", "Fac", {}, {"Scale": 3.0}))
    cases.append(Case("ShaderNodeTexVoronoi", "Distance", {}, {"Scale": 3.0}))
    cases.append(Case("ShaderNodeTexGradient", "Color"))
    return cases


ALL = [*maths(), *colours(), *noises(), *voronois(), *patterns(), *skies(), *images(), *surfaces()]
