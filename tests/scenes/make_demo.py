"""Write demo.blend: a lens maker's desk at dusk, the demo scene of Petzval.

Everything is generated here: geometry by numpy and bmesh, textures by numpy and Pillow. Dedicated to
the public domain (CC0). Run with the Python of an old bpy, so that later Blenders can open the file:

    python tests/scenes/make_demo.py --output tests/scenes/demo.blend
    python tests/scenes/make_demo.py --preview preview.png --size 480 --samples 96
"""

import argparse
import math
import os
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector

sys.path.insert(0, str(Path(__file__).resolve().parent))

import demo_props as props
import demo_room as room
import demo_textures as paint
from demo_materials import glow, linear, packed_image, principled
from demo_mesh import instance, join, placement, smooth_path, to_mesh, to_object, tube

DESK_HEIGHT = 0.75
DESK_WIDTH, DESK_DEPTH = 1.95, 1.25
DESK_CENTRE_Y = 0.0

CAMERA_AT = (0.0, -0.95, 1.02)
CAMERA_TILT = -5.0
CAMERA_TURN = 3.0
SENSOR_WIDTH = 135.0
FOCAL_LENGTH = 102.0
F_STOP = 3.4

HERO_AT = (0.09, 0.10)
HERO_TURN = -33.0

PANORAMA_SIZE = (1024, 2048)
PANORAMA_TURN = -52.0
SKY_STRENGTH = 1.35


class Studio:
    """The scene being built: collections, materials and a few counters."""

    def __init__(self):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.scene = bpy.context.scene
        self.scene.name = "Demo"
        self.materials = {}
        self.collections = {}
        self.emissive_triangles = 0

    def collection(self, name):
        """A collection by name, made on first use."""
        if name not in self.collections:
            self.collections[name] = bpy.data.collections.new(name)
            self.scene.collection.children.link(self.collections[name])
        return self.collections[name]

    def put(self, shape, name, materials, group, **where):
        """Add a shape with the named materials; `where` are `placement` arguments."""
        chosen = [self.materials[m] for m in materials]
        return to_object(shape, name, chosen, self.collection(group), placement(**where))


def make_materials(studio):
    """Paint all textures and make all materials."""
    size = (1024, 1024)
    image = packed_image
    made = studio.materials

    color, rough = paint.wood((2048, 2048), (0.13, 0.06, 0.032), (0.27, 0.14, 0.072), (0.40, 0.23, 0.12), 1, 9, 0.4)
    color, rough = paint.scratched((2048, 2048), color, rough - 0.04, 2)
    scale = (0.8, 0.8)
    made["walnut"] = principled(
        "Walnut", color=(image("walnut", color, quality=84), scale),
        roughness=(image("walnut_roughness", rough[::2, ::2], data=True, quality=78), scale),
    )  # fmt: skip
    color, rough = paint.wood(size, (0.15, 0.035, 0.015), (0.33, 0.10, 0.04), (0.47, 0.18, 0.075), 5, 5, 0.5)
    mahogany, mahogany_rough = (
        image("mahogany", color),
        image("mahogany_roughness", rough - 0.12, data=True, quality=80),
    )
    made["mahogany"] = principled("Mahogany", color=(mahogany, (5, 3)), roughness=(mahogany_rough, (5, 3)))
    made["dark wood"] = principled(
        "Dark wood",
        color=(image("dark_wood", color * (0.42, 0.52, 0.60)), (1.6, 1.2)),
        roughness=(mahogany_rough, (1.6, 1.2)),
    )
    color, rough = paint.floorboards(size, 3)
    made["floor"] = principled(
        "Oak floor",
        color=(image("oak_floor", color), (0.8, 0.55)),
        roughness=(image("oak_floor_roughness", rough, data=True, quality=78), (0.8, 0.55)),
    )
    made["plaster"] = principled(
        "Plaster", color=(image("plaster", paint.plaster(size, (0.50, 0.47, 0.41), 4)), (0.45, 0.45)), roughness=0.85
    )
    made["paint"] = principled(
        "Old paint",
        color=(image("old_paint", paint.plaster((512, 512), (0.62, 0.59, 0.50), 24)), (1.3, 1.3)),
        roughness=0.45,
    )
    made["ceiling"] = principled("Ceiling", color=linear(0.72, 0.69, 0.63), roughness=0.9)

    color, rough = paint.brass(size, 5)
    brass_color, brass_rough = image("brass", color), image("brass_roughness", rough, data=True, quality=82)
    made["brass"] = principled("Brass", color=(brass_color, (3, 6)), roughness=(brass_rough, (3, 6)), metallic=1.0)
    color, rough = paint.engraved_brass((256, 2048), 15)
    made["engraved"] = principled(
        "Engraved brass",
        color=image("engraved", color),
        roughness=image("engraved_roughness", rough, data=True),
        metallic=1.0,
    )
    made["old brass"] = principled(
        "Dull brass",
        color=linear(0.55, 0.42, 0.22),
        roughness=(image("patina", 0.22 + 0.35 * paint.noise(*size, 1.3, (1, 1), 31), data=True, quality=80), (2, 4)),
        metallic=1.0,
    )
    made["black"] = principled("Black lacquer", color=(0.006, 0.006, 0.007), roughness=0.45)
    made["resin"] = principled("Black resin", color=(0.008, 0.007, 0.008), roughness=0.08)

    color, rough = paint.leather(size, (0.30, 0.115, 0.045), (0.60, 0.28, 0.11), 6)
    leather_rough = image("leather_roughness", rough, data=True, quality=80)
    made["leather"] = principled(
        "Cognac leather", color=(image("leather", color), (3, 3)), roughness=(leather_rough, (3, 3))
    )
    color, _ = paint.leather(size, (0.30, 0.040, 0.030), (0.48, 0.10, 0.06), 46)
    made["bellows"] = principled(
        "Bellows leather", color=(image("bellows", color), (5, 5)), roughness=(leather_rough, (5, 5)), specular=0.6
    )

    made["books"] = principled(
        "Book cloth", color=image("book_atlas", paint.book_atlas(2048, 9), quality=84), roughness=0.55
    )
    made["pages"] = principled(
        "Page edges", color=(image("page_edges", paint.page_edges((512, 512), 12)), (14, 4)), roughness=0.85
    )
    made["notebook"] = principled(
        "Notebook", color=image("notebook", paint.notebook((1448, 2048), 10), quality=86), roughness=0.75
    )

    made["glass"] = principled(
        "Glass",
        color=(1, 1, 1),
        transmission=1.0,
        ior=1.52,
        roughness=(image("smudges", paint.smudges((512, 512), 71), data=True), (2, 8)),
    )
    made["lens glass"] = principled("Lens glass", color=(0.985, 0.99, 1.0), transmission=1.0, ior=1.55, roughness=0.0)
    made["whisky"] = principled("Whisky", color=linear(0.93, 0.60, 0.20), transmission=1.0, ior=1.35, roughness=0.0)

    made["leaf"] = principled("Leaf", color=image("leaf", paint.leaf((512, 256), 11)), roughness=0.38)
    made["stem"] = principled("Stem", color=linear(0.33, 0.36, 0.18), roughness=0.6)
    made["terracotta"] = principled(
        "Terracotta",
        color=(image("terracotta", paint.plaster((512, 512), (0.62, 0.33, 0.21), 81)), (3, 9)),
        roughness=0.8,
    )
    made["soil"] = principled("Soil", color=linear(0.14, 0.10, 0.07), roughness=0.95)
    made["rug"] = principled("Kilim", color=image("rug", paint.rug((768, 1280), 8), quality=86), roughness=0.95)
    made["fringe"] = principled("Fringe", color=linear(0.72, 0.65, 0.51), roughness=0.9)
    made["linen"] = principled(
        "Linen",
        color=(
            image("linen", paint.weave((1024, 1024), (0.42, 0.22, 0.16), (0.36, 0.17, 0.12), 7, 160), quality=80),
            (3.5, 3.5),
        ),
        roughness=0.9,
    )
    made["lace"] = principled(
        "Lace",
        color=linear(0.86, 0.84, 0.78),
        roughness=0.9,
        alpha=(image("lace", paint.lace((512, 512), 14), data=True, png=True), (2.5, 2.5)),
    )
    made["shade"] = principled(
        "Lamp shade", color=(image("shade", paint.weave((512, 512), (0.80, 0.66, 0.46), (0.78, 0.62, 0.42), 17, 96)), (4, 4)),
        roughness=0.9, emission=(1.0, 0.52, 0.20), emission_strength=1.6,
    )  # fmt: skip
    made["enamel"] = principled("Green enamel", color=linear(0.07, 0.22, 0.16), roughness=0.16)
    made["white enamel"] = principled("White enamel", color=linear(0.90, 0.87, 0.80), roughness=0.35)
    made["globe"] = principled("Globe", color=image("globe", paint.globe_map((512, 1024), 12)), roughness=0.28)
    made["dial"] = principled("Dial", color=image("dial", paint.clock_face(768)), roughness=0.22)
    made["painting"] = principled("Painting", color=image("painting", paint.landscape((640, 896), 13)), roughness=0.35)
    made["painting 2"] = principled(
        "Painting 2", color=image("painting_2", paint.landscape((640, 512), 23, warm=False)), roughness=0.35
    )
    made["wax"] = principled("Wax", color=linear(0.86, 0.79, 0.62), roughness=0.4)
    made["red paint"] = principled("Red paint", color=linear(0.55, 0.11, 0.06), roughness=0.3)
    made["bare wood"] = principled("Bare wood", color=linear(0.78, 0.60, 0.38), roughness=0.7)
    made["ribbon"] = principled("Ribbon", color=linear(0.48, 0.07, 0.07), roughness=0.6)
    made["wire"] = principled("Wire", color=linear(0.10, 0.08, 0.06), roughness=0.5)
    made["copper wire"] = principled("Copper wire", color=linear(0.85, 0.52, 0.34), roughness=0.25, metallic=1.0)

    warm = (1.0, 0.50, 0.17)
    made["fairy"] = glow("Fairy light", warm, 26.0)
    made["festoon"] = glow("Festoon bulb", (1.0, 0.47, 0.15), 17.0)
    made["festoon far"] = glow("Far festoon bulb", (1.0, 0.44, 0.13), 15.0)
    made["flame"] = glow("Flame", (1.0, 0.58, 0.20), 60.0)
    made["bulb"] = glow("Desk bulb", (1.0, 0.60, 0.27), 150.0)


def build_rooms(studio):
    """Walls, floors, windows, curtains, bookcase with books, pictures."""
    group = "Rooms"
    studio.put(room.walls(), "Walls", ["plaster"], group)
    studio.put(room.ceilings(), "Ceilings", ["ceiling"], group)
    studio.put(room.floor(), "Floor", ["floor"], group, z=-0.002)
    for k, opening in enumerate(room.WINDOWS):
        studio.put(room.window_joinery(*opening, columns=2 + 2 * (k == 0)), f"Window {k + 1}", ["paint"], group)
    studio.put(room.door_casing(), "Door casing", ["paint"], group)
    y0, y1, z0, z1 = room.WINDOWS[1]
    for name, y, width, turn, tie in (("near", y0 - 0.20, 0.36, 90, 0.35), ("far", y1 - 0.12, 0.32, 90, 0.3)):
        drape = props.curtain(width, 2.3, 7, 0.045, 3, tie)
        studio.put(drape, f"Curtain {name}", ["linen"], group, x=room.LEFT + 0.11, y=y, z=0.08, rz=turn)
    lace = props.curtain(0.75, 0.80, 9, 0.022, 8, rows=15)
    studio.put(lace, "Lace curtain", ["lace"], group, x=room.LEFT - 0.03, y=y1 - 0.78, z=z1 - 0.84, rz=90)
    rod = tube([(room.LEFT + 0.11, y0 - 0.3, z1 + 0.06), (room.LEFT + 0.11, y1 + 0.22, z1 + 0.06)], 0.012, 16)
    studio.put(rod, "Curtain rod", ["old brass"], group)
    studio.put(
        props.picture(0.52, 0.66, 0.07),
        "Picture on the wall",
        ["old brass", "painting 2"],
        group,
        x=2.32,
        y=room.BACK - 0.02,
        z=1.62,
    )
    studio.put(
        room.wall_clock(0.13), "Wall clock", ["dark wood", "brass", "dial"], group, x=-1.56, y=room.BACK - 0.05, z=1.70
    )
    build_bookcase(studio)


def build_bookcase(studio):
    """The bookcase behind the desk, full of linked books, with a few objects between them."""
    width, height, depth = 1.95, 2.05, 0.28
    x0, y0 = 0.12, room.BACK - 0.01
    case, shelves = room.bookcase(width, height, depth, 6)
    studio.put(case, "Bookcase", ["dark wood"], "Rooms", x=x0, y=y0)
    rng = np.random.default_rng(20)
    prototypes = []
    for k, (shape, thickness, tall, deep) in enumerate(room.book_prototypes(32, 21)):
        mesh = to_mesh(shape, f"Book {k + 1}")
        mesh.materials.append(studio.materials["books"])
        mesh.materials.append(studio.materials["pages"])
        prototypes.append((mesh, thickness, tall, deep))
    books = studio.collection("Books")
    for z in shelves:
        for start, end in ((0.04, width / 2 - 0.02), (width / 2 + 0.02, width - 0.04)):
            x = start
            while x < end - 0.06:
                mesh, thickness, tall, _ = prototypes[rng.integers(len(prototypes))]
                if x + thickness > end or tall > 0.30:
                    break
                lean = rng.uniform(-9, -3) if rng.random() < 0.06 else 0.0
                matrix = placement(x0 + x, y0 - depth + 0.03 + rng.uniform(0, 0.02), z, ry=lean, rz=rng.normal(0, 0.8))
                instance(mesh, "Shelf book", books, matrix)
                x += thickness + 0.0008 + (0.035 if lean else 0)
                if rng.random() < 0.03:
                    x += rng.uniform(0.05, 0.16)
    studio.prototypes = prototypes


def lay_books(studio, indices, x, y, z, turn, rng):
    """A pile of lying books from the prototypes; returns the height of its top."""
    for k in indices:
        mesh, thickness, tall, deep = studio.prototypes[k]
        twist = turn + rng.normal(0, 5)
        lie = Matrix.Translation((x + rng.normal(0, 0.004), y + rng.normal(0, 0.004), z))
        lie = lie @ Matrix.Rotation(math.radians(twist), 4, "Z") @ Matrix.Rotation(math.radians(90), 4, "Y")
        lie = lie @ Matrix.Translation((-thickness, -deep / 2, -tall / 2))
        instance(mesh, "Desk book", studio.collection("Desk"), lie)
        z += thickness + 0.0004
    return z


def build_desk(studio):
    """The desk and the still life on it."""
    group = "Desk"
    top = DESK_HEIGHT
    rng = np.random.default_rng(33)
    studio.put(room.table(DESK_WIDTH, DESK_DEPTH, top), "Desk", ["walnut"], group, y=DESK_CENTRE_Y)

    hx, hy = HERO_AT
    studio.put(props.kilim(0.66, 0.40), "Kilim", ["rug", "fringe"], group, x=0.0, y=-0.02, z=top, rz=4)
    # Two big volumes under the camera.
    stand = [(0.27, 0.36, 0.040, 12, -33 - 90), (0.255, 0.335, 0.032, 5, -29 + 90)]
    z = top + 0.006
    for k, (deep, tall, thick, cell, turn) in enumerate(stand):
        shape = props.book(deep, tall, thick, cell).at(-thick, -deep / 2, -tall / 2).at(ry=90)
        studio.put(shape, f"Folio {k + 1}", ["books", "pages"], group, x=hx, y=hy, z=z, rz=turn + 90)
        z += thick + 0.0005
    hero = props.field_camera()
    slots = ["mahogany", "brass", "bellows", "black", "lens glass", "engraved"]
    studio.put(hero, "Field camera", slots, group, x=hx, y=hy, z=z + 0.001, rz=HERO_TURN)
    turn = math.radians(HERO_TURN)
    tip = 0.125 + 0.012 + 0.128
    studio.focus = Vector((hx + tip * math.sin(turn), hy - tip * math.cos(turn), z + 0.16))

    studio.put(
        props.open_notebook(),
        "Notebook",
        ["notebook", "pages", "leather", "ribbon"],
        group,
        x=-0.35,
        y=-0.17,
        z=top,
        rz=9,
    )
    studio.put(
        props.loupe(), "Loupe", ["brass", "lens glass", "dark wood"], group, x=-0.265, y=-0.17, z=top + 0.014, rz=38
    )
    studio.put(props.fountain_pen(), "Pen", ["resin", "brass"], group, x=-0.385, y=-0.262, z=top + 0.013, rz=-20)

    glass, liquid = props.tumbler()
    for shape, name, slot in ((glass, "Tumbler", "glass"), (liquid, "Whisky", "whisky")):
        studio.put(shape, name, [slot], group, x=0.385, y=-0.12, z=top + 0.0003)
    bottle, spirit = props.decanter()
    for shape, name, slot in ((bottle, "Decanter", "glass"), (spirit, "Decanted whisky", "whisky")):
        studio.put(shape, name, [slot], group, x=0.53, y=0.10, z=top + 0.0003)

    studio.put(
        props.pocket_watch(),
        "Pocket watch",
        ["brass", "dial", "lens glass"],
        group,
        x=0.215,
        y=-0.225,
        z=top + 0.0265,
        rx=58,
        rz=-12,
    )
    studio.put(
        props.wedge(0.040, 0.030, 0.042), "Watch stand", ["mahogany"], group, x=0.222, y=-0.198, z=top + 0.003, rz=-12
    )
    links = props.chain(
        [
            (0.235, -0.185, top + 0.050),
            (0.262, -0.195, top + 0.030),
            (0.285, -0.235, top + 0.002),
            (0.265, -0.290, top),
            (0.300, -0.330, top),
            (0.340, -0.310, top),
            (0.330, -0.270, top),
            (0.365, -0.255, top),
        ]
    )
    studio.put(links, "Watch chain", ["brass"], group)
    for k, (radius, centre, edge, x, y) in enumerate(
        (
            (0.024, 0.010, 0.004, -0.10, -0.33),
            (0.017, 0.009, 0.003, -0.045, -0.365),
            (0.030, 0.012, 0.004, -0.155, -0.285),
            (0.013, 0.006, 0.003, 0.045, -0.345),
        )
    ):
        studio.put(
            props.optical_element(radius, centre, edge),
            f"Loose lens {k + 1}",
            ["lens glass", "brass"],
            group,
            x=x,
            y=y,
            z=top + 0.003,
        )

    lamp = props.desk_lamp()
    studio.put(lamp, "Desk lamp", ["brass", "enamel", "white enamel", "bulb"], group, x=0.60, y=0.42, z=top, rz=18)
    studio.emissive_triangles += 320
    studio.put(props.globe(), "Globe", ["globe", "brass", "dark wood"], group, x=-0.92, y=0.36, z=top, rz=40)
    studio.put(
        props.cup_of_pencils(), "Pencils", ["brass", "red paint", "bare wood", "black"], group, x=-0.36, y=0.24, z=top
    )
    studio.put(props.candlestick(), "Candlestick", ["brass", "wax", "black", "flame"], group, x=-0.50, y=0.06, z=top)
    studio.put(props.plant(5), "Plant", ["leaf", "stem", "terracotta", "soil"], group, x=-0.70, y=0.34, z=top, rz=20)
    lay_books(studio, [20, 6, 11, 27], 0.80, 0.20, top + 0.0004, 100, rng)
    lay_books(studio, [2, 17], -0.80, 0.02, top + 0.0004, 80, rng)


def build_furniture(studio):
    """The middle distance and the far room."""
    group = "Furniture"
    studio.put(props.armchair(), "Armchair", ["leather", "dark wood", "old brass"], group, x=1.25, y=2.35, rz=-38)
    studio.put(props.floor_lamp(), "Floor lamp", ["old brass", "shade"], group, x=1.95, y=2.95)
    studio.emissive_triangles += 40 * 4 * 3 * 2
    studio.put(
        props.telescope(), "Telescope", ["old brass", "dark wood", "black", "lens glass"], group, x=-1.28, y=2.75, rz=8
    )
    sill = room.WINDOWS[1][2] + 0.004
    studio.put(
        props.plant(8, 11, 0.22, 0.09, 0.05, 0.13),
        "Sill plant",
        ["leaf", "stem", "terracotta", "soil"],
        group,
        x=room.LEFT - 0.04,
        y=3.25,
        z=sill,
    )
    studio.put(
        props.plant(9, 7, 0.15, 0.07, 0.05, 0.09),
        "Sill plant 2",
        ["leaf", "stem", "terracotta", "soil"],
        group,
        x=room.LEFT - 0.03,
        y=2.55,
        z=sill,
    )
    studio.put(room.table(1.5, 0.9, 0.75), "Far table", ["walnut"], group, x=-0.95, y=7.3)
    seat = to_mesh(props.chair(), "Chair")
    seat.materials.append(studio.materials["dark wood"])
    for k, (x, y, turn) in enumerate(((-1.35, 6.65, 184), (-0.55, 6.7, 172), (-0.5, 7.9, 6), (-1.3, 7.95, -4))):
        instance(seat, f"Chair {k + 1}", studio.collection(group), placement(x, y, 0, rz=turn))
    studio.put(room.table(1.3, 0.42, 0.80), "Console", ["dark wood"], group, x=-1.35, y=room.FAR_BACK - 0.26)
    studio.put(
        props.picture(0.86, 0.62, 0.09),
        "Far painting",
        ["dark wood", "painting"],
        group,
        x=-1.35,
        y=room.FAR_BACK - 0.03,
        z=1.62,
    )
    shade = join([props.drum_shade(0.15, 0.19).at(z=0.33).slot(1), props.candlestick().at().slot(0)])
    studio.put(shade, "Far lamp", ["dark wood", "shade"], group, x=-1.72, y=room.FAR_BACK - 0.27, z=0.80)
    studio.emissive_triangles += 40 * 4 * 3 * 2
    studio.put(
        props.plant(14, 10, 0.9, 0.34, 0.15, 0.5, 4),
        "Far palm",
        ["leaf", "stem", "terracotta", "soil"],
        group,
        x=-0.65,
        y=9.9,
    )


def build_lights_strings(studio):
    """Fairy lights on the desk, and festoons from over the desk through the doorway to the far wall."""
    group = "String lights"
    top = DESK_HEIGHT
    path = smooth_path(
        [
            (-0.31, -0.42, 1.50), (-0.205, -0.62, 1.14), (-0.152, -0.698, 0.965), (-0.200, -0.62, 0.84), (-0.21, -0.49, top + 0.006), (-0.08, -0.43, top + 0.003),
            (0.10, -0.42, top + 0.003), (0.24, -0.40, top + 0.003), (0.27, -0.345, top + 0.004), (0.19, -0.31, top + 0.006), (0.06, -0.285, top + 0.009), (-0.06, -0.24, top + 0.010), (-0.17, -0.16, top + 0.010),
            (-0.24, 0.00, top + 0.010), (-0.20, 0.16, top + 0.008), (-0.22, 0.32, top + 0.004), (-0.05, 0.40, top + 0.01),
            (0.20, 0.42, top + 0.03), (0.42, 0.46, top + 0.02), (0.57, 0.44, top + 0.05), (0.605, 0.42, top + 0.25),
        ],
        900,
    )  # fmt: skip
    wiggle = 0.006 * np.stack([np.sin(np.arange(900) * 0.12), np.cos(np.arange(900) * 0.155), np.zeros(900)], axis=-1)
    path = path + wiggle
    studio.put(tube(path, 0.0006, 6), "Fairy wire", ["copper wire"], group)
    points = room.hung_lights(path, 0.052, 0.02) + [0, 0, 0.003]
    radii = np.full(len(points), 0.0030)
    distance = np.linalg.norm(points - np.array(CAMERA_AT), axis=1)
    fine = (distance > 0.75) & (distance < 1.05)
    add_bulbs(studio, points, radii, fine, "Fairy lights", "fairy", group)

    door_top = room.DOOR[2]
    anchors = [
        (1.55, -0.10, 1.72),
        (-0.40, room.BACK - 0.03, door_top + 0.02),
        (-1.7, 7.6, 2.30),
        (-0.2, room.FAR_BACK - 0.1, 2.62),
    ]
    hang_festoon(studio, room.spans(anchors[:2], [0.42]), 0.235, "Festoon", "festoon", group)
    hang_festoon(studio, room.spans(anchors[1:], [0.30, 0.10]), 0.60, "Far festoon", "festoon far", group)
    anchors = [
        (room.LEFT + 0.12, 1.2, 2.30),
        (room.LEFT + 0.14, 4.1, 2.34),
        (-0.1, room.BACK - 0.05, 2.32),
        (2.4, room.BACK - 0.06, 2.36),
    ]
    cable = room.spans(anchors, [0.20, 0.22, 0.20])
    hang_festoon(studio, cable, 0.27, "Wall festoon", "festoon", group)
    rng = np.random.default_rng(12)
    curtain = []
    for x in np.linspace(-1.9, -0.5, 4):
        for z in np.arange(2.45, 1.0 + 0.5 * rng.random(), -0.50):
            curtain.append((x + rng.normal(0, 0.08), room.FAR_BACK - 0.08, z + rng.uniform(-0.15, 0.15)))
    curtain = np.array([p for p in curtain if not (-1.9 < p[0] < -0.8 and p[2] < 2.05)])
    add_bulbs(studio, curtain, np.full(len(curtain), 0.036), None, "Far curtain of lights", "festoon far", group)


def hang_festoon(studio, cable, spacing, name, material, group):
    """A cable with sockets and bulbs whose size follows the blur disc at their distance."""
    points = room.hung_lights(cable, spacing, spacing / 2)
    distance = np.linalg.norm(points - np.array(CAMERA_AT), axis=1)
    radii = np.clip(0.0042 * (distance - 0.55), 0.006, 0.036)
    studio.put(room.wire(cable), f"{name} cable", ["wire"], group)
    sockets = []
    for p, r in zip(points, radii, strict=True):
        sockets.append(tube([p, p - [0, 0, 1.6 * r]], r * 0.55, 10))
    studio.put(join(sockets), f"{name} sockets", ["wire"], group)
    drop = np.stack([0 * radii, 0 * radii, 2.5 * radii], axis=-1)
    add_bulbs(studio, points - drop, radii, None, name, material, group)


def add_bulbs(studio, points, radii, fine, name, material, group):
    """One mesh for all bulbs of a string."""
    shape = props.bulbs(points, radii, fine)
    studio.emissive_triangles += len(shape.faces)
    studio.put(shape, name, [material], group)


def build_world(studio):
    """The dusk panorama as a packed environment texture, turned by a Mapping node."""
    height, width = PANORAMA_SIZE
    radiance = paint.dusk_panorama(PANORAMA_SIZE, 3, 0.5)
    image = bpy.data.images.new("dusk", width, height, float_buffer=True)
    image.colorspace_settings.name = "Linear Rec.709"
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = radiance[::-1]
    image.pixels.foreach_set(pixels.ravel())
    settings = studio.scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth, settings.exr_codec = (
        "OPEN_EXR",
        "RGB",
        "16",
        "DWAA",
    )
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "dusk.exr")
        image.save_render(path, scene=studio.scene)
        blob = Path(path).read_bytes()
    bpy.data.images.remove(image)
    settings.file_format = "PNG"
    image = bpy.data.images.new("dusk", 8, 8)
    image.source = "FILE"
    image.filepath = "//textures/dusk.exr"
    image.pack(data=blob, data_len=len(blob))
    image.colorspace_settings.name = "Linear Rec.709"

    world = bpy.data.worlds.new("Dusk")
    studio.scene.world = world
    world.use_nodes = True
    tree = world.node_tree
    background = tree.nodes["Background"]
    background.inputs["Strength"].default_value = SKY_STRENGTH
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    mapping = tree.nodes.new("ShaderNodeMapping")
    mapping.inputs["Rotation"].default_value = (0, 0, math.radians(PANORAMA_TURN))
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])


def add_light(studio, name, kind, where, power, color, **settings):
    """A lamp; `settings` are attributes of the light, `aim` a point that it looks at."""
    aim = settings.pop("aim", None)
    light = bpy.data.lights.new(name, kind)
    light.energy, light.color = power, color
    for key, value in settings.items():
        setattr(light, key, value)
    obj = bpy.data.objects.new(name, light)
    obj.location = where
    if aim is not None:
        obj.rotation_euler = (Vector(aim) - Vector(where)).to_track_quat("-Z", "Y").to_euler()
    studio.collection("Lights").objects.link(obj)
    return obj


def build_lights(studio):
    """Blue dusk through the near window (an area light out of the picture) and warm lamps."""
    y0, y1, z0, z1 = room.WINDOWS[0]
    add_light(
        studio, "Dusk in the near window", "AREA", (room.LEFT - 0.18, (y0 + y1) / 2, (z0 + z1) / 2), 180.0, (0.52, 0.70, 1.0),
        aim=(0.0, (y0 + y1) / 2, (z0 + z1) / 2), shape="RECTANGLE", size=y1 - y0, size_y=z1 - z0,
    )  # fmt: skip
    add_light(studio, "Floor lamp light", "POINT", (1.95, 2.95, 1.44), 110.0, (1.0, 0.58, 0.26), shadow_soft_size=0.10)
    add_light(
        studio, "Lamp behind the photographer", "AREA", (0.95, -1.75, 1.65), 32.0, (1.0, 0.72, 0.46),
        aim=(0.1, 0.1, 0.9), shape="DISK", size=0.40,
    )  # fmt: skip
    add_light(
        studio,
        "Far lamp light",
        "POINT",
        (-1.72, room.FAR_BACK - 0.27, 1.22),
        40.0,
        (1.0, 0.56, 0.24),
        shadow_soft_size=0.08,
    )
    add_light(studio, "Far room light", "POINT", (0.5, 7.0, 2.3), 110.0, (1.0, 0.60, 0.30), shadow_soft_size=0.25)
    add_light(
        studio, "Shelf light", "SPOT", (0.75, 2.9, 2.60), 300.0, (1.0, 0.62, 0.32),
        aim=(0.85, 4.2, 1.2), spot_size=math.radians(95), spot_blend=0.8, shadow_soft_size=0.12,
    )  # fmt: skip


def build_camera(studio):
    """The camera, focused on an empty at the front of the brass lens."""
    focus = bpy.data.objects.new("Focus", None)
    focus.location = studio.focus
    focus.empty_display_size = 0.03
    studio.scene.collection.objects.link(focus)
    data = bpy.data.cameras.new("Camera")
    data.sensor_fit, data.sensor_width, data.sensor_height = "HORIZONTAL", SENSOR_WIDTH, SENSOR_WIDTH * 9 / 16
    data.lens = FOCAL_LENGTH
    data.clip_start, data.clip_end = 0.05, 200.0
    data.dof.use_dof = True
    data.dof.focus_object = focus
    data.dof.aperture_fstop = F_STOP
    camera = bpy.data.objects.new("Camera", data)
    camera.location = CAMERA_AT
    camera.rotation_euler = (math.radians(90 + CAMERA_TILT), 0, math.radians(CAMERA_TURN))
    studio.scene.collection.objects.link(camera)
    studio.scene.camera = camera


def set_render(studio):
    """Resolution, view transform, and Cycles as the reference renderer."""
    scene = studio.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = 1280, 720
    scene.render.resolution_percentage = 100
    scene.render.filepath = "//demo"
    cycles = scene.cycles
    cycles.samples, cycles.max_bounces = 256, 8
    cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = cycles.transparent_max_bounces = 8
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = 0.0
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    scene.view_settings.view_transform = "AgX"
    scene.view_settings.look = "AgX - Medium High Contrast"
    scene.view_settings.exposure = 0.0


def report(studio):
    """Print what the scene holds."""
    graph = bpy.context.evaluated_depsgraph_get()
    total, unique = 0, {}
    for item in graph.object_instances:
        obj = item.object
        if obj.type == "MESH":
            mesh = obj.data
            count = sum(len(p.vertices) - 2 for p in mesh.polygons) if mesh.name not in unique else unique[mesh.name]
            unique[mesh.name] = count
            total += count
    print(f"triangles: {total} drawn, {sum(unique.values())} unique; emissive about {studio.emissive_triangles}")
    packed = sum(i.packed_file.size for i in bpy.data.images if i.packed_file)
    print(
        f"images: {len(bpy.data.images)}, packed {packed / 1e6:.1f} MB; focus {tuple(round(c, 3) for c in studio.focus)}"
    )


def preview(path, width, samples, denoise):
    """Render the scene with Cycles into a PNG."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = width, width * 9 // 16
    scene.cycles.samples = samples
    scene.cycles.use_denoising = denoise
    scene.render.filepath = str(Path(path).resolve())
    bpy.ops.render.render(write_still=True)


def main():
    """Build, then save or render."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", help="write the .blend here")
    parser.add_argument("--preview", help="render a PNG here")
    parser.add_argument("--size", type=int, default=480, help="width of the preview")
    parser.add_argument("--samples", type=int, default=96)
    parser.add_argument("--denoise", action="store_true")
    options = parser.parse_args()
    studio = Studio()
    make_materials(studio)
    build_rooms(studio)
    build_desk(studio)
    build_furniture(studio)
    build_lights_strings(studio)
    build_world(studio)
    build_lights(studio)
    build_camera(studio)
    set_render(studio)
    report(studio)
    if options.output:
        bpy.context.preferences.filepaths.save_version = 0
        bpy.ops.wm.save_as_mainfile(filepath=str(Path(options.output).resolve()), compress=True)
        print(f"{options.output}: {os.path.getsize(options.output) / 1e6:.1f} MB")
    if options.preview:
        preview(options.preview, options.size, options.samples, options.denoise)


if __name__ == "__main__":
    main()
