# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The time of a sample, and the moving parts of the scene at that time.

In a moving scene, each thread has separate blocks. Lamps, lights and the camera are few: their tables are interpolated
to the time before a path begins, linearly between even times. So no other kernel needs to handle their motion.
Instances are many, and are interpolated when a ray has hit them.

Paths that are connected with light paths have the time of these, which is one of a few for each set: see
``cpu.light_paths.LightPaths``.

The time of the shutter is cut into *segments*, in which no lamp changes its shape. Each has a block, whose tables are
those of these shapes. In most scenes there is only one.
"""

from __future__ import annotations

import numpy as np

from ...jit import kernel, table
from ..scene import Scene, Shutter
from .camera import camera_table
from .light_paths.records import time_table as light_path_times
from .path import path_table
from .rays import ray_table
from .samplers import get_1d
from .workspace import secondary_table

TIME_SET = 1 << 44  # of random numbers

TABLES = {
    "shutter_times": np.dtype(np.float64),
    "moving": np.dtype(np.float64),  # the moving tables, as concatenated numbers
    "moving_places": np.dtype(np.int64),  # in ``moving``, of those that move
    "moving_keys": np.dtype(np.float64),  # their values at each of the even times of the segment
    "shutter_segments": np.dtype(np.int64),  # of each step between even times
}
SCALARS = [
    ("moves", np.int64),
    ("time", np.float64),
    ("segments", np.int64),
    ("first_step", np.int64),  # of the segment
    ("moving_steps", np.int64),  # of the segment; 0: nothing moves in it
    ("rolling_shutter", np.float64),
]

NOT_ROLLING = -1.0

time_table = table("shutter_times", np.float64)
moving_table = table("moving", np.float64)
place_table = table("moving_places", np.int64)
key_table = table("moving_keys", np.float64)
segment_table = table("shutter_segments", np.int64)


def pack_shutter(scene: Scene) -> tuple[dict[str, np.ndarray], dict[str, float]]:
    """The table and the scalars of the shutter, and no other of ``TABLES``."""
    shutter = scene.shutter or Shutter()
    rolling = NOT_ROLLING if shutter.rolling is None else shutter.rolling
    return {"shutter_times": np.asarray(shutter.times, np.float64)}, {
        "moves": scene.shutter is not None,
        "time": 0.0,
        "segments": 1,
        "first_step": 0,
        "moving_steps": 0,
        "rolling_shutter": rolling,
    }


class Moving:
    """Moving tables of a segment, of which each thread has copies: from their values at even times, ``keys``.

    Only float64 numbers move; the rest is as in ``base``. A table whose length changes stays as it is. ``fixed``:
    tables of the segment in which nothing moves.
    """

    def __init__(self, base: dict[str, np.ndarray], keys: list[dict[str, np.ndarray]], first_step: int = 0):
        self._base, self.fixed, places, values = {}, {}, [], []
        self.scalars = {"first_step": first_step, "moving_steps": 0}
        start = 0
        for name, array in base.items():
            self.fixed[name] = array
            if not is_wide(array.dtype) or any(len(key[name]) != len(array) for key in keys):
                continue
            numbers = [_numbers(key[name]) for key in keys]
            moves = np.flatnonzero(_floats(array) & np.any([n != numbers[0] for n in numbers[1:]], axis=0))
            if len(moves):
                self._base[name] = self.fixed.pop(name)
                places.append(start + moves)
                values.append(np.stack([n[moves] for n in numbers]))
                start += array.nbytes // 8
                self.scalars["moving_steps"] = len(keys) - 1
        self.fixed["moving_places"] = np.concatenate(places) if places else np.zeros(0, np.int64)
        self.fixed["moving_keys"] = np.concatenate(values, axis=1).ravel() if values else np.zeros(0)

    def own(self) -> dict[str, np.ndarray]:
        """The moving tables for a thread; ``moving`` is the memory of all others."""
        count = sum(array.nbytes // 8 for array in self._base.values())
        memory, tables, start = np.zeros(count), {}, 0
        for name, array in self._base.items():
            part = memory[start : start + array.nbytes // 8]
            part[:] = _numbers(array)
            tables[name] = part.view(array.dtype)
            start += len(part)
        return tables | {"moving": memory}


def is_wide(dtype: np.dtype) -> bool:
    """Whether all floats of a record have eight bytes, and it can be read as such numbers."""
    fields = dtype.fields or {"": (dtype, 0)}
    return dtype.itemsize % 8 == 0 and all(
        part.base.kind != "f" or part.base.itemsize == 8 for part, *_ in fields.values()
    )


def _numbers(array: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(array).view(np.float64).ravel()


def _floats(array: np.ndarray) -> np.ndarray:
    """(numbers,) whether each number of a table is a float."""
    fields = array.dtype.fields or {"": (array.dtype, 0)}
    row = np.zeros(array.dtype.itemsize // 8, bool)
    for part, offset, *_ in fields.values():
        if part.base.kind == "f":
            row[offset // 8 : (offset + part.itemsize) // 8] = True
    return np.tile(row, len(array))


@kernel
def _time_at(times, u):
    """The time of a uniform number u. ``times``: those of even numbers."""
    place = u * (len(times) - 1)
    cell = min(int(place), len(times) - 2)
    return times[cell] + (place - cell) * (times[cell + 1] - times[cell])


@kernel
def draw_time(block, workspace, y):
    """Draw the time of the workspace's path, which begins in the line ``y``: 0 to 1."""
    path = path_table(workspace)[0]
    u, times = get_1d(path.index, path.seed, TIME_SET), light_path_times(block)
    time = times[min(int(u * len(times)), len(times) - 1)] if len(times) > 0 else _time_at(time_table(block), u)
    if block.rolling_shutter != NOT_ROLLING:
        line = 1.0 - y / camera_table(block)[0].rows
        time = (time - 0.5) * block.rolling_shutter + (line - 0.5) * (1.0 - block.rolling_shutter) + 0.5
    time = min(max(time, 0.0), 1.0)
    _set_time(workspace, time)
    return time


@kernel
def _set_time(workspace, time):
    """Let rays of the workspace have this time, also those of its secondary workspace."""
    ray_table(workspace)[0].time = time
    ray_table(secondary_table(workspace)[0])[0].time = time


@kernel
def stop_at(blocks, workspaces, time):
    """Index of the block for rays of the workspace at a time."""
    _set_time(workspaces[0], time)
    return block_at(blocks, 0, time)


@kernel
def block_at(blocks, first, time):
    """Index of the block for a time, of those of one scene from ``first`` on. Interpolates its moving data."""
    segments = segment_table(blocks[first])
    position = time * len(segments)
    step = min(int(position), len(segments) - 1)
    index = first + segments[step]
    block = blocks[index]
    block.time = time
    times = light_path_times(block)
    for number in range(len(times)):
        if times[number] == time:
            block.light_path_first_node = number * block.light_path_node_count
    if block.moving_steps > 0:
        moving, places, keys = moving_table(block), place_table(block), key_table(block)
        count = len(places)
        part = position - step
        row = (step - block.first_step) * count
        for place in range(count):
            start = keys[row + place]
            moving[places[place]] = start + part * (keys[row + count + place] - start)
    return index
