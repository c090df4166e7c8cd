# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the benchmark ``revisions`` runs in a process of its own: renders a file by the extension of any checkout.

    revision_session.py CHECKOUT FILE.blend SIZE FEW MANY ANSWER.json

Uses only what every revision has: ``scripts/host.py``, and the names of settings. Times are processor times.
"""

import json
import pathlib
import sys
import time

import bpy

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
    filter_glossy=0.0,
)


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
    pathlib.Path(answer).write_text(json.dumps(dict(start=start, rate=rate)), encoding="utf-8")
    host.finish(0)


if __name__ == "__main__":
    main(*sys.argv[1:])
