# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials: the surface shader of each as the engine's Principled BSDF, exactly or by the nearest there is."""

from __future__ import annotations

import json

import bpy

from ..description import MaterialDescription, Report
from . import attributes, nodes, shaders
from .aovs import Aovs
from .graph import describe as describe_graph
from .image import Images
from .kept import Kept, uid
from .texture import Inputs

#: No material has this number.
_SMOKE = -1


class Materials:
    """The materials of one scene, by the engine's index."""

    def __init__(
        self, kept: Kept, images: Images, aovs: Aovs, report: Report, override: bpy.types.Material | None = None
    ) -> None:
        self._builder = kept.builder
        self._kept = kept
        #: What everything is made of instead.
        self.override = override
        self._aovs = aovs
        self._images = images
        self._report = report
        self._known = kept.materials
        self._wanted = kept.wanted

    def index(self, material: bpy.types.Material | None) -> int:
        """The engine's index of a material; an empty slot gets Blender's default grey."""
        material = self.override or material
        key = uid(material)
        if key not in self._known:
            described = MaterialDescription("(none)") if material is None else self.describe(material)
            self._add(key, described)
        return self._known[key]

    def _add(self, key: int, described: MaterialDescription) -> None:
        self._known[key] = self._builder.add_material(described)
        self._kept.changes += 1

    def volume_index(self, material: bpy.types.Material | None) -> int:
        """The same for a volume object, which without one is smoke."""
        material = self.override or material
        if material is not None:
            return self.index(material)
        self._kept.fills_space = True
        if _SMOKE not in self._known:
            node = {"type": "ShaderNodeVolumePrincipled", "name": "Principled Volume", "options": {}, "inputs": {}}
            link = {"node": 0, "socket": "Volume"}
            graph = {"nodes": [node], "surface": None, "volume": link, "displacement": None}
            described = MaterialDescription("(smoke)", graph=json.dumps(graph))
            self._add(_SMOKE, described)
        return self._known[_SMOKE]

    def wanted(self, material: bpy.types.Material | None) -> frozenset[str]:
        """The attributes that a material asks of meshes."""
        material = self.override or material
        self.index(material)
        return frozenset() if material is None else self._wanted.get(uid(material), frozenset())

    def describe(self, material: bpy.types.Material) -> MaterialDescription:
        """What the engine is told of a material: by the short way, where that says all; else all of its nodes."""
        described = self._surface(material)
        described.pass_index = material.pass_index
        if uses_nodes(material):
            owner = f"Material '{material.name}'"
            found = self._aovs.describe(material.node_tree, lambda node: self._images.of_node(node, owner))
            if found is not None:
                described.aovs = json.dumps(found[0]), found[1]
                key = uid(material)
                self._wanted[key] = self._wanted.get(key, frozenset()) | attributes.wanted(found[0])
        return described

    def _surface(self, material: bpy.types.Material) -> MaterialDescription:
        report = Report()
        try:
            described = self._by_the_short_way(material, report)
        except nodes.TooLarge:
            described = None
        if described is not None and not report.warnings:
            numbers = [
                layer.numbers.get(name.lower(), 0.0) for layer in described.layers for name in attributes.STRETCH
            ]
            if any(number != 0.0 for number in numbers):
                self._wanted[uid(material)] = frozenset({attributes.GENERATED})
            return described
        output = material.node_tree.get_output_node("CYCLES")
        if output is None:
            self._report.warnings += report.warnings
            return described
        owner = f"Material '{material.name}'"
        graph = describe_graph(material.node_tree, lambda node: self._images.of_node(node, owner))
        self._kept.fills_space |= graph["volume"] is not None
        self._wanted[uid(material)] = attributes.wanted(graph)
        return MaterialDescription(
            material.name,
            graph=json.dumps(graph),
            displacement_method=material.displacement_method,
        )

    def _by_the_short_way(self, material: bpy.types.Material, report: Report) -> MaterialDescription:
        if material.grease_pencil is not None or not uses_nodes(material):
            return _plain(material)
        inputs = Inputs(f"Material '{material.name}'", self._images, report)
        output = material.node_tree.get_output_node("CYCLES")
        if output is None:
            inputs.warn("it has no Material Output node, its surface is black")
            return MaterialDescription(material.name, base_color=(0.0, 0.0, 0.0), specular=False)
        for name in ("Volume", "Displacement"):
            if isinstance(nodes.trace(nodes.Input(output.inputs[name])), nodes.Source):
                inputs.warn(f"its {name.lower()} is told by its nodes alone")
        found = nodes.trace(nodes.Input(output.inputs["Surface"]))
        if not isinstance(found, nodes.Source):
            # Nothing to hit but a volume's border; without a volume Blender shows black.
            through = output.inputs["Volume"].is_linked
            return MaterialDescription(
                material.name, base_color=(0.0, 0.0, 0.0), specular=False, alpha=0.0 if through else 1.0
            )
        return shaders.describe(found, material.name, inputs)


def uses_nodes(holder: bpy.types.ID) -> bool:
    """Whether a material, world or light is made of nodes."""
    if holder.node_tree is None:
        return False
    # From 5.0 on materials and worlds always are, and asking is deprecated.
    always = bpy.app.version >= (5, 0, 0) and not isinstance(holder, bpy.types.Light)
    return always or holder.use_nodes


def _plain(material: bpy.types.Material) -> MaterialDescription:
    return MaterialDescription(
        material.name,
        base_color=tuple(material.diffuse_color[:3]),
        metallic=material.metallic,
        roughness=material.roughness,
    )
