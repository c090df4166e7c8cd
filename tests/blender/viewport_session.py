# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What test_viewport_gui runs in a Blender with a window: lamps in the viewport, and renders in it that are interrupted.

    blender --factory-startup --python viewport_session.py -- REPORT.json

The report says what was seen at each step; judging it is the test's part.
"""

import json
import os
import pathlib
import sys
import tempfile
import threading
import time
import traceback

import bpy
import numpy as np

REPORT = pathlib.Path(sys.argv[sys.argv.index("--") + 1])
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from bpy_extras.view3d_utils import location_3d_to_region_2d  # noqa: E402

import sdf_lights.blender as addon  # noqa: E402  (found on the path set above)

PATIENCE = 120.0
UNDOS = 20
report: dict = {}


def area():
    return next(area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == "VIEW_3D")


def region():
    return next(region for region in area().regions if region.type == "WINDOW")


def space():
    return area().spaces.active


def override():
    return bpy.context.temp_override(window=bpy.context.window_manager.windows[0], area=area(), region=region())


def threads() -> list[str]:
    return sorted(thread.name for thread in threading.enumerate() if thread.name == "SDF Lights: viewport")


def pixel_at(place) -> list[float]:
    """RGB on the screen, mean of a few pixels, of a place in the world."""
    path = os.path.join(tempfile.gettempdir(), f"viewport_session_{os.getpid()}.png")
    with override():
        bpy.ops.screen.screenshot_area(filepath=path)
    image = bpy.data.images.load(path)
    width, height = image.size
    values = np.array(image.pixels[:]).reshape(height, width, -1)
    bpy.data.images.remove(image)
    os.remove(path)
    at = location_3d_to_region_2d(region(), space().region_3d, place)
    # The screenshot is of the area, which the region is a part of.
    x, y = int(at.x) + region().x - area().x, int(at.y) + region().y - area().y
    return values[y - 2:y + 3, x - 2:x + 3, :3].mean(axis=(0, 1)).tolist()


def lamp(name, shape, location, **parameters):
    light = bpy.data.lights.new(name, "POINT")
    light.energy, light.sdf_lamp.use, light.sdf_lamp.shape = 60.0, True, shape
    for key, value in parameters.items():
        setattr(getattr(light.sdf_lamp, shape.lower()), key, value)
    obj = bpy.data.objects.new(name, light)
    obj.location = location
    bpy.context.scene.collection.objects.link(obj)
    return obj


def rendered():
    from sdf_lights.blender.viewport import rendered

    return next(iter(rendered._running), None)


def until(condition):
    """Steps that wait for something; raises if it does not come."""
    deadline = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(f"waited in vain, line {sys._getframe(1).f_back.f_lineno}")
        yield 0.05


def has_samples(least=1):
    view = rendered()
    return view is not None and view._render.picture is not None and view._render.picture.samples >= least


def session():
    scene = bpy.context.scene
    for obj in list(scene.objects):
        bpy.data.objects.remove(obj)
    scene.world.color = (0.0, 0.0, 0.0)
    bpy.ops.mesh.primitive_plane_add(size=10.0, location=(0.0, 0.0, -1.0))
    red = lamp("Red", "SPHERE", (0.0, 0.0, 0.5), radius=0.8)
    red.data.color = (1.0, 0.05, 0.0)
    bpy.context.view_layer.objects.active = red
    place = tuple(red.location + red.matrix_world.to_3x3().col[0] * 0.3)
    scene.sdf_lights.device = "REFERENCE"  # machine code may have to be compiled first
    space().overlay.show_extras = False
    bpy.ops.ed.undo_push(message="Start")

    # -- the proxy
    for shading in ("SOLID", "WIREFRAME", "RENDERED"):
        scene.render.engine = "BLENDER_WORKBENCH"
        space().shading.type = shading
        for shown in (True, False):
            scene.sdf_lights_overlay.show_lamps = shown
            yield 1.5
            report[f"{shading} {'with' if shown else 'without'}"] = pixel_at(place)
    scene.sdf_lights_overlay.show_lamps = True
    from sdf_lights.blender.viewport import proxy_error

    report["error"] = proxy_error(red.data)
    red.data.sdf_lamp.source, red.data.sdf_lamp.expression = "EXPRESSION", "sphere(0.8"
    yield 1.0
    report["error in expression"] = proxy_error(red.data)
    red.data.sdf_lamp.source = "PRIMITIVE"

    # -- the path tracer
    scene.render.engine = "SDF_LIGHTS"
    space().shading.type = "RENDERED"
    yield from until(has_samples)
    yield 0.5
    report["RENDERED path traced"] = pixel_at(place)
    report["threads"] = threads()

    before = rendered()._render.picture
    space().region_3d.view_distance *= 1.1
    yield from until(lambda: rendered()._render.picture.camera is not before.camera)
    report["picture after a zoom"] = rendered()._render.picture.number > before.number
    counts = []
    for step in range(UNDOS):
        with override():
            red = bpy.data.objects["Red"]
            red.location.x = 0.02 * step
            bpy.ops.ed.undo_push(message=f"Move {step}")
        yield 0.01
    for step in range(UNDOS):
        with override():
            operator = bpy.ops.ed.undo if step % 3 else bpy.ops.ed.redo
            if operator.poll():
                operator()
        yield 0.01
        counts.append(len(threads()))
    report["most threads while undoing"] = max(counts)
    yield from until(has_samples)
    report["renders after undo"] = True

    # -- ends of the render
    bpy.context.scene.render.engine = "BLENDER_WORKBENCH"
    yield 1.0
    report["threads after a change of engine"] = threads()
    bpy.context.scene.render.engine = "SDF_LIGHTS"
    yield from until(threads)
    space().shading.type = "SOLID"
    yield 1.0
    report["threads after a change of shading"] = threads()
    space().shading.type = "RENDERED"
    yield from until(threads)
    area_of_view = area()
    area_of_view.type = "TEXT_EDITOR"
    yield 1.0
    report["threads after the area has changed"] = threads()
    area_of_view.type = "VIEW_3D"
    yield from until(threads)
    with override():
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=False)
    yield 1.0
    report["threads after loading a file"] = threads()
    report["failure"] = sys.modules["sdf_lights.blender.viewport"]._failure
    lamp("Last", "SPHERE", (0.0, 0.0, 3.0))
    bpy.context.scene.sdf_lights.device = "REFERENCE"
    bpy.context.scene.render.engine = "SDF_LIGHTS"
    space().shading.type = "RENDERED"
    yield from until(threads)


def finish():
    REPORT.write_text(json.dumps(report), encoding="utf-8")
    sys.stdout.flush()
    # With a render under way: its threads must not keep Blender from ending.
    bpy.ops.wm.quit_blender()


steps = session()


def tick():
    try:
        known = len(report)
        wait = next(steps)
        if len(report) != known:
            print(list(report.items())[known:], flush=True)
        return wait
    except StopIteration:
        pass
    except Exception:
        report["traceback"] = traceback.format_exc()
    finish()


addon.register()
bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(tick, first_interval=1.0, persistent=True)
