"""Materials of the demo scene: one Principled BSDF each, fed by constants and packed images only."""

import io

import bpy
import numpy as np
from PIL import Image

JPEG_QUALITY = 88


def packed_image(name, array, data=False, quality=JPEG_QUALITY, png=False):
    """Encode a 0..1 array as a JPEG (or PNG) that lives inside the .blend only."""
    pixels = np.clip(array * 255 + 0.5, 0, 255).astype(np.uint8)
    stream = io.BytesIO()
    extension = "png" if png else "jpg"
    if png:
        Image.fromarray(pixels).save(stream, "PNG", optimize=True)
    else:
        Image.fromarray(pixels).save(stream, "JPEG", quality=quality, optimize=True)
    blob = stream.getvalue()
    image = bpy.data.images.new(name, 8, 8)
    image.source = "FILE"
    image.filepath = f"//textures/{name}.{extension}"
    image.pack(data=blob, data_len=len(blob))
    image.colorspace_settings.name = "Non-Color" if data else "sRGB"
    return image


def principled(name, **settings):
    """A material with a single Principled BSDF.

    Settings are socket values by short name; an image (or an (image, (scale_x, scale_y)) or
    (image, (scale_x, scale_y), (shift_x, shift_y)) tuple, which adds a Mapping node) becomes a texture.
    """
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    shader = tree.nodes["Principled BSDF"]
    sockets = {
        "color": "Base Color",
        "metallic": "Metallic",
        "roughness": "Roughness",
        "ior": "IOR",
        "specular": "Specular IOR Level",
        "transmission": "Transmission Weight",
        "alpha": "Alpha",
        "emission": "Emission Color",
        "emission_strength": "Emission Strength",
    }
    row = 0
    for key, value in settings.items():
        socket = shader.inputs[sockets[key]]
        if isinstance(value, bpy.types.Image) or (isinstance(value, tuple) and isinstance(value[0], bpy.types.Image)):
            image, *mapping = value if isinstance(value, tuple) else (value,)
            texture = tree.nodes.new("ShaderNodeTexImage")
            texture.image = image
            texture.location = (-400, 300 - 300 * row)
            tree.links.new(texture.outputs["Color"], socket)
            if mapping:
                uv = tree.nodes.new("ShaderNodeUVMap")
                uv.uv_map = "UVMap"
                uv.location = (-900, 300 - 300 * row)
                node = tree.nodes.new("ShaderNodeMapping")
                node.location = (-650, 300 - 300 * row)
                node.inputs["Scale"].default_value = (*mapping[0], 1.0)
                if len(mapping) > 1:
                    node.inputs["Location"].default_value = (*mapping[1], 0.0)
                tree.links.new(uv.outputs["UV"], node.inputs["Vector"])
                tree.links.new(node.outputs["Vector"], texture.inputs["Vector"])
            row += 1
        elif isinstance(value, (tuple, list)):
            socket.default_value = (*value, 1.0)
        else:
            socket.default_value = value
    return material


def glow(name, color, strength):
    """A material with a single Emission node, for bulbs."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.remove(tree.nodes["Principled BSDF"])
    emission = tree.nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value = (*color, 1.0)
    emission.inputs["Strength"].default_value = strength
    tree.links.new(emission.outputs["Emission"], tree.nodes["Material Output"].inputs["Surface"])
    return material


def linear(r, g, b):
    """An sRGB colour in 0..1 as the linear triple that node sockets take."""
    c = np.array((r, g, b), float)
    return tuple(np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4).tolist())
