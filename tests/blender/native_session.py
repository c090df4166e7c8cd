# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What test_native_gui runs in a Blender with a window: what people who know Blender expect of a lamp."""

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
from sdf_lights.blender import feedback, gizmos, lamp_panels, preset_pictures, viewport  # noqa: E402
from sdf_lights.blender.findings import grouped  # noqa: E402
from sdf_lights.blender.viewport import bodies  # noqa: E402

PICTURES = ARGUMENTS[1] if len(ARGUMENTS) > 1 else None


def arrows():
    """A drag of an arrow: undone by one step, named beside the mouse, and stopped where the shape would end."""
    view = areas("VIEW_3D")[0]
    with override(view):
        bpy.ops.sdf_lights.lamp_add(shape="BOX_FRAME")
    frame = bpy.context.object.data.sdf_lamp.box_frame
    with override(view):
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
    bpy.ops.ed.undo_push(message="Add SDF Lamp")
    yield 1.0
    start = tuple(frame.half_size), frame.thickness
    tip = on_screen(view, (start[0][0], 0.0, 0.0))
    ahead = tip[0] + 40.0, tip[1]
    move((ahead[0] - 1, ahead[1]))
    yield
    move(ahead)
    yield 0.5
    report["hover"] = [shown.text for shown in gizmos._shown.values()]
    picture(PICTURES, "arrow_label", view)
    far = on_screen(view, (1.5 * start[0][0], 0.0, 0.0))
    yield from drag(ahead, (ahead[0] + far[0] - tip[0], ahead[1]))
    yield
    report["grown"] = frame.half_size[0] / start[0][0]
    move(inside(view, 0.5, 0.9))
    yield
    press(inside(view, 0.5, 0.9), "Z", ctrl=True)
    yield 1.0
    obj = bpy.context.object
    report["undone"] = [
        obj is not None and obj.type == "LIGHT" and tuple(obj.data.sdf_lamp.box_frame.half_size) == start[0]
    ]
    frame = obj.data.sdf_lamp.box_frame
    # Inwards, far beyond the middle: the bars would be thicker than the frame.
    yield from drag(ahead, (ahead[0] - 500.0, ahead[1]))
    yield
    report["held"] = frame.half_size[0] >= frame.thickness > 0.0
    report["valid"] = "" if not viewport.proxy_error(obj.data) else viewport.proxy_error(obj.data)


def _shown(view):
    with override(view):
        return viewport.drawn.overlay.shown(bpy.context)


def last_good():
    """A value with which there is no shape leaves what was there, with the reason."""
    view = areas("VIEW_3D")[0]
    lamp = bpy.context.object.data.sdf_lamp
    yield from until(lamps_are_drawn)
    lamp.source, lamp.expression = "EXPRESSION", "sphere(0.4) - box(0.2)"
    yield 1.0
    yield from until(lamps_are_drawn)
    lamp.expression = "sphere(0.4) - bo"
    yield 1.0
    yield from until(lamps_are_drawn)
    report["kept"] = len(_shown(view))
    report["reason"] = viewport.proxy_error(bpy.context.object.data)
    report["said"] = [text for region in viewport.drawn.overlay._labels.values() for _, text in region]
    picture(PICTURES, "last_good", view)


def sections():
    """The same panels in the same order in both places."""
    found = {}
    for place, kinds in (("sidebar", lamp_panels.IN_SIDEBAR), ("properties", lamp_panels.IN_PROPERTIES)):
        found[place] = [(kind.bl_label, "DEFAULT_CLOSED" in kind.bl_options) for kind in kinds]
    report["sections"] = found
    view, properties = areas("VIEW_3D")[0], areas("PROPERTIES")[0]
    lamp = bpy.context.object.data.sdf_lamp
    lamp.source, lamp.shape = "PRIMITIVE", "TORUS_KNOT"
    lamp.emission.source = "FLAME"
    view.spaces.active.show_region_ui = True
    yield 1.0
    region_of(view, "UI").active_panel_category = "SDF Lights"
    properties.spaces.active.context = "DATA"
    yield 1.0
    picture(PICTURES, "sections")
    view.spaces.active.show_region_ui = False
    yield


def editors():
    """Edit Nodes and Show in Text Editor where there is no such editor."""
    view, lamp = areas("VIEW_3D")[0], bpy.context.object.data.sdf_lamp
    lamp.emission.source = "UNIFORM"
    report["before"] = [len(areas("TEXT_EDITOR")), len(areas("NODE_EDITOR"))]
    with override(view):
        bpy.ops.sdf_lights.preset_load(preset="NEON_HEART")
        bpy.ops.sdf_lights.expression_show()
    yield 1.0
    (editor,) = areas("TEXT_EDITOR")
    report["text"] = editor.spaces.active.text == lamp.text
    editor.type = "VIEW_3D"
    yield
    view = areas("VIEW_3D")[0]
    with override(view):
        bpy.ops.sdf_lights.nodes_new()
        bpy.ops.sdf_lights.nodes_show()
    yield 1.0
    (editor,) = (  # too narrow to be divided once more: in a window of its own
        area
        for other in bpy.context.window_manager.windows
        for area in other.screen.areas
        if area.type == "NODE_EDITOR"
    )
    report["nodes"] = editor.ui_type == "SDFLIGHTS_NodeTree" and editor.spaces.active.node_tree == lamp.nodes
    if len(bpy.context.window_manager.windows) > 1:
        with bpy.context.temp_override(window=bpy.context.window_manager.windows[1]):
            bpy.ops.wm.window_close()
    yield 1.0
    areas("DOPESHEET_EDITOR")[0].type = "CONSOLE"
    areas("VIEW_3D")[1].type = "IMAGE_EDITOR"
    yield


def warnings():
    """One line in the image editor's header after a render with warnings, and the list behind it."""
    for index in range(3):
        material = bpy.data.materials.new(f"Lost {index}")
        nodes = material.node_tree.nodes
        script = nodes.new("ShaderNodeScript")
        script.outputs.new("NodeSocketColor", "Color") if not script.outputs else None
        image = nodes.new("ShaderNodeTexImage")
        image.image = bpy.data.images.new(f"Gone {index}", 4, 4)
        image.image.source, image.image.filepath = "FILE", "/nowhere.png"
        material.node_tree.links.new(image.outputs[0], nodes["Principled BSDF"].inputs["Base Color"])
        mesh = bpy.data.meshes.new("Face")
        mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
        mesh.materials.append(material)
        bpy.context.scene.collection.objects.link(bpy.data.objects.new(f"Face {index}", mesh))
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location = 0.0, 0.0, 5.0
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera
    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.sdf_lights.device, scene.sdf_lights.samples, scene.sdf_lights.denoise = "REFERENCE", 1, False
    bpy.ops.render.render()
    editor = areas("IMAGE_EDITOR")[0]
    editor.spaces.active.image = bpy.data.images["Render Result"]
    yield 1.0
    report["warnings"] = feedback.counted(feedback._last[scene.name])
    report["groups"] = list(grouped(feedback._last[scene.name]))
    with override(editor):
        bpy.ops.sdf_lights.warnings_show("INVOKE_DEFAULT")
    yield 1.0
    picture(PICTURES, "warnings")
    press(inside(editor, 0.5, 0.05), "ESC")
    yield


def presets():
    """Presets as bright as the render shows them to the camera, and one of the user's own."""
    view, scene = areas("VIEW_3D")[0], bpy.context.scene
    _clear()
    scene.sdf_lights_overlay.brightness = "LIGHT"
    with override(view):
        bpy.ops.view3d.view_axis(type="FRONT")
    report["presets"] = {}
    for name in ("CAMPFIRE", "NEON_RING", "SUNSET"):
        with override(view):
            bpy.ops.sdf_lights.lamp_add(source="PRESET", preset=name)
            bpy.ops.sdf_lights.view_frame()
        yield 1.0
        yield from until(lamps_are_drawn)
        points = bodies.points_in_world(bpy.context.object)
        eye = Eye(*points[:: max(len(points) // 40, 1)].tolist())
        view.tag_redraw()
        yield 1.0
        yield from until(lambda: eye.colors)
        report["presets"][name] = np.max(list(eye.colors.values()), axis=0).tolist()
        eye.close()
        bpy.data.objects.remove(bpy.context.object)
    scene.sdf_lights_overlay.brightness = "SHAPE"
    with override(view):
        bpy.ops.sdf_lights.lamp_add(shape="TORUS")
        lamp = bpy.context.object.data.sdf_lamp
        lamp.torus.minor_radius = 0.123
        bpy.ops.sdf_lights.lamp_preset_add(name="Test of a Ring")
        bpy.ops.sdf_lights.lamp_add(shape="BOX")
        file = next(
            found
            for folder in bpy.utils.preset_paths("sdf_lights/lamp")
            for found in pathlib.Path(folder).glob("*.py")
            if found.stem.lower() == "test_of_a_ring"
        )
        bpy.ops.script.execute_preset(filepath=str(file), menu_idname="SDFLIGHTS_PT_lamp_presets")
        lamp = bpy.context.object.data.sdf_lamp
    report["own preset"] = [lamp.shape, lamp.torus.minor_radius]
    file.unlink()
    yield


def files():
    """A lamp of another file, overridden: viewports follow. A lamp as an asset."""
    view, folder = areas("VIEW_3D")[0], pathlib.Path(ARGUMENTS[0]).parent
    _clear()
    with override(view):
        bpy.ops.sdf_lights.lamp_add(shape="TORUS")
        bpy.ops.sdf_lights.lamp_mark_asset()
        obj = bpy.context.object
        report["asset"] = [obj.asset_data is not None, *obj.preview.image_size]
        bpy.data.libraries.write(str(folder / "lamps.blend"), {obj}, fake_user=True)
        bpy.data.objects.remove(obj)
        with bpy.data.libraries.load(str(folder / "lamps.blend"), link=True) as (there, here):
            here.objects = there.objects
        bpy.context.scene.collection.objects.link(here.objects[0])
        made = here.objects[0].override_create(remap_local_usages=True)
        made.data.override_create(remap_local_usages=True)
        bpy.context.view_layer.objects.active = made
    made.data.sdf_lamp.torus.major_radius = 0.77
    yield 1.0
    yield from until(lamps_are_drawn)
    report["overridden"] = [placed.lamp.shape.major_radius for placed in _shown(view)]


def other_engine():
    """What the panel says with another engine, and the mesh for it."""
    view, scene = areas("VIEW_3D")[0], bpy.context.scene
    _clear()
    with override(view):
        bpy.ops.sdf_lights.lamp_add(shape="TORUS")
    engines = {item.identifier for item in scene.render.bl_rna.properties["engine"].enum_items}
    scene.render.engine = "BLENDER_EEVEE" if "BLENDER_EEVEE" in engines else "BLENDER_EEVEE_NEXT"
    areas("PROPERTIES")[0].spaces.active.context = "DATA"
    yield 1.0
    with override(areas("PROPERTIES")[0]):
        report["other engine"] = [
            lamp_panels.SDFLIGHTS_PT_other_engine.poll(bpy.context),
            *(kind.poll(bpy.context) for kind in lamp_panels.IN_PROPERTIES),
        ]
    scene.render.engine = "CYCLES"
    yield 1.0
    with override(view):
        bpy.ops.sdf_lights.beside_cycles_add()
    yield 1.0
    picture(PICTURES, "other_engine", areas("PROPERTIES")[0])
    report["beside"] = [len(bpy.data.scenes), scene.sdf_lights.beside.render.engine, bpy.context.scene == scene]
    with override(view):
        bpy.ops.sdf_lights.beside_cycles_remove()
        bpy.ops.sdf_lights.lamp_to_mesh()
    report["converted"] = bpy.context.object.type
    scene.render.engine = "SDF_LIGHTS"
    yield


def words():
    """The cure for a misspelt word; menus with the words of the field, and icons."""
    view = areas("VIEW_3D")[0]
    _clear()
    with override(view):
        bpy.ops.sdf_lights.lamp_add(shape="MANDELBULB")
    lamp = bpy.context.object.data.sdf_lamp
    report["labels"] = [
        prop.name for prop in lamp.mandelbulb.bl_rna.properties if prop.identifier in ("power", "rounds")
    ]
    lamp.source, lamp.expression = "EXPRESSION", "bx(0.4)"
    yield 1.0
    report["cure"] = viewport.proxy_error(bpy.context.object.data)
    report["icons"] = [preset_pictures.icon_of(name) > 0 for name in ("campfire", "neon_ring")]
    tree = bpy.data.node_groups.new("Words", "SDFLIGHTS_NodeTree")
    report["node colours"] = [
        [round(part, 3) for part in tree.nodes.new(f"SDFLIGHTS_Node_{name}").color]
        for name in ("sphere", "union", "translate")
    ]
    bpy.data.node_groups.remove(tree)


def thumbnail():
    """The preview of a light, as the Properties editor shows it."""
    view = areas("VIEW_3D")[0]
    _clear()
    with override(view):
        bpy.ops.sdf_lights.lamp_add(shape="TORUS")
    light = bpy.context.object.data
    light.color = 1.0, 0.1, 0.1
    with bpy.context.temp_override(id=light):
        bpy.ops.ed.lib_id_generate_preview()
    pixels = np.zeros(0)

    def is_there():
        nonlocal pixels
        preview = light.preview
        if preview is None or not preview.image_size[0]:
            return False
        pixels = np.array(preview.image_pixels_float).reshape(*preview.image_size[::-1], 4)
        return pixels[..., 0].max() > 0.0

    yield from until(is_there, 120.0)
    yield 1.0
    is_there()
    size = pixels.shape[0]
    report["thumbnail"] = [
        float((pixels[..., 0] - pixels[..., 2]).max()),
        float((pixels[..., 0] - pixels[..., 2])[size // 2 - 1 : size // 2 + 1, size // 2].max()),
    ]


def _clear():
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)


def steps():
    bpy.app.debug_python = True  # Blender says what it minds about classes
    addon.register()
    addon.unregister()
    addon.register()
    bpy.app.debug_python = False
    print("REGISTERED", flush=True)
    _clear()
    bpy.context.scene.render.engine = "SDF_LIGHTS"
    bpy.ops.ed.undo_push(message="Start")
    parts = (arrows, last_good, sections, presets, files, other_engine, words, thumbnail, editors, warnings)
    for part in parts:
        yield from part()


if __name__ == "__main__":
    run(steps())
