# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kinds of lights, and what artists let them do."""

from __future__ import annotations

import bpy
from scenery.modelling import add, plane
from scenery.staging import light

from .stage import feature, lamp


def _collection(included=(), excluded=()):
    """A collection for linking, with objects that it includes or excludes."""
    made = bpy.data.collections.new("Linked")
    for name in (*included, *excluded):
        made.objects.link(bpy.data.objects[name])
    for thing, link in zip(made.objects, made.collection_objects):
        link.light_linking.link_state = "INCLUDE" if thing.name in included else "EXCLUDE"
    return made


@feature("Lights")
def sun(scene):
    """A sun of 5° in place of the area light."""
    bpy.data.objects.remove(bpy.data.objects["Key"])
    light("Sun", "SUN", 3.0, (0.0, 0.0, 4.0), (0.8, 0.8, 0.0), (1.0, 0.9, 0.8), angle=0.09)


@feature("Lights")
def spots(scene):
    """A soft spot and a square area light with a spread."""
    bpy.data.objects["Key"].data.spread = 0.7
    light(
        "Spot",
        "SPOT",
        120.0,
        (1.2, -1.5, 2.5),
        (0.1, 0.4, 0.3),
        (0.4, 1.0, 0.6),
        spot_size=0.5,
        spot_blend=0.6,
        shadow_soft_size=0.05,
    )


@feature("Lights")
def ellipses(scene):
    """An area light with the form of an ellipse, and a small disk."""
    key = bpy.data.objects["Key"].data
    key.shape, key.size, key.size_y = "ELLIPSE", 1.6, 0.4
    light("Disk", "AREA", 20.0, (0.2, -1.2, 1.6), (0.2, 0.6, 0.3), (0.4, 0.6, 1.0), shape="DISK", size=0.3)


@feature("Light control")
def light_linking(scene):
    """Lights that light only some objects."""
    bpy.data.objects["Key"].light_linking.receiver_collection = _collection(excluded=["Block", "Plastic"])
    bpy.data.objects["Fill"].light_linking.receiver_collection = _collection(["Floor", "Metal", "Glass"])


@feature("Light control")
def shadow_linking(scene):
    """Lights for which only some objects cast shadows."""
    bpy.data.objects["Key"].light_linking.blocker_collection = _collection(excluded=["Block"])
    bpy.data.objects["Fill"].light_linking.blocker_collection = _collection(["Metal"])


@feature("Light control")
def visibility_of_lights(scene):
    """A lamp that the camera does not see, a light not seen by glossy rays, and one not by diffuse rays."""
    lamp().visible_camera = False
    bpy.data.objects["Key"].visible_glossy = False
    bpy.data.objects["Fill"].visible_diffuse = False


@feature("Light control")
def visibility_of_objects(scene):
    """A block without a shadow, a ball that only the camera sees, one without reflection."""
    bpy.data.objects["Block"].visible_shadow = False
    ball = bpy.data.objects["Plastic"]
    ball.visible_diffuse = ball.visible_glossy = ball.visible_transmission = ball.visible_shadow = False
    bpy.data.objects["Metal"].visible_glossy = False


@feature("Light control")
def bounces_of_lights(scene):
    """Lights whose light scatters once, or not at all."""
    bpy.data.objects["Key"].data.cycles.max_bounces = 1
    bpy.data.objects["Fill"].data.cycles.max_bounces = 0


@feature("Light control")
def lights_without_shadow(scene):
    """A light that casts no shadow."""
    key = bpy.data.objects["Key"].data
    if hasattr(key, "use_shadow"):
        key.use_shadow = False


@feature("Light control")
def portal(scene):
    """The world through a window with a portal."""
    for name in ("Key", "Fill"):
        bpy.data.objects.remove(bpy.data.objects[name])
    paint = bpy.data.materials["Wall"]
    for name, place, turn, size in (
        ("Ceiling", (0.0, 0.0, 3.0), (180, 0, 0), (8.0, 8.0)),
        ("Left", (-2.0, -1.6, 1.5), (90, 0, 90), (4.0, 3.0)),
        ("Back", (0.0, -6.0, 1.5), (90, 0, 180), (8.0, 3.0)),
        ("Right", (2.0, -1.6, 0.4), (90, 0, -90), (9.0, 0.8)),
        ("Lintel", (2.0, -1.6, 2.6), (90, 0, -90), (9.0, 0.8)),
    ):
        add(name, plane(name, size), paint, location=place, rotation=turn)
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 3.0
    window = light("Portal", "AREA", 1.0, (2.0, -1.6, 1.5), (0.0, -1.6, 1.5), shape="RECTANGLE", size=9.0, size_y=1.4)
    window.data.cycles.is_portal = True
