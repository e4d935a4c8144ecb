# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials: a shader graph as the one Principled surface that comes nearest, with a word where it is not exact."""

from __future__ import annotations

import bpy

from ..description import MaterialDescription, Report
from .image import Images
from .inputs import Inputs
from .nodes import Output, constant, output_surface

# Parts of Principled that the engine does not have: input names, and what they are called.
_PRINCIPLED_MISSING = (
    (("Subsurface Weight",), "subsurface scattering"),
    (("Coat Weight",), "coat"),
    (("Sheen Weight",), "sheen"),
    (("Diffuse Roughness",), "diffuse roughness"),
    (("Anisotropic",), "anisotropy"),
    (("Thin Film Thickness",), "thin film"),
)


class Materials:
    """The materials of a scene, sent once each."""

    def __init__(self, builder, images: Images, report: Report) -> None:
        self._builder = builder
        self._images = images
        self._report = report
        self._sent: dict[str, int] = {}

    def of(self, obj: bpy.types.Object) -> list[int]:
        """The engine's numbers for an object's slots; Blender's default grey for empty ones."""
        slots = [slot.material for slot in obj.material_slots]
        if not slots and hasattr(obj.data, "materials"):
            slots = list(obj.data.materials)
        return [self._index(material) for material in slots]

    def _index(self, material: bpy.types.Material | None) -> int:
        key = material.name_full if material else ""
        if key not in self._sent:
            description = self._describe(material) if material else MaterialDescription("(none)")
            self._sent[key] = self._builder.add_material(description)
        return self._sent[key]

    def _describe(self, material: bpy.types.Material) -> MaterialDescription:
        if material.node_tree is None or not getattr(material, "use_nodes", True):
            return MaterialDescription(
                material.name,
                base_color=tuple(material.diffuse_color)[:3],
                metallic=material.metallic,
                roughness=material.roughness,
            )
        found = output_surface(material.node_tree)
        return _Surface(material.name, self._images, self._report).describe(found)


class _Surface:
    def __init__(self, name: str, images: Images, report: Report) -> None:
        self._name = name
        self._inputs = Inputs(name, images, report)
        self._report = report

    def describe(self, shader: Output | None) -> MaterialDescription:
        if shader is None:
            # Nothing linked: black, as in Cycles.
            return MaterialDescription(self._name, base_color=(0.0, 0.0, 0.0), specular=False)
        known = {
            "BSDF_PRINCIPLED": self._principled,
            "BSDF_DIFFUSE": self._diffuse,
            "EMISSION": self._emission,
            "BSDF_GLOSSY": self._glossy,
            "BSDF_METALLIC": self._metallic,
            "BSDF_GLASS": self._glass,
            "BSDF_REFRACTION": self._glass,
            "BSDF_TRANSPARENT": self._transparent,
            "MIX_SHADER": self._mix,
            "ADD_SHADER": self._add,
        }.get(shader.node.type)
        if known is not None:
            return known(shader)
        self._warn(f"shader '{shader.node.name}' ({shader.node.bl_label}) is not supported yet; shown as diffuse")
        return self._diffuse(shader)

    def _warn(self, text: str) -> None:
        self._report.warn(f"material '{self._name}': {text}")

    def _principled(self, n: Output) -> MaterialDescription:
        for names, what in _PRINCIPLED_MISSING:
            socket = n.input(*names)
            if socket is not None and constant(socket) != 0.0:
                self._warn(f"{what} is not supported yet; left out")
        self._warn_normal(n)
        i = self._inputs
        return MaterialDescription(
            self._name,
            base_color=i.colour(n, (0.8, 0.8, 0.8), "Base Color"),
            metallic=i.number(n, 0.0, "Metallic"),
            roughness=i.number(n, 0.5, "Roughness"),
            ior=i.plain(n, 1.5, "IOR"),
            specular_ior_level=i.plain(n, 0.5, "Specular IOR Level"),
            specular_tint=i.plain_colour(n, (1.0, 1.0, 1.0), "Specular Tint"),
            transmission=i.number(n, 0.0, "Transmission Weight", "Transmission"),
            alpha=i.number(n, 1.0, "Alpha"),
            emission_color=i.colour(n, (1.0, 1.0, 1.0), "Emission Color", "Emission"),
            emission_strength=i.plain(n, 0.0, "Emission Strength"),
        )

    def _diffuse(self, n: Output) -> MaterialDescription:
        self._warn_normal(n)
        return MaterialDescription(
            self._name, base_color=self._inputs.colour(n, (0.8, 0.8, 0.8), "Color", "Base Color"), specular=False
        )

    def _emission(self, n: Output) -> MaterialDescription:
        return MaterialDescription(
            self._name,
            base_color=(0.0, 0.0, 0.0),
            specular=False,
            emission_color=self._inputs.colour(n, (1.0, 1.0, 1.0), "Color"),
            emission_strength=self._inputs.plain(n, 1.0, "Strength"),
        )

    def _glossy(self, n: Output) -> MaterialDescription:
        self._warn_normal(n)
        return MaterialDescription(
            self._name,
            base_color=self._inputs.colour(n, (0.8, 0.8, 0.8), "Color"),
            metallic=1.0,
            roughness=self._inputs.number(n, 0.5, "Roughness"),
        )

    def _metallic(self, n: Output) -> MaterialDescription:
        if n.node.fresnel_type != "F82":
            self._warn(f"shader '{n.node.name}': metal by its physical index is not supported yet; its colour is used")
        return MaterialDescription(
            self._name,
            base_color=self._inputs.colour(n, (0.62, 0.58, 0.54), "Base Color"),
            specular_tint=self._inputs.plain_colour(n, (1.0, 1.0, 1.0), "Edge Tint"),
            metallic=1.0,
            roughness=self._inputs.number(n, 0.5, "Roughness"),
        )

    def _glass(self, n: Output) -> MaterialDescription:
        self._warn_normal(n)
        if n.node.type == "BSDF_REFRACTION":
            self._warn(f"shader '{n.node.name}': refraction without reflection is shown as glass")
        tint = self._inputs.plain_colour(n, (1.0, 1.0, 1.0), "Color")
        return MaterialDescription(
            self._name,
            # Principled tints what it transmits by the root of its colour, a glass node by its colour.
            base_color=tuple(min(c, 1.0) ** 2 for c in tint),
            specular_tint=tint,
            roughness=self._inputs.number(n, 0.0, "Roughness"),
            ior=self._inputs.plain(n, 1.5, "IOR"),
            transmission=1.0,
        )

    def _transparent(self, n: Output) -> MaterialDescription:
        tint = self._inputs.plain_colour(n, (1.0, 1.0, 1.0), "Color")
        if min(tint) < 1.0:
            self._warn(f"shader '{n.node.name}': the tint of transparency is not supported yet; shown as clear")
        return MaterialDescription(self._name, alpha=0.0)

    def _mix(self, n: Output) -> MaterialDescription:
        factor = n.input("Fac", "Factor")
        first, second = (s.source() for s in list(n.inputs())[1:3])
        first, second = (s if isinstance(s, Output) else None for s in (first, second))
        part = constant(factor)
        if part is not None and part <= 0.0:
            return self.describe(first)
        if part is not None and part >= 1.0:
            return self.describe(second)
        # Something cut out of transparency: the factor is its alpha.
        if _is(first, "BSDF_TRANSPARENT") and not _is(second, "BSDF_TRANSPARENT"):
            material = self.describe(second)
            material.alpha = part if part is not None else self._inputs.of(factor, 1.0, colour=False)
            return material
        if _is(second, "BSDF_TRANSPARENT") and not _is(first, "BSDF_TRANSPARENT"):
            material = self.describe(first)
            if part is None:
                self._warn(f"shader '{n.node.name}': its factor cannot be inverted yet; shown as opaque")
            else:
                material.alpha = 1.0 - part
            return material
        self._warn(f"shader '{n.node.name}': mixing shaders is not supported yet; the stronger one is shown")
        return self.describe(second if part is not None and part > 0.5 else first)

    def _add(self, n: Output) -> MaterialDescription:
        sources = [s.source() for s in n.inputs()]
        shaders = [s for s in sources if isinstance(s, Output)]
        glow = next((s for s in shaders if _is(s, "EMISSION")), None)
        rest = [s for s in shaders if s is not glow]
        if not rest:
            return self.describe(glow)
        material = self.describe(rest[0])
        if glow is not None:
            emitting = self._emission(glow)
            material.emission_color = emitting.emission_color
            material.emission_strength = emitting.emission_strength
        if len(rest) > 1:
            self._warn(f"shader '{n.node.name}': adding shaders is not supported yet; the first is shown")
        return material

    def _warn_normal(self, n: Output) -> None:
        socket = n.input("Normal")
        if socket is not None and isinstance(socket.source(), Output):
            self._warn("bump and normal maps are not supported yet; shown smooth")


def _is(shader: Output | None, node_type: str) -> bool:
    return shader is not None and shader.node.type == node_type
