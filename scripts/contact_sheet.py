# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders every shape, and every example expression, as a lit lamp, and puts the pictures on sheets with their
names."""

from __future__ import annotations

import argparse
import dataclasses
import math
import pathlib
import sys
import time

import numpy as np
import OpenImageIO

REPOSITORY = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(REPOSITORY))

from sdf_lights.render import session  # noqa: E402
from sdf_lights.render.material import Material, Node  # noqa: E402
from sdf_lights.render.scene import Camera, Instance, Lamp, Mesh, Scene  # noqa: E402
from sdf_lights.render.settings import Settings  # noqa: E402
from sdf_lights.sdf.emission import Emission  # noqa: E402
from sdf_lights.sdf.examples import examples  # noqa: E402
from sdf_lights.sdf.expression import Expression  # noqa: E402
from sdf_lights.sdf.shapes import SHAPES, Shape  # noqa: E402

CAPTION = 18  # pixels under each picture
PALETTE = ((1.0, 0.62, 0.30), (0.45, 0.75, 1.0), (1.0, 0.42, 0.55), (0.62, 1.0, 0.58), (0.80, 0.60, 1.0))
EYE = np.array([1.9, -3.4, 1.75])  # camera that looks at a lamp one metre large, just above the ground
TARGET = np.array([0.0, 0.0, 0.47])
FACING = math.radians(65.0)
BRIGHTNESS = 1.2  # radiance of the lamp along its mean chord


def sheets() -> dict[str, list[tuple[str, Shape]]]:
    """The content of each sheet: name -> captions and shapes."""
    alone = {name: kind() for name, kind in SHAPES.items() if not _needs_parts(kind) and kind.bounded}
    fractal = {
        name: shape for name, shape in alone.items() if type(shape).__module__.endswith((".fractals", ".orbits"))
    }
    return {
        "shapes": [(name, shape) for name, shape in alone.items() if name not in fractal],
        "fractals": list(fractal.items()),
        "examples": [(name, Expression(example.text).shape()) for name, example in examples().items()],
    }


def _needs_parts(kind: type[Shape]) -> bool:
    return len(kind.fields()) < len(dataclasses.fields(kind))


def _ground() -> Mesh:
    """A floor that bends up into a wall behind the lamp, 400 strips: no edge is visible."""
    angles = np.linspace(0.0, 0.5 * math.pi, 48)
    profile = [(-8.0, 0.0), *((2.0 + 2.0 * math.sin(a), 2.0 - 2.0 * math.cos(a)) for a in angles), (4.0, 8.0)]
    positions = np.array([(x, y, z) for y, z in profile for x in (-10.0, 10.0)], np.float32)
    triangles = []
    for row in range(len(profile) - 1):
        a = 2 * row
        triangles += [(a, a + 1, a + 3), (a, a + 3, a + 2)]
    return Mesh("Ground", positions, np.array(triangles, np.int32))


def _camera(aspect: float) -> Camera:
    back = (EYE - TARGET) / np.linalg.norm(EYE - TARGET)
    right = np.cross((0.0, 0.0, 1.0), back)
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([right, np.cross(back, right), back], axis=1)
    matrix[:3, 3] = EYE
    half = 0.205
    return Camera(matrix, window=(-half * aspect, half * aspect, -half, half))


def _placed(shape: Shape) -> np.ndarray:
    """Scales a shape to one metre and puts it just above the ground; a flat shape is turned upright to face the
    camera."""
    low, high = shape.bounds()
    size = high - low
    matrix = np.eye(4)
    if size[2] < 0.5 * min(size[:2]):
        cosine, sine = math.cos(FACING), math.sin(FACING)
        matrix[1:3, 1:3] = (cosine, -sine), (sine, cosine)
    low, high = shape.bounds(matrix)
    scale = 1.0 / float(max(high - low))
    matrix[:3] *= scale
    matrix[:3, 3] -= scale * 0.5 * (low[0] + high[0]), scale * 0.5 * (low[1] + high[1]), scale * low[2] - 0.06
    return matrix


def picture(shape: Shape, color, width: int, height: int, samples: int, emission: Emission | None = None) -> np.ndarray:
    """(height, width, 3) display values, row 0 at the top."""
    matrix = _placed(shape)
    ground = Material("Ground", Node("diffuse", {"color": (0.42, 0.42, 0.44)}))
    scene = Scene(
        _camera(width / height),
        width,
        height,
        meshes=[_ground()],
        instances=[Instance(0, np.eye(4), (0,))],
        materials=[ground],
        lamps=[Lamp("Lamp", shape, matrix, density=1.0, color=color, emission=emission)],
        settings=Settings(samples=samples, noise_threshold=0.0, max_bounces=2, denoise=True),
    )
    film = session.render(scene, ("Combined",))
    for warning in scene.warnings:
        print(f"  {warning}", file=sys.stderr)
    light = film.read("Combined")[::-1, :, :3].astype(float)
    # The exposure that an artist would choose: the body of the lamp just saturates.
    lit = light.max(axis=2)
    light *= BRIGHTNESS / max(float(np.quantile(lit, 0.97)), 1e-9)
    return srgb(1.0 - np.exp(-light))


def srgb(light: np.ndarray) -> np.ndarray:
    """Display values of scene-linear ones in [0, 1]."""
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def caption(text: str, width: int) -> np.ndarray:
    """A line of text below a picture of that width, (CAPTION, width, 3) display values."""
    buffer = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(width, CAPTION, 3, OpenImageIO.FLOAT))
    OpenImageIO.ImageBufAlgo.fill(buffer, (0.09, 0.09, 0.10))
    size = next((size for size in range(12, 7, -1) if _width(text, size) < width), 7)
    OpenImageIO.ImageBufAlgo.render_text(
        buffer, width // 2, CAPTION - 6, text, size, "", (0.85, 0.85, 0.85), alignx="center", aligny="baseline"
    )
    return buffer.get_pixels(OpenImageIO.FLOAT)


def _width(text: str, size: int) -> int:
    """Pixels that a line of text takes."""
    region = OpenImageIO.ImageBufAlgo.text_size(text, size)
    return region.xend - region.xbegin


def sheet(cells: list[np.ndarray], columns: int) -> np.ndarray:
    """One picture of all cells, in rows of at most ``columns``, as even as they can be."""
    columns = -(-len(cells) // -(-len(cells) // columns))
    cells = cells + [np.full_like(cells[0], 0.09)] * (-len(cells) % columns)
    rows = [np.concatenate(cells[i : i + columns], axis=1) for i in range(0, len(cells), columns)]
    return np.concatenate(rows, axis=0)


def write(path: pathlib.Path, image: np.ndarray) -> None:
    pixels = (np.clip(image, 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8)
    output = OpenImageIO.ImageOutput.create(str(path))
    spec = OpenImageIO.ImageSpec(pixels.shape[1], pixels.shape[0], 3, OpenImageIO.UINT8)
    if output is None or not output.open(str(path), spec) or not output.write_image(np.ascontiguousarray(pixels)):
        raise SystemExit(f"contact_sheet: {path} could not be written.")
    output.close()


def main(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="contact_sheet", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="SHEET", help="shapes, fractals or examples; default: all three")
    parser.add_argument("--samples", type=int, default=12, help="samples per pixel (12)")
    parser.add_argument("--size", type=int, default=112, help="width of one picture in pixels (112)")
    parser.add_argument("--columns", type=int, default=10, help="most pictures side by side (10)")
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs" / "images", help="folder (docs/images)")
    options = parser.parse_args(arguments)
    known = sheets()
    for name in options.names:
        if name not in known:
            parser.error(f"there is no sheet {name!r}: choose from {', '.join(known)}")
    for name in options.names or known:
        started, cells = time.perf_counter(), []
        for index, (text, shape) in enumerate(known[name]):
            print(f"{name} {index + 1}/{len(known[name])}: {text}", file=sys.stderr)
            image = picture(shape, PALETTE[index % len(PALETTE)], options.size, options.size * 7 // 8, options.samples)
            cells.append(np.concatenate([image, caption(text.replace("_", " "), options.size)]))
        path = options.out / f"{name}.png"
        write(path, sheet(cells, options.columns))
        print(f"{path} ({len(cells)} lamps, {time.perf_counter() - started:.0f} s)")


if __name__ == "__main__":
    main(sys.argv[1:])
