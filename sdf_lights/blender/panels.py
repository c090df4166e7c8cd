# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels: properties of render, view layer, light and object, and the tab in the 3D view.

Blender's own panels are reused if they fit (``stock_panels``).
"""

import bpy

from . import cycles, feedback
from .lamp_panels import draw_emission
from .lamp_presets import SDFLIGHTS_PT_lamp_presets
from .naming import ENGINE
from .passes import owner_of, switches
from .preferences import draw_back_end
from .sampling_presets import SDFLIGHTS_PT_sampling_presets, SDFLIGHTS_PT_viewport_sampling_presets

# Blender's generic panels that are wrong for this engine, or that are replaced below.
_EXCLUDED = {
    "DATA_PT_light",
    "DATA_PT_spot",
    "DATA_PT_falloff_curve",
    "NODE_DATA_PT_light",
    "NODE_DATA_PT_spot",
    "RENDER_PT_freestyle",
    "RENDER_PT_simplify",
    "RENDER_PT_simplify_viewport",
    "RENDER_PT_simplify_render",
    "VIEWLAYER_PT_filter",
    "VIEWLAYER_PT_layer_passes",
    "VIEWLAYER_PT_freestyle",
    "VIEWLAYER_PT_freestyle_lineset",
    "VIEWLAYER_PT_freestyle_linestyle",
}

# EEVEE's panels for properties that this engine reads too.
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


class RenderPanel:
    """Common base of panels in the Properties editor."""

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
        """Nothing: the panel only holds others."""


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
    """A panel with some properties of ``scene.sdf_lights``, or of its viewport group. ``header`` is a switch in the
    header. ``presets`` is the panel of presets that opens there."""

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
    return type(name, (RenderPanel, bpy.types.Panel), namespace)


class SDFLIGHTS_PT_sampling(RenderPanel, bpy.types.Panel):
    bl_label = "Sampling"

    def draw_properties(self, layout, context):
        if context.scene.sdf_lights.origin == cycles.UNKNOWN:
            cycles.settle_soon()
        if hasattr(context.scene, "cycles"):
            layout.operator(cycles.SDFLIGHTS_OT_cycles_settings_copy.bl_idname, icon="COPYDOWN")


class SDFLIGHTS_PT_film(RenderPanel, bpy.types.Panel):
    bl_label = "Film"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 1  # after Simplify and Motion Blur

    def draw_properties(self, layout, context):
        settings = context.scene.sdf_lights
        layout.prop(settings, "exposure")
        layout.prop(context.scene.render, "film_transparent", text="Transparent")
        column = layout.column()
        column.prop(settings, "filter", text="Pixel Filter")
        column = column.column()
        column.active = settings.filter != "BOX"
        column.prop(settings, "filter_width", text="Width")


class SDFLIGHTS_PT_performance(RenderPanel, bpy.types.Panel):
    bl_label = "Performance"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 1

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
        ("noise_threshold", "samples", "min_samples", "time_limit", "denoise"),
        "SDFLIGHTS_PT_sampling",
        viewport=True,
        closed=True,
        presets=SDFLIGHTS_PT_viewport_sampling_presets,
    ),
    _settings_panel(
        "SDFLIGHTS_PT_sampling_render",
        "Render",
        ("noise_threshold", "samples", "min_samples", "time_limit", "denoise"),
        "SDFLIGHTS_PT_sampling",
        presets=SDFLIGHTS_PT_sampling_presets,
    ),
    _settings_panel(
        "SDFLIGHTS_PT_sampling_advanced",
        "Advanced",
        (
            "seed",
            "animate_seed",
            "sample_offset",
            "guided_samples",
            "indirect_paths",
            "lamp_paths",
            "path_reuse",
            "caustic_paths",
        ),
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
        ("filter_glossy", "caustics_reflective", "caustics_refractive"),
        "SDFLIGHTS_PT_light_paths",
        closed=True,
    ),
    SDFLIGHTS_PT_film,
    SDFLIGHTS_PT_performance,
)


# -- view layer --------------------------------------------------------------------------------------------------------


class SDFLIGHTS_PT_passes(RenderPanel, bpy.types.Panel):
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
        (RenderPanel, bpy.types.Panel),
        {
            "bl_label": label,
            "bl_context": "view_layer",
            "bl_parent_id": "SDFLIGHTS_PT_passes",
            "draw_properties": draw_properties,
        },
    )


_PASSES = (SDFLIGHTS_PT_passes, _passes_panel("Data", False), _passes_panel("Light", True))


class SDFLIGHTS_PT_override(RenderPanel, bpy.types.Panel):
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


class SDFLIGHTS_PT_light(RenderPanel, bpy.types.Panel):
    bl_label = "Light"
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.light is not None

    def draw_header_preset(self, context):
        if context.light.sdf_lamp.use:
            SDFLIGHTS_PT_lamp_presets.draw_panel_header(self.layout)

    def draw(self, context):
        if not context.light.sdf_lamp.use:
            self.layout.row().prop(context.light, "type", expand=True)
        super().draw(context)

    def draw_properties(self, layout, context):
        light = context.light
        layout.prop(light.sdf_lamp, "use")
        if light.sdf_lamp.use:
            return
        layout.prop(light.sdf_lamp, "use_pass")
        draw_emission(layout, light)
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


class SDFLIGHTS_PT_world_preview(RenderPanel, bpy.types.Panel):
    bl_label = "Preview"
    bl_context = "world"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.world is not None

    def draw(self, context):
        self.layout.template_preview(context.world)


# -- object ------------------------------------------------------------------------------------------------------------


class SDFLIGHTS_PT_object_visibility(RenderPanel, bpy.types.Panel):
    bl_label = "Ray Visibility"
    bl_context = "object"
    bl_parent_id = "OBJECT_PT_visibility"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.object is not None

    def draw_properties(self, layout, context):
        column = layout.column(align=True)
        for name in ("camera", "diffuse", "glossy", "transmission", "volume_scatter", "shadow"):
            column.prop(context.object, f"visible_{name}", text=name.replace("_", " ").title())


# -- registration ------------------------------------------------------------------------------------------------------

CLASSES = (
    *_RENDER,
    *_PASSES,
    SDFLIGHTS_PT_override,
    SDFLIGHTS_PT_light,
    SDFLIGHTS_PT_world_preview,
    SDFLIGHTS_PT_object_visibility,
)


def register():
    for panel in stock_panels():
        panel.COMPAT_ENGINES.add(ENGINE)


def unregister():
    for panel in bpy.types.Panel.__subclasses__():
        getattr(panel, "COMPAT_ENGINES", set()).discard(ENGINE)
