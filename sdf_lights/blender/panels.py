# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels: properties of render, view layer, light and object, and the tab in the 3D view.

Blender's own panels for other engines are reused where they fit (``stock_panels``).
"""

import math

import bpy
import numpy as np

from ..render.errors import RenderError
from ..sdf.shapes import Shape
from ..sdf.syntax import ExpressionError
from . import cycles, feedback, labels, parameters, readout, viewport
from .context import LampTab, lamp_of
from .lamp import pattern_of, shape_of
from .naming import ENGINE, LABEL
from .passes import owner_of, switches
from .preferences import draw_back_end
from .properties import PRIMITIVES
from .sampling_presets import SDFLIGHTS_PT_sampling_presets, SDFLIGHTS_PT_viewport_sampling_presets

# Blender's panels for every engine that say what is not so here, or that stand below in another form.
_EXCLUDED = {
    "DATA_PT_light",
    "DATA_PT_spot",
    "DATA_PT_falloff_curve",
    "NODE_DATA_PT_light",
    "NODE_DATA_PT_spot",
    "RENDER_PT_freestyle",
    "RENDER_PT_simplify",
    "VIEWLAYER_PT_filter",
    "VIEWLAYER_PT_layer_passes",
    "VIEWLAYER_PT_freestyle",
    "VIEWLAYER_PT_freestyle_lineset",
    "VIEWLAYER_PT_freestyle_linestyle",
}

# Panels made for EEVEE that edit what this engine reads too.
_EEVEE = {
    "EEVEE_MATERIAL_PT_context_material",
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_WORLD_PT_surface",
    "MATERIAL_PT_preview",
    "DATA_PT_camera_dof",
    "DATA_PT_camera_dof_aperture",
}


def stock_panels():
    """Blender's own panels that apply to this engine."""
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", ())
        if panel.__name__ in _EEVEE or "BLENDER_RENDER" in engines and panel.__name__ not in _EXCLUDED:
            yield panel


class _Panel:
    """What the panels of the Properties editor have in common."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"

    @classmethod
    def poll(cls, context):
        return context.engine == ENGINE

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        self.draw_properties(layout, context)

    def draw_properties(self, layout, context):
        """Nothing, for a panel that only holds others."""


# -- render ------------------------------------------------------------------------------------------------------------


def _settings_panel(
    name: str,
    label: str,
    properties: tuple[str, ...],
    parent: str = "",
    closed: bool = False,
    viewport: bool = False,
    header: str = "",
    presets: type | None = None,
) -> type:
    """A panel with some properties of ``scene.sdf_lights``, or of its viewport group; ``header`` is a switch, and
    ``presets`` the panel of presets that opens from there."""

    def group(context):
        settings = context.scene.sdf_lights
        return settings.viewport if viewport else settings

    def draw_properties(self, layout, context):
        column = layout.column()
        column.active = not header or getattr(group(context), header)
        for prop in properties:
            column.prop(group(context), prop)

    namespace = {"bl_label": label, "draw_properties": draw_properties}
    if parent:
        namespace["bl_parent_id"] = parent
    if closed:
        namespace["bl_options"] = {"DEFAULT_CLOSED"}
    if header:
        namespace["draw_header"] = lambda self, context: self.layout.prop(group(context), header, text="")
    if presets is not None:
        namespace["draw_header_preset"] = lambda self, context: presets.draw_panel_header(self.layout)
    return type(name, (_Panel, bpy.types.Panel), namespace)


class SDFLIGHTS_PT_sampling(_Panel, bpy.types.Panel):
    bl_label = "Sampling"

    def draw_properties(self, layout, context):
        if context.scene.sdf_lights.origin == cycles.UNKNOWN:
            cycles.settle_soon()
        if hasattr(context.scene, "cycles"):
            layout.operator(cycles.SDFLIGHTS_OT_cycles_settings_copy.bl_idname, icon="COPYDOWN")


class SDFLIGHTS_PT_film(_Panel, bpy.types.Panel):
    bl_label = "Film"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_properties(self, layout, context):
        settings = context.scene.sdf_lights
        layout.prop(settings, "exposure")
        layout.prop(context.scene.render, "film_transparent", text="Transparent")
        column = layout.column()
        column.prop(settings, "filter", text="Pixel Filter")
        column = column.column()
        column.active = settings.filter != "BOX"
        column.prop(settings, "filter_width", text="Width")


class SDFLIGHTS_PT_performance(_Panel, bpy.types.Panel):
    bl_label = "Performance"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_properties(self, layout, context):
        render = context.scene.render
        layout.prop(context.scene.sdf_lights, "device")
        made_by = feedback.made_by(context.scene.name)
        if made_by:
            layout.label(text=f"Last render: {made_by}")
        column = layout.column()
        column.prop(render, "threads_mode", text="Threads Mode")
        column = column.column()
        column.enabled = render.threads_mode == "FIXED"
        column.prop(render, "threads", text="Threads")
        draw_back_end(layout)


_RENDER = (
    SDFLIGHTS_PT_sampling,
    _settings_panel(
        "SDFLIGHTS_PT_sampling_viewport",
        "Viewport",
        ("noise_threshold", "samples", "min_samples", "time_limit"),
        "SDFLIGHTS_PT_sampling",
        viewport=True,
        closed=True,
        presets=SDFLIGHTS_PT_viewport_sampling_presets,
    ),
    _settings_panel(
        "SDFLIGHTS_PT_sampling_viewport_denoise",
        "Denoise",
        (),
        "SDFLIGHTS_PT_sampling_viewport",
        viewport=True,
        closed=True,
        header="denoise",
    ),
    _settings_panel(
        "SDFLIGHTS_PT_sampling_render",
        "Render",
        ("noise_threshold", "samples", "min_samples", "time_limit"),
        "SDFLIGHTS_PT_sampling",
        presets=SDFLIGHTS_PT_sampling_presets,
    ),
    _settings_panel(
        "SDFLIGHTS_PT_sampling_render_denoise",
        "Denoise",
        (),
        "SDFLIGHTS_PT_sampling_render",
        closed=True,
        header="denoise",
    ),
    _settings_panel(
        "SDFLIGHTS_PT_sampling_advanced",
        "Advanced",
        ("seed", "animate_seed", "guided_samples", "indirect_paths"),
        "SDFLIGHTS_PT_sampling",
        closed=True,
    ),
    _settings_panel("SDFLIGHTS_PT_light_paths", "Light Paths", (), closed=True),
    _settings_panel(
        "SDFLIGHTS_PT_light_paths_bounces",
        "Max Bounces",
        (
            "max_bounces",
            "diffuse_bounces",
            "glossy_bounces",
            "transmission_bounces",
            "volume_bounces",
            "transparent_bounces",
        ),
        "SDFLIGHTS_PT_light_paths",
    ),
    _settings_panel(
        "SDFLIGHTS_PT_light_paths_clamping",
        "Clamping",
        ("clamp_direct", "clamp_indirect"),
        "SDFLIGHTS_PT_light_paths",
        closed=True,
    ),
    _settings_panel(
        "SDFLIGHTS_PT_light_paths_caustics",
        "Caustics",
        ("caustics_reflective", "caustics_refractive"),
        "SDFLIGHTS_PT_light_paths",
        closed=True,
    ),
    SDFLIGHTS_PT_film,
    SDFLIGHTS_PT_performance,
)


# -- view layer --------------------------------------------------------------------------------------------------------


class SDFLIGHTS_PT_passes(_Panel, bpy.types.Panel):
    bl_label = "Passes"
    bl_context = "view_layer"


def _passes_panel(label: str, light: bool) -> type:
    def draw_properties(self, layout, context):
        column = layout.column(heading="Include", align=True)
        for item, text in switches(light):
            owner = owner_of(item, context.view_layer)
            if owner is not None:
                column.prop(owner, item.switch, **({"text": text} if text else {}))

    return type(
        f"SDFLIGHTS_PT_passes_{label.lower()}",
        (_Panel, bpy.types.Panel),
        {
            "bl_label": label,
            "bl_context": "view_layer",
            "bl_parent_id": "SDFLIGHTS_PT_passes",
            "draw_properties": draw_properties,
        },
    )


_PASSES = (SDFLIGHTS_PT_passes, _passes_panel("Data", False), _passes_panel("Light", True))


class SDFLIGHTS_PT_override(_Panel, bpy.types.Panel):
    bl_label = "Override"
    bl_context = "view_layer"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_properties(self, layout, context):
        view_layer = context.view_layer
        layout.prop(view_layer, "material_override")
        layout.prop(view_layer, "world_override")
        layout.prop(view_layer, "samples")
        column = layout.column()
        column.active = view_layer.samples > 0
        column.prop(context.scene.sdf_lights, "layer_samples")
        if hasattr(view_layer, "cycles"):
            layout.prop(view_layer.cycles, "use_denoising", text="Denoising")


# -- light -------------------------------------------------------------------------------------------------------------


def draw_emission(layout, light) -> None:
    """Colour and power, which an SDF lamp shares with Blender's lights."""
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
    """Where the shape of an SDF lamp comes from, and its problems, in lines of ``width`` letters."""
    lamp = light.sdf_lamp
    layout.prop(lamp, "source")
    if lamp.source == "EXPRESSION":
        _draw_expression(layout, lamp)
    elif lamp.source == "NODES":
        _draw_nodes(layout, lamp)
    else:
        layout.prop(lamp, "shape")
        name = lamp.shape.lower()
        for about in PRIMITIVES[name].fields():
            layout.prop(getattr(lamp, name), about.name)
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
        layout.prop(lamp, "expression")
    else:
        layout.operator("sdf_lights.expression_show", icon="TEXT")
    layout.menu("SDFLIGHTS_MT_examples", text="Load Example")
    _draw_parameters(layout, lamp)


def _draw_nodes(layout, lamp) -> None:
    layout.template_ID(lamp, "nodes", new="sdf_lights.nodes_new")
    if lamp.nodes is not None:
        layout.operator("sdf_lights.nodes_show", icon="NODETREE")
        _draw_parameters(layout, lamp)


def _draw_parameters(layout, lamp) -> None:
    """Properties that an expression or a node tree declares."""
    if parameters.missing(lamp):
        parameters.update_soon(lamp.id_data)  # nothing may be changed while drawing
    column = layout.column()
    for declared in parameters.declarations(lamp):
        if parameters.exists(lamp.id_data, declared):
            label = declared.name.replace("_", " ").title()
            column.prop(lamp.id_data, parameters.path(declared), text=label)
    unused = parameters.unused(lamp.id_data)
    if unused:
        layout.operator("sdf_lights.parameters_remove", text=f"Remove {len(unused)} Unused", icon="TRASH")


def _placed_shape(lamp, obj) -> tuple[Shape, np.ndarray]:
    """The shape of a lamp, and the matrix of its object. Raises RenderError where there is nothing that could glow."""
    matrix = np.array([tuple(row) for row in obj.matrix_world] if obj is not None else np.eye(4), np.float64)
    shape = shape_of(lamp, matrix)
    if not np.isfinite(matrix).all() or math.isclose(np.linalg.det(matrix[:3, :3]), 0.0, abs_tol=1e-30):
        raise RenderError("The object is scaled to zero, so there is nothing to glow: set its scale.")
    return shape, matrix


def draw_readout(layout, light, obj, width: int) -> None:
    """What is known of a lamp's shape, in lines of ``width`` letters."""
    lamp = light.sdf_lamp
    try:
        shape, matrix = _placed_shape(lamp, obj)
    except RenderError:  # which the panel of the shape says
        layout.label(text="There is no shape")
        return
    try:
        pattern = pattern_of(lamp, matrix)
    except RenderError:  # which the panel of the emission says
        pattern = None
    column = layout.column(align=True)
    for line in readout.facts(shape, matrix, light, pattern):
        column.label(text=line)
    if not shape.certified:
        labels.draw_sentence(layout, "Thin parts may be missing", width, "INFO")
    problem = viewport.proxy_error(light)
    if problem:
        labels.draw_sentence(layout, f"In the viewport: {problem}", width)


class SDFLIGHTS_PT_light(_Panel, bpy.types.Panel):
    bl_label = "Light"
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.light is not None

    def draw(self, context):
        if not context.light.sdf_lamp.use:
            self.layout.row().prop(context.light, "type", expand=True)
        super().draw(context)

    def draw_properties(self, layout, context):
        light = context.light
        layout.prop(light.sdf_lamp, "use")
        layout.prop(light.sdf_lamp, "use_pass")
        draw_emission(layout, light)
        if light.sdf_lamp.use:
            return
        column = layout.column()
        if light.type in {"POINT", "SPOT"}:
            column.prop(light, "shadow_soft_size", text="Radius")
            column.prop(light, "use_soft_falloff")
        elif light.type == "SUN":
            column.prop(light, "angle")
        elif light.type == "AREA":
            column.prop(light, "shape")
            sizes = column.column(align=True)
            if light.shape in {"RECTANGLE", "ELLIPSE"}:
                sizes.prop(light, "size", text="Size X")
                sizes.prop(light, "size_y", text="Y")
            else:
                sizes.prop(light, "size")
            column.prop(light, "spread")
        if light.type == "SPOT":
            column.prop(light, "spot_size", text="Beam Angle")
            column.prop(light, "spot_blend", text="Blend", slider=True)
            column.prop(light, "show_cone")
        column.prop(light, "use_shadow", text="Cast Shadow")


class SDFLIGHTS_PT_lamp(_Panel, bpy.types.Panel):
    bl_label = "Shape"
    bl_context = "data"
    bl_parent_id = "SDFLIGHTS_PT_light"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.light is not None and context.light.sdf_lamp.use

    def draw_properties(self, layout, context):
        draw_shape(layout, context.light, context.object, labels.letters(context))
        layout.prop(context.light.sdf_lamp, "visible_camera", text="Visible to Camera")
        draw_readout(layout, context.light, context.object, labels.letters(context))


# -- object ------------------------------------------------------------------------------------------------------------


class SDFLIGHTS_PT_object_visibility(_Panel, bpy.types.Panel):
    bl_label = "Ray Visibility"
    bl_context = "object"
    bl_parent_id = "OBJECT_PT_visibility"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.object is not None

    def draw_properties(self, layout, context):
        column = layout.column(align=True)
        for name in ("camera", "diffuse", "glossy", "transmission", "shadow"):
            column.prop(context.object, f"visible_{name}", text=name.title())


# -- 3D view -----------------------------------------------------------------------------------------------------------


class _View3D(LampTab):
    """What the panels of a lamp in the lamps' tab have in common."""

    @classmethod
    def poll(cls, context):
        return lamp_of(context) is not None

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        self.draw_properties(layout, context)

    def draw_properties(self, layout, context):
        raise NotImplementedError


class SDFLIGHTS_PT_view3d(LampTab, bpy.types.Panel):
    bl_label = "SDF Lamp"

    def draw(self, context):
        layout, obj = self.layout, context.object
        if obj is None or obj.type != "LIGHT":
            layout.menu("SDFLIGHTS_MT_lamp_add", text="Add SDF Lamp", icon="LIGHT_POINT")
            return
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(obj.data.sdf_lamp, "use")
        if context.engine != ENGINE:
            labels.draw_sentence(
                layout,
                f"Renders as a point light: choose {LABEL} in Render Properties",
                labels.letters(context),
                "INFO",
            )


class SDFLIGHTS_PT_view3d_shape(_View3D, bpy.types.Panel):
    bl_label = "Shape"
    bl_parent_id = "SDFLIGHTS_PT_view3d"

    def draw_properties(self, layout, context):
        draw_shape(layout, context.object.data, context.object, labels.letters(context))


class SDFLIGHTS_PT_view3d_emission(_View3D, bpy.types.Panel):
    bl_label = "Emission"
    bl_parent_id = "SDFLIGHTS_PT_view3d"

    def draw_properties(self, layout, context):
        draw_emission(layout, context.object.data)
        layout.prop(context.object.data.sdf_lamp, "visible_camera", text="Visible to Camera")


class SDFLIGHTS_PT_view3d_readout(_View3D, bpy.types.Panel):
    bl_label = "Readout"
    bl_parent_id = "SDFLIGHTS_PT_view3d"

    def draw_properties(self, layout, context):
        draw_readout(layout, context.object.data, context.object, labels.letters(context))


# -- registration ------------------------------------------------------------------------------------------------------

CLASSES = (
    *_RENDER,
    *_PASSES,
    SDFLIGHTS_PT_override,
    SDFLIGHTS_PT_light,
    SDFLIGHTS_PT_lamp,
    SDFLIGHTS_PT_object_visibility,
    SDFLIGHTS_PT_view3d,
    SDFLIGHTS_PT_view3d_shape,
    SDFLIGHTS_PT_view3d_emission,
    SDFLIGHTS_PT_view3d_readout,
)


def register():
    for panel in stock_panels():
        panel.COMPAT_ENGINES.add(ENGINE)


def unregister():
    for panel in bpy.types.Panel.__subclasses__():
        getattr(panel, "COMPAT_ENGINES", set()).discard(ENGINE)
