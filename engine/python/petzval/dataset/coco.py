# SPDX-License-Identifier: GPL-3.0-or-later
"""COCO's annotations of instances (cocodataset.org, "Data format"): boxes, areas, run lengths and polygons of masks."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Mask = npt.NDArray[np.bool_]


def run_lengths(mask: Mask) -> list[int]:
    """COCO's uncompressed run lengths: column by column from the upper left corner, zeros first."""
    flat = mask.T.ravel()
    changes = np.flatnonzero(flat[1:] != flat[:-1]) + 1
    ends = np.concatenate([[0], changes, [len(flat)]])
    counts = np.diff(ends).tolist()
    return [0, *counts] if flat[0] else counts


def packed(counts: list[int]) -> str:
    """COCO's compressed run lengths: from the third on each as the difference to the one two before, in groups of five bits, the
    least first, from character 48 on (cocoapi, common/maskApi.c, rleToString)."""
    text = ""
    for i, count in enumerate(counts):
        left = count - counts[i - 2] if i > 2 else count
        more = True
        while more:
            bits = left & 31
            left >>= 5
            more = left != -1 if bits & 16 else left != 0
            text += chr((bits | 32 if more else bits) + 48)
    return text


def box(mask: Mask) -> list[int]:
    """x, y, width and height of the pixels of a mask, from the upper left corner."""
    columns, rows = np.flatnonzero(mask.any(axis=0)), np.flatnonzero(mask.any(axis=1))
    return [int(columns[0]), int(rows[0]), int(columns[-1] - columns[0] + 1), int(rows[-1] - rows[0] + 1)]


def polygons(mask: Mask) -> list[list[int]]:
    """The outlines of a mask along the edges of its pixels, each x, y, x, y, ... with corners alone. Holes are filled: COCO's polygons
    have none. Areas that touch at a corner are apart."""
    padded = np.pad(mask, 1)
    # Edges with the mask on their right, by where they start; rows count downwards.
    edges: dict[tuple[int, int], list[tuple[int, int]]] = {}

    def add(starts: npt.NDArray[np.intp], way: tuple[int, int], shift: tuple[int, int]) -> None:
        for row, column in starts:
            start = (int(column) - 1 + shift[0], int(row) - 1 + shift[1])
            edges.setdefault(start, []).append((start[0] + way[0], start[1] + way[1]))

    inner = padded[1:-1, 1:-1]
    add(np.argwhere(np.pad(inner & ~padded[:-2, 1:-1], 1)), (1, 0), (0, 0))
    add(np.argwhere(np.pad(inner & ~padded[1:-1, 2:], 1)), (0, 1), (1, 0))
    add(np.argwhere(np.pad(inner & ~padded[2:, 1:-1], 1)), (-1, 0), (1, 1))
    add(np.argwhere(np.pad(inner & ~padded[1:-1, :-2], 1)), (0, -1), (0, 1))
    found = []
    while edges:
        start = min(edges)
        here, way, outline = start, (1, 0), [start]
        while True:
            ways = edges[here]
            # Where four edges meet: the turn to the right, which stays with the pixel.
            there = next((one for one in ways if (one[0] - here[0], one[1] - here[1]) == (-way[1], way[0])), ways[0])
            ways.remove(there)
            if not ways:
                del edges[here]
            way, here = (there[0] - here[0], there[1] - here[1]), there
            if here == start:
                break
            outline.append(here)
        corners = _corners(np.array(outline))
        x, y = corners.T.astype(float)
        # Holes go round the other way.
        if np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) > 0.0:
            found.append([int(one) for one in corners.ravel()])
    return found


def _corners(outline: npt.NDArray[np.int_]) -> npt.NDArray[np.int_]:
    """The corners of an outline, without the points in the middle of straight edges."""
    ways = np.roll(outline, -1, axis=0) - outline
    corners: npt.NDArray[np.int_] = outline[(ways != np.roll(ways, 1, axis=0)).any(axis=1)]
    return corners


def annotated(
    ids: npt.NDArray[np.uint16], category_of: dict[int, int], form: str, least_area: int
) -> list[dict[str, Any]]:
    """An annotation for each instance of a class that a picture shows, without the numbers of picture and annotation. `form`: "rle" or
    "polygons"."""
    found = []
    for one in np.unique(ids):
        category = category_of.get(int(one))
        if not category:
            continue
        mask = ids == one
        area = int(mask.sum())
        if area < least_area:
            continue
        segmentation: Any = polygons(mask)
        if form == "rle":
            segmentation = {"size": list(mask.shape), "counts": packed(run_lengths(mask))}
        found.append(
            {"category_id": category, "bbox": box(mask), "area": area, "iscrowd": 0, "segmentation": segmentation, "instance_id": int(one)}
        )  # fmt: skip
    return found


def whole(
    images: list[dict[str, Any]], per_image: list[list[dict[str, Any]]], categories: list[dict[str, Any]]
) -> dict[str, Any]:
    """The file: pictures, annotations and categories, numbered from 1."""
    numbered: list[dict[str, Any]] = []
    for image, several in zip(images, per_image, strict=True):
        for one in several:
            numbered.append({"id": len(numbered) + 1, "image_id": image["id"], **one})
    return {
        "info": {"description": "Rendered by Petzval"},
        "images": images,
        "annotations": numbered,
        "categories": categories,
    }
