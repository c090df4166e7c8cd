# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of Simplify and Motion Blur with all properties that this engine reads. For Simplify, these are more than in
Blender's own panel, because other engines have panels of their own."""

import bpy

from .panels import RenderPanel


class SDFLIGHTS_PT_motion_blur(RenderPanel, bpy.types.Panel):
    bl_label = "Motion Blur"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context):
        self.layout.prop(context.scene.render, "use_motion_blur", text="")

    def draw_properties(self, layout, context):
        render = context.scene.render
        layout.active = render.use_motion_blur
        layout.prop(render, "motion_blur_position", text="Position")
        layout.prop(render, "motion_blur_shutter")


class SDFLIGHTS_PT_motion_blur_curve(RenderPanel, bpy.types.Panel):
    bl_label = "Shutter Curve"
    bl_parent_id = "SDFLIGHTS_PT_motion_blur"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_properties(self, layout, context):
        render = context.scene.render
        layout.active = render.use_motion_blur
        layout.template_curve_mapping(render, "motion_blur_shutter_curve")


class SDFLIGHTS_PT_simplify(RenderPanel, bpy.types.Panel):
    bl_label = "Simplify"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context):
        self.layout.prop(context.scene.render, "use_simplify", text="")


class _Simplify(RenderPanel):
    bl_parent_id = "SDFLIGHTS_PT_simplify"
    own: tuple[tuple[str, str], ...] = ()  # Blender's properties, with labels
    cycles: tuple[tuple[str, str], ...] = ()  # properties that exist while the Cycles add-on is enabled

    def draw_properties(self, layout, context):
        scene = context.scene
        layout.active = scene.render.use_simplify
        column = layout.column()
        for owner, properties in ((scene.render, self.own), (getattr(scene, "cycles", None), self.cycles)):
            for name, label in properties:
                if hasattr(owner, name):
                    column.prop(owner, name, text=label)


class SDFLIGHTS_PT_simplify_viewport(_Simplify, bpy.types.Panel):
    bl_label = "Viewport"
    own = (
        ("simplify_subdivision", "Max Subdivision"),
        ("simplify_child_particles", "Child Particles"),
        ("use_simplify_normals", "Normals"),
        ("simplify_volumes", "Volume Resolution"),
    )
    cycles = (("texture_resolution", "Texture Resolution"), ("texture_limit", "Texture Size Limit"))


class SDFLIGHTS_PT_simplify_render(_Simplify, bpy.types.Panel):
    bl_label = "Render"
    own = (
        ("simplify_subdivision_render", "Max Subdivision"),
        ("simplify_child_particles_render", "Child Particles"),
    )
    cycles = (("texture_resolution_render", "Texture Resolution"), ("texture_limit_render", "Texture Size Limit"))


class SDFLIGHTS_PT_simplify_culling(RenderPanel, bpy.types.Panel):
    bl_label = "Culling"
    bl_parent_id = "SDFLIGHTS_PT_simplify"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and hasattr(context.scene, "cycles")

    def draw_properties(self, layout, context):
        settings = context.scene.cycles
        layout.active = context.scene.render.use_simplify
        for heading, use, margin in (
            ("Camera Culling", "use_camera_cull", "camera_cull_margin"),
            ("Distance Culling", "use_distance_cull", "distance_cull_margin"),
        ):
            row = layout.row(heading=heading)
            row.prop(settings, use, text="")
            value = row.column()
            value.active = getattr(settings, use)
            value.prop(settings, margin, text="")


CLASSES = (
    SDFLIGHTS_PT_simplify,
    SDFLIGHTS_PT_simplify_viewport,
    SDFLIGHTS_PT_simplify_render,
    SDFLIGHTS_PT_simplify_culling,
    SDFLIGHTS_PT_motion_blur,
    SDFLIGHTS_PT_motion_blur_curve,
)
