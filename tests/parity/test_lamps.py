# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps whose nodes are computed where they shine, against Cycles in the same Blender, block by block."""

from __future__ import annotations

import numpy as np
import pytest

from support.ball_row import alike
from support.lamp_studio import KINDS, lamp
from support.node_tree import Tree


def half(names, kinds=tuple(KINDS)) -> list:
    """Pairs of a name and a kind of lamp: every second of a chessboard in `make test`, the others as recipes."""
    pairs = [(i + j, name, kind) for i, name in enumerate(names) for j, kind in enumerate(kinds)]
    return [pytest.param(name, kind, marks=pytest.mark.recipe) if n % 2 else (name, kind) for n, name, kind in pairs]


def shows(t: Tree, output, scale: float = 1.0, shift: float = 0.0):
    """Emission whose colour is a vector, scaled and shifted."""
    scaled = t.node("VectorMath", {"operation": "MULTIPLY_ADD"}, _0=output, _1=(scale,) * 3, _2=(shift,) * 3)
    t.shows(t.node("Emission", Color=scaled.outputs[0], Strength=1.5).outputs[0])


#: What is computed alike follows each other, so that every kind of lamp is tested with one or the other.
SPACES = ("Normal", "True Normal", "UV", "Parametric", "Position", "Object", "Incoming")


@pytest.mark.first_only("space", "kind")
@pytest.mark.parametrize(("space", "kind"), half(SPACES))
def test_coordinates(studio, blender, tmp_path, kind, space):
    def build(t):
        node = "TexCoord" if space in ("Normal", "UV", "Object") else "NewGeometry"
        # Not below 0: what cancels out is lost in noise.
        scales = {"UV": (0.9, 0.1), "Parametric": (0.9, 0.1), "Object": (0.1, 0.5)}
        shows(t, t.node(node).outputs[space], *scales.get(space, (0.45, 0.5)))

    lamp(blender, kind, build)
    alike(tmp_path)


@pytest.mark.first_only("falloff", "kind")
@pytest.mark.parametrize(
    ("falloff", "kind"), half(("Quadratic", "Linear", "Constant"), ("POINT", "SPOT", "AREA", "POINT without size"))
)
def test_falloff(studio, blender, tmp_path, kind, falloff):
    def build(t):
        node = t.node("LightFalloff", Strength=0.4, Smooth=0.7)
        t.shows(t.node("Emission", Strength=node.outputs[falloff]).outputs[0])

    lamp(blender, kind, build)
    alike(tmp_path)


def noise(t: Tree):
    made = t.node("TexNoise", Vector=t.coordinates("Normal"), Scale=4.0)
    t.shows(t.node("Emission", Color=t.ramp(made.outputs[0]), Strength=2.0).outputs[0])


def gobo(t: Tree):
    """A pattern in the light's cone, as of a projector."""
    parts = t.node("SeparateXYZ", Vector=t.coordinates("Normal"))
    across = [t.node("Math", {"operation": "DIVIDE"}, _0=parts.outputs[axis], _1=parts.outputs["Z"]) for axis in "XY"]
    place = t.node("CombineXYZ", X=across[0].outputs[0], Y=across[1].outputs[0])
    checker = t.node("TexChecker", Vector=place.outputs[0], Scale=3.0, Color1=(0.9, 0.2, 0.1, 1.0))
    t.shows(t.node("Emission", Color=checker.outputs["Color"]).outputs[0])


def warm(t: Tree):
    t.shows(t.node("Emission", Color=t.node("Blackbody", Temperature=3000.0).outputs[0], Strength=2.0).outputs[0])


def by_path(output: str):
    def build(t):
        share = t.node("Math", {"operation": "MULTIPLY"}, _0=t.node("LightPath").outputs[output], _1=0.3)
        share = t.node("Math", {"operation": "ADD"}, _0=share.outputs[0], _1=0.2)
        t.shows(t.node("Emission", Strength=share.outputs[0]).outputs[0])

    build.__name__ = output
    return build


def two(t: Tree):
    one = t.node("Emission", Color=(1.0, 0.2, 0.1, 1.0), Strength=0.5)
    other = t.node("Emission", Color=(0.1, 0.3, 1.0, 1.0), Strength=2.0)
    t.shows(t.node("MixShader", _0=0.3, _1=one.outputs[0], _2=other.outputs[0]).outputs[0])


#: Of a ray's depths and kinds, as of coordinates.
PATHS = ("Is Camera Ray", "Is Shadow Ray", "Is Diffuse Ray", "Is Glossy Ray", "Ray Depth", "Diffuse Depth")


@pytest.mark.first_only("build", "kind")
@pytest.mark.parametrize(
    ("build", "kind"),
    half((noise, gobo, warm, two, *map(by_path, PATHS)), ("POINT", "SPOT", "SUN", "AREA")),
    ids=lambda one: getattr(one, "__name__", one),
)
def test_nodes(studio, blender, tmp_path, kind, build):
    lamp(blender, kind, build)
    # Where only light from other surfaces comes to there is some noise.
    alike(tmp_path, block=0.06)


def luminaire(vertical, horizontal, candela, kind: int = 1) -> str:
    """A file of the Illuminating Engineering Society."""
    words = [f"1 1000 1.5 {len(vertical)} {len(horizontal)} {kind} 2 0.1 0.1 0.0", "0.9 1.0 60.0"]
    words += [" ".join(map(str, row)) for row in (vertical, horizontal, *candela)]
    return "\r\n".join(["IESNA:LM-63-2002", "[MANUFAC] nobody", "TILT=NONE", *words, ""])


def bright(vertical, horizontal):
    return [[round(900 + 700 * np.cos(np.radians(3 * v)) * np.cos(np.radians(h)) + 2 * v, 2) for v in vertical]
            for h in horizontal]  # fmt: skip


LUMINAIRES = {
    "round": (range(0, 181, 15), [0]),
    "below": (range(0, 91, 10), [0]),
    "quarter": (range(0, 181, 20), range(0, 91, 30)),
    "half": (range(0, 181, 20), range(0, 181, 45)),
    "whole": (range(0, 181, 20), range(0, 361, 40)),
    "open": (range(0, 181, 20), range(0, 360, 40)),
}


# All from a text in the file; one from a file of its own too, which is read alike.
@pytest.mark.parametrize(
    ("name", "is_file"), [*(pytest.param(name, False, marks=[pytest.mark.once] * (name != "whole")) for name in LUMINAIRES), ("whole", True)],
    ids=[*LUMINAIRES, "whole from a file"],
)  # fmt: skip
def test_luminaires(studio, blender, tmp_path, name, is_file):
    vertical, horizontal = LUMINAIRES[name]
    if len(horizontal) == 1 and blender.app.version < (5, 0, 0):
        pytest.skip("Blender 4.5 shows these 6 % brighter")
    text = luminaire(vertical, horizontal, bright(vertical, horizontal))

    def build(t):
        node = t.node("TexIES", None, Strength=0.02)
        if is_file:
            path = tmp_path / "lamp.ies"
            path.write_bytes(text.encode())
            node.mode, node.filepath = "EXTERNAL", str(path)
        else:
            node.mode, node.ies = "INTERNAL", blender.data.texts.new("lamp")
            node.ies.write(text)
        t.shows(t.node("Emission", Strength=node.outputs[0]).outputs[0])

    lamp(blender, "POINT without size", build)
    alike(tmp_path)


def test_a_luminaire_without_its_file_is_named(studio, blender, tmp_path):
    lamp(blender, "POINT", lambda t: t.shows(t.node("Emission", Strength=t.node("TexIES").outputs[0]).outputs[0]))
    studio.render(tmp_path)
    warnings = studio.part("render.statistics").last("Scene").warnings
    assert len(warnings) == 1 and "Lamp" in warnings[0] and "file is missing" in warnings[0]


SETTINGS = {
    "no shadow": ("AREA", {"use_shadow": False}),
    "a spot of little blend": ("SPOT", {"spot_blend": 0.0}),
    "a square cone": ("SPOT", {"use_square": True}),
    "a narrow beam": ("AREA", {"spread": 0.5}),
    "not by size": ("SPOT", {"normalize": False}),
    "not by size, a point": ("POINT", {"normalize": False}),
    "not by size, without one": ("POINT without size", {"normalize": False}),
    "not by size, a spot without one": ("SPOT", {"normalize": False, "shadow_soft_size": 0.0}),
    "warm": ("SUN", {"use_temperature": True, "temperature": 3200.0}),
    "sampled by directions alone": ("AREA", {"use_multiple_importance_sampling": False}),
}


@pytest.mark.parametrize("name", SETTINGS)
def test_settings(studio, blender, tmp_path, name):
    kind, settings = SETTINGS[name]
    light = lamp(blender, kind).data
    for key, value in settings.items():
        where = light.cycles if key.startswith("use_multiple") else light
        if not hasattr(where, key):
            pytest.skip("this Blender's lamps have no such setting")
        setattr(where, key, value)
    alike(tmp_path, block=0.06)


def test_a_portal_gives_no_light(blender, studio, tmp_path):
    """It tells Cycles where the sky comes in; here the picture is that without it, to the last bit."""
    blender.context.scene.petzval.samples = 4
    without = studio.render(tmp_path)
    holder = lamp(blender, "AREA")
    assert (studio.render(tmp_path) != without).any()
    if not hasattr(holder.data, "cycles"):
        pytest.skip("no Cycles")
    holder.data.cycles.is_portal = True
    assert (studio.render(tmp_path) == without).all()


@pytest.mark.first_only("kind")
@pytest.mark.parametrize("kind", ["POINT", "SPOT", "SUN", "AREA"])
def test_a_lamp_that_takes_light_away(studio, blender, tmp_path, kind):
    """A lamp of negative power beside a brighter one."""
    holder = lamp(blender, kind)
    holder.data.energy *= -0.1
    other = lamp(blender, "SUN")
    other.rotation_euler = (0.9, -0.4, 0.0)
    alike(tmp_path)


def glow_by_normal(t: Tree):
    return t.node("Emission", Color=t.node("NewGeometry").outputs["Normal"], Strength=0.8).outputs[0]


def glow_by_a_negative_number(t: Tree):
    strength = t.node("Math", {"operation": "MULTIPLY"}, _0=-1.0, _1=0.7).outputs[0]
    return t.node("Emission", Color=(0.6, 0.3, 0.1, 1.0), Strength=strength).outputs[0]


def principled_glow_by_normal(t: Tree):
    normal = t.node("NewGeometry").outputs["Normal"]
    return t.node("BsdfPrincipled", Emission_Color=normal, Emission_Strength=0.8).outputs[0]


GLOWS = (glow_by_normal, glow_by_a_negative_number, principled_glow_by_normal)


@pytest.mark.first_only("build")
@pytest.mark.parametrize("build", GLOWS, ids=lambda build: build.__name__)
def test_a_surface_that_takes_light_away(studio, blender, tmp_path, build):
    """Emission that is negative, in part or all over."""
    made = blender.data.materials.new("Glow")
    made.use_nodes = True
    made.node_tree.nodes.clear()
    t = Tree(made.node_tree, made.node_tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    t.shows(build(t))
    blender.context.object.data.materials[0] = made
    lamp(blender, "SUN")
    alike(tmp_path)
