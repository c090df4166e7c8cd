# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What test_rendered_gui runs in a Blender with a window: all that may happen to a viewport while it renders.

    blender --factory-startup --enable-event-simulate --python rendered_session.py -- REPORT.json FILE.blend

The report says what was seen at each step; judging it is the test's part.
"""

import pathlib
import sys
import time

import bpy
import numpy as np

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPOSITORY), str(REPOSITORY / "scripts")]

from window import (  # noqa: E402
    ARGUMENTS,
    Eye,
    areas,
    drag,
    inside,
    move,
    on_screen,
    override,
    press,
    region_of,
    report,
    run,
    threads,
    until,
)

import sdf_lights.blender as addon  # noqa: E402  (found on the path set above)
from sdf_lights.blender.viewport import rendered  # noqa: E402

MOVES, UNDOS = 20, 200
LAMP, FLOOR = (0.0, 0.0, 0.6), (0.9, -0.9, 0.0)  # places that the eye looks at


def view(area=None):
    """The render of a viewport."""
    found = rendered._by_region.get(region_of(area or areas()[0]).as_pointer())
    return found() if found is not None else None


def picture(area=None):
    """The latest picture that was drawn into a viewport."""
    found = view(area)
    return found.drawn if found is not None else None


def is_sampled(area=None):
    """Whether the viewport shows samples at full resolution of the data as they are."""
    found, shown = view(area), picture(area)
    return (
        found is not None
        and found._stale is None
        and shown is not None
        and shown.divider == 1
        and shown.samples >= 2
        and shown.camera is found._scene.camera
    )


def rendering():
    found = view()
    return found is not None and found.busy


def scene():
    made = bpy.context.scene
    for obj in list(made.objects):
        bpy.data.objects.remove(obj)
    made.world = None
    made.render.engine = "SDF_LIGHTS"
    made.sdf_lights.viewport.samples = 4096
    made.sdf_lights.viewport.noise_threshold = 0.0
    with override():
        bpy.ops.mesh.primitive_plane_add(size=6.0)
        bpy.context.object.name = "Floor"
    light = bpy.data.lights.new("Red", "POINT")
    light.energy, light.color = 60.0, (1.0, 0.05, 0.0)
    light.sdf_lamp.use, light.sdf_lamp.shape, light.sdf_lamp.box_frame.thickness = True, "SPHERE", 0.1
    lamp = bpy.data.objects.new("Red", light)
    lamp.location = LAMP
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.0, -6.0, 1.5), (1.4, 0.0, 0.0)
    for obj in (lamp, camera):
        made.collection.objects.link(obj)
    made.camera = camera
    bpy.context.view_layer.objects.active = lamp
    made.render.resolution_x, made.render.resolution_y = 640, 360


def session():
    addon.register()
    scene()
    yield 0.5
    area = areas()[0]
    area.spaces.active.region_3d.view_distance = 7.0
    area.spaces.active.overlay.show_extras = area.spaces.active.overlay.show_floor = False
    eye = Eye(LAMP, FLOOR)
    with override():
        bpy.ops.ed.undo_push(message="Start")
    area.spaces.active.shading.type = "RENDERED"
    started = time.monotonic()
    yield from until(is_sampled)
    report["seconds to the first samples"] = time.monotonic() - started
    yield 1.0
    report["lamp"], report["floor"] = eye.color(0), eye.color(1)
    yield from clicked()
    yield from orbited(eye)
    yield from undone_and_redone(eye)
    yield from cut(eye)
    yield from second_viewport()
    yield from switched()
    yield from saved(eye)
    report["failures"] = sys.modules["sdf_lights.blender.viewport"]._failures
    report["errors"] = rendered.warnings()


def clicked():
    """Click on the floor, then on the body of the lamp beside its icon, then on the floor with Shift."""
    report["clicked"] = []
    for place, shift in ((FLOOR, False), ((LAMP[0] + 0.3, LAMP[1], LAMP[2]), False), (FLOOR, True)):
        mouse = move(on_screen(areas()[0], place))
        yield 0.3
        press(mouse, "LEFTMOUSE", shift=shift)
        yield 1.0
        layer = bpy.context.view_layer
        report["clicked"].append([layer.objects.active.name, sorted(obj.name for obj in layer.objects.selected)])


def orbited(eye):
    """Drag with the middle button, in steps, while the render starts anew at each."""
    area = areas()[0]
    before = np.array(area.spaces.active.region_3d.view_matrix)
    start, numbers = inside(area), [picture().number]
    yield from drag(start, (start[0] + 120.0, start[1]), "MIDDLEMOUSE", 30, lambda: numbers.append(picture().number))
    yield from until(is_sampled)
    yield 0.5
    after = np.array(area.spaces.active.region_3d.view_matrix)
    cosine = 0.5 * (np.trace(before[:3, :3] @ after[:3, :3].T) - 1.0)
    report["orbit turned by"] = float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))
    report["pictures while orbiting"] = numbers[-1] - numbers[0]
    report["picture after the orbit is of the view"] = bool(
        np.allclose(picture().camera.matrix[:3, :3], after[:3, :3].T, atol=1e-5)
    )
    report["lamp after the orbit"] = eye.color(0)


def undone_and_redone(eye):
    """Edit with undo steps, then Ctrl Z and Ctrl Shift Z, 200 of them, none of which waits for a render to end."""
    for step in range(MOVES):
        bpy.data.objects["Red"].location.x = 0.1 * (step + 1)
        if step % 5 == 4:
            bpy.data.objects["Red"].data.sdf_lamp.shape = "BOX_FRAME" if step % 2 else "SPHERE"
        with override():
            bpy.ops.ed.undo_push(message=f"Move {step}")
        yield 0.02
    yield from until(is_sampled)
    place = move(inside(areas()[0]))
    positions, most, while_rendering = [], 0, 0
    for turn in range(UNDOS):
        backwards = turn // MOVES % 2 == 0
        press(place, "Z", ctrl=True, shift=not backwards)
        was = rendering()
        yield 0.02
        yield from until(lambda: view() is not None and (rendering() or view()._render.finished))
        while_rendering += was
        most = max(most, len(threads()))
        positions.append(round(bpy.data.objects["Red"].location.x, 3))
    report["undos"], report["undos while rendering"] = len(positions), while_rendering
    report["places of undo"] = sorted(set(positions))
    report["last place of undo"] = positions[-1]
    report["most threads while undoing"] = most
    while bpy.data.objects["Red"].location.x > 0.05:
        press(place, "Z", ctrl=True)
        yield 0.1
    yield from until(is_sampled)
    yield 1.0
    report["lamp after undo"], report["floor after undo"] = eye.color(0), eye.color(1)


def cut(eye):
    """Local view, the render region, and camera view with a frame and a region of its own."""
    area = areas()[0]
    space = area.spaces.active
    for obj in bpy.context.view_layer.objects:
        obj.select_set(obj.name == "Floor")
    before = [list(row) for row in space.region_3d.view_matrix], space.region_3d.view_distance
    with override():
        bpy.ops.view3d.localview(frame_selected=False)
    yield from until(lambda: is_sampled() and not view()._scene.lamps)
    yield 0.5
    report["lamp in local view"] = eye.color(0)
    with override():
        bpy.ops.view3d.localview(frame_selected=False)
    yield from until(lambda: is_sampled() and view()._scene.lamps)
    space.region_3d.view_distance = before[1]

    region = region_of(area)
    with override():
        bpy.ops.view3d.render_border(xmin=0, xmax=region.width // 2, ymin=0, ymax=region.height)
    yield from until(lambda: is_sampled() and picture().window[2] < region.width)
    yield 0.5
    report["window of the region"] = [*picture().window, region.width, region.height]
    eye.colors.clear()
    yield from until(lambda: (0, 1) in eye.colors)
    report["floor outside of the region"] = eye.color(1)
    with override():
        bpy.ops.view3d.clear_render_border()

    with override():
        bpy.ops.view3d.view_camera()
    yield from until(lambda: space.region_3d.view_perspective == "CAMERA")
    yield 1.0
    yield from until(lambda: is_sampled() and picture().window[2] == region.width)
    yield 0.5
    report["lamp in camera view"] = eye.color(0)
    bpy.context.scene.render.use_border = True
    for name, value in zip(("min_x", "max_x", "min_y", "max_y"), (0.25, 0.75, 0.25, 0.75)):
        setattr(bpy.context.scene.render, f"border_{name}", value)
    yield from until(lambda: is_sampled() and picture().window[2] < region.width)
    report["window of the camera's region"] = [*picture().window, region.width, region.height]
    bpy.context.scene.render.use_border = False
    yield from until(lambda: is_sampled() and picture().window[2] == region.width)


def second_viewport():
    area = areas()[0]
    with override(area):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5)
    yield from until(lambda: len(areas()) == 2)
    for area in areas():
        area.spaces.active.shading.type = "RENDERED"  # Blender makes the copy Solid
    yield from until(lambda: all(is_sampled(area) for area in areas()))
    report["threads of two viewports"] = len(threads())
    with override(areas()[1]):
        bpy.ops.screen.area_close()
    yield from until(lambda: len(areas()) == 1)
    yield 1.0
    report["threads after one was closed"] = len(threads())
    yield from until(is_sampled)


def switched():
    """Other engines, editors and shadings, each while a render goes on."""
    area = areas()[0]
    for name, there, back in (
        (
            "engine",
            lambda: setattr(bpy.context.scene.render, "engine", "BLENDER_WORKBENCH"),
            lambda: setattr(bpy.context.scene.render, "engine", "SDF_LIGHTS"),
        ),
        ("editor", lambda: setattr(area, "type", "TEXT_EDITOR"), lambda: setattr(area, "type", "VIEW_3D")),
        (
            "shading",
            lambda: setattr(area.spaces.active.shading, "type", "SOLID"),
            lambda: setattr(area.spaces.active.shading, "type", "RENDERED"),
        ),
    ):
        yield from until(rendering)
        there()
        yield 1.0
        report[f"threads after another {name}"] = len(threads())
        back()
        yield from until(is_sampled)


def saved(eye):
    light = bpy.data.objects["Red"].data
    light.sdf_lamp.shape, light.sdf_lamp.sphere.radius = "SPHERE", 0.7
    yield from until(lambda: is_sampled() and view()._scene.lamps[0].shape.radius > 0.69)
    yield 1.5
    report["lamp before saving"] = eye.color(0)
    with override():
        bpy.ops.wm.save_as_mainfile(filepath=ARGUMENTS[1])
    bpy.data.objects["Red"].data.sdf_lamp.sphere.radius = 0.2
    yield 0.2
    with override():
        bpy.ops.wm.open_mainfile(filepath=ARGUMENTS[1])
    yield 0.2
    report["threads after loading"] = len(threads())
    areas()[0].spaces.active.shading.type = "RENDERED"  # Blender opens files in Solid
    yield from until(is_sampled)
    yield 1.5
    report["lamp after loading"] = eye.color(0)
    report["shape after loading"] = [
        bpy.data.objects["Red"].data.sdf_lamp.shape,
        bpy.data.objects["Red"].data.sdf_lamp.sphere.radius,
    ]


# With a render under way: its threads must not keep Blender from ending.
run(session(), finish=bpy.ops.wm.quit_blender)
