# SPDX-License-Identifier: GPL-3.0-or-later
"""What surfaces do with light: Principled's sockets and the other shaders, one each."""

from __future__ import annotations

from . import scene
from .studio import (
    BLUE,
    CREAM,
    DARK,
    GOLD,
    GREEN,
    RED,
    WHITE,
    ball,
    cube,
    empty_studio,
    lamp,
    material,
    monkey,
    plain,
    plane,
)


def _pair(first, second) -> None:
    """A head and a ball beside it."""
    empty_studio()
    monkey(first, (-0.75, 0.0, 0.85), 1.7, turn=20)
    ball(second, (1.15, -0.3, 0.8), 0.8)


@scene("Principled: paint and plastic")
def principled_plastic():
    _pair(plain(RED, Roughness=0.25), plain(BLUE, Roughness=0.5, Specular_IOR_Level=0.8))


@scene("Principled: metal, smooth and rough")
def principled_metal():
    _pair(plain(GOLD, Metallic=1.0, Roughness=0.35), plain((0.7, 0.72, 0.75, 1.0), Metallic=1.0, Roughness=0.08))


@scene("Principled: half metal, tinted gloss")
def principled_specular_tint():
    _pair(
        plain(GREEN, Metallic=0.4, Roughness=0.3),
        plain(DARK, Roughness=0.3, Specular_Tint=GOLD, Specular_IOR_Level=0.9),
    )


@scene("Principled: clear glass (light through it by paths that meet the lamp)")
def principled_glass():
    # A lamp that is large: what shines through glass is found by paths alone, in both programs.
    empty_studio(lit=False)
    lamp("AREA", 500.0, (0.0, -1.0, 5.0), shape="SQUARE", size=5.0)
    ball(plain(WHITE, Transmission_Weight=1.0, Roughness=0.0, IOR=1.5), (-0.9, 0.0, 0.9), 0.9)
    cube(plain((0.75, 0.9, 0.8, 1.0), Transmission_Weight=1.0, Roughness=0.0, IOR=1.33), (1.0, -0.3, 0.65), 1.2)


@scene("Principled: rough glass", tolerance=0.03, why="Cycles' rough refraction is brighter; docs/design/closures.md")
def principled_rough_glass():
    empty_studio(lit=False)
    lamp("AREA", 500.0, (0.0, -1.0, 5.0), shape="SQUARE", size=5.0)
    ball(plain(WHITE, Transmission_Weight=1.0, Roughness=0.3, IOR=1.45), (-0.9, 0.0, 0.9), 0.9)
    cube(plain(GOLD, Transmission_Weight=0.6, Roughness=0.2, IOR=1.6), (1.0, -0.3, 0.65), 1.2)


@scene("Principled: coat, clear and tinted")
def principled_coat():
    _pair(
        plain(RED, Roughness=0.6, Coat_Weight=1.0, Coat_Roughness=0.05),
        plain(CREAM, Roughness=0.5, Coat_Weight=0.8, Coat_Roughness=0.15, Coat_Tint=GOLD, Coat_IOR=1.8),
    )


@scene("Principled: sheen")
def principled_sheen():
    _pair(
        plain(DARK, Roughness=0.8, Sheen_Weight=1.0, Sheen_Roughness=0.3, Sheen_Tint=GOLD),
        plain(BLUE, Roughness=0.8, Sheen_Weight=0.7, Sheen_Roughness=0.6),
    )


@scene("Principled: brushed metal")
def principled_anisotropic():
    _pair(
        plain(GOLD, Metallic=1.0, Roughness=0.35, Anisotropic=0.8),
        plain(WHITE, Metallic=1.0, Roughness=0.3, Anisotropic=0.6, Anisotropic_Rotation=0.25),
    )


@scene("Principled: wax and skin", noise=0.02)
def principled_subsurface():
    _pair(
        plain(CREAM, Subsurface_Weight=1.0, Subsurface_Radius=(0.4, 0.2, 0.1), Subsurface_Scale=0.5),
        plain((0.8, 0.5, 0.4, 1.0), Subsurface_Weight=0.6, Subsurface_Radius=(0.3, 0.1, 0.05), Subsurface_Scale=0.4),
    )


@scene("Principled: what glows")
def principled_emission():
    empty_studio(0.1, lit=False)
    monkey(plain(DARK, Emission_Color=(1.0, 0.45, 0.15, 1.0), Emission_Strength=4.0), (-0.8, 0.2, 0.85), 1.7, turn=20)
    ball(plain(CREAM, Roughness=0.2), (1.15, -0.3, 0.8), 0.8)


@scene("Principled: alpha")
def principled_alpha():
    _pair(plain(RED, Alpha=0.6), plain(GREEN, Alpha=0.25, Roughness=0.1))


@scene("Principled: thin film", noise=0.02)
def principled_thin_film():
    def film(**inputs):
        inputs = {"Thin_Film_Thickness": 450.0, "Thin_Film_IOR": 1.4, **inputs}
        return plain(**inputs)

    _pair(
        film(colour=DARK, Roughness=0.05), film(colour=WHITE, Metallic=1.0, Roughness=0.15, Thin_Film_Thickness=600.0)
    )


@scene("Diffuse, smooth and rough")
def diffuse():
    _pair(material(lambda t: t.shows(t.diffuse(RED))), material(lambda t: t.shows(t.diffuse(CREAM, Roughness=0.8))))


@scene("Glossy: GGX, Beckmann")
def glossy():
    _pair(
        material(lambda t: t.shows(t.glossy(GOLD, 0.35, "MULTI_GGX"))),
        material(lambda t: t.shows(t.glossy(CREAM, 0.3, "BECKMANN"))),
    )


@scene("Glass and Refraction shaders, smooth")
def glass():
    empty_studio(lit=False)
    lamp("AREA", 500.0, (0.0, -1.0, 5.0), shape="SQUARE", size=5.0)
    clear = material(lambda t: t.shows(t.node("BsdfGlass", Roughness=0.0, IOR=1.5).outputs[0]))
    bent = material(lambda t: t.shows(t.node("BsdfRefraction", Color=CREAM, Roughness=0.0, IOR=1.3).outputs[0]))
    monkey(clear, (-0.75, 0.0, 0.85), 1.7, turn=20)
    ball(bent, (1.15, -0.3, 0.8), 0.8)


@scene("Translucent paper before a lamp")
def translucent():
    empty_studio(0.2, lit=False)
    sheet = material(lambda t: t.shows(t.mix(0.4, t.diffuse(CREAM), t.node("BsdfTranslucent", Color=GOLD).outputs[0])))
    plane(sheet, (0.0, 0.0, 1.3), 2.4, (80, 0, 15))
    lamp("POINT", 250.0, (0.6, 1.6, 1.8), shadow_soft_size=0.3)
    cube(plain(RED), (-0.5, 0.7, 0.4), 0.8)


@scene("Transparent, tinted, in front of things")
def transparent():
    empty_studio()
    tinted = material(lambda t: t.shows(t.node("BsdfTransparent", Color=(0.9, 0.6, 0.5, 1.0)).outputs[0]))
    ball(tinted, (-0.6, -0.8, 1.0), 0.8)
    monkey(plain(GREEN), (0.3, 0.6, 1.0), 1.8)


@scene("Sheen shader")
def sheen():
    _pair(
        material(lambda t: t.shows(t.node("BsdfSheen", Color=GOLD, Roughness=0.4).outputs[0])),
        material(
            lambda t: t.shows(
                t.node("AddShader", _0=t.diffuse(DARK), _1=t.node("BsdfSheen", Color=BLUE, Roughness=0.6).outputs[0])
                .outputs[0]
            )
        ),
    )  # fmt: skip


@scene("Metallic shader: F82 and physical")
def metallic():
    f82 = {"fresnel_type": "F82"}
    physical = {"fresnel_type": "PHYSICAL_CONDUCTOR"}
    _pair(
        material(
            lambda t: t.shows(t.node("BsdfMetallic", f82, Base_Color=GOLD, Edge_Tint=CREAM, Roughness=0.3).outputs[0])
        ),
        material(lambda t: t.shows(t.node("BsdfMetallic", physical, Roughness=0.15).outputs[0])),
    )


@scene("Subsurface Scattering shader", noise=0.02)
def subsurface():
    def body(radius):
        return material(
            lambda t: t.shows(
                t.node(
                    "SubsurfaceScattering", {"falloff": "RANDOM_WALK"}, Color=CREAM, Scale=0.3, Radius=radius
                ).outputs[0]
            )
        )

    _pair(body((1.0, 0.5, 0.2)), body((0.2, 0.5, 1.0)))


@scene("Shaders mixed by Fresnel, and added")
def mixed_shaders():
    def coat(t):
        t.shows(t.mix(t.node("Fresnel", IOR=1.6).outputs[0], t.diffuse(GREEN), t.glossy(roughness=0.15)))

    def added(t):
        t.shows(t.node("AddShader", _0=t.diffuse((0.3, 0.1, 0.1, 1.0)), _1=t.glossy((0.3,) * 3 + (1.0,))).outputs[0])

    _pair(material(coat), material(added))


@scene("Emission shader by the side that is seen")
def emission_one_sided():
    empty_studio(0.1, lit=False)

    def one_side(t):
        back = t.node("NewGeometry").outputs["Backfacing"]
        t.shows(t.mix(back, t.node("Emission", Color=CREAM, Strength=6.0).outputs[0], t.diffuse(BLUE)))

    plane(material(one_side), (-1.3, 0.3, 1.2), 1.6, (90, 0, 60))
    monkey(plain(CREAM), (0.8, 0.0, 0.9), 1.6, turn=-20)


@scene("Hair shader: mirrored and come through, on a mesh, under an even sky")
def hair():
    """By the triangles' own edges, and along a tangent."""
    empty_studio(lit=False, strength=1.0)
    shaders = (
        lambda t: t.node("BsdfHair", Color=GOLD, RoughnessU=0.4, RoughnessV=0.7),
        lambda t: t.node("BsdfHair", {"component": "Transmission"}, Color=WHITE, RoughnessU=0.5, RoughnessV=0.5),
        lambda t: t.node("BsdfHair", Color=RED, RoughnessU=0.2, RoughnessV=1.0, Offset=0.3, Tangent=_around_z(t)),
    )
    for i, shader in enumerate(shaders):
        ball(material(lambda t, shader=shader: t.shows(shader(t).outputs[0])), (1.7 * i - 1.7, 0.0, 0.75), 0.75)


@scene("Principled Hair (Chiang) by absorption, melanin and colour, on a mesh, under an even sky")
def principled_hair():
    """Where lamps light a mesh of it, Cycles leaves out half of the directions; docs/design/closures.md."""
    empty_studio(lit=False, strength=1.0)
    cases = (
        {"parametrization": "ABSORPTION", "Absorption_Coefficient": (0.2, 0.5, 1.3), "Roughness": 0.5},
        {"parametrization": "MELANIN", "Melanin": 0.35, "Melanin_Redness": 0.6, "Tint": (1.0, 0.8, 0.7, 1.0)},
        {"parametrization": "COLOR", "Color": BLUE, "Roughness": 0.4, "Radial_Roughness": 0.6, "Random_Roughness": 0.2},
    )
    for i, case in enumerate(cases):
        settings = {"model": "CHIANG", "parametrization": case.pop("parametrization")}
        made = material(lambda t, s=settings, c=case: t.shows(t.node("BsdfHairPrincipled", s, **c).outputs[0]))
        ball(made, (1.7 * i - 1.7, 0.0, 0.75), 0.75)


def _around_z(t):
    return t.node("Tangent", {"direction_type": "RADIAL", "axis": "Z"}).outputs[0]
