# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes as Principled BSDF inputs. What is only near is said."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from ..description import ImageInput, MaterialDescription
from . import nodes, values
from .texture import Inputs

BLACK = (0.0, 0.0, 0.0)
WHITE = (1.0, 1.0, 1.0)
#: Principled inputs that the engine does not know; zero leaves each out.
UNUSED = ("Subsurface Weight", "Coat Weight", "Sheen Weight", "Anisotropic", "Thin Film Thickness", "Diffuse Roughness")


def describe(source: nodes.Source, name: str, inputs: Inputs) -> MaterialDescription:
    """What a shader node is as a material of that name."""
    if source.socket.type != "SHADER":
        return _bare_colour(source, name, inputs)
    convert = _CONVERTERS.get(source.node.type)
    if convert is None:
        return _unknown(source, name, inputs)
    return convert(source, name, inputs)


def _principled(source: nodes.Source, name: str, inputs: Inputs) -> MaterialDescription:
    for unused in UNUSED:
        if unused in source.node.inputs and values.constant(source.input(unused)) != 0.0:
            inputs.warn(f"Principled BSDF's {unused} is not supported yet, it is left out")
    _warn_of_normal(source, inputs)
    return MaterialDescription(
        name,
        base_color=inputs.colour(source.input("Base Color")),
        metallic=inputs.number(source.input("Metallic")),
        roughness=inputs.number(source.input("Roughness")),
        ior=inputs.constant(source.input("IOR")),
        specular_ior_level=inputs.constant(source.input("Specular IOR Level")),
        specular_tint=inputs.constant(source.input("Specular Tint")),
        transmission=inputs.number(source.input("Transmission Weight")),
        alpha=inputs.number(source.input("Alpha")),
        **_emission(source, "Emission Color", "Emission Strength", inputs),
    )


def _emission(source: nodes.Source, colour: str, strength: str, inputs: Inputs) -> dict[str, Any]:
    amount = inputs.constant(source.input(strength))
    if amount == 0.0:
        return {}
    return {"emission_color": inputs.colour(source.input(colour)), "emission_strength": amount}


def _emitter(source: nodes.Source, name: str, inputs: Inputs) -> MaterialDescription:
    return MaterialDescription(name, base_color=BLACK, specular=False, **_emission(source, "Color", "Strength", inputs))


def _diffuse(source: nodes.Source, name: str, inputs: Inputs) -> MaterialDescription:
    _warn_of_normal(source, inputs)
    return MaterialDescription(name, base_color=inputs.colour(source.input("Color")), specular=False)


def _near_diffuse(source: nodes.Source, name: str, inputs: Inputs) -> MaterialDescription:
    inputs.warn(f"{source.node.bl_label} is not supported yet, it is shown as diffuse")
    return _diffuse(source, name, inputs)


def _glossy(source: nodes.Source, name: str, inputs: Inputs) -> MaterialDescription:
    _warn_of_normal(source, inputs)
    colour = inputs.colour(source.input("Base Color" if source.node.type == "BSDF_METALLIC" else "Color"))
    if colour != WHITE:
        inputs.warn(f"{source.node.bl_label} is shown as a Principled metal, which is brighter at its edges")
    return MaterialDescription(
        name, base_color=colour, metallic=1.0, roughness=inputs.number(source.input("Roughness"))
    )


def _glass(source: nodes.Source, name: str, inputs: Inputs) -> MaterialDescription:
    _warn_of_normal(source, inputs)
    if source.node.type == "BSDF_REFRACTION":
        inputs.warn("Refraction BSDF is not supported yet, it is shown as glass, which reflects too")
    colour = inputs.colour(source.input("Color"))
    if isinstance(colour, ImageInput):
        inputs.warn("the image in a Glass BSDF's colour tints less than in Blender")
    elif colour != WHITE:
        # Principled glass is tinted by the root of its base colour.
        colour = tuple(part * part for part in colour)
    return MaterialDescription(
        name,
        base_color=colour,
        transmission=1.0,
        roughness=inputs.number(source.input("Roughness")),
        ior=inputs.constant(source.input("IOR")),
    )


def _transparent(source: nodes.Source, name: str, inputs: Inputs) -> MaterialDescription:
    if source.node.type == "HOLDOUT":
        inputs.warn("Holdout is not supported yet, it is shown as transparent")
    elif inputs.colour(source.input("Color")) != WHITE:
        inputs.warn("the colour of a Transparent BSDF is not supported yet, it is clear")
    return MaterialDescription(name, base_color=BLACK, specular=False, alpha=0.0)


def _mix(source: nodes.Source, name: str, inputs: Inputs) -> MaterialDescription:
    share = nodes.Input(source.node.inputs[0], source.groups)
    ends = [nodes.trace(nodes.Input(socket, source.groups)) for socket in source.node.inputs[1:3]]
    first, second = (end if isinstance(end, nodes.Source) else None for end in ends)
    amount = values.constant(share)
    if amount is not None and (amount <= 0.0 or amount >= 1.0):
        return _or_black(first if amount <= 0.0 else second, name, inputs)
    if _is_clear(first) and second is not None:
        opaque = describe(second, name, inputs)
        if opaque.alpha == 1.0:
            return replace(opaque, alpha=inputs.number(share))
    if _is_clear(second) and first is not None and amount is not None:
        opaque = describe(first, name, inputs)
        if opaque.alpha == 1.0:
            return replace(opaque, alpha=1.0 - amount)
    coat = _coated(first, second, name, inputs)
    if coat is not None:
        return coat
    if amount is None:
        amount = values.estimate(share)
    use_second = first is None or _is_clear(first) or (amount or 0.0) > 0.5
    inputs.warn(f"Mix Shader is not supported yet, its {'second' if use_second and second else 'first'} shader is used")
    return _or_black((second if use_second else first) or first, name, inputs)


def _coated(
    first: nodes.Source | None, second: nodes.Source | None, name: str, inputs: Inputs
) -> MaterialDescription | None:
    """A diffuse surface under a glossy one, as materials were made before Principled."""
    by_kind = {end.node.type: end for end in (first, second) if end is not None}
    if by_kind.keys() != {"BSDF_DIFFUSE", "BSDF_GLOSSY"}:
        return None
    inputs.warn("a Mix Shader of diffuse and glossy is shown as Principled")
    under, over = by_kind["BSDF_DIFFUSE"], by_kind["BSDF_GLOSSY"]
    return replace(_diffuse(under, name, inputs), specular=True, roughness=inputs.number(over.input("Roughness")))


def _is_clear(source: nodes.Source | None) -> bool:
    """A Transparent BSDF that does not tint."""
    if source is None or source.node.type != "BSDF_TRANSPARENT":
        return False
    colour = values.constant(source.input("Color"))
    return colour is not None and colour[:3] == WHITE


def _add(source: nodes.Source, name: str, inputs: Inputs) -> MaterialDescription:
    ends = [nodes.trace(nodes.Input(socket, source.groups)) for socket in source.node.inputs[:2]]
    ends = [end for end in ends if isinstance(end, nodes.Source)]
    lights = [end for end in ends if end.node.type == "EMISSION"]
    others = [end for end in ends if end.node.type != "EMISSION"]
    if len(ends) == 2 and len(lights) == 1:
        surface, light = describe(others[0], name, inputs), describe(lights[0], name, inputs)
        if surface.emission_strength == 0.0:
            return replace(surface, emission_color=light.emission_color, emission_strength=light.emission_strength)
    if len(ends) > 1:
        inputs.warn("Add Shader is not supported yet, its first shader is used")
    return _or_black(ends[0] if ends else None, name, inputs)


def _or_black(source: nodes.Source | None, name: str, inputs: Inputs) -> MaterialDescription:
    """An empty shader input is black in Blender."""
    if source is None:
        return MaterialDescription(name, base_color=BLACK, specular=False)
    return describe(source, name, inputs)


def _bare_colour(source: nodes.Source, name: str, inputs: Inputs) -> MaterialDescription:
    """A colour where a shader belongs glows with that colour in Blender."""
    colour = values.folded(source)
    if colour is None:
        inputs.warn(f"{source.node.bl_label} as a surface is not supported yet, it is black")
        return MaterialDescription(name, base_color=BLACK, specular=False)
    colour = colour[:3] if isinstance(colour, tuple) else (colour,) * 3
    return MaterialDescription(name, base_color=BLACK, specular=False, emission_color=colour, emission_strength=1.0)


def _unknown(source: nodes.Source, name: str, inputs: Inputs) -> MaterialDescription:
    """The colour that the node has, as a diffuse surface."""
    inputs.warn(f"{source.node.bl_label} is not supported yet, it is shown as diffuse")
    given = next((socket for socket in source.node.inputs if socket.type == "RGBA" and socket.enabled), None)
    if given is None:
        return MaterialDescription(name, specular=False)
    return MaterialDescription(name, base_color=inputs.colour(nodes.Input(given, source.groups)), specular=False)


def _warn_of_normal(source: nodes.Source, inputs: Inputs) -> None:
    normal = source.node.inputs.get("Normal")
    if normal is None:
        return
    found = nodes.trace(nodes.Input(normal, source.groups))
    if isinstance(found, nodes.Source):
        inputs.warn(f"{found.node.bl_label} is not supported yet, the surface stays smooth")


_CONVERTERS: dict[str, Callable[[nodes.Source, str, Inputs], MaterialDescription]] = {
    "BSDF_PRINCIPLED": _principled,
    "EMISSION": _emitter,
    "BSDF_DIFFUSE": _diffuse,
    "BSDF_TRANSLUCENT": _near_diffuse,
    "SUBSURFACE_SCATTERING": _near_diffuse,
    "BSDF_TOON": _near_diffuse,
    "BSDF_SHEEN": _near_diffuse,
    "BSDF_GLOSSY": _glossy,
    "BSDF_METALLIC": _glossy,
    "BSDF_GLASS": _glass,
    "BSDF_REFRACTION": _glass,
    "BSDF_TRANSPARENT": _transparent,
    "HOLDOUT": _transparent,
    "MIX_SHADER": _mix,
    "ADD_SHADER": _add,
}
