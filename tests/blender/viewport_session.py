# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What test_viewport_gui runs in a Blender with a window: lamps in the viewport, and renders in it that are
interrupted."""

import pathlib
import sys

import bpy

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPOSITORY), str(REPOSITORY / "scripts")]

from window import Eye, areas, override, report, run, threads, until  # noqa: E402

import sdf_lights.blender as addon  # noqa: E402  (found on the path set above)

UNDOS = 20


def space():
    return areas()[0].spaces.active


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


def has_samples(least=1):
    view = rendered()
    return view is not None and view._render.picture is not None and view._render.picture.samples >= least


def session():
    addon.register()
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
    eye = Eye(place)
    bpy.ops.ed.undo_push(message="Start")

    # -- the proxy
    for shading in ("SOLID", "WIREFRAME", "RENDERED"):
        scene.render.engine = "BLENDER_WORKBENCH"
        space().shading.type = shading
        scene.sdf_lights_overlay.show_lamps = False
        yield 1.5
        report[f"{shading} without"] = base = eye.color()
        scene.sdf_lights_overlay.show_lamps = True
        yield from until(lambda: abs(eye.color()[0] - base[0]) > 0.05)
        yield 0.5
        report[f"{shading} with"] = eye.color()
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
    report["RENDERED path traced"] = eye.color()
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
    area_of_view = areas()[0]
    area_of_view.type = "TEXT_EDITOR"
    yield 1.0
    report["threads after the area has changed"] = threads()
    area_of_view.type = "VIEW_3D"
    yield from until(threads)
    with override():
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=False)
    yield 1.0
    report["threads after loading a file"] = threads()
    report["failures"] = sys.modules["sdf_lights.blender.viewport"]._failures
    lamp("Last", "SPHERE", (0.0, 0.0, 3.0))
    bpy.context.scene.sdf_lights.device = "REFERENCE"
    bpy.context.scene.render.engine = "SDF_LIGHTS"
    space().shading.type = "RENDERED"
    yield from until(threads)


# With a render under way: its threads must not keep Blender from ending.
run(session(), finish=bpy.ops.wm.quit_blender)
