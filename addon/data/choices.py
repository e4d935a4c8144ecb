# SPDX-License-Identifier: GPL-3.0-or-later
"""The choices of the settings: identifier, name, tooltip. No bpy."""

from __future__ import annotations

# The numbers are those in saved files.
MODELS = (
    ("LENS", "Lens", "A real lens: every ray is traced through its surfaces", "", 0),
    (
        "IMAGE_BASED",
        "Image-Based",
        "The lens as a table of its rays at one wavelength (Heidrich 1997): all that it does but colour, at the same cost "
        "for any lens",
        "",
        5,
    ),
    ("PARAXIAL", "Paraxial", "The lens to first order: no aberrations and no vignetting, but colours apart", "", 3),
    ("THICK", "Thick Lens", "The lens's principal planes and pupils: perfect images, the right size and blur", "", 4),
    ("THIN", "Thin Lens", "Depth of field without aberrations, framed by Blender's own focal length", "", 1),
    ("PINHOLE", "Pinhole", "Everything sharp, framed by Blender's own focal length", "", 2),
    (
        "CALIBRATED",
        "Calibrated",
        "Each ray as a calibration of a real camera has it: OpenCV, COLMAP, ROS, Kalibr, Basalt, NVIDIA, 3DEqualizer, or an ST map",
        "",
        6,
    ),
)
# The numbers are those in saved files.
FOCAL_MODES = (
    (
        "BLENDER",
        "As Blender Frames",
        "The whole lens scaled, a zoom lens zoomed, until it frames what Blender's own focal length, sensor and shift frame",
        "",
        3,
    ),
    ("PUBLISHED", "As Published", "The lens at the size in which it was published", "", 0),
    ("LENGTH", "Focal Length", "The whole lens scaled to a focal length", "", 1),
    ("SCALE", "Scale", "The whole lens scaled by a factor", "", 2),
)
FOCUS_MODES = (
    ("CAMERA", "Object or Distance", "The camera's own depth of field settings: its focus object, else its distance"),
    ("INFINITY", "Infinity", "What is infinitely far is sharp"),
    ("FILM", "Film Distance", "The film stands at a distance behind the lens; what is sharp follows"),
    (
        "AUTO",
        "Autofocus",
        "What is seen at a point of the picture, when it is rendered: the smallest spot of exact rays",
    ),
)
ANCHORS = (
    (
        "ENTRANCE_PUPIL",
        "Entrance Pupil",
        "The no-parallax point: the camera view frames the same picture at all depths",
    ),
    ("FRONT_VERTEX", "Front Vertex", "The middle of the front glass"),
    ("FILM", "Film", "The film stays and the lens moves; distances are those on the scale of a lens barrel"),
)
FOCUS_RELATIONS = (
    ("EXACT", "Exact", "The lens's own conjugates, from the camera's place on"),
    ("THIN", "Thin Lens", "1/U + 1/V = 1/f, the distances counted from the principal planes"),
)
COATINGS = (
    ("AS_FILE", "As Lens File", "What the lens file says; a single layer of MgF2 where it says nothing"),
    ("NONE", "Uncoated", "Bare glass, as before 1940"),
    ("MGF2", "Single Layer", "A quarter of a wave of magnesium fluoride wherever glass meets air"),
    ("DOUBLE", "Two Layers", "Two quarter waves wherever glass meets air"),
    ("TRIPLE", "Three Layers", "Quarter, half and quarter of a wave wherever glass meets air: broadband"),
)
# The numbers are those in saved files.
FILM_MODES = (
    ("SENSOR", "Camera Sensor", "The camera's own sensor size and fit", "", 0),
    (
        "LENS",
        "Of the Lens",
        "The film for which the lens is made, as its file says, else as large as its design's field of view; the picture is the largest "
        "part of it with the picture's shape",
        "",
        2,
    ),
    (
        "SIZE",
        "Film Size",
        "A film of its own size; the picture is the largest part of it with the picture's shape",
        "",
        1,
    ),
)

PRECISIONS = (
    (
        "AUTO",
        "Automatic",
        "Single precision where it moves no ray by more than a hundredth of a pixel, else double",
        "",
        0,
    ),
    ("F32", "Single", "The quicker one, whatever it moves", "", 1),
    ("F64", "Double", "The exact one", "", 2),
)
SPECTRA = (
    ("VISIBLE", "Visible Light", "Light of all visible wavelengths, each bent as the glass bends it", "", 0),
    (
        "THREE",
        "Three Wavelengths",
        "One wavelength for each of red, green and blue: fringes come in three steps",
        "",
        1,
    ),
    ("SINGLE", "One Wavelength", "The picture keeps its colours and shows the lens without its dispersion", "", 2),
)
INTEGRATORS = (
    ("PATH", "Path Tracing", "Light is looked for from the camera", "", 0),
    (
        "BIDIRECTIONAL",
        "Bidirectional",
        "From the lights, too: for caustics and small lamps. Needs the real lens, with one scale for all axes",
        "",
        1,
    ),
)
PIPELINES = (
    ("AUTO", "Automatic", "Hero where the glass parts the colours, else from the film", "", 0),
    ("FILM", "From the Film", "Each path starts on the film, in one wavelength", "", 1),
    (
        "SCENE",
        "From the Scene",
        "Each path starts between a sharp point and the entrance pupil, for all wavelengths",
        "",
        3,
    ),
    (
        "HERO",
        "Hero Wavelength",
        "One wavelength leads; its path serves seven others, which land where they must",
        "",
        2,
    ),
)
PIXEL_SIZES = (
    ("1", "1x", "As fine as the screen", "", 0),
    ("2", "2x", "A quarter as many pixels", "", 1),
    ("4", "4x", "A sixteenth as many", "", 2),
    ("8", "8x", "A sixty-fourth as many", "", 3),
)
#: The kinds of bake, as Blender names them. The numbers are those in saved files, and Cycles'.
BAKE_TYPES = (
    ("COMBINED", "Combined", "All light that the surface sends out", "", 0),
    ("AO", "Ambient Occlusion", "How much of the surroundings is open, nothing near in the way", "", 1),
    ("SHADOW", "Shadow", "The part of the light that other objects leave", "", 2),
    ("POSITION", "Position", "Place in the world", "", 11),
    ("NORMAL", "Normal", "Normals, those of bump and normal maps too", "", 3),
    ("UV", "UV", "Texture coordinates of the UV map that is rendered", "", 4),
    ("ROUGHNESS", "Roughness", "Roughness of the material", "", 5),
    ("EMIT", "Emission", "Light that the material sends out by itself", "", 6),
    ("ENVIRONMENT", "Environment", "The world, in the direction of the surface from the world's origin", "", 7),
    ("DIFFUSE", "Diffuse", "Light or colour of diffuse shaders", "", 8),
    ("GLOSSY", "Glossy", "Light or colour of shaders that reflect", "", 9),
    ("TRANSMISSION", "Transmission", "Light or colour of shaders that let light through", "", 10),
)
