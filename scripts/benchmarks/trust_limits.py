# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Memory and time of pictures, lamps, meshes, instances and textures, and the sizes that follow."""

from __future__ import annotations

import time

import numpy as np

from . import isolation

LARGE = 16_384  # pixels along a side of the largest still in the table
MEGABYTE = 1e6
LAMPS = 100, 1_000, 4_000
SCENES = {"triangles": 2_000_000, "instances": 100_000, "texels": 64_000_000}


def lamps(counts: tuple[int, ...]) -> list[dict]:
    """Processor time and memory of many lamps, each with a shape of a different size."""
    from sdf_lights.emitter.building.build import build_lamp
    from sdf_lights.emitter.building.pack import pack_lamps
    from sdf_lights.sdf.shapes import Sphere

    rows = []
    for count in counts:
        place, started = np.eye(4), time.process_time()
        built = [build_lamp(f"Lamp {index}", Sphere(0.1 + 1e-6 * index), place) for index in range(count)]
        tables = pack_lamps(built)
        size = sum(table.nbytes for table in tables.values())
        rows.append(dict(lamps=count, seconds=time.process_time() - started, kilobytes_each=size / count / 1e3))
    return rows


def pictures() -> list[dict]:
    """Bytes per pixel of the picture alone, and of each additional pass."""
    from sdf_lights.render.film import bytes_of_a_pixel
    from sdf_lights.render.passes import PASSES
    from support import scenes

    scene = scenes.SCENES["torus_room"](LARGE, LARGE)
    scene.settings.denoise = False
    alone = bytes_of_a_pixel(scene)
    rows = [dict(passes="Combined alone", megabytes_per_megapixel=alone, gigabytes_of_16k=alone * LARGE**2 / 1e9)]
    scene.settings.denoise = True
    more = bytes_of_a_pixel(scene) - alone
    scene.settings.denoise = False
    rows.append(dict(passes="with denoising", megabytes_per_megapixel=more, gigabytes_of_16k=more * LARGE**2 / 1e9))
    for item in PASSES:
        more = bytes_of_a_pixel(scene, (item.name,)) - alone
        if item.name != "Combined" and more:
            rows.append(dict(passes=item.name, megabytes_per_megapixel=more, gigabytes_of_16k=more * LARGE**2 / 1e9))
    return rows


# -- scenes ---------------------------------------------------------------------------------------------------------


def _grid(triangles: int):
    """A mesh of waves with about so many triangles."""
    from sdf_lights.render.scene import Mesh

    side = max(int(np.sqrt(triangles / 2)), 1)
    x, y = np.meshgrid(*[np.linspace(-1.0, 1.0, side + 1, dtype=np.float32)] * 2, indexing="ij")
    positions = np.stack([x, y, 0.1 * np.sin(9.0 * x * y)], axis=-1).reshape(-1, 3)
    corner = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    first, second = (corner[:, None] + np.array(steps) for steps in ((0, side + 1, side + 2), (0, side + 2, 1)))
    return Mesh("Grid", positions, np.concatenate([first, second]).astype(np.int32))


def _filled(kind: str, count: int):
    """The room of the tests with so many triangles, instances or texels in it; and their number."""
    import dataclasses

    from sdf_lights.render.scene import Instance
    from support import scenes

    if kind == "texels":
        scene = scenes.SCENES["textured"](16, 16)
        side = int(np.sqrt(count))
        image = scene.images[0]
        pixels = np.zeros((side, side, *image.pixels.shape[2:]), image.pixels.dtype)
        scene.images[0] = dataclasses.replace(image, pixels=pixels)
        return scene, side * side
    scene = scenes.SCENES["torus_room"](16, 16)
    mesh = _grid(count if kind == "triangles" else 2)
    scene.meshes.append(mesh)
    places = np.random.default_rng(1).uniform(-5.0, 5.0, (count if kind == "instances" else 1, 3))
    for place in places:
        matrix = np.eye(4)
        matrix[:3, 3] = place
        scene.instances.append(Instance(len(scene.meshes) - 1, matrix, (0,)))
    return scene, len(mesh.triangles) if kind == "triangles" else len(places)


def _taken(kind: str, count: int) -> dict:
    """The additional cost of a scene compared with an empty one, from its meshes to the structures for rays; in a
    separate process."""
    from sdf_lights.render.cpu.block import PackedScene
    from sdf_lights.render.film import Film

    from .soaking import memory

    empty = _filled(kind, 1)[0]
    small = PackedScene(empty, Film(empty, ()))  # compiles
    scene, number = _filled(kind, count)
    before, started = memory(), time.process_time()
    packed = PackedScene(scene, Film(scene, ()))
    seconds = time.process_time() - started
    found = dict(what=kind, number=number, seconds=seconds, bytes_each=(memory() - before) / number)
    small.release()
    packed.release()
    return found


def scenes(quick: bool) -> list[dict]:
    """Bytes and time of triangles, instances and texels, in addition to their own data."""
    rows = []
    for kind, count in SCENES.items():
        process = isolation.Isolated()
        rows.append(process.call(_taken, kind, count // 10 if quick else count))
        process.close()
    return rows


PARTS = {
    "lamps": lambda quick: lamps(LAMPS[:1] if quick else LAMPS),
    "pictures": lambda quick: pictures(),
    "scenes": scenes,
}
