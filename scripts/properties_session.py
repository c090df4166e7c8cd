# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What artist_screenshots runs in a Blender with a window: the panels of the Properties editor, and the overlays.

blender --factory-startup --enable-event-simulate --python properties_session.py -- REPORT.json FOLDER
"""

import pathlib
import sys

import bpy

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(REPOSITORY), str(REPOSITORY / "scripts")]

from window import ARGUMENTS, areas, event, inside, move, override, picture, region_of, run  # noqa: E402

import sdf_lights.blender as addon  # noqa: E402  (found on the path set above)
from sdf_lights.blender import lamp_panels, panels, scene_panels, scene_report  # noqa: E402
from sdf_lights.render.cpu import background  # noqa: E402

FOLDER = ARGUMENTS[1]
PAGES, PAGE = 3, 17  # of the tab Render, and turns of the wheel from one to the next
PREVIEW = 10.0  # seconds for the preview of the world, if its kernels are compiled
END = 40  # turns of the wheel to the end of a tab


def opened() -> None:
    """Let all panels of these tabs be open from the start, before they are registered."""
    for module in (lamp_panels, panels, scene_panels, scene_report):
        for kind in module.CLASSES:
            if getattr(kind, "bl_context", "") in ("render", "view_layer", "world", "data"):
                kind.bl_options = getattr(kind, "bl_options", set()) - {"DEFAULT_CLOSED"}


def opened_visibility() -> None:
    """Let Blender's panel around Ray Visibility be open, too."""
    kind = bpy.types.OBJECT_PT_visibility
    bpy.utils.unregister_class(kind)
    kind.bl_options = getattr(kind, "bl_options", set()) - {"DEFAULT_CLOSED"}
    bpy.utils.register_class(kind)


def wheel(place, turns: int):
    """Steps: turn the wheel."""
    for _ in range(turns):
        event("WHEELDOWNMOUSE", "PRESS", place)
        yield 0.1
    yield 1.0


def deviations() -> None:
    """What a report lists: a mistake in a lamp, a setting of Cycles, a missing file."""
    bpy.ops.sdf_lights.lamp_add(source="EXPRESSION", location=(0.0, 2.0, 1.0))
    bpy.context.object.data.sdf_lamp.expression = "box(0.5) - spere(0.6)"
    material = bpy.data.objects["Cube"].active_material
    tree = material.node_tree
    picture_node = tree.nodes.new("ShaderNodeTexImage")
    picture_node.image = bpy.data.images.new("Bricks", 8, 8)
    picture_node.image.source, picture_node.image.filepath = "FILE", "//textures/bricks.png"
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    tree.links.new(picture_node.outputs[0], shader.inputs["Base Color"])
    bpy.data.objects["Cube"].shadow_terminator_shading_offset = 0.1
    bpy.context.view_layer.update()
    bpy.ops.sdf_lights.scene_check()


def steps():
    opened()
    opened_visibility()
    addon.register()
    scene, view = bpy.context.scene, areas()[0]
    bpy.data.objects.remove(bpy.data.objects["Light"])
    with override(view):
        bpy.ops.sdf_lights.lamp_add(source="PRESET", preset="LANTERN", location=(1.5, 0.0, 1.0))
    scene.render.engine = "SDF_LIGHTS"
    color = scene.world.node_tree.nodes["Background"].inputs["Color"]
    color.default_value = (0.2, 0.4, 0.8, 1.0)
    yield 1.0
    with override(view):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5)
    yield
    area, other = sorted(areas(), key=lambda area: area.x)
    area.type = other.type = "PROPERTIES"
    yield 1.0
    place = inside(area, 0.5, 0.3)
    for name, context in (("world", "WORLD"), ("view_layer", "VIEW_LAYER"), ("lamp", "DATA"), ("render_0", "RENDER")):
        area.spaces.active.context = context
        while name == "world" and background.running():
            yield 1.0
        yield PREVIEW if name == "world" else 1.5
        picture(FOLDER, name, area)
        if name == "view_layer":
            move(place)
            yield from wheel(place, END)
            move(inside(other, 0.5, 0.9))  # away from the tooltips
            yield 1.0
            picture(FOLDER, "view_layer_end", area)
    move(place)
    yield
    for page in range(1, PAGES):
        yield from wheel(place, PAGE)
        picture(FOLDER, f"render_{page}", area)
    with override(other):
        other.type = "VIEW_3D"
    yield
    with override(other):
        deviations()
    yield from wheel(place, END)
    picture(FOLDER, "report", area)
    bpy.context.view_layer.objects.active = next(obj for obj in scene.objects if obj.name.endswith("Lantern"))
    other.spaces.active.show_region_ui = True
    yield 1.5  # the tabs are known once they are drawn
    region_of(other, "UI").active_panel_category = "SDF Lights"
    yield 1.5
    place = move(inside(other, 0.5, 0.5, "UI"))
    yield from wheel(place, END)
    picture(FOLDER, "feedback", other)
    other.spaces.active.show_region_ui = False
    yield 1.0
    bpy.context.view_layer.objects.active = bpy.data.objects["Cube"]
    area.spaces.active.context = "OBJECT"
    yield 1.0
    yield from wheel(place, END)
    move(inside(other, 0.5, 0.9))  # away from the tooltips
    yield 1.0
    picture(FOLDER, "object", area)
    with override(other):
        bpy.ops.object.light_add(type="AREA", location=(-1.5, 0.0, 2.0))
    area.spaces.active.context = "DATA"
    yield 1.5
    picture(FOLDER, "light", area)
    bpy.context.view_layer.objects.active = next(obj for obj in scene.objects if obj.name.endswith("Lantern"))
    scene.render.engine = "BLENDER_WORKBENCH"
    yield 1.5
    picture(FOLDER, "other_engine", area)
    scene.render.engine = "SDF_LIGHTS"
    yield 1.5
    with override(other, "HEADER"):
        bpy.ops.wm.call_panel(name="VIEW3D_PT_overlay", keep_open=True)
    yield 1.5
    picture(FOLDER, "overlay", other)


run(steps())
