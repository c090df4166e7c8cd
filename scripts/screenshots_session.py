# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The session of artist_screenshots in a Blender with a window: scenes for the documents, and a picture of each.

blender --factory-startup --enable-event-simulate --python screenshots_session.py -- REPORT.json FOLDER
"""

import pathlib
import sys

import bpy
from mathutils import Euler

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(REPOSITORY), str(REPOSITORY / "scripts")]

from window import ARGUMENTS, areas, inside, lamps_are_drawn, move, override, picture, region_of, run, until  # noqa: E402

import sdf_lights.blender as addon  # noqa: E402  (found on the path set above)
from sdf_lights.blender.viewport import rendered  # noqa: E402

FOLDER = ARGUMENTS[1]


def is_rendered():
    return any(found._render.finished for found in rendered._running)


def clear():
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)


def look(view, location, distance, pitch=1.1, turn=0.6):
    region = view.spaces.active.region_3d
    region.view_perspective, region.view_location, region.view_distance = "PERSP", location, distance
    region.view_rotation = Euler((pitch, 0.0, turn)).to_quaternion()


def add(view, location=(0.0, 0.0, 0.0), rotation=(0.0, 0.0, 0.0), color=None, power=None, **choice):
    with override(view):
        bpy.ops.sdf_lights.lamp_add(location=location, rotation=rotation, **choice)
    light = bpy.context.object.data
    light.color, light.energy = color or light.color, power or light.energy
    return bpy.context.object


def taken(view, name, crop=None):
    """Steps: wait until lamps are drawn, and take the picture without a tooltip."""
    move(inside(view, 0.3, 0.1))
    if view.spaces.active.show_region_ui:
        yield 1.0  # the tabs are known once they are drawn
        region_of(view, "UI").active_panel_category = "SDF Lights"
    yield 1.0
    yield from until(lamps_are_drawn)
    yield 1.0
    picture(FOLDER, name, crop)


def sidebar(view):
    clear()
    frame = add(view, shape="BOX_FRAME", color=(1.0, 0.6, 0.25))
    frame.data.sdf_lamp.box_frame.thickness = 0.08
    look(view, (0.6, 0.6, 0.0), 4.0)
    yield from taken(view, "sidebar", view)


def mistakes(view):
    clear()
    lamp = add(view, shape="BOX_FRAME", color=(1.0, 0.6, 0.25)).data.sdf_lamp
    view.spaces.active.show_region_ui = True
    look(view, (0.6, 0.6, 0.0), 4.0)
    lamp.source, lamp.expression = "EXPRESSION", "box(0.5) - spere(0.6)"
    yield from taken(view, "error", view)
    text = bpy.data.texts.new("Hollow Cube")
    text.write("size = slider(0.5, 0.1, 2)  # half of the size\nbox(size) - spere(1.3 * size)\n")
    lamp.text = text
    with override(view):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5)
    yield
    editor = max(areas(), key=lambda area: area.x)
    view = min(areas(), key=lambda area: area.x)
    editor.type = "TEXT_EDITOR"
    yield
    with override(view):
        bpy.ops.sdf_lights.expression_show()
    yield from taken(view, "mistake")
    text.lines[1].body = "box(size) - sphere(1.3 * size)"
    with override(editor):
        bpy.ops.screen.area_close()
    yield


def nodes(view):
    with override(view):
        bpy.ops.screen.area_split(direction="HORIZONTAL", factor=0.5)
    yield
    editor, view = sorted(areas()[:2], key=lambda area: area.y)
    editor.ui_type = "SDFLIGHTS_NodeTree"
    editor.spaces.active.show_region_ui = False
    yield
    with override(view):
        bpy.ops.sdf_lights.nodes_new()
    tree = bpy.context.object.data.sdf_lamp.nodes
    look(view, (0.6, 0.6, 0.0), 4.0)
    yield
    for node in tree.nodes:
        node.select = False
    with override(editor):
        bpy.ops.node.view_all()
    yield
    yield from taken(view, "nodes")
    ball = next(node for node in tree.nodes if node.bl_idname == "SDFLIGHTS_Node_sphere")
    vector = tree.nodes.new("SDFLIGHTS_Node_vector")
    vector.location, vector.select = (ball.location.x - 190.0, ball.location.y - 140.0), False
    tree.links.new(vector.outputs[0], ball.inputs[0])
    yield
    with override(editor):
        bpy.ops.node.view_all()
    yield
    yield from taken(view, "nodes_mistake", editor)


def solid(view):
    clear()
    view.spaces.active.show_region_ui = False
    with override(view):
        bpy.ops.mesh.primitive_plane_add(size=7.0)
        bpy.ops.mesh.primitive_uv_sphere_add(radius=0.55, location=(1.4, -1.0, 0.55))
        bpy.ops.object.shade_smooth()
        bpy.ops.mesh.primitive_cube_add(size=0.7, location=(-1.6, 0.9, 0.35))
    add(view, (-1.6, 0.9, 0.75), (0.3, 0.2, 0.0), (1.0, 0.35, 0.1), shape="TORUS")
    add(view, (1.3, 0.4, 0.55), color=(0.3, 1.0, 0.4), source="PRESET", preset="SPONGE")
    add(view, (-0.2, -1.2, 0.6), color=(1.0, 0.7, 0.3), source="PRESET", preset="HOLLOW_CUBE")
    add(view, (0.0, 1.2, 0.7), source="PRESET", preset="NEON_HEART")
    for obj in bpy.context.scene.objects:
        obj.select_set(obj.name.startswith(("Torus", "Hollow")))
    look(view, (0.0, 0.0, 0.4), 7.0, 1.0, 0.4)
    yield from taken(view, "solid", view)
    view.spaces.active.show_region_ui = True


def traced(view):
    clear()
    space, scene = view.spaces.active, bpy.context.scene
    with override(view):
        bpy.ops.mesh.primitive_plane_add(size=12.0)
        bpy.ops.mesh.primitive_monkey_add(size=1.3, location=(1.1, 0.1, 0.66), rotation=(-0.6, 0.0, 0.2))
        bpy.ops.object.modifier_add(type="SUBSURF")
        bpy.context.object.modifiers[0].levels = 2
        bpy.ops.object.shade_smooth()
        bpy.ops.mesh.primitive_cube_add(size=0.6, location=(-0.3, 1.6, 0.3), rotation=(0.0, 0.0, 0.5))
    add(view, (-1.0, 0.2, 0.85), (0.0, 0.0, 0.3), source="PRESET", preset="NEON_HEART", power=20.0)
    add(view, (0.3, -1.0, 0.45), source="PRESET", preset="HOLLOW_CUBE", power=12.0)
    scene.world = None
    scene.sdf_lights.viewport.samples, scene.sdf_lights.viewport.denoise = 256, False
    look(view, (0.1, 0.2, 0.6), 5.6, 1.2, 0.25)
    yield 1.0
    space.shading.type = "RENDERED"
    yield from until(is_rendered)
    yield from taken(view, "rendered", view)
    space.shading.type = "SOLID"


def steps():
    addon.register()
    scene = bpy.context.scene
    scene.render.engine = "SDF_LIGHTS"
    view = areas()[0]
    view.spaces.active.show_region_ui = True
    yield 1.0
    for part in (sidebar, solid, traced, mistakes, nodes):
        yield from part(areas()[0])


run(steps())
