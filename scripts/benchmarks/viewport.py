# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The viewport: milliseconds of a frame of lamps, and from an edit until it is seen.

Frames are drawn without a window, by number of lamps and resolution. The lamps have five shapes, side by side in a grid
that fills the picture, so each ray meets few of them and each pixel some. A frame is drawn and its mask read back,
which waits for the graphics card. ``edit`` frames follow a change of one number of every lamp.

If there is a Blender with a window, edits are made in it: see viewport_session.py.
"""

from __future__ import annotations

import functools
import pathlib
import statistics
import tempfile
import time

import host
import numpy as np
from sessions import SessionError, seen_by

from .progress import Progress
from .resume import Parts

HELP = "the viewport: milliseconds of a frame of 1, 10 and 50 lamps at 960 × 540, and from edits until they are seen"

SIZE = 960, 540
COUNTS = 1, 10, 50
SHADINGS = "SOLID", "RENDERED"
SCALES = 1, 2, 4
FRAMES = 5
EDITS = 15
SESSION = pathlib.Path(__file__).with_name("viewport_session.py")
WINDOW = 1180, 760  # in which the viewport has about 960 × 540 pixels


def _shapes(index: int, size: float) -> object:
    from sdf_lights.sdf.shapes import SHAPES, Difference

    torus, sphere, box, frame = (SHAPES[name] for name in ("torus", "sphere", "box", "box_frame"))
    return (
        torus(0.35 * size, 0.12 * size),
        SHAPES["menger_sponge"](),
        frame(0.4 * size),
        Difference(box(0.4 * size), sphere(0.5 * size)),
        SHAPES["rounded_box"](),
    )[index % 5]


def _lamps(count: int, size: float) -> list:
    from sdf_lights.render.scene import Lamp

    columns = int(np.ceil(np.sqrt(count * SIZE[0] / SIZE[1])))
    rows = -(-count // columns)
    step = 2.0 / max(columns, rows * SIZE[0] / SIZE[1])
    lamps = []
    for index in range(count):
        matrix = np.diag([0.8 * step] * 3 + [1.0])
        matrix[:2, 3] = (index % columns - 0.5 * (columns - 1)) * step, (index // columns - 0.5 * (rows - 1)) * step
        lamps.append(Lamp(f"Lamp {index}", _shapes(index, size), matrix))
    return lamps


class _Canvas:
    """A frame buffer of the size of the picture, and its view."""

    def __init__(self, painter, scale: int):
        import gpu

        from sdf_lights.blender.viewport.painter import View

        self._painter, size = painter, tuple(side // scale for side in SIZE)
        glow, self._mask = (gpu.types.GPUTexture(size, format=kind) for kind in ("RGBA16F", "RGBA8"))
        self._buffer = gpu.types.GPUFrameBuffer(color_slots=(glow, self._mask))
        view, near, far, half = np.eye(4), 0.1, 100.0, 0.3
        view[2, 3] = -1.0 / half
        projection = np.zeros((4, 4))
        projection[0, 0], projection[1, 1], projection[3, 2] = 1.0 / half, SIZE[0] / SIZE[1] / half, -1.0
        projection[2, 2:] = -(far + near) / (far - near), -2.0 * far * near / (far - near)
        self._view = View(view, projection, size)

    def draw(self, lamps, finder) -> tuple[float, float]:
        """Milliseconds until the commands are issued, and until the picture is ready."""
        from sdf_lights.blender.viewport.painter import Drawn

        started = time.perf_counter()
        with self._buffer.bind():
            self._buffer.clear(color=(0.0, 0.0, 0.0, 0.0))
            self._painter.draw(
                [Drawn(lamp, finder.find(lamp.name, lamp.shape, wait=True)) for lamp in lamps], self._view
            )
        given = time.perf_counter()
        self._mask.read()
        return 1e3 * (given - started), 1e3 * (time.perf_counter() - started)


def _frames(count: int, repeats: int) -> list[dict]:
    """Rows of a number of lamps."""
    import gpu

    if not hasattr(gpu, "init"):
        return [dict(problem="only Blender 5.2 and later draw without a window: run this with its Python module")]
    gpu.init()
    from sdf_lights.blender.viewport.facts import FactFinder
    from sdf_lights.blender.viewport.painter import Painter

    painter, finder, rows = Painter(), FactFinder(), []
    lamps = _lamps(count, 1.0)
    for lamp in lamps:
        painter.compile(lamp)
    for scale in SCALES:
        canvas = _Canvas(painter, scale)
        canvas.draw(lamps, finder)  # drivers finish compiling at the first use
        still = [canvas.draw(lamps, finder) for _ in range(repeats)]
        edits = [canvas.draw(_lamps(count, 1.0 + 0.01 * (turn + 1)), finder) for turn in range(repeats)]
        rows.append(
            dict(
                lamps=count,
                pixels="×".join(str(side // scale) for side in SIZE),
                commands_ms=statistics.median(given for given, _ in still),
                frame_ms=statistics.median(whole for _, whole in still),
                frame_after_edit_ms=statistics.median(whole for _, whole in edits),
            )
        )
    return rows


def _edits(shading: str, repeats: int) -> list[dict]:
    """Rows of the edits in a shading."""
    command = host.windowed_blender()
    if command is None:
        return [dict(problem=host.NO_WINDOW)]
    with tempfile.TemporaryDirectory() as folder:
        try:
            report = seen_by(command, SESSION, pathlib.Path(folder), str(repeats), shading, size=WINDOW)
        except SessionError as error:
            return [dict(problem=str(error)[-2000:])]
    return [
        {key: row[key] for key in ("shading", "edit")}
        | {f"{key}_ms": statistics.median(row[key]) for key in ("restart", "picture", "seen")}
        | {f"{key}_ms": max(row[key]) for key in ("blocked", "worked")}
        for row in report["rows"]
    ]


def run(options) -> tuple[dict, list[dict]]:
    repeats = options.repeats or (1 if options.quick else FRAMES)
    turns = options.repeats or (2 if options.quick else EDITS)
    progress, parts, frames, edits = Progress(len(COUNTS) + len(SHADINGS)), Parts(options), [], []
    for count in COUNTS:
        progress.show(f"frames of {count} lamps")
        frames += [
            row for row in parts.of(f"{count} lamps", functools.partial(_frames, count, repeats)) if row not in frames
        ]
        progress.step()
    for shading in SHADINGS:
        progress.show(f"edits, {shading.lower()}")
        edits += [row for row in parts.of(shading, functools.partial(_edits, shading, turns)) if row not in edits]
        progress.step()
    parts.finish()
    progress.close()
    summary = {
        f"viewport_{what}_{row['lamps']}": row[what]
        for row in frames
        if row.get("pixels") == "960×540"
        for what in ("frame_ms", "frame_after_edit_ms")
    }
    traced = [row for row in edits if row.get("shading") == "RENDERED"]
    if traced:
        summary |= {
            f"viewport_{what}": max(row[what] for row in traced) for what in ("restart_ms", "picture_ms", "worked_ms")
        }
    return summary, frames + edits
