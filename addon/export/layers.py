# SPDX-License-Identifier: GPL-3.0-or-later
"""The layers of a material as the engine gets them: by the short way that most materials take, wherever that says the
same."""

from __future__ import annotations

from ..description import ImageInput, LayerDescription, MaterialDescription

BLACK = (0.0, 0.0, 0.0)
WHITE = (1.0, 1.0, 1.0)
#: Layers that the engine takes.
MOST = 32

#: What a Principled of the short way does not have, by the value that leaves it out.
_WITHOUT = {
    "subsurface_weight": 0.0,
    "coat_weight": 0.0,
    "sheen_weight": 0.0,
    "anisotropic": 0.0,
    "film_thickness_nm": 0.0,
    "diffuse_roughness": 0.0,
    "specular_tint": WHITE,
}
_VARYING = ("base_color", "metallic", "roughness", "transmission", "alpha")


def material(name: str, layers: list[LayerDescription]) -> MaterialDescription:
    """A material of these layers."""
    layers = [layer for layer in layers if layer.weight > 0.0 and not _is_dark_emission(layer)]
    return _short(name, layers) or MaterialDescription(name, layers=layers)


def _short(name: str, layers: list[LayerDescription]) -> MaterialDescription | None:
    """One body, one light, and what is clear around them; None where that is not all."""
    if not layers:
        return MaterialDescription(name, base_color=BLACK, specular=False)
    lights = [layer for layer in layers if layer.kind == "EMISSION"]
    clear = [layer for layer in layers if layer.kind == "TRANSPARENT"]
    bodies = [layer for layer in layers if layer not in lights and layer not in clear]
    if max(len(lights), len(clear), len(bodies)) > 1 or any(layer.colours["color"] != WHITE for layer in clear):
        return None
    body = _body(name, bodies[0]) if bodies else MaterialDescription(name, base_color=BLACK, specular=False)
    if body is None:
        return None
    if clear and not bodies and not lights:
        body.alpha = 0.0
        return body if _counts_all(clear[0]) else None
    solid = bodies + lights
    if clear:
        alpha = _alpha(solid, clear[0])
        if alpha is None or body.alpha != 1.0:
            return None
        body.alpha = alpha
    elif not all(_counts_all(layer) for layer in bodies):
        return None
    if lights:
        return _lit(body, lights[0], has_body=bool(bodies))
    return body


def _body(name: str, layer: LayerDescription) -> MaterialDescription | None:
    if layer.kind == "DIFFUSE" and layer.numbers["roughness"] == 0.0:
        return MaterialDescription(name, base_color=layer.colours["color"], specular=False)
    if layer.kind != "PRINCIPLED" or layer.distribution != "MULTI_GGX":
        return None
    given = {**layer.colours, **layer.numbers}
    still = (given["ior"], given["specular_ior_level"], given["emission_strength"])
    if any(given[key] != value for key, value in _WITHOUT.items()) or any(isinstance(v, ImageInput) for v in still):
        return None
    return MaterialDescription(
        name,
        **{key: given[key] for key in _VARYING},
        ior=given["ior"],
        specular_ior_level=given["specular_ior_level"],
        emission_color=given["emission_color"],
        emission_strength=given["emission_strength"],
    )


def _lit(body: MaterialDescription, light: LayerDescription, *, has_body: bool) -> MaterialDescription | None:
    """The body with a light of its own."""
    strength = light.numbers["strength"]
    # Emission of a body that is partly clear is so, too; a light beside it is not.
    beside = has_body and (body.emission_strength != 0.0 or body.alpha != 1.0)
    if beside or light.shares or isinstance(strength, ImageInput):
        return None
    body.emission_color = light.colours["color"]
    body.emission_strength = strength * light.weight if body.alpha == 1.0 else strength
    return body


def _counts_all(layer: LayerDescription) -> bool:
    return layer.weight == 1.0 and not layer.shares


def _alpha(solid: list[LayerDescription], clear: LayerDescription) -> float | ImageInput | None:
    """The share of the solid layer of a mix with a clear one."""
    if len(solid) != 1:
        return None
    (layer,) = solid
    if not layer.shares and not clear.shares:
        return layer.weight if abs(layer.weight + clear.weight - 1.0) < 1e-6 else None
    if layer.weight == clear.weight == 1.0 and len(layer.shares) == len(clear.shares) == 1:
        (share, is_rest), (other, other_is_rest) = layer.shares[0], clear.shares[0]
        return share if share == other and not is_rest and other_is_rest else None
    return None


def _is_dark_emission(layer: LayerDescription) -> bool:
    return layer.kind == "EMISSION" and (layer.numbers["strength"] == 0.0 or layer.colours["color"] == BLACK)
