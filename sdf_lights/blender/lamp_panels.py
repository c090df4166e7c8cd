# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of a lamp: the same panels, in the same order, in the sidebar of the 3D view and in the tab Data of the
Properties editor."""

import math

import bpy
import numpy as np

from ..render.errors import RenderError
from ..sdf.shapes import Shape
from ..sdf.syntax import ExpressionError
from . import beside_cycles, emission_panel, labels, parameters, readout, sources, viewport
from .context import LampTab, lamp_of, light_of
from .lamp import pattern_of, shape_of
from .lamp_presets import SDFLIGHTS_PT_lamp_presets
from .naming import ENGINE, LABEL
from .properties import PRIMITIVES


def draw_emission(layout, light) -> None:
    """Colour and power, as for Blender's lights."""
    column = layout.column()
    row = column.column(heading="Temperature", align=True).row(align=True)
    row.prop(light, "use_temperature", text="")
    value = row.row()
    value.active = light.use_temperature
    value.prop(light, "temperature", text="")
    column.prop(light, "color", text="Tint" if light.use_temperature else "Color")
    lamp = light.sdf_lamp
    if lamp.use and not lamp.normalize:
        column.prop(lamp, "density")
    else:
        column.prop(light, "energy", text="Strength" if light.type == "SUN" and not lamp.use else "Power")
    column.prop(light, "exposure")
    column.prop(lamp if lamp.use else light, "normalize")


def draw_shape(layout, light, obj, width: int) -> None:
    """Draw the source of an SDF lamp's shape, and its problems in lines of ``width`` letters."""
    lamp = light.sdf_lamp
    layout.prop(lamp, "source")
    if lamp.source == "EXPRESSION":
        _draw_expression(layout, lamp)
    elif lamp.source == "NODES":
        _draw_nodes(layout, lamp)
    elif lamp.source == "OBJECT":
        _draw_object(layout, lamp)
    elif lamp.source == "IMAGE":
        layout.template_ID(lamp, "image", open="image.open")
        for name in ("image_part", "image_threshold", "image_size", "thickness", "image_colors"):
            layout.prop(lamp, name)
    elif lamp.source == "NETWORK":
        row = layout.row(align=True)
        row.prop(lamp, "network", text="File", placeholder="Example")
        row.operator("sdf_lights.network_reload", text="", icon="FILE_REFRESH")
    else:
        layout.prop(lamp, "shape")
        name = lamp.shape.lower()
        for about in PRIMITIVES[name].fields():
            layout.prop(getattr(lamp, name), about.name)
    for remark in sources.remarks(lamp):
        labels.draw_sentence(layout, remark, width, "INFO")
    try:
        _placed_shape(lamp, obj)
    except RenderError as error:
        column = layout.column()
        column.alert = True
        labels.draw_problem(column, error, width)
        if isinstance(error.__cause__, ExpressionError) and lamp.source == "EXPRESSION" and lamp.text is not None:
            layout.operator("sdf_lights.expression_show", text="Go to the Line", icon="TEXT")
    row = layout.row(align=True)
    if lamp.source != "NODES":
        row.operator("sdf_lights.nodes_new", text="To Nodes", icon="NODETREE")
    if lamp.source != "EXPRESSION":
        row.operator("sdf_lights.nodes_to_expression", text="To Expression", icon="TEXT")


def _draw_expression(layout, lamp) -> None:
    layout.template_ID(lamp, "text", new="sdf_lights.expression_to_text", open="text.open")
    if lamp.text is None:
        labels.draw_expression(layout, lamp)
    else:
        layout.operator("sdf_lights.expression_show", icon="TEXT")
    layout.menu("SDFLIGHTS_MT_examples", text="Load Example")
    _draw_parameters(layout, lamp)


def _draw_nodes(layout, lamp) -> None:
    layout.template_ID(lamp, "nodes", new="sdf_lights.nodes_new")
    if lamp.nodes is not None:
        layout.operator("sdf_lights.nodes_show", icon="NODETREE")
        _draw_parameters(layout, lamp)


def _draw_object(layout, lamp) -> None:
    layout.prop(lamp, "object")
    if lamp.object is not None and lamp.object.type in ("MESH", "META"):
        layout.prop(lamp, "voxel_size")
    if lamp.object is not None and lamp.object.type in ("FONT", "CURVE"):
        layout.prop(lamp, "object_form")
        if lamp.object_form == "NEON":
            layout.prop(lamp, "neon_radius")
            layout.prop(lamp, "neon_gap")
        else:
            layout.prop(lamp, "thickness")


def _draw_parameters(layout, lamp) -> None:
    """Properties that an expression or a node tree declares."""
    if parameters.missing(lamp):
        parameters.update_soon(lamp.id_data)  # drawing may not change data
    column = layout.column()
    for declared in parameters.declarations(lamp):
        if parameters.exists(lamp.id_data, declared):
            column.prop(lamp.id_data, parameters.path(declared), text=parameters.label_of(declared))
    unused = parameters.unused(lamp.id_data)
    if unused:
        layout.operator("sdf_lights.parameters_remove", text=f"Remove {len(unused)} Unused", icon="TRASH")


def _placed_shape(lamp, obj) -> tuple[Shape, np.ndarray]:
    """The shape of a lamp, and the matrix of its object. Raises RenderError if nothing could glow."""
    matrix = np.array([tuple(row) for row in obj.matrix_world] if obj is not None else np.eye(4), np.float64)
    shape = shape_of(lamp, matrix)
    if not np.isfinite(matrix).all() or math.isclose(np.linalg.det(matrix[:3, :3]), 0.0, abs_tol=1e-30):
        raise RenderError("The object is scaled to zero, so nothing can glow: set its scale.")
    return shape, matrix


def draw_visibility(layout, lamp) -> None:
    """Draw the settings of a lamp's visibility to the camera."""
    layout.prop(lamp, "visible_camera", text="Visible to Camera")
    row = layout.row()
    row.active = lamp.visible_camera
    row.prop(lamp, "camera_brightness")


def draw_readout(layout, light, obj, width: int) -> None:
    """What is known of a lamp's shape, in lines of ``width`` letters."""
    lamp = light.sdf_lamp
    try:
        shape, matrix = _placed_shape(lamp, obj)
    except RenderError:  # the panel of the shape shows the error
        layout.label(text="There is no shape")
        shape = None
    if shape is not None:
        try:
            pattern = pattern_of(lamp, matrix)
        except RenderError:  # the panel of the emission shows the error
            pattern = None
        column = layout.column(align=True)
        for line in readout.facts(shape, matrix, light, pattern):
            column.label(text=line)
        if not readout.is_certified(shape):
            labels.draw_sentence(layout, "Thin parts may be missing", width, "INFO")
    problem = viewport.proxy_error(light)
    if problem:
        labels.draw_sentence(layout, f"In the viewport: {problem}", width)


def draw_details(layout, light, obj) -> None:
    """Draw how a lamp's shape is represented and traced."""
    try:
        shape, _ = _placed_shape(light.sdf_lamp, obj)
    except RenderError:
        return
    column = layout.column(align=True)
    for line in readout.details(shape):
        column.label(text=line)


# -- sections ----------------------------------------------------------------------------------------------------------


def _shape_section(layout, context, light, obj) -> None:
    draw_shape(layout, light, obj, labels.letters(context))


def _emission_section(layout, context, light, obj) -> None:
    draw_emission(layout, light)


def _pattern_section(layout, context, light, obj) -> None:
    emission_panel.draw(layout, light, labels.letters(context))


def _visibility_section(layout, context, light, obj) -> None:
    draw_visibility(layout, light.sdf_lamp)
    layout.prop(light.sdf_lamp, "use_pass")


def _readout_section(layout, context, light, obj) -> None:
    draw_readout(layout, light, obj, labels.letters(context))


def _details_section(layout, context, light, obj) -> None:
    draw_details(layout, light, obj)


SECTIONS = (  # end of the panel's name, label, parent section, draw function, closed by default
    ("shape", "Shape", "", _shape_section, False),
    ("emission", "Emission", "", _emission_section, False),
    ("pattern", "Pattern", "", _pattern_section, False),
    ("visibility", "Visibility", "", _visibility_section, False),
    ("readout", "Readout", "", _readout_section, True),
    ("details", "Details", "readout", _details_section, True),
)


class _Section:
    """The common part of a section in both editors."""

    @classmethod
    def poll(cls, context):
        return lamp_of(context) is not None

    def draw(self, context):
        self.layout.use_property_split = True
        type(self).draws(self.layout, context, light_of(context), context.object)


class _InSidebar(_Section, LampTab):
    parent = "SDFLIGHTS_PT_view3d"


class _InProperties(_Section):
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "data"
    parent = "SDFLIGHTS_PT_light"

    @classmethod
    def poll(cls, context):
        return context.engine == ENGINE and lamp_of(context) is not None


def _panels(place: type) -> list[type]:
    made = []
    for name, label, inside, draws, closed in SECTIONS:
        namespace = {
            "bl_label": label,
            "bl_parent_id": f"{place.parent}_{inside}" if inside else place.parent,
            "bl_options": {"DEFAULT_CLOSED"} if closed else set(),
            "draws": staticmethod(draws),
        }
        made.append(type(f"{place.parent}_{name}", (place, bpy.types.Panel), namespace))
    return made


class SDFLIGHTS_PT_view3d(LampTab, bpy.types.Panel):
    bl_label = "SDF Lamp"

    def draw_header_preset(self, context):
        if lamp_of(context) is not None:
            SDFLIGHTS_PT_lamp_presets.draw_panel_header(self.layout)

    def draw(self, context):
        layout, obj = self.layout, context.object
        if obj is None or obj.type != "LIGHT":
            layout.menu("SDFLIGHTS_MT_lamp_add", text="Add SDF Lamp", icon="LIGHT_POINT")
            return
        layout.use_property_split = True
        layout.prop(obj.data.sdf_lamp, "use")
        draw_other_engine(layout, context, obj.data)


def draw_other_engine(layout, context, light) -> None:
    """The lamp in another engine, and the remedies."""
    if context.engine == ENGINE or not light.sdf_lamp.use:
        return
    labels.draw_sentence(
        layout,
        f"This engine renders a point light without the shape: choose {LABEL} in Render Properties, or convert the lamp",
        labels.letters(context),
        "INFO",
    )
    layout.operator("sdf_lights.lamp_to_mesh", text="Convert to Mesh for This Engine", icon="OUTLINER_OB_MESH")
    beside_cycles.draw(layout, context)


class SDFLIGHTS_PT_other_engine(bpy.types.Panel):
    """Settings of SDF lamps, shown while another engine is chosen."""

    bl_label = "SDF Lamp"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return context.engine != ENGINE and lamp_of(context) is not None

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.prop(light_of(context).sdf_lamp, "use")
        draw_other_engine(self.layout, context, light_of(context))


IN_SIDEBAR, IN_PROPERTIES = _panels(_InSidebar), _panels(_InProperties)

CLASSES = (SDFLIGHTS_PT_view3d, *IN_SIDEBAR, *IN_PROPERTIES, SDFLIGHTS_PT_other_engine)
