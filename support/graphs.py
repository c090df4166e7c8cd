# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Graphs of materials made in Python, from the same definitions as Blender's nodes."""

from sdf_lights.graph.formula import Vector, constant
from sdf_lights.render.material import Material, Node
from sdf_lights.render.nodes import node_outputs
from sdf_lights.render.nodes.variables import BARYCENTRIC

PLACE = Vector(*BARYCENTRIC, constant(0.0))
"""The position of a point in its triangle, as image coordinates: they need no mesh."""


class Graph:
    """Nodes of one material: ``graph.image(0)``, ``graph.material("name", closure)``."""

    def __init__(self):
        self.parameters = []

    def node(self, name, inputs=None, settings=None, wanted=()):
        return node_outputs(name, self.parameters, inputs, settings, set(wanted))

    def uv(self, name=""):
        return self.node("ShaderNodeUVMap", settings={"uv_map": name})["UV"]

    def image(self, index, vector=PLACE, output="Color", interpolation="Linear", extension="REPEAT", projection="FLAT"):
        return self.node(
            "ShaderNodeTexImage",
            {"Vector": vector},
            dict(image=index, interpolation=interpolation, extension=extension, projection=projection),
            {output},
        )[output]

    def mapping(self, vector, location=(0.0, 0.0, 0.0), rotation=(0.0, 0.0, 0.0), scale=(1.0, 1.0, 1.0), kind="POINT"):
        return self.node(
            "ShaderNodeMapping",
            dict(Vector=vector, Location=location, Rotation=rotation, Scale=scale),
            {"vector_type": kind},
        )["Vector"]

    def normal_map(self, color=(0.5, 0.5, 1.0), strength=1.0, space="TANGENT", uv_map=""):
        return self.node("ShaderNodeNormalMap", dict(Color=color, Strength=strength), dict(space=space, uv_map=uv_map))[
            "Normal"
        ]

    def bump(self, height, distance=1.0, strength=1.0, invert=False):
        return self.node(
            "ShaderNodeBump", dict(Height=height, Distance=distance, Strength=strength), dict(invert=invert)
        )["Normal"]

    def occlusion(self, color, distance=1.0, samples=2, **settings):
        return self.node(
            "ShaderNodeAmbientOcclusion",
            dict(Color=color, Distance=distance),
            dict(samples=samples, occlusion_distance=10.0, **settings),
        )["Color"]

    def bevel(self, radius, samples=1):
        return self.node("ShaderNodeBevel", dict(Radius=radius), dict(samples=samples))["Normal"]

    def raycast(self, direction, length, **settings):
        return self.node("ShaderNodeRaycast", dict(Direction=direction, Length=length), settings)

    def material(self, name: str, surface: Node) -> Material:
        return Material(name, surface, parameters=self.parameters)
