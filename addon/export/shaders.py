# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes as layers: closures with what each counts. What is only near is said."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from ..description import FloatInput, LayerDescription, MaterialDescription
from . import layers, nodes, values
from .texture import Inputs

Layers = list[LayerDescription]


@dataclass(frozen=True)
class Weight:
    """What a shader counts: a number, times shares that vary over the surface, as they are or what they leave of 1."""

    scale: float = 1.0
    shares: tuple[tuple[FloatInput, bool], ...] = ()

    def times(self, share: FloatInput, *, is_rest: bool) -> Weight:
        """A part of it."""
        if isinstance(share, float | int):
            share = min(max(share, 0.0), 1.0)
            return replace(self, scale=self.scale * (1.0 - share if is_rest else share))
        return replace(self, shares=(*self.shares, (share, is_rest)))


def describe(source: nodes.Source, name: str, inputs: Inputs) -> MaterialDescription:
    """What a shader node is as a material of that name."""
    found = _layers(source, Weight(), inputs)
    if len(found) > layers.MOST:
        inputs.warn(f"it has {len(found)} closures, those after the first {layers.MOST} are left out")
    return layers.material(name, found)


def _layers(source: nodes.Source, weight: Weight, inputs: Inputs) -> Layers:
    if weight.scale == 0.0:
        return []
    if source.socket.type != "SHADER":
        return _bare_colour(source, weight, inputs)
    with nodes.entered(source) as is_new:
        if is_new:
            return _CONVERTERS.get(source.node.type, _unknown)(source, weight, inputs)
    inputs.warn(f"{source.node.name}: its links run in a circle, which is cut")
    return []


def _layer(kind: str, weight: Weight, colours: dict[str, Any], numbers: dict[str, Any] | None = None, **more: Any):
    return LayerDescription(kind, weight.scale, list(weight.shares), colours, numbers or {}, **more)


class _Sockets:
    """The inputs of a node by name; a Blender that does not have one yet gets what it stands for there."""

    def __init__(self, source: nodes.Source, inputs: Inputs) -> None:
        self._source, self._inputs = source, inputs

    def colour(self, name: str, otherwise: tuple[float, float, float] = layers.WHITE) -> Any:
        return self._inputs.colour(self._source.input(name)) if self.has(name) else otherwise

    def number(self, name: str, otherwise: float = 0.0) -> Any:
        return self._inputs.number(self._source.input(name)) if self.has(name) else otherwise

    def has(self, name: str) -> bool:
        return name in self._source.node.inputs


def _principled(source: nodes.Source, weight: Weight, inputs: Inputs) -> Layers:
    ask = _Sockets(source, inputs)
    _warn_of_vectors(source, inputs, "Normal", "Coat Normal")
    anisotropic = ask.number("Anisotropic")
    if anisotropic != 0.0:
        _warn_of_vectors(source, inputs, "Tangent")
    coat, sheen, film = ask.number("Coat Weight"), ask.number("Sheen Weight"), ask.number("Thin Film Thickness")
    strength, inner = ask.number("Emission Strength"), ask.number("Subsurface Weight")
    colours = {
        "base_color": ask.colour("Base Color"),
        "specular_tint": ask.colour("Specular Tint"),
        "subsurface_radius": ask.colour("Subsurface Radius") if inner != 0.0 else layers.WHITE,
        "coat_tint": ask.colour("Coat Tint") if coat != 0.0 else layers.WHITE,
        "sheen_tint": ask.colour("Sheen Tint") if sheen != 0.0 else layers.WHITE,
        "emission_color": ask.colour("Emission Color") if strength != 0.0 else layers.WHITE,
    }
    numbers = {
        "metallic": ask.number("Metallic"),
        "roughness": ask.number("Roughness"),
        "ior": ask.number("IOR"),
        "alpha": ask.number("Alpha"),
        "diffuse_roughness": ask.number("Diffuse Roughness"),
        "subsurface_weight": inner,
        "subsurface_scale": ask.number("Subsurface Scale") if inner != 0.0 else 0.0,
        "subsurface_ior": ask.number("Subsurface IOR", 1.4) if inner != 0.0 else 1.4,
        "subsurface_anisotropy": ask.number("Subsurface Anisotropy") if inner != 0.0 else 0.0,
        "specular_ior_level": ask.number("Specular IOR Level", 0.5),
        "anisotropic": anisotropic,
        "anisotropic_rotation": ask.number("Anisotropic Rotation") if anisotropic != 0.0 else 0.0,
        "transmission": ask.number("Transmission Weight"),
        "coat_weight": coat,
        "coat_roughness": ask.number("Coat Roughness") if coat != 0.0 else 0.0,
        "coat_ior": ask.number("Coat IOR") if coat != 0.0 else 1.5,
        "sheen_weight": sheen,
        "sheen_roughness": ask.number("Sheen Roughness") if sheen != 0.0 else 0.5,
        "emission_strength": strength,
        "film_thickness_nm": film,
        "film_ior": ask.number("Thin Film IOR") if film != 0.0 else 1.33,
    }
    node = source.node
    method = nodes.subsurface_method(node, "subsurface_method")
    return [_layer("PRINCIPLED", weight, colours, numbers, distribution=node.distribution, subsurface_method=method)]


def _subsurface(source: nodes.Source, weight: Weight, inputs: Inputs) -> Layers:
    _warn_of_vectors(source, inputs, "Normal")
    ask = _Sockets(source, inputs)
    colours = {"color": ask.colour("Color"), "radius": ask.colour("Radius")}
    numbers = {
        "scale": ask.number("Scale"),
        "ior": ask.number("IOR", 1.4),
        "roughness": ask.number("Roughness", 1.0),
        "anisotropy": ask.number("Anisotropy"),
    }
    method = nodes.subsurface_method(source.node, "falloff")
    return [_layer("SUBSURFACE", weight, colours, numbers, subsurface_method=method)]


def _emission(source: nodes.Source, weight: Weight, inputs: Inputs) -> Layers:
    ask = _Sockets(source, inputs)
    return [_layer("EMISSION", weight, {"color": ask.colour("Color")}, {"strength": ask.number("Strength")})]


def _diffuse(source: nodes.Source, weight: Weight, inputs: Inputs) -> Layers:
    _warn_of_vectors(source, inputs, "Normal")
    ask = _Sockets(source, inputs)
    # A Diffuse BSDF alone has a roughness that means this.
    roughness = ask.number("Roughness") if source.node.type == "BSDF_DIFFUSE" else 0.0
    return [_layer("DIFFUSE", weight, {"color": ask.colour("Color")}, {"roughness": roughness})]


def _translucent(source: nodes.Source, weight: Weight, inputs: Inputs) -> Layers:
    _warn_of_vectors(source, inputs, "Normal")
    return [_layer("TRANSLUCENT", weight, {"color": _Sockets(source, inputs).colour("Color")})]


def _brushed(source: nodes.Source, inputs: Inputs) -> dict[str, Any]:
    """Roughness along and across."""
    ask = _Sockets(source, inputs)
    _warn_of_vectors(source, inputs, "Normal")
    anisotropy = ask.number("Anisotropy")
    if anisotropy != 0.0:
        _warn_of_vectors(source, inputs, "Tangent")
    return {
        "roughness": ask.number("Roughness"),
        "anisotropy": anisotropy,
        "rotation": ask.number("Rotation") if anisotropy != 0.0 else 0.0,
    }


def _glossy(source: nodes.Source, weight: Weight, inputs: Inputs) -> Layers:
    colours = {"color": _Sockets(source, inputs).colour("Color")}
    return [_layer("GLOSSY", weight, colours, _brushed(source, inputs), distribution=source.node.distribution)]


def _film(source: nodes.Source, inputs: Inputs) -> dict[str, Any]:
    ask = _Sockets(source, inputs)
    thickness = ask.number("Thin Film Thickness")
    return {"film_thickness_nm": thickness, "film_ior": ask.number("Thin Film IOR", 1.33) if thickness != 0.0 else 1.33}


def _metal(source: nodes.Source, weight: Weight, inputs: Inputs) -> Layers:
    ask = _Sockets(source, inputs)
    if source.node.fresnel_type == "PHYSICAL_CONDUCTOR":
        kind, colours = "CONDUCTOR", {"base": ask.colour("IOR"), "edge": ask.colour("Extinction")}
    else:
        kind, colours = "METAL", {"base": ask.colour("Base Color"), "edge": ask.colour("Edge Tint")}
    numbers = {**_brushed(source, inputs), **_film(source, inputs)}
    return [_layer(kind, weight, colours, numbers, distribution=source.node.distribution)]


def _glass(source: nodes.Source, weight: Weight, inputs: Inputs) -> Layers:
    _warn_of_vectors(source, inputs, "Normal")
    ask = _Sockets(source, inputs)
    kind = "REFRACTION" if source.node.type == "BSDF_REFRACTION" else "GLASS"
    numbers = {"roughness": ask.number("Roughness"), "ior": ask.number("IOR")}
    if kind == "GLASS":
        numbers.update(_film(source, inputs))
    return [_layer(kind, weight, {"color": ask.colour("Color")}, numbers, distribution=source.node.distribution)]


def _sheen(source: nodes.Source, weight: Weight, inputs: Inputs) -> Layers:
    _warn_of_vectors(source, inputs, "Normal")
    ask = _Sockets(source, inputs)
    kind = "VELVET" if source.node.distribution == "ASHIKHMIN" else "MICROFIBER"
    return [_layer(kind, weight, {"color": ask.colour("Color")}, {"roughness": ask.number("Roughness")})]


def _toon(source: nodes.Source, weight: Weight, inputs: Inputs) -> Layers:
    _warn_of_vectors(source, inputs, "Normal")
    ask = _Sockets(source, inputs)
    kind = "GLOSSY_TOON" if source.node.component == "GLOSSY" else "TOON"
    numbers = {"size": ask.number("Size"), "smooth": ask.number("Smooth")}
    return [_layer(kind, weight, {"color": ask.colour("Color")}, numbers)]


def _transparent(source: nodes.Source, weight: Weight, inputs: Inputs) -> Layers:
    return [_layer("TRANSPARENT", weight, {"color": _Sockets(source, inputs).colour("Color")})]


def _holdout(_source: nodes.Source, weight: Weight, inputs: Inputs) -> Layers:
    inputs.warn("Holdout is not supported yet, it is shown as transparent")
    return [_layer("TRANSPARENT", weight, {"color": layers.WHITE})]


def _mix(source: nodes.Source, weight: Weight, inputs: Inputs) -> Layers:
    given = [nodes.Input(socket, source.groups) for socket in source.node.inputs]
    ends = [nodes.trace(end) for end in given[1:3]]
    # What is mixed with nothing needs no share to be read.
    share = inputs.number(given[0]) if any(isinstance(end, nodes.Source) for end in ends) else 0.0
    found: Layers = []
    for end, is_rest in zip(ends, (True, False), strict=True):
        if isinstance(end, nodes.Source):
            found += _layers(end, weight.times(share, is_rest=is_rest), inputs)
    return found


def _add(source: nodes.Source, weight: Weight, inputs: Inputs) -> Layers:
    ends = [nodes.trace(nodes.Input(socket, source.groups)) for socket in source.node.inputs[:2]]
    return [layer for end in ends if isinstance(end, nodes.Source) for layer in _layers(end, weight, inputs)]


def _bare_colour(source: nodes.Source, weight: Weight, inputs: Inputs) -> Layers:
    """A colour where a shader belongs glows with that colour in Blender."""
    colour = values.folded(source)
    if colour is None:
        inputs.warn(f"{source.node.bl_label} as a surface is not supported yet, it is black")
        return []
    colour = tuple(colour[:3]) if isinstance(colour, tuple) else (colour,) * 3
    return [_layer("EMISSION", weight, {"color": colour}, {"strength": 1.0})]


def _unknown(source: nodes.Source, weight: Weight, inputs: Inputs) -> Layers:
    """The colour that the node has, as a diffuse surface."""
    inputs.warn(f"{source.node.bl_label} is not supported yet, it is shown as diffuse")
    given = next((socket for socket in source.node.inputs if socket.type == "RGBA" and socket.enabled), None)
    colour = (0.8, 0.8, 0.8) if given is None else inputs.colour(nodes.Input(given, source.groups))
    return [_layer("DIFFUSE", weight, {"color": colour}, {"roughness": 0.0})]


def _warn_of_vectors(source: nodes.Source, inputs: Inputs, *names: str) -> None:
    """Directions that bend or turn the surface's own."""
    for name in names:
        socket = source.node.inputs.get(name)
        found = None if socket is None else nodes.trace(nodes.Input(socket, source.groups))
        if not isinstance(found, nodes.Source):
            continue
        if name == "Tangent":
            inputs.warn(f"{found.node.bl_label} as a tangent is not supported yet, it turns about the object's z axis")
        else:
            inputs.warn(f"{found.node.bl_label} is not supported yet, the surface stays smooth")


_CONVERTERS: dict[str, Callable[[nodes.Source, Weight, Inputs], Layers]] = {
    "BSDF_PRINCIPLED": _principled,
    "EMISSION": _emission,
    "BSDF_DIFFUSE": _diffuse,
    "BSDF_TRANSLUCENT": _translucent,
    "SUBSURFACE_SCATTERING": _subsurface,
    "BSDF_TOON": _toon,
    "BSDF_SHEEN": _sheen,
    "BSDF_GLOSSY": _glossy,
    "BSDF_METALLIC": _metal,
    "BSDF_GLASS": _glass,
    "BSDF_REFRACTION": _glass,
    "BSDF_TRANSPARENT": _transparent,
    "HOLDOUT": _holdout,
    "MIX_SHADER": _mix,
    "ADD_SHADER": _add,
}
