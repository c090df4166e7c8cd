# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the benchmark ``revisions`` runs in a process of its own: renders a file by the extension of any checkout.

    revision_session.py CHECKOUT FILE.blend SIZE FEW MANY ANSWER.json

Uses only what every revision has: ``scripts/host.py``, and the names of settings. Times are processor times. The error
of a sample is the mean over pixels of its relative variance, by the scatter of seeds.
"""

import json
import pathlib
import sys
import time

import bpy
import numpy as np

# The same work in all revisions: a path does not split, and every pixel has as many samples as another. A revision
# without a setting does not have what the setting switches off.
PLAIN = dict(
    device="CPU",
    origin="OWN",
    noise_threshold=0.0,
    denoise=False,
    filter="BOX",
    filter_width=1.0,
    indirect_paths=1,
    guided_samples=False,
    lamp_paths="NEVER",
    path_reuse="NEVER",
    caustic_paths="NEVER",
    filter_glossy=0.0,
)


SEEDS = 8
FLOOR = 0.01  # part of the mean square brightness that is added to the squares which errors are relative to


def error_of_a_sample(scene, samples: int, path: pathlib.Path) -> float:
    scene.sdf_lights.samples = samples
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = str(path)
    pictures = []
    for seed in range(SEEDS):
        scene.sdf_lights.seed = seed
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(str(path))
        image.colorspace_settings.name = "Non-Color"
        values = np.empty(len(image.pixels), np.float32)
        image.pixels.foreach_get(values)
        pictures.append(values.reshape(-1, 4)[:, :3].astype(float))
        bpy.data.images.remove(image)
    squares = np.mean(pictures, axis=0) ** 2
    return samples * float(np.mean(np.var(pictures, axis=0, ddof=1) / (squares + FLOOR * squares.mean())))


def main(checkout: str, blend: str, size: str, few: str, many: str, answer: str) -> None:
    sys.path.insert(0, str(pathlib.Path(checkout, "scripts")))
    import host

    host.register_extension()
    bpy.ops.wm.open_mainfile(filepath=blend)
    scene = bpy.context.scene
    scene.render.engine = host.ENGINE
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 64, 36, 100
    known = scene.sdf_lights.bl_rna.properties.keys()
    for name, value in PLAIN.items():
        if name in known:
            setattr(scene.sdf_lights, name, value)

    def seconds(samples: int) -> float:
        scene.sdf_lights.samples = samples
        before = time.process_time()
        bpy.ops.render.render()
        return time.process_time() - before

    seconds(1)
    start = time.process_time()
    scene.render.resolution_x = scene.render.resolution_y = int(size)
    seconds(1)
    short, long = seconds(int(few)), seconds(int(many))
    rate = (int(many) - int(few)) * int(size) ** 2 / (long - short)
    error = error_of_a_sample(scene, int(few), pathlib.Path(answer).with_name("picture.exr"))
    pathlib.Path(answer).write_text(json.dumps(dict(start=start, rate=rate, error=error)), encoding="utf-8")
    host.finish(0)


if __name__ == "__main__":
    main(*sys.argv[1:])
