"""Painted image textures of the demo scene, made of nothing but numpy noise and Pillow drawing.

Every painter returns a float array in 0..1, (height, width, 3) sRGB colour or (height, width) numbers;
`dusk_panorama` returns linear radiance instead. All are deterministic.
"""

import math

import numpy as np
from PIL import Image, ImageDraw, ImageFilter


def noise(height, width, beta=1.6, stretch=(1.0, 1.0), seed=0, low=0.0):
    """Tileable power-law noise, equalised to 0..1. `stretch` (y, x) elongates the features.

    `low` removes features longer than 1/low of the picture.
    """
    rng = np.random.default_rng(seed)
    fy = np.fft.fftfreq(height)[:, None] * height * stretch[0]
    fx = np.fft.rfftfreq(width)[None, :] * width * stretch[1]
    f = np.hypot(fy, fx)
    f[0, 0] = 1.0
    amplitude = f ** (-beta) * (f >= low)
    amplitude[0, 0] = 0.0
    spectrum = np.fft.rfft2(rng.normal(size=(height, width))) * amplitude
    field = np.fft.irfft2(spectrum, s=(height, width))
    # Map through a soft normal distribution rather than by rank: fast, and keeps the tails.
    return np.clip(0.5 + field / (5.0 * field.std()), 0, 1)


def smooth(edge0, edge1, x):
    """Smoothstep."""
    t = np.clip((x - edge0) / (edge1 - edge0), 0, 1)
    return t * t * (3 - 2 * t)


def mix(a, b, t):
    """Blend colours or fields; a scalar field is broadcast over the channels."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    if np.ndim(t) == 2 and (a.ndim in (1, 3) or b.ndim in (1, 3)):
        t = t[..., None]
    return a * (1 - t) + b * t


def ramp(field, stops):
    """Colour ramp: stops are (position, (r, g, b))."""
    at = [s[0] for s in stops]
    return np.stack([np.interp(field, at, [s[1][k] for s in stops]) for k in range(3)], axis=-1)


def wood(size, dark, middle, light, seed, rings=7.0, figure=0.5):
    """Colour and roughness of a plank; the grain runs along V."""
    h, w = size
    x = np.linspace(0, 1, w)[None, :] * np.ones((h, 1))
    wander = noise(h, w, 2.2, (3.0, 1.0), seed)
    phase = rings * (x + figure * (wander - 0.5))
    ring = phase - np.floor(phase)
    ring = np.where(ring < 0.82, ring / 0.82, (1 - ring) / 0.18)
    fibre = noise(h, w, 0.75, (26.0, 1.0), seed + 1, low=20)
    pores = smooth(0.70, 0.86, noise(h, w, 0.35, (34.0, 1.0), seed + 2, low=60))
    cloud = noise(h, w, 1.8, (2.0, 1.0), seed + 3)
    tone = 0.45 * ring + 0.35 * fibre + 0.35 * cloud - 0.08
    color = ramp(tone, [(0.1, light), (0.5, middle), (0.95, dark)])
    color = mix(color, np.array(dark) * 0.55, pores * 0.6)
    rough = 0.34 + 0.16 * fibre + 0.22 * pores + 0.14 * (cloud - 0.5)
    return np.clip(color, 0, 1), np.clip(rough, 0.05, 1)


def scratched(size, color, rough, seed, scratches=160, rings=6):
    """Years of use on a desk top: scratches, glass rings, dull and polished patches, ink spots."""
    h, w = size
    rng = np.random.default_rng(seed)
    marks = Image.new("L", (w, h), 0)
    draw = ImageDraw.Draw(marks)
    for _ in range(scratches):
        x, y = rng.uniform(0, w), rng.uniform(0, h)
        angle, length = rng.uniform(0, 2 * math.pi), rng.exponential(0.04) * w
        points = [(x, y)]
        for _ in range(5):
            angle += rng.normal(0, 0.08)
            points.append((points[-1][0] + length / 5 * math.cos(angle), points[-1][1] + length / 5 * math.sin(angle)))
        draw.line(points, fill=int(rng.uniform(40, 170)), width=1)
    for _ in range(rings):
        x, y, r = rng.uniform(0, w), rng.uniform(0, h), rng.uniform(0.021, 0.026) * w
        start = rng.uniform(0, 360)
        draw.arc((x - r, y - r, x + r, y + r), start, start + rng.uniform(140, 330), fill=110, width=4)
    for _ in range(14):
        x, y, r = rng.uniform(0, w), rng.uniform(0, h), rng.exponential(3.0) + 1
        draw.ellipse((x - r, y - r, x + r, y + r * 0.8), fill=200)
    mark = np.asarray(marks.filter(ImageFilter.GaussianBlur(0.8)), float) / 255
    patches = noise(h, w, 1.5, (1, 1), seed + 1)
    smear = noise(h, w, 1.2, (1, 4), seed + 2, low=4)
    color = color * (1 - 0.45 * mark[..., None]) * (0.86 + 0.28 * patches[..., None])
    rough = rough + 0.30 * mark + 0.30 * (patches - 0.5) + 0.22 * (smear - 0.5)
    return np.clip(color, 0, 1), np.clip(rough, 0.08, 0.9)


def floorboards(size, seed, boards=8):
    """Old oak boards laid side by side (grain along V), each from another part of the tree."""
    h, w = size
    rng = np.random.default_rng(seed)
    base, rough = wood((h, w), (0.17, 0.085, 0.045), (0.35, 0.19, 0.10), (0.48, 0.29, 0.16), seed, 22, 0.12)
    color, width = base.copy(), w // boards
    for b in range(boards):
        part = slice(b * width, (b + 1) * width)
        shift = int(rng.uniform(0, h))
        color[:, part] = np.roll(base[:, part], shift, 0) * rng.uniform(0.72, 1.15)
    wear = noise(h, w, 1.5, (1, 1), seed + 5)
    return np.clip(color, 0, 1), np.clip(rough + 0.10 + 0.4 * (wear - 0.5), 0.15, 0.95)


def plaster(size, tint, seed):
    """Lime-washed wall: brush clouds, stains, hairline cracks."""
    h, w = size
    cloud = noise(h, w, 1.7, (1, 1), seed)
    brush = noise(h, w, 0.9, (1.0, 2.5), seed + 1, low=6)
    fine = noise(h, w, 0.4, (1, 1), seed + 2, low=40)
    stain = smooth(0.62, 0.85, noise(h, w, 2.0, (1.0, 1.6), seed + 3))
    tone = 0.86 + 0.22 * (cloud - 0.5) + 0.13 * (brush - 0.5) + 0.10 * (fine - 0.5) - 0.10 * stain
    color = np.array(tint) * tone[..., None]
    ridge = np.abs(noise(h, w, 1.9, (1, 1), seed + 4) - 0.5)
    crack = smooth(0.0035, 0.0008, ridge) * smooth(0.5, 0.7, noise(h, w, 2, (1, 1), seed + 5))
    color = color * (1 - 0.35 * crack[..., None])
    return np.clip(color, 0, 1)


def brass(size, seed):
    """Lacquered brass, handled for a century: colour and roughness."""
    h, w = size
    cloud = noise(h, w, 1.6, (1, 1), seed)
    spots = smooth(0.70, 0.83, noise(h, w, 0.9, (1, 1), seed + 1, low=12))
    turned = noise(h, w, 0.4, (1.0, 60.0), seed + 2, low=50)
    color = ramp(cloud, [(0.15, (0.60, 0.42, 0.20)), (0.5, (0.80, 0.61, 0.30)), (0.85, (0.90, 0.74, 0.42))])
    color = mix(color, (0.36, 0.23, 0.11), 0.42 * spots)
    color = color * (0.94 + 0.12 * turned[..., None])
    rough = 0.20 + 0.24 * (cloud - 0.5) + 0.28 * spots + 0.16 * (turned - 0.5)
    return np.clip(color, 0, 1), np.clip(rough, 0.07, 0.7)


def leather(size, dark, light, seed):
    """Grained leather, rubbed light on the high spots: colour and roughness."""
    h, w = size
    cells = noise(h, w, 0.9, (1, 1), seed, low=28)
    crease = smooth(0.03, 0.0, np.abs(noise(h, w, 1.1, (1, 1), seed + 1, low=14) - 0.5))
    worn = smooth(0.5, 0.8, noise(h, w, 1.8, (1, 1), seed + 2))
    color = mix(dark, light, np.clip(0.6 * cells + 0.45 * worn - 0.05, 0, 1))
    color = color * (1 - 0.4 * crease[..., None])
    rough = 0.42 + 0.25 * (cells - 0.5) + 0.2 * crease - 0.12 * worn
    return np.clip(color, 0, 1), np.clip(rough, 0.12, 0.9)


def weave(size, warp, weft, seed, threads=128):
    """Plain woven cloth, a thread every few pixels, with slubs."""
    h, w = size
    y, x = np.mgrid[0:h, 0:w]
    u, v = x * threads / w, y * threads / h
    over = (np.floor(u) + np.floor(v)) % 2
    bump_u = np.abs(np.sin(math.pi * u))
    bump_v = np.abs(np.sin(math.pi * v))
    shade = np.where(over > 0, bump_u, bump_v)
    slub_a = noise(h, w, 0.7, (30, 1), seed, low=20)
    slub_b = noise(h, w, 0.7, (1, 30), seed + 1, low=20)
    a = np.array(warp) * (0.75 + 0.5 * slub_a[..., None])
    b = np.array(weft) * (0.75 + 0.5 * slub_b[..., None])
    color = np.where(over[..., None] > 0, a, b) * (0.55 + 0.45 * shade[..., None])
    return np.clip(color * (0.9 + 0.2 * noise(h, w, 1.6, (1, 1), seed + 2)[..., None]), 0, 1)


def lace(size, seed):
    """Alpha of a sheer curtain: an open net with dense sprigs."""
    h, w = size
    y, x = np.mgrid[0:h, 0:w]
    net = np.maximum(np.cos(2 * math.pi * (x + y) * 32 / w), np.cos(2 * math.pi * (x - y) * 32 / w))
    alpha = 0.16 + 0.34 * smooth(0.55, 0.9, net)
    cell = 128
    cx, cy = (x + (y // cell % 2) * cell // 2) % cell - cell / 2, y % cell - cell / 2
    angle, radius = np.arctan2(cy, cx), np.hypot(cx, cy) / (cell / 2)
    petal = 0.42 + 0.30 * np.abs(np.cos(2.5 * angle))
    alpha = np.maximum(alpha, 0.75 * smooth(petal + 0.05, petal - 0.05, radius))
    return np.clip(alpha + 0.05 * (noise(h, w, 0.8, (1, 1), seed) - 0.5), 0, 1)


def rug(size, seed):
    """A knotted carpet: border bands and a lattice of medallions in madder and indigo."""
    h, w = size
    y, x = np.mgrid[0:h, 0:w]
    qx, qy = (x // 4 * 4 + 2) / w, (y // 4 * 4 + 2) / h
    edge = np.minimum(np.minimum(qx, 1 - qx) * w, np.minimum(qy, 1 - qy) * h) / min(h, w)
    madder, indigo, ivory, gold = (0.36, 0.07, 0.05), (0.06, 0.08, 0.17), (0.66, 0.57, 0.42), (0.55, 0.36, 0.13)
    color = np.ones((h, w, 3)) * madder
    lattice = np.abs(((qx * 8) % 1) - 0.5) + np.abs(((qy * 8 * h / w) % 1) - 0.5)
    color[lattice < 0.22] = indigo
    color[lattice < 0.12] = ivory
    color[(lattice > 0.46) & (lattice < 0.52)] = gold
    middle = np.abs(qx - 0.5) * 2.6 + np.abs(qy - 0.5) * 2.2
    for limit, tone in ((0.62, indigo), (0.56, gold), (0.52, madder), (0.30, ivory), (0.26, indigo), (0.12, gold)):
        color[middle < limit] = tone
    for limit, tone in ((0.17, gold), (0.16, indigo), (0.055, ivory), (0.045, madder), (0.012, gold)):
        color[edge < limit] = tone
    band = (edge > 0.06) & (edge < 0.15)
    knots = np.sin(qx * w / min(h, w) * 60) * np.sin(qy * h / min(h, w) * 60)
    color[band & (knots > 0.35)] = ivory
    color[band & (knots < -0.55)] = madder
    pile = noise(h, w, 0.5, (1, 1), seed, low=60)
    abrash = noise(h, w, 1.6, (3, 1), seed + 1)
    return np.clip(color * (0.55 + 0.55 * pile + 0.4 * (abrash - 0.2))[..., None], 0, 1)


def book_atlas(size, seed):
    """Sixteen bindings in a 4 x 4 atlas; each cell is back board (0.4), spine (0.2), front board (0.4)."""
    rng = np.random.default_rng(seed)
    cell = size // 4
    atlas = np.zeros((size, size, 3))
    cloths = [
        (0.30, 0.06, 0.05), (0.08, 0.15, 0.11), (0.07, 0.10, 0.19), (0.36, 0.22, 0.10),
        (0.13, 0.10, 0.09), (0.46, 0.36, 0.24), (0.24, 0.10, 0.12), (0.20, 0.22, 0.16),
        (0.42, 0.13, 0.07), (0.10, 0.19, 0.22), (0.55, 0.47, 0.35), (0.22, 0.14, 0.08),
        (0.16, 0.08, 0.06), (0.30, 0.27, 0.22), (0.05, 0.07, 0.10), (0.48, 0.28, 0.09),
    ]  # fmt: skip
    for index, cloth in enumerate(cloths):
        fine = noise(cell, cell, 0.5, (1, 1), seed + index, low=50)
        cloud = noise(cell, cell, 1.7, (1, 1), seed + 50 + index)
        base = np.array(cloth) * (0.72 + 0.3 * fine + 0.35 * cloud)[..., None]
        gilt = Image.new("L", (cell, cell), 0)
        draw = ImageDraw.Draw(gilt)
        s0, s1 = int(0.41 * cell), int(0.59 * cell)
        for y in sorted(rng.choice(np.arange(0.06, 0.94, 0.04), rng.integers(3, 7), replace=False)):
            draw.rectangle((s0, y * cell, s1, y * cell + rng.integers(1, 4)), fill=230)
        label = rng.uniform(0.14, 0.30)
        for line in range(rng.integers(2, 5)):
            words(draw, rng, (0.425 * cell, (label + 0.05 * line) * cell), 0.15 * cell, 0.030 * cell, 235, 2)
        words(draw, rng, (0.44 * cell, 0.86 * cell), 0.12 * cell, 0.025 * cell, 220, 2)
        if index % 3 != 2:
            draw.rectangle((0.66 * cell, 0.06 * cell, 0.96 * cell, 0.94 * cell), outline=150, width=2)
            cx, cy, r = 0.81 * cell, 0.42 * cell, 0.07 * cell
            for k in range(int(rng.integers(4, 9))):
                t = k * math.pi / 4
                draw.line(
                    (cx - r * math.cos(t), cy - r * math.sin(t), cx + r * math.cos(t), cy + r * math.sin(t)), 190, 2
                )
            draw.ellipse((cx - r, cy - r, cx + r, cy + r), outline=200, width=2)
        worn = noise(cell, cell, 1.0, (1, 1), seed + 99 + index, low=3)
        mask = np.asarray(gilt, float) / 255 * smooth(0.25, 0.5, worn)
        color = mix(base, (0.74, 0.55, 0.25), 0.85 * mask)
        x = np.linspace(0, 1, cell)[None, :] * np.ones((cell, 1))
        y = np.linspace(0, 1, cell)[:, None] * np.ones((1, cell))
        rub = np.exp(-(np.minimum(y, 1 - y) * 40)) + np.exp(-(np.abs(x - 0.4) * 120)) + np.exp(-(np.abs(x - 0.6) * 120))
        color = mix(color, np.array(cloth) * 0.6 + 0.28, np.clip(rub * (worn + 0.1), 0, 1) * 0.7)
        row, column = divmod(index, 4)
        atlas[row * cell : (row + 1) * cell, column * cell : (column + 1) * cell] = color
    return np.clip(atlas, 0, 1)


def words(draw, rng, start, length, height, fill, width=1):
    """A line of marks that reads as script from a little way off."""
    x, y = start
    end = x + length
    while x < end:
        count = int(rng.integers(2, 9))
        points = []
        for _ in range(count * 3):
            tall = rng.choice([0.45, 0.5, 0.55, 1.0], p=[0.35, 0.25, 0.2, 0.2])
            points.append((x, y + height * (1 - rng.uniform(0.0, tall))))
            x += height * 0.19
            if x > end:
                break
        if len(points) > 1:
            draw.line(points, fill=fill, width=width, joint="curve")
        x += height * 0.45


def page_edges(size, seed):
    """The fore-edge of a book block: lines along V."""
    h, w = size
    lines = noise(h, w, 0.15, (80, 1), seed, low=60)
    stain = noise(h, w, 1.7, (1, 1), seed + 1)
    color = ramp(
        0.6 * lines + 0.4 * stain, [(0.2, (0.42, 0.33, 0.21)), (0.5, (0.69, 0.60, 0.44)), (0.8, (0.80, 0.73, 0.58))]
    )
    return np.clip(color, 0, 1)


def paper(size, seed, tint=(0.86, 0.79, 0.64)):
    """Aged rag paper."""
    h, w = size
    cloud = noise(h, w, 1.5, (1, 1), seed)
    fibre = noise(h, w, 0.4, (1, 1), seed + 1, low=50)
    fox = smooth(0.74, 0.86, noise(h, w, 1.0, (1, 1), seed + 2, low=10))
    color = np.array(tint) * (0.90 + 0.12 * cloud + 0.06 * fibre)[..., None]
    y, x = np.mgrid[0:h, 0:w]
    edge = np.minimum(np.minimum(x, w - x), np.minimum(y, h - y)) / min(h, w)
    color = mix(color, np.array(tint) * (0.80, 0.72, 0.58), np.exp(-edge * 22) * 0.7)
    return np.clip(mix(color, (0.62, 0.46, 0.26), 0.35 * fox), 0, 1)


def notebook(size, seed):
    """An open notebook: a portrait lens in section with its rays on the left, notes on the right."""
    h, w = size
    rng = np.random.default_rng(seed)
    page = Image.fromarray((paper(size, seed) * 255).astype(np.uint8))
    draw = ImageDraw.Draw(page)
    ink, pale, red = (38, 30, 44), (120, 112, 118), (128, 34, 26)
    half = w // 2

    def arc(x, height, radius, colour=ink, width=6):
        """A refracting surface through (x, axis), centre to the right for positive radius."""
        points = []
        for t in np.linspace(-1, 1, 40):
            y = t * height
            points.append((x + radius - math.copysign(math.sqrt(radius**2 - y**2), radius), axis + y))
        draw.line(points, fill=colour, width=width)
        return points[0], points[-1]

    axis = h * 0.36
    draw.line((half * 0.07, axis, half * 0.93, axis), fill=pale, width=2)
    for surfaces, height in (
        (((0.20, 330), (0.25, -300), (0.275, 1500)), 130),
        (((0.47, -900), (0.49, 260)), 118),
        (((0.51, 300), (0.555, -420)), 118),
    ):
        ends = [arc(half * x, height, r) for x, r in surfaces]
        for k in (0, 1):
            draw.line([e[k] for e in ends], fill=ink, width=6)
    for start in (-100, -60, 60, 100):
        draw.line(
            [(half * 0.05, axis + start), (half * 0.235, axis + start * 0.97), (half * 0.51, axis + start * 0.62), (half * 0.93, axis)],
            fill=red, width=4,
        )  # fmt: skip
    draw.line((half * 0.40, axis - 170, half * 0.40, axis - 92), fill=ink, width=4)
    draw.line((half * 0.40, axis + 92, half * 0.40, axis + 170), fill=ink, width=4)
    draw.arc((half * 0.90, axis - 260, half * 1.02, axis + 260), 130, 230, fill=pale, width=2)
    for k in range(7):
        words(draw, rng, (half * 0.16 + k * half * 0.10, axis + 175 + 8 * (k % 2)), half * 0.06, 20, ink, 2)
    words(draw, rng, (half * 0.12, h * 0.07), half * 0.55, 46, ink, 4)
    for row in range(13):
        y = h * 0.60 + row * h * 0.027
        draw.line((half * 0.10, y + 26, half * 0.88, y + 26), fill=(176, 160, 140), width=1)
        for column in range(5):
            words(draw, rng, (half * (0.12 + 0.155 * column), y), half * rng.uniform(0.07, 0.12), 22, ink, 3)
    for row in range(27):
        y = h * 0.07 + row * h * 0.032
        length = half * (0.78 if row % 7 else 0.45) * rng.uniform(0.92, 1.0)
        words(draw, rng, (half * 1.11, y), length, 27, ink, 3)
    draw.ellipse((half * 1.55, h * 0.66, half * 1.86, h * 0.66 + half * 0.31), outline=red, width=3)
    shade = 1 - 0.35 * np.exp(-np.abs(np.linspace(-1, 1, w)) * 26)
    return np.asarray(page.filter(ImageFilter.GaussianBlur(0.6)), float) / 255 * shade[None, :, None]


def leaf(size, seed):
    """A leaf blade, midrib along V in the middle of U."""
    h, w = size
    y, x = np.mgrid[0:h, 0:w]
    u, v = x / w - 0.5, 1 - y / h
    rib = np.exp(-np.abs(u) * 60)
    vein = np.exp(-np.abs(((v - np.abs(u) * 0.9) * 11) % 1 - 0.5) * 14)
    cloud = noise(h, w, 1.5, (1, 1), seed)
    color = ramp(cloud, [(0.2, (0.07, 0.14, 0.05)), (0.55, (0.13, 0.24, 0.08)), (0.85, (0.24, 0.33, 0.11))])
    color = mix(color, (0.42, 0.50, 0.25), np.clip(0.7 * rib + 0.35 * vein, 0, 1))
    dry = smooth(0.40, 0.52, np.abs(u) + 0.12 * (noise(h, w, 1.2, (1, 1), seed + 1) - 0.5))
    return np.clip(mix(color, (0.34, 0.25, 0.11), 0.5 * dry), 0, 1)


def engraved_brass(size, seed):
    """Brass with the maker's script engraved along U: colour and roughness (tileable around a barrel)."""
    h, w = size
    color, rough = brass(size, seed)
    rng = np.random.default_rng(seed)
    cut = Image.new("L", (w, h), 0)
    draw = ImageDraw.Draw(cut)
    for k in range(3):
        x = w * (k / 3 + 0.03)
        words(draw, rng, (x, h * 0.16), w * 0.24, h * 0.30, 255, 5)
        words(draw, rng, (x + w * 0.03, h * 0.62), w * 0.16, h * 0.18, 255, 3)
    mask = np.asarray(cut.filter(ImageFilter.GaussianBlur(0.8)), float) / 255
    return mix(color, (0.10, 0.07, 0.05), 0.9 * mask), np.clip(rough + 0.35 * mask, 0, 0.8)


def clock_face(size):
    """An enamel dial with Roman-looking strokes and two blued hands."""
    image = Image.new("RGB", (size, size), (226, 219, 200))
    draw = ImageDraw.Draw(image)
    c = size / 2
    draw.ellipse((6, 6, size - 6, size - 6), outline=(70, 52, 30), width=size // 60)
    for minute in range(60):
        t = minute * math.pi / 30
        r0, r1 = (0.80, 0.88) if minute % 5 == 0 else (0.84, 0.88)
        draw.line(
            (c + c * r0 * math.sin(t), c - c * r0 * math.cos(t), c + c * r1 * math.sin(t), c - c * r1 * math.cos(t)),
            fill=(25, 22, 22), width=max(1, size // (120 if minute % 5 == 0 else 300)),
        )  # fmt: skip
    for hour in range(12):
        for stroke in range(1 + hour % 4):
            t = hour * math.pi / 6 + (stroke - (hour % 4) / 2) * 0.055
            draw.line(
                (c + c * 0.60 * math.sin(t), c - c * 0.60 * math.cos(t), c + c * 0.76 * math.sin(t), c - c * 0.76 * math.cos(t)),
                fill=(25, 22, 22), width=size // 80,
            )  # fmt: skip
    for t, r, width in ((math.radians(148), 0.48, 34), (math.radians(338), 0.72, 46)):
        draw.line((c, c, c + c * r * math.sin(t), c - c * r * math.cos(t)), fill=(24, 30, 66), width=size // width)
    draw.ellipse((c - 9, c - 9, c + 9, c + 9), fill=(24, 30, 66))
    return np.asarray(image.filter(ImageFilter.GaussianBlur(0.7)), float) / 255


def globe_map(size, seed):
    """A sepia terrestrial globe of a world that never was."""
    h, w = size
    land = noise(h, w, 1.75, (1, 1), seed) + 0.02 * (noise(h, w, 0.8, (1, 1), seed + 1, low=20) - 0.5)
    shore = smooth(0.515, 0.525, land)
    sea = ramp(land, [(0.1, (0.16, 0.24, 0.24)), (0.5, (0.34, 0.42, 0.36))])
    ground = ramp(land, [(0.5, (0.62, 0.50, 0.28)), (0.65, (0.56, 0.36, 0.18)), (0.85, (0.36, 0.24, 0.13))])
    color = mix(sea, ground, shore)
    coast = np.exp(-np.abs(land - 0.52) * 220)
    color = color * (1 - 0.6 * coast[..., None])
    y, x = np.mgrid[0:h, 0:w]
    lines = (x % (w // 24) < 1) | (y % (h // 12) < 1)
    color[lines] *= 0.7
    return np.clip(color * (0.8 + 0.3 * noise(h, w, 1.2, (1, 1), seed + 2)[..., None]), 0, 1)


def landscape(size, seed, warm=True):
    """A small oil painting: sky, hills that fade into haze, water, a few trees."""
    h, w = size
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:h, 0:w]
    v = y / h
    top, low = ((0.24, 0.33, 0.45), (0.86, 0.64, 0.38)) if warm else ((0.30, 0.38, 0.44), (0.70, 0.72, 0.66))
    color = mix(np.ones((h, w, 3)) * top, low, smooth(0.0, 0.55, v))
    clouds = smooth(0.5, 0.75, noise(h, w, 1.6, (1, 3), seed))
    color = mix(color, (0.92, 0.80, 0.62), 0.6 * clouds * smooth(0.6, 0.1, v))
    for k in range(5):
        ridge = 0.46 + 0.075 * k + (0.14 - 0.02 * k) * (noise(4, w, 1.5, (1, 1), seed + 10 + k)[1] - 0.5)
        haze = np.array(mix(low, (0.10, 0.13, 0.07), 0.25 + 0.17 * k))
        color = np.where((v > ridge[None, :])[..., None], haze, color)
    for _ in range(18):
        cx, base, r = rng.uniform(0, w), rng.uniform(0.72, 0.9) * h, rng.uniform(0.03, 0.08) * h
        blob = np.hypot((x - cx) / 0.7, y - base + r) + r * 0.6 * (
            noise(h, w, 1.0, (1, 1), int(rng.integers(99))) - 0.5
        )
        color = mix(color, (0.09, 0.11, 0.05), smooth(r, r * 0.8, blob) * 0.9)
    stroke = noise(h, w, 0.7, (1.0, 3.0), seed + 30, low=12)
    crackle = smooth(0.02, 0.0, np.abs(noise(h, w, 1.0, (1, 1), seed + 31, low=12) - 0.5))
    return np.clip(color * (0.72 + 0.5 * stroke)[..., None] * (1 - 0.12 * crackle[..., None]), 0, 1)


def smudges(size, seed, base=0.02, amount=0.16):
    """Roughness of handled glass: nearly clear, finger marks and dust where light grazes."""
    h, w = size
    haze = smooth(0.55, 0.95, noise(h, w, 1.3, (1, 1), seed))
    fingers = smooth(0.66, 0.9, noise(h, w, 1.2, (1, 1), seed + 1, low=6))
    return np.clip(base + amount * haze + amount * 0.6 * fingers, 0, 1)


def dusk_panorama(size, seed, glow_azimuth=0.5):
    """Linear radiance of a dusk sky over a town, equirectangular; `glow_azimuth` is U of the afterglow."""
    h, w = size
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:h, 0:w]
    u, lat = (x + 0.5) / w, (0.5 - (y + 0.5) / h) * math.pi
    away = np.abs(u - glow_azimuth)
    away = np.minimum(away, 1 - away)
    glow = np.exp(-((away / 0.13) ** 2))
    height = np.clip(np.degrees(lat), 0, 90)
    sky = ramp(
        height,
        [
            (0, (0.36, 0.36, 0.48)), (5, (0.14, 0.29, 0.64)), (12, (0.07, 0.21, 0.64)),
            (26, (0.04, 0.13, 0.50)), (60, (0.045, 0.10, 0.30)), (90, (0.03, 0.07, 0.24)),
        ],
    )  # fmt: skip
    warm = ramp(
        height,
        [
            (0, (1.9, 0.62, 0.20)),
            (4, (1.25, 0.48, 0.22)),
            (9, (0.48, 0.23, 0.20)),
            (16, (0.10, 0.06, 0.09)),
            (28, (0, 0, 0)),
        ],
    )
    sky = sky + warm * glow[..., None]
    drift = noise(h, w, 1.55, (1.0, 4.0), seed)
    cloud = smooth(0.52, 0.74, drift) * smooth(1, 6, height) * smooth(50, 16, height)
    lit = mix((0.12, 0.15, 0.28), (1.2, 0.40, 0.24), glow * smooth(20, 4, height))
    sky = mix(sky, lit, 0.75 * cloud)
    # Hills, then three ranks of roofs, each nearer, lower in latitude and darker.
    picture = sky
    hills = 1.6 + 2.2 * noise(4, w, 1.6, (1, 1), seed + 3)[1]
    picture = np.where(
        (np.degrees(lat) < hills[None, :])[..., None], mix((0.11, 0.13, 0.23), (0.5, 0.25, 0.2), glow * 0.6), picture
    )
    for rank, (low, high, width, tone) in enumerate(
        (
            (0.6, 3.6, 1.1, (0.062, 0.070, 0.115)),
            (-0.8, 8.5, 2.2, (0.030, 0.034, 0.056)),
            (-4.5, 13.0, 5.5, (0.012, 0.013, 0.020)),
        )
    ):
        column = 0.0
        while column < 360:
            breadth = width * rng.uniform(0.5, 1.6)
            top = low + (high - low) * rng.beta(1.6, 3.0)
            x0, x1 = int(column / 360 * w), max(int((column + breadth) / 360 * w), int(column / 360 * w) + 2)
            y0 = int((0.5 - top / 180) * h)
            pitched = rng.random() < 0.5
            for xx in range(x0, min(x1, w)):
                rise = (x1 - x0) * 0.35 * (1 - abs(2 * (xx - x0) / (x1 - x0) - 1)) if pitched else 0
                picture[max(int(y0 - rise), 0) : int(h * 0.56), xx] = tone
            if rng.random() < 0.35:
                cx = rng.integers(x0, max(x1, x0 + 1)) % w
                picture[y0 - int(rng.uniform(3, 9)) : y0, cx : cx + 1 + rank // 2] = tone
            step = max(2, int((0.35 + 0.25 * rank) / 360 * w))
            for yy in range(y0 + step, int(h * 0.53), step + 1):
                for xx in range(x0 + 1, min(x1 - 1, w - 2), step + 1):
                    if rng.random() < (0.16, 0.12, 0.075)[rank]:
                        bright = rng.uniform(3, 12) * (1, 1.4, 1.8)[rank]
                        hue = (1.0, rng.uniform(0.45, 0.75), rng.uniform(0.12, 0.45))
                        picture[yy : yy + 1 + rank, xx : xx + 1 + rank // 2] = np.array(hue) * bright
            column += breadth * rng.uniform(0.85, 1.1)
    below = np.degrees(lat) < -9
    picture[below] = (0.02, 0.022, 0.03)
    for _ in range(240):
        xx, yy = int(rng.uniform(0, w - 2)), int(h * (0.5 + rng.uniform(0.010, 0.055)))
        picture[yy : yy + 2, xx : xx + 2] = np.array((1.0, rng.uniform(0.5, 0.75), 0.25)) * rng.uniform(8, 30)
    return picture
