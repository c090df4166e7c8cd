# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What test_shadings_gui runs in a Blender with a window: a lamp in every shading of every engine, with and without
overlays."""

import pathlib
import sys

import bpy

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPOSITORY), str(REPOSITORY / "scripts")]

from window import Eye, areas, override, report, run, until  # noqa: E402

import sdf_lights.blender as addon  # noqa: E402  (found on the path set above)
from sdf_lights.blender import viewport  # noqa: E402
from sdf_lights.blender.viewport import rendered  # noqa: E402

LAMP, BEHIND = (0.0, 0.0, 0.6), (1.6, 0.0, 0.6)  # of the two lamps; a wall is in front of the second


ENGINES = "BLENDER_EEVEE", "BLENDER_WORKBENCH", "CYCLES", "SDF_LIGHTS"


def add(name, place, color):
    light = bpy.data.lights.new(name, "POINT")
    light.energy, light.color = 60.0, color
    light.sdf_lamp.use, light.sdf_lamp.shape, light.sdf_lamp.sphere.radius = True, "SPHERE", 0.5
    lamp = bpy.data.objects.new(name, light)
    lamp.location = place
    bpy.context.scene.collection.objects.link(lamp)


def scene():
    made = bpy.context.scene
    for obj in list(made.objects):
        bpy.data.objects.remove(obj)
    made.world = None
    made.sdf_lights.viewport.samples = 16
    made.cycles.preview_samples, made.cycles.use_preview_denoising = 4, False
    with override():
        bpy.ops.mesh.primitive_plane_add(size=8.0)
        bpy.ops.mesh.primitive_cube_add(size=1.0, location=(BEHIND[0], -1.5, 0.7))
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.rotation_euler = (1.2, 0.0, 0.0)  # on the side of the wall that the camera sees
    made.collection.objects.link(sun)
    add("Red", LAMP, (1.0, 0.05, 0.0))
    add("Blue", BEHIND, (0.0, 0.05, 1.0))
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.8, -7.0, 0.7), (1.5708, 0.0, 0.0)
    made.collection.objects.link(camera)
    made.camera = camera


def is_still():
    """Whether all lamps are drawn as they are, in full resolution, and the path tracer has all its samples."""
    return (
        not viewport.drawn.overlay.finder.busy
        and not any(viewport.drawn.overlay._labels.values())
        and all(view._render.finished for view in rendered._running)
    )


def meshes_after(space, eye):
    """What of the scene is gone through for the depth behind lamps, where overlays leave none."""
    bpy.context.scene.render.engine = "BLENDER_WORKBENCH"
    space.shading.type, space.overlay.show_overlays = "RENDERED", False
    surfaces, cube = viewport.drawn.overlay._surfaces, bpy.data.objects["Cube"]
    report["meshes"] = rows = {}
    for name, change in {
        "a start": lambda: None,
        "a turn of the view": lambda: setattr(space.region_3d, "view_camera_zoom", 10.0),
        "a move": lambda: setattr(cube.location, "z", 0.8),
        "hiding one": lambda: cube.hide_set(True),
        "a filter of the viewport": lambda: setattr(space, "show_object_viewport_mesh", False),
    }.items():
        before, drawn, redraws = list(surfaces._shown.values()), surfaces._drawn, eye.redraws
        change()
        areas()[0].tag_redraw()
        yield from until(lambda: eye.redraws > redraws)
        yield 0.6
        yield from until(is_still)
        shown = list(surfaces._shown.values())[-1]
        rows[name] = dict(
            drawn=surfaces._drawn is not drawn, listed=all(shown is not other for other in before), count=len(shown[1])
        )


def session():
    addon.register()
    bpy.ops.preferences.addon_enable(module="cycles")
    scene()
    space = areas()[0].spaces.active
    with override():
        bpy.ops.view3d.view_camera()
    space.overlay.show_extras = space.overlay.show_floor = space.overlay.show_relationship_lines = False
    eye = Eye(LAMP, BEHIND)
    settings = bpy.context.scene.sdf_lights_overlay
    report["seen"] = rows = []
    for engine in ENGINES:
        bpy.context.scene.render.engine = engine
        for shading in ("WIREFRAME", "SOLID", "MATERIAL", "RENDERED"):
            if shading == "MATERIAL" and engine == "BLENDER_WORKBENCH":
                continue  # there is none
            space.shading.type = shading
            row = {"engine": engine, "shading": shading}
            settings.show_lamps = False
            eye.colors.clear()
            yield from until(lambda: shading == "WIREFRAME" or (0, 1) in eye.colors and max(eye.color(1)) > 0.1)
            for overlays, lamps in ((True, False), (True, True), (False, True)):
                space.overlay.show_overlays, settings.show_lamps = overlays, lamps
                yield 0.6
                yield from until(is_still)
                redraws = eye.redraws
                areas()[0].tag_redraw()
                yield from until(lambda: eye.redraws > redraws)
                row[f"{'overlays' if overlays else 'no overlays'}, {'lamps' if lamps else 'no lamps'}"] = [
                    eye.color(0),
                    eye.color(1),
                ]
            space.overlay.show_overlays = True
            rows.append(row)
    yield from meshes_after(space, eye)
    report["failures"] = viewport._failures


run(session())
