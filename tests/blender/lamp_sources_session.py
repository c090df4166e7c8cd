# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What test_lamp_sources_gui runs in a Blender with a window: a lamp whose shape comes from one source after the other,
with its panel in the sidebar and its body in the viewport."""

import math
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
    button_of,
    lamps_are_drawn,
    move,
    picture,
    press,
    region_of,
    report,
    run,
    until,
)

import sdf_lights.blender as addon  # noqa: E402  (found on the path set above)
from sdf_lights.blender import objects  # noqa: E402
from sdf_lights.blender.lamp import shape_of  # noqa: E402

PICTURES = ARGUMENTS[1] if len(ARGUMENTS) > 1 else None
PATH = 'bpy.data.lights["Lamp"].sdf_lamp.'


def linked(name, data):
    obj = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(obj)
    obj.hide_set(True)
    return obj


def text():
    curve = bpy.data.curves.new("Text", "FONT")
    curve.body, curve.size, curve.align_x, curve.align_y = "O", 2.0, "CENTER", "CENTER"
    return linked("Text", curve)


def curve():
    data = bpy.data.curves.new("Curve", "CURVE")
    data.dimensions, data.bevel_depth = "3D", 0.2
    spline = data.splines.new("NURBS")
    spline.points.add(7)
    for point, a in zip(spline.points, np.linspace(0.0, 2.0 * math.pi, 8, endpoint=False)):
        point.co = math.cos(a), math.sin(a), 0.0, 1.0
    spline.use_cyclic_u = True
    return linked("Curve", data)


def mesh():
    bpy.ops.mesh.primitive_torus_add(major_radius=0.8, minor_radius=0.2)
    data = bpy.context.object.data
    bpy.data.objects.remove(bpy.context.object)
    return linked("Mesh", data)


def volume():
    """A level set that OpenVDB writes, where Blender has its module."""
    module = objects.volumes.vdb()
    if module is None:
        return None
    grid = module.createLevelSetSphere(radius=0.7, voxelSize=0.05) if hasattr(module, "createLevelSetSphere") else None
    if grid is None:
        return None
    path = pathlib.Path(ARGUMENTS[0]).with_name("ball.vdb")
    module.write(str(path), grids=[grid])
    data = bpy.data.volumes.new("Volume")
    data.filepath = str(path)
    return linked("Volume", data)


def image():
    made = bpy.data.images.new("Image", 64, 64, alpha=True)
    y, x = np.mgrid[:64, :64] - 31.5
    pixels = np.ones((64, 64, 4), np.float32)
    pixels[..., 3] = np.hypot(x, y) < 28.0
    made.pixels.foreach_set(pixels.ravel())
    made.update()
    return made


def bounds(lamp):
    return [np.round(end, 3).tolist() for end in shape_of(lamp).bounds()]


def session():
    addon.register()
    scene = bpy.context.scene
    for obj in list(scene.objects):
        bpy.data.objects.remove(obj)
    scene.render.engine = "SDF_LIGHTS"
    scene.world = None
    area = areas()[0]
    space = area.spaces.active
    sources = dict(text=text(), curve=curve(), mesh=mesh(), volume=volume())
    light = bpy.data.lights.new("Lamp", "POINT")
    holder = linked("Lamp", light)
    holder.hide_set(False)
    lamp = light.sdf_lamp
    lamp.use = True
    bpy.context.view_layer.objects.active = holder
    holder.select_set(True)
    space.show_region_ui, space.shading.type = True, "SOLID"
    space.region_3d.view_rotation = (1.0, 0.0, 0.0, 0.0)
    space.region_3d.view_perspective, space.region_3d.view_distance = "ORTHO", 6.0
    space.region_3d.view_location = (0.0, 0.0, 0.0)
    yield 1.0
    region_of(area, "UI").active_panel_category = "SDF Lights"
    eye = Eye((0.0, 0.0, 0.0), (0.62, 0.0, 0.0), (0.9, 0.0, 0.0))  # in the middle, in the letter, in the rings

    def seen(name):
        """Steps: wait for the lamp, and report what is drawn."""
        yield 1.0
        yield from until(lamps_are_drawn)
        area.tag_redraw()
        yield 1.0
        report[name] = dict(bounds=bounds(lamp), middle=eye.color(0), letter=eye.color(1), ring=eye.color(2))
        picture(PICTURES, f"source_{name.replace(' ', '_')}")

    lamp.source = "OBJECT"
    yield 1.0
    picture(PICTURES, "source_without_object")
    report["object button"] = yield from button_of(area, f"{PATH}object")
    # The list of objects that can be chosen: those that are lamps, and no others.
    press(move(report["object button"]), "LEFTMOUSE")
    yield 1.0
    picture(PICTURES, "source_picker")
    press(report["object button"], "ESC")
    yield 1.0
    for name, obj in sources.items():
        if obj is None:
            continue
        lamp.object = obj
        yield from seen(name)
    lamp.object = sources["text"]
    yield from seen("text again")
    sources["text"].data.body = "I"
    yield from seen("text changed")
    lamp.object_form = "NEON"
    yield from seen("neon")
    lamp.object_form = "SOLID"
    lamp.object = sources["mesh"]
    sources["mesh"].modifiers.new("Thin", "DISPLACE").strength = -0.1
    yield from seen("mesh changed")
    lamp.source = "IMAGE"
    lamp.image, lamp.image_size = image(), 2.0
    yield from seen("image")
    lamp.image_size = 1.0
    yield from seen("image changed")
    lamp.source = "NETWORK"
    yield 3.0  # software OpenGL takes minutes for the body of a network
    report["network"] = dict(bounds=bounds(lamp))
    picture(PICTURES, "source_network")
    report["network button"] = yield from button_of(area, f"{PATH}network")
    eye.close()


run(session())
