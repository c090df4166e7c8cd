# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps of objects, pictures and networks: how they are made, and how they follow what is edited there."""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent
from bpy_extras.object_utils import AddObjectHelper, object_data_add

from ..render.errors import RenderError
from . import fallback, network_lamps, objects, parameters, picture_lamps
from .context import light_of
from .lamp import shape_of
from .operators import SDFLIGHTS_MT_lamp_add
from .properties import FORMS

POWER = 100.0  # W
RAYS = tuple(f"visible_{kind}" for kind in ("camera", "diffuse", "glossy", "transmission", "volume_scatter", "shadow"))


def _parts_of(thing: bpy.types.ID) -> list[bpy.types.ID | None]:
    """What of a thing changes the shape that is made of it."""
    data = getattr(thing, "data", None)
    return [thing, data, getattr(data, "taper_object", None), getattr(data, "shape_keys", None)]


@persistent
def _changed(scene, depsgraph):
    """Tells lamps of changes in what they are made of: Blender only tags what it knows of."""
    changed = set()
    for update in depsgraph.updates:
        if update.is_updated_geometry or update.is_updated_shading or not isinstance(update.id, bpy.types.Object):
            changed.add(update.id.original.session_uid)
    if not changed:
        return
    images = {update.id.original.session_uid for update in depsgraph.updates if isinstance(update.id, bpy.types.Image)}
    picture_lamps.forget(images)
    for light in bpy.data.lights:
        # A light that is updated already needs nothing: so an object that depends on its own lamp does not go on for
        # ever.
        if not light.sdf_lamp.use or light.session_uid in changed:
            continue
        used = [part for thing in parameters.things_of(light) for part in _parts_of(thing)]
        if any(block is not None and block.session_uid in changed for block in used):
            light.update_tag()


class SDFLIGHTS_OT_object_to_lamp(bpy.types.Operator):
    """Make lamps of the selected objects. They stay live: edit an object, and its lamp follows"""

    bl_idname = "sdf_lights.object_to_lamp"
    bl_label = "To SDF Lamp"
    bl_options = {"REGISTER", "UNDO"}

    form: bpy.props.EnumProperty(name="Form", description="What the lamp makes of the object", items=FORMS)
    power: bpy.props.FloatProperty(
        name="Power", description="Power of each lamp", default=POWER, min=0.0, soft_max=1000.0, unit="POWER"
    )

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT" and any(obj.type in objects.READERS for obj in context.selected_objects)

    def execute(self, context):
        chosen = [obj for obj in context.selected_objects if obj.type in objects.READERS]
        made = []
        for obj in chosen:
            light = bpy.data.lights.new(f"{obj.name} Lamp", "POINT")
            light.energy = self.power
            lamp = light.sdf_lamp
            lamp.use, lamp.source, lamp.object, lamp.object_form = True, "OBJECT", obj, self.form
            if self.form == "NEON":
                light.color = NEON_COLOR
            try:
                shape_of(lamp)
            except RenderError as error:
                self.report({"WARNING"}, str(error))
                bpy.data.lights.remove(light)
                continue
            fallback.follow(light)
            made.append(self._placed(obj, light))
        if not made:
            return {"CANCELLED"}
        for obj in context.selected_objects:
            obj.select_set(False)
        for obj in made:
            obj.select_set(True)
        context.view_layer.objects.active = made[-1]
        return {"FINISHED"}

    @staticmethod
    def _placed(obj: bpy.types.Object, light: bpy.types.Light) -> bpy.types.Object:
        """The lamp's object, which goes where the object goes. That is shown as wires, to be edited, and not
        rendered."""
        lamp = bpy.data.objects.new(light.name, light)
        for collection in obj.users_collection:
            collection.objects.link(lamp)
        lamp.parent = obj
        if obj.is_editable:
            obj.display_type = "WIRE"
            if obj.type == "META":  # Blender makes no surface of one that is hidden in renders
                for kind in RAYS:
                    setattr(obj, kind, False)
            else:
                obj.hide_render = True
        return lamp


class SDFLIGHTS_OT_text_lamp_add(bpy.types.Operator, AddObjectHelper):
    """Add a text, and a lamp of its shape. Press Tab to write"""

    bl_idname = "sdf_lights.text_lamp_add"
    bl_label = "Add Text Lamp"
    bl_options = {"REGISTER", "UNDO"}

    body: bpy.props.StringProperty(name="Text", description="What is written", default="OPEN")
    form: bpy.props.EnumProperty(name="Form", description="What the lamp makes of the text", items=FORMS)

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT"

    def execute(self, context):
        curve = bpy.data.curves.new("Text", "FONT")
        curve.body, curve.extrude = self.body, 0.0 if self.form == "NEON" else 0.05
        object_data_add(context, curve, operator=self, name="Text")
        return bpy.ops.sdf_lights.object_to_lamp(form=self.form)

    def draw(self, context):
        self.layout.use_property_split = True
        for name in ("body", "form", "align", "location", "rotation"):
            self.layout.prop(self, name)


class SDFLIGHTS_OT_network_reload(bpy.types.Operator):
    """Read the file of the lamp's network again"""

    bl_idname = "sdf_lights.network_reload"
    bl_label = "Reload Network"

    @classmethod
    def poll(cls, context):
        light = light_of(context)
        return light is not None and light.sdf_lamp.use and light.sdf_lamp.source == "NETWORK"

    def execute(self, context):
        light = light_of(context)
        network_lamps.forget()
        light.update_tag()
        try:
            shape_of(light.sdf_lamp)
        except RenderError as error:
            self.report({"WARNING"}, str(error))
        fallback.follow(light)
        return {"FINISHED"}


class SDFLIGHTS_OT_network_lamp_add(bpy.types.Operator, AddObjectHelper):
    """Add a lamp of a network. It is the add-on's example until another file is chosen"""

    bl_idname = "sdf_lights.network_lamp_add"
    bl_label = "Add Network Lamp"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT"

    def execute(self, context):
        light = bpy.data.lights.new("Network Lamp", "POINT")
        light.energy = POWER
        light.sdf_lamp.use, light.sdf_lamp.source = True, "NETWORK"
        fallback.follow(light)
        object_data_add(context, light, operator=self, name="Network Lamp")
        return {"FINISHED"}

    def draw(self, context):
        self.layout.use_property_split = True
        for name in ("align", "location", "rotation"):
            self.layout.prop(self, name)


NEON_COLOR = (1.0, 0.18, 0.09)  # of neon itself; other gases and coatings have others


def draw_convert(self, context):
    """Entries in Object > Convert, for objects that can be lamps."""
    if SDFLIGHTS_OT_object_to_lamp.poll(context):
        self.layout.separator()
        for form, text in (("SOLID", "To SDF Lamp"), ("NEON", "To Neon Lamp")):
            self.layout.operator(SDFLIGHTS_OT_object_to_lamp.bl_idname, text=text, icon="LIGHT").form = form


def draw_add(self, context):
    """Entries in Add > Light > SDF Lamp."""
    self.layout.separator()
    for form, text in (("SOLID", "Text"), ("NEON", "Neon Text")):
        self.layout.operator(SDFLIGHTS_OT_text_lamp_add.bl_idname, text=text, icon="OUTLINER_OB_FONT").form = form
    self.layout.operator(SDFLIGHTS_OT_network_lamp_add.bl_idname, text="Network", icon="OUTLINER_OB_LIGHTPROBE")


CLASSES = (
    SDFLIGHTS_OT_object_to_lamp,
    SDFLIGHTS_OT_text_lamp_add,
    SDFLIGHTS_OT_network_lamp_add,
    SDFLIGHTS_OT_network_reload,
)


def register():
    bpy.app.handlers.depsgraph_update_post.append(_changed)
    bpy.types.VIEW3D_MT_object_convert.append(draw_convert)
    SDFLIGHTS_MT_lamp_add.append(draw_add)


def unregister():
    SDFLIGHTS_MT_lamp_add.remove(draw_add)
    bpy.types.VIEW3D_MT_object_convert.remove(draw_convert)
    bpy.app.handlers.depsgraph_update_post.remove(_changed)
