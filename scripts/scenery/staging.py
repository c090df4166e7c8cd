# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cameras, Blender's own lights, and worlds."""

from __future__ import annotations

import math

import bpy
import numpy as np
from mathutils import Vector

from .materials import Graph
from .modelling import add


def camera(eye, target, degrees: float = 50.0, aperture: float = 0.0, focus=None) -> bpy.types.Object:
    """A camera at ``eye`` that looks at ``target``; with an f-number for ``aperture`` it is sharp at ``focus``
    alone."""
    data = bpy.data.cameras.new("Camera")
    data.sensor_fit, data.angle, data.clip_start = "HORIZONTAL", math.radians(degrees), 0.01
    if aperture:
        data.dof.use_dof, data.dof.aperture_fstop = True, aperture
        data.dof.focus_distance = (Vector(focus or target) - Vector(eye)).length
    thing = add("Camera", data, location=eye)
    thing.rotation_euler = aimed(eye, target)
    bpy.context.scene.camera = thing
    return thing


def aimed(eye, target):
    return (Vector(target) - Vector(eye)).to_track_quat("-Z", "Y").to_euler()


def light(name: str, kind: str, watts: float, location, target=None, color=(1.0, 1.0, 1.0), **settings):
    """A light; a sun has W/m². ``target``: where it points."""
    data = bpy.data.lights.new(name, kind)
    data.energy, data.color = watts, color
    for key, value in settings.items():
        setattr(data, key, value)
    thing = add(name, data, location=location)
    if target is not None:
        thing.rotation_euler = aimed(location, target)
    return thing


def world(color, strength: float = 1.0) -> Graph:
    """A world of one colour; its graph, to add more to."""
    data = bpy.data.worlds.new("World")
    bpy.context.scene.world = data
    graph = Graph(data)
    graph.finish(graph.node("ShaderNodeBackground", Color=(*color, 1.0), Strength=strength))
    return graph


def sky(elevation: float, azimuth: float, strength: float = 0.1, disc: bool = True) -> None:
    """The sky model of the running version; angles in degrees."""
    data = bpy.data.worlds.new("Sky")
    bpy.context.scene.world = data
    graph = Graph(data)
    socket = graph.node("ShaderNodeTexSky")
    kinds = socket.node.bl_rna.properties["sky_type"].enum_items.keys()
    socket.node.sky_type = "MULTIPLE_SCATTERING" if "MULTIPLE_SCATTERING" in kinds else "NISHITA"
    socket.node.sun_elevation, socket.node.sun_rotation = math.radians(elevation), math.radians(azimuth)
    socket.node.sun_disc = disc
    graph.finish(graph.node("ShaderNodeBackground", Color=socket, Strength=strength))


def panorama(name: str, lamps, ground=(0.1, 0.09, 0.08), zenith=(0.25, 0.3, 0.4), strength: float = 1.0) -> None:
    """A world from an equirectangular picture of floats: a gradient with soft ``lamps``, each (azimuth, elevation,
    angle, colour), in degrees."""
    height = 128
    v, u = (np.mgrid[0:height, 0 : 2 * height] + 0.5) / height
    elevation, azimuth = (v - 0.5) * math.pi, (u - 1.0) * math.pi
    upward = np.sin(elevation)[..., None]
    pixels = np.where(upward > 0.0, np.asarray(zenith) * (0.4 + 0.6 * upward), np.asarray(ground))
    for turn, rise, angle, color in lamps:
        turn, rise, angle = (math.radians(value) for value in (turn, rise, angle))
        between = np.sin(elevation) * math.sin(rise) + np.cos(elevation) * math.cos(rise) * np.cos(azimuth - turn)
        pixels = pixels + np.exp(-(((np.arccos(np.clip(between, -1.0, 1.0))) / angle) ** 4))[..., None] * color
    image = bpy.data.images.new(name, 2 * height, height, float_buffer=True)
    image.pixels.foreach_set(
        np.concatenate([pixels, np.ones((*pixels.shape[:2], 1))], axis=2).astype(np.float32).ravel()
    )
    image.pack()
    data = bpy.data.worlds.new(name)
    bpy.context.scene.world = data
    graph = Graph(data)
    socket = graph.node("ShaderNodeTexEnvironment")
    socket.node.image = image
    graph.finish(graph.node("ShaderNodeBackground", Color=socket, Strength=strength))


def glowing(name: str, color, strength: float) -> bpy.types.Material:
    graph = Graph(name)
    return graph.finish(graph.node("ShaderNodeEmission", Color=color, Strength=strength))
