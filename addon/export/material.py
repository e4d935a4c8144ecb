# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials: the shader nodes of each, as a graph for the engine."""

from __future__ import annotations

import json
from typing import Any

import bpy

from petzval.description import MaterialDescription

from . import attributes, nodes
from .aovs import Aovs
from .graph import describe as describe_graph
from .image import Images
from .kept import Kept, uid
from .report import Report

#: The number of smoke, which no material has.
_SMOKE = -1
#: From this version on the material of an empty slot is a Principled BSDF, before it a Diffuse BSDF.
_DEFAULT_IS_PRINCIPLED = (5, 0, 0)


class Materials:
    """The materials of one scene, by the engine's index."""

    def __init__(
        self, kept: Kept, images: Images, aovs: Aovs, report: Report, override: bpy.types.Material | None = None
    ) -> None:
        self._builder = kept.builder
        self._kept = kept
        #: The material of everything, in place of its own.
        self.override = override
        self._aovs = aovs
        self._images = images
        self._report = report
        self._known = kept.materials
        self._wanted = kept.wanted
        #: The attributes that rays of any material ask of surfaces that they hit.
        self.of_rays = _of_rays()

    def index(self, material: bpy.types.Material | None) -> int:
        """The engine's index of a material; an empty slot gets Blender's default grey."""
        material = self.override or material
        key = uid(material)
        if key not in self._known:
            self._add(key, _default() if material is None else self.describe(material))
        return self._known[key]

    def _add(self, key: int, described: MaterialDescription) -> None:
        self._known[key] = self._builder.add_material(described)
        self._kept.changes += 1

    def volume_index(self, material: bpy.types.Material | None) -> int:
        """The engine's index of a volume object's material; without one it is smoke."""
        material = self.override or material
        if material is not None:
            return self.index(material)
        self._kept.fills_space = True
        if _SMOKE not in self._known:
            smoke = _one_node("ShaderNodeVolumePrincipled", {}, "volume", "Volume")
            self._add(_SMOKE, MaterialDescription("(smoke)", json.dumps(smoke)))
        return self._known[_SMOKE]

    def wanted(self, material: bpy.types.Material | None) -> frozenset[str]:
        """The attributes that a material asks of meshes, and `of_rays`."""
        material = self.override or material
        self.index(material)
        return self.of_rays | (frozenset() if material is None else self._wanted.get(uid(material), frozenset()))

    def describe(self, material: bpy.types.Material) -> MaterialDescription:
        """The description of a material for the engine."""
        if material.grease_pencil is not None or not uses_nodes(material):
            described = MaterialDescription(material.name, json.dumps(_without_nodes(material)))
        else:
            described = self._of_nodes(material)
        described.pass_index = material.pass_index
        described.transparent_shadows = getattr(material, "use_transparent_shadow", True)
        cycles = getattr(material, "cycles", None)
        described.corrects_bumps = getattr(cycles, "use_bump_map_correction", True)
        described.emission_sampling = getattr(cycles, "emission_sampling", "AUTO")
        return described

    def _of_nodes(self, material: bpy.types.Material) -> MaterialDescription:
        tree, owner, key = material.node_tree, f"Material '{material.name}'", uid(material)
        if tree.get_output_node("CYCLES") is None:
            self._report.warn(f"{owner}: it has no Material Output node, its surface is black")
        graph = describe_graph(tree, lambda node: self._images.of_node(node, material))
        self._kept.fills_space |= graph["volume"] is not None
        self._wanted[key] = attributes.wanted(graph)
        described = MaterialDescription(
            material.name, json.dumps(graph), displacement_method=material.displacement_method
        )
        found = self._aovs.describe(tree, lambda node: self._images.of_node(node, material))
        if found is not None:
            described.aovs = json.dumps(found[0]), found[1]
            self._wanted[key] |= attributes.wanted(found[0])
        return described


def _of_rays() -> frozenset[str]:
    """The attributes that Raycast nodes ask of whatever they hit."""
    if not hasattr(bpy.types, "ShaderNodeRaycast"):
        return frozenset()
    trees = [one.node_tree for one in bpy.data.materials if one.node_tree is not None]
    trees += [one for one in bpy.data.node_groups if one.type == "SHADER"]
    rays = [node for tree in trees for node in tree.nodes if node.type == nodes.RAYCAST]
    return frozenset(one.default_value for node in rays for one in node.inputs if one.type == "STRING")


def uses_nodes(holder: bpy.types.ID) -> bool:
    """True if a material, world or light is made of nodes."""
    if holder.node_tree is None:
        return False
    # From 5.0 on materials and worlds always are, and asking is deprecated.
    always = bpy.app.version >= (5, 0, 0) and not isinstance(holder, bpy.types.Light)
    return always or holder.use_nodes


def _default() -> MaterialDescription:
    """Cycles' material of an empty slot."""
    kind = "ShaderNodeBsdfPrincipled" if bpy.app.version >= _DEFAULT_IS_PRINCIPLED else "ShaderNodeBsdfDiffuse"
    return MaterialDescription("(none)", json.dumps(_one_node(kind, {})))


def _without_nodes(material: bpy.types.Material) -> dict[str, Any]:
    """The graph that Cycles gives a material without nodes."""
    return _one_node("ShaderNodeBsdfDiffuse", {"Color": list(material.diffuse_color[:3])})


def _one_node(kind: str, inputs: dict[str, Any], end: str = "surface", socket: str = "BSDF") -> dict[str, Any]:
    """A graph of one node."""
    node = {"type": kind, "name": kind, "options": {}, "inputs": inputs}
    ends = {"surface": None, "volume": None, "displacement": None, end: {"node": 0, "socket": socket}}
    return {"nodes": [node], **ends}
