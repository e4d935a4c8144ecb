# SPDX-License-Identifier: GPL-3.0-or-later
"""Values of inputs: folded where they stand still, guessed where they vary and nothing better can be had.

Numbers are floats, colours and vectors tuples. None means that it cannot be said.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from .blackbody import blackbody
from .nodes import Input, Source, entered, trace, value

Ask = Callable[[Input], Any]

#: What a node gives on average, for guessing.
_AVERAGES = {
    "TEX_NOISE": 0.5,
    "TEX_VORONOI": 0.5,
    "TEX_WAVE": 0.5,
    "TEX_MAGIC": 0.5,
    "TEX_MUSGRAVE": 0.5,
    "TEX_GRADIENT": 0.5,
    "TEX_WHITE_NOISE": 0.5,
    "FRESNEL": 0.1,
    "LAYER_WEIGHT": 0.2,
    "NEW_GEOMETRY": 0.0,
}
# Of a colour ramp whose place on the ramp varies.
_RAMP_STEPS = 9


def constant(start: Input) -> Any:
    """The value of an input where it does not vary; None where it may."""
    return _evaluate(start, _fold, constant)


def estimate(start: Input) -> Any:
    """About the average of an input that varies; None where there is no telling."""
    return _evaluate(start, _guess, estimate)


def folded(source: Source) -> Any:
    """What a node's output always gives; None where it may vary."""
    return _fold(source, constant)


def _evaluate(start: Input, node_value: Callable[[Source, Ask], Any], ask: Ask) -> Any:
    found = trace(start)
    if found is None:
        # Nothing arrives through a dead end: Blender takes zero.
        own = value(start.socket)
        return tuple(0.0 for _ in own) if isinstance(own, tuple) else 0.0
    if isinstance(found, Input):
        given = value(found.socket)
    else:
        with entered(found) as is_new:
            given = node_value(found, ask) if is_new else None
    return None if given is None else _as_kind_of(start, given)


def _as_kind_of(start: Input, given: Any) -> Any:
    """A value as Blender converts it on its way into a socket: grey to colour, colour to its luminance."""
    own = value(start.socket)
    if isinstance(own, tuple) and not isinstance(given, tuple):
        return (given,) * min(len(own), 3)
    if isinstance(own, float) and isinstance(given, tuple):
        return _luminance(given)
    return given


def _luminance(colour: tuple[float, ...]) -> float:
    return 0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2]


def _fold(source: Source, ask: Ask) -> Any:
    """The value of a node whose inputs stand still; None where the engine is to find it."""
    converter = _NODES.get(source.node.type)
    try:
        return None if converter is None else converter(source, ask)
    except (OverflowError, ZeroDivisionError):
        return None


def _guess(source: Source, ask: Ask) -> Any:
    node = source.node
    if node.type in _AVERAGES:
        return _AVERAGES[node.type]
    if node.type == "LIGHT_PATH":
        return float(source.socket.name == "Is Camera Ray")
    if node.type in {"TEX_BRICK", "TEX_CHECKER"}:
        return _blend(0.5, ask(source.input("Color1")), ask(source.input("Color2")))
    if node.type == "VALTORGB" and constant(source.input(node.inputs[0].name)) is None:
        steps = [node.color_ramp.evaluate((step + 0.5) / _RAMP_STEPS) for step in range(_RAMP_STEPS)]
        return tuple(sum(parts) / _RAMP_STEPS for parts in zip(*(step[:3] for step in steps), strict=True))
    return _fold(source, ask)


def _own(source: Source, _ask: Ask) -> Any:
    return value(source.node.outputs[0])


def _combine(source: Source, ask: Ask) -> Any:
    if getattr(source.node, "mode", "RGB") != "RGB":
        return None
    parts = [ask(part) for part in source.inputs()]
    return None if None in parts else tuple(parts)


def _separate(source: Source, ask: Ask) -> Any:
    if getattr(source.node, "mode", "RGB") != "RGB":
        return None
    given = ask(Input(source.node.inputs[0], source.groups))
    place = list(source.node.outputs).index(source.socket)
    return None if given is None or place > 2 else given[place]


def _gamma(source: Source, ask: Ask) -> Any:
    colour, gamma = ask(source.input("Color")), ask(source.input("Gamma"))
    if colour is None or gamma is None:
        return None
    return tuple(max(part, 0.0) ** gamma for part in colour[:3])


def _invert(source: Source, ask: Ask) -> Any:
    share, colour = ask(Input(source.node.inputs[0], source.groups)), ask(source.input("Color"))
    if share is None or colour is None:
        return None
    return tuple(part + share * (1.0 - 2.0 * part) for part in colour[:3])


def _grey(source: Source, ask: Ask) -> Any:
    colour = ask(source.input("Color"))
    return None if colour is None else _luminance(colour)


def _ramp(source: Source, ask: Ask) -> Any:
    place = ask(Input(source.node.inputs[0], source.groups))
    if place is None:
        return None
    result = source.node.color_ramp.evaluate(place)
    return result[3] if source.socket.name == "Alpha" else tuple(result[:3])


def _blackbody(source: Source, ask: Ask) -> Any:
    kelvin = ask(source.input("Temperature"))
    return None if kelvin is None else blackbody(kelvin)


_MIXES: dict[str, Callable[[float, float], float]] = {
    "MIX": lambda a, b: b,
    "MULTIPLY": lambda a, b: a * b,
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "SCREEN": lambda a, b: 1.0 - (1.0 - a) * (1.0 - b),
    "DARKEN": min,
    "LIGHTEN": max,
    "DIFFERENCE": lambda a, b: abs(a - b),
}


def _mix(source: Source, ask: Ask) -> Any:
    node = source.node
    inputs = [Input(socket, source.groups) for socket in node.inputs if socket.enabled]
    if len(inputs) != 3:
        return None
    share, first, second = (ask(one) for one in inputs)
    colours = node.type == "MIX_RGB" or node.data_type == "RGBA"
    operation = _MIXES.get(node.blend_type) if colours else _MIXES["MIX"]
    if operation is None:
        return None
    if isinstance(share, float) and getattr(node, "clamp_factor", True):
        share = min(max(share, 0.0), 1.0)
    # What is not mixed in at all need not be known.
    if share == 0.0:
        return first
    if share == 1.0 and operation is _MIXES["MIX"]:
        return second
    if first is None or second is None or not isinstance(share, float):
        return None
    if not isinstance(first, tuple):
        return first + share * (operation(first, second) - first)
    return _blend(share, first, tuple(operation(a, b) for a, b in zip(first[:3], second[:3], strict=True)))


def _blend(share: float, first: Any, second: Any) -> Any:
    if first is None or second is None:
        return None
    return tuple(a + share * (b - a) for a, b in zip(first[:3], second[:3], strict=True))


_MATH: dict[str, Callable[..., float]] = {
    "ADD": lambda a, b, _: a + b,
    "SUBTRACT": lambda a, b, _: a - b,
    "MULTIPLY": lambda a, b, _: a * b,
    "DIVIDE": lambda a, b, _: a / b if b else 0.0,
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "MINIMUM": lambda a, b, _: min(a, b),
    "MAXIMUM": lambda a, b, _: max(a, b),
    "POWER": lambda a, b, _: a**b if a >= 0.0 or float(b).is_integer() else 0.0,
    "SQRT": lambda a, *_: math.sqrt(max(a, 0.0)),
    "ABSOLUTE": lambda a, *_: abs(a),
    "LESS_THAN": lambda a, b, _: float(a < b),
    "GREATER_THAN": lambda a, b, _: float(a > b),
}


def _math(source: Source, ask: Ask) -> Any:
    operation = _MATH.get(source.node.operation)
    # Inputs that an operation does not use are switched off, but hold a value.
    parts = [ask(Input(socket, source.groups)) for socket in source.node.inputs]
    if operation is None or None in parts:
        return None
    try:
        result = operation(*parts)
    except (OverflowError, ZeroDivisionError):
        return 0.0
    return min(max(result, 0.0), 1.0) if source.node.use_clamp else result


_NODES: dict[str, Callable[[Source, Ask], Any]] = {
    "VALUE": _own,
    "RGB": _own,
    "MATH": _math,
    "MIX": _mix,
    "MIX_RGB": _mix,
    "COMBINE_COLOR": _combine,
    "COMBRGB": _combine,
    "COMBXYZ": _combine,
    "SEPARATE_COLOR": _separate,
    "SEPRGB": _separate,
    "SEPXYZ": _separate,
    "GAMMA": _gamma,
    "INVERT": _invert,
    "RGBTOBW": _grey,
    "VALTORGB": _ramp,
    "BLACKBODY": _blackbody,
}
