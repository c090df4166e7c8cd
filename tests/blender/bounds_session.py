# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What test_native_gui runs in a Blender with a window: all that Blender does by the bounds of an object, with
lamps."""

import pathlib
import sys

import bpy
import numpy as np

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPOSITORY), str(REPOSITORY / "scripts")]

from window import (  # noqa: E402
    ARGUMENTS,
    Eye,
    areas,
    drag,
    event,
    inside,
    lamps_are_drawn,
    move,
    on_screen,
    override,
    picture,
    press,
    region_of,
    report,
    run,
    until,
)

import sdf_lights.blender as addon  # noqa: E402  (found on the path set above)
from sdf_lights.blender import fallback  # noqa: E402
from sdf_lights.blender.viewport import bodies  # noqa: E402

PICTURES = ARGUMENTS[1] if len(ARGUMENTS) > 1 else None


def covered(view, obj):
    """Part of the shorter side of a viewport that a lamp takes."""
    region = region_of(view)
    places = np.array([on_screen(view, point) for point in bodies.points_in_world(obj)])
    return float((places.max(axis=0) - places.min(axis=0)).max() / min(region.width, region.height))


def selected():
    return sorted(obj.name for obj in bpy.context.view_layer.objects.selected)


def clear_selection():
    for obj in bpy.context.view_layer.objects:
        obj.select_set(False)


def pressed(view, key):
    """Steps: a key that moves the view, until it has moved."""
    data = view.spaces.active.region_3d
    before = data.view_distance
    press(move(inside(view, 0.3, 0.3)), key)
    yield from until(lambda: abs(data.view_distance - before) > 1e-3 * before, 30.0)
    last = None
    while last != data.view_distance:
        last = data.view_distance
        yield 0.5


def framed(view, ring):
    """Numpad period on a lamp ten metres wide, and on one of ten centimetres."""
    lamp = ring.data.sdf_lamp.torus
    for size in (5.0, 0.05):
        lamp.major_radius, lamp.minor_radius = size, 0.2 * size
        yield 1.0
        yield from pressed(view, "NUMPAD_PERIOD")
        report[f"framed {size}"] = covered(view, ring)
        report[f"circle {size}"] = ring.data.shadow_soft_size
    lamp.major_radius, lamp.minor_radius = 1.0, 0.1
    yield 0.5
    yield from pressed(view, "HOME")
    report["framed all"] = covered(view, ring)


def boxed(view, ring):
    """A drag around a part of the ring that is far from its origin, then keys for a circle there."""

    def across(x):
        return on_screen(view, (x, 0.0, 0.0))

    clear_selection()
    right = across(1.0)
    yield from drag((right[0] - 25.0, right[1] - 60.0), (right[0] + 40.0, right[1] + 60.0))
    yield 0.5
    report["in the box"] = selected()
    middle = across(0.74)  # between the body and the circle that Blender draws
    yield from drag((middle[0] - 9.0, middle[1] - 9.0), (middle[0] + 9.0, middle[1] + 9.0))
    yield 0.5
    report["in a box in the hole"] = selected()
    press(move(middle), "B")
    yield 0.3
    yield from drag((right[0] - 25.0, right[1] - 60.0), (right[0] + 40.0, right[1] + 60.0))
    yield 0.5
    report["after B"] = selected()
    press(move(middle), "C")
    yield 0.3
    event("MIDDLEMOUSE", "PRESS", move(right))
    yield 0.3
    picture(PICTURES, "circle_select", view)
    event("MIDDLEMOUSE", "RELEASE", right)
    yield 0.3
    report["taken off by the circle"] = selected()
    event("LEFTMOUSE", "PRESS", right)
    yield 0.3
    event("LEFTMOUSE", "RELEASE", right)
    press(right, "ESC")
    yield 0.5
    report["after C"] = selected()
    press(inside(view, 0.5, 0.9), "Z", ctrl=True)
    yield 0.5
    report["undone"] = selected()


def thin(view, ring):
    """A ring as thick as a hair, from far away, in Solid."""
    ring.data.sdf_lamp.torus.minor_radius = 0.002
    ring.data.color = 1.0, 0.1, 0.1
    space = view.spaces.active
    clear_selection()
    with override(view):
        bpy.ops.view3d.view_axis(type="TOP")
    space.region_3d.view_distance = 12.0
    space.overlay.show_floor = space.overlay.show_axis_x = space.overlay.show_axis_y = False
    turns = np.linspace(0.1, 1.4, 8)
    eye = Eye(*((np.cos(turn), np.sin(turn), 0.0) for turn in turns), (0.5, 0.0, 0.0))
    yield 1.0
    yield from until(lamps_are_drawn)
    yield 1.0
    background = eye.color(len(turns))
    report["thin"] = [eye.color(index)[0] - background[0] for index in range(len(turns))]
    picture(PICTURES, "thin", view)
    eye.close()


def transformed(view, ring):
    """Apply Scale, and where it cannot be; the origin to the geometry."""
    lamp = ring.data.sdf_lamp
    lamp.torus.minor_radius = 0.1
    with override(view):
        ring.select_set(True)
        bpy.context.view_layer.objects.active = ring
        ring.scale = 2.0, 2.0, 2.0
        yield 0.3
        bpy.ops.sdf_lights.scale_apply()
        report["applied"] = [*ring.scale, lamp.torus.major_radius, lamp.torus.minor_radius]
        ring.scale = 1.0, 2.0, 1.0
        try:
            bpy.ops.sdf_lights.scale_apply()
            report["refused"] = ""
        except RuntimeError as error:
            report["refused"] = str(error)
        ring.scale = 1.0, 1.0, 1.0
        lamp.source, lamp.expression = "EXPRESSION", "translate(sphere(0.4), (1, 0, 0))"
        yield 0.3
        before = bodies.points_in_world(ring).mean(axis=0)
        bpy.ops.sdf_lights.origin_to_geometry()
        yield 0.3
        after = bodies.points_in_world(ring).mean(axis=0)
    report["origin"] = [*ring.location, *(after - before)]


def other_engines(view, ring):
    """The light that other engines see: its colour is that of the pattern."""
    lamp = ring.data.sdf_lamp
    lamp.source, lamp.emission.source = "PRIMITIVE", "FLAME"
    yield 1.5
    node = fallback._own_node(ring.data)
    report["flame"] = [*node.inputs["Color"].default_value][:3]
    report["tint"] = [*ring.data.color]
    lamp.emission.source = "UNIFORM"
    yield 1.5
    report["even"] = [*node.inputs["Color"].default_value][:3]


def steps():
    addon.register()
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    bpy.context.scene.render.engine = "SDF_LIGHTS"
    view = areas()[0]
    with override(view):
        bpy.ops.mesh.primitive_cube_add(size=0.2, location=(0.0, 3.0, 0.0))
        bpy.ops.sdf_lights.lamp_add(shape="TORUS")
        bpy.ops.view3d.view_axis(type="TOP")
    ring = bpy.context.object
    ring.name = "Ring"
    bpy.ops.ed.undo_push(message="Start")
    yield 2.0
    for part in (framed, boxed):
        yield from part(view, ring)
    # Undo has made the objects anew.
    for part in (thin, transformed, other_engines):
        yield from part(view, bpy.data.objects["Ring"])


if __name__ == "__main__":
    run(steps())
