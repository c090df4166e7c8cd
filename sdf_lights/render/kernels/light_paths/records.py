# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Records of light paths: their vertices, and the tree that chooses among these."""

from __future__ import annotations

import numpy as np

from ....jit import table

# Where a light path has met a surface that scatters light. ``wi`` is the way back to where the light came from. The
# vertex stands for light that leaves on the side of ``normal``, the geometric normal, and ``flux`` is the power (RGB,
# W) that arrives for that.
VERTEX = np.dtype(
    [
        ("position", "f8", 3),
        ("normal", "f8", 3),
        ("wi", "f8", 3),
        ("flux", "f8", 3),
        ("importance", "f8"),  # estimate of the power that leaves
        ("u", "f8"),
        ("v", "f8"),
        ("instance", "i4"),
        ("primitive", "i4"),
        ("emitter", "i4"),
        ("scatters", "i4"),  # how often the light will have been scattered once it leaves
        ("diffuse", "i4"),  # bounces of each kind that a path from the camera would have counted beyond this surface
        ("glossy", "i4"),
        ("transmission", "i4"),
        (
            "transparent",
            "i4",
        ),  # transparent surfaces on the way, and 1 where none of them is before the first scattering
    ],
    align=True,
)

# The two children of a node are neighbours. Axes 0 to 2 are those of positions, 3 to 5 those of normals.
NODE = np.dtype(
    [
        ("centroid", "f8", 3),
        ("normal", "f8", 3),  # mean of the normals: shorter than 1 where they differ
        ("flux", "f8"),
        ("spread", "f8"),  # root of the mean square distance from the centroid
        ("radius", "f8"),  # of a ball around the centroid that holds all vertices
        ("area", "f8"),  # m², of a rectangle with the same covariance
        ("split", "f8"),
        ("axis", "i8"),  # −1: a leaf
        ("child", "i8"),  # the first of two
        ("top", "i8"),  # place among the nodes that a point chooses among at first; −1: none
        ("first", "i8"),  # of the vertices of the pass
        ("count", "i8"),
        ("known", "i8"),  # of the vertices that the tree was made from
    ],
    align=True,
)

# Where light paths of the world and of suns are sent: see distant.py. The first row is a ball around the whole scene.
TARGET = np.dtype([("position", "f8", 3), ("radius", "f8")], align=True)

PLACE = 1 << 20  # of a pixel that no picture has, whose random numbers light paths have
MOST_NODES, MOST_TOPS = 4096, 32
# Of a material: connections find light that it scatters; all of that; light paths follow what it scatters diffusely,
# and by all closures. AT_VERTEX instead, in the ``follow`` of a path: they find what the surface scatters, but in sharp
# lobes.
CONNECTS, CONNECTS_ALL, FOLLOW_DIFFUSE, FOLLOW_ALL, AT_VERTEX = 1, 2, 4, 8, 16
# What a point expects of each top node.
CHOICE = np.dtype([("total", "f8"), ("count", "i8"), ("weight", "f8", MOST_TOPS)], align=True)

TABLES = {
    "light_path_nodes": NODE,
    "light_path_tops": np.dtype(np.int64),
    "light_path_vertices": VERTEX,
    "light_path_materials": np.dtype(np.int64),  # sums of CONNECTS, …
    "light_path_sources": np.dtype(np.int64),  # of each emitter: 1 if light paths start there
    "light_path_power": np.dtype(
        np.float64
    ),  # of each emitter and those before it (W), as far as light paths start there
    "light_path_targets": TARGET,
    "light_path_times": np.dtype(np.float64),  # in moving scenes, the times that have light paths
    "light_path_code": np.dtype(np.int64),
}
SCALARS = [
    ("light_paths", np.int64),  # 1: strategy and tables are there
    ("light_path_connections", np.int64),  # for each ray that scatters where paths split
    ("light_path_roulette", np.float64),  # the least chance with which a path goes on where connections find its light
    ("light_path_follows", np.int64),  # 1: light paths follow all that the scene scatters
    ("light_path_node_count", np.int64),  # of the tree; ``light_path_nodes`` has a copy for each time
    ("light_path_first_node", np.int64),  # of the copy for the time of the path
    ("light_path_all", np.int64),  # 1: all light that a path finds beyond a connection is of light paths, too
]
WORKSPACE_TABLES = {"light_path_choice": CHOICE}
# Of the surface where the path splits, of a later one, and of some points of a group that shares vertices.
FIRST_OF_GROUP, REPRESENTATIVES = 2, 4
WORKSPACE_COUNTS = {"light_path_choice": FIRST_OF_GROUP + REPRESENTATIVES}

node_table = table("light_path_nodes", NODE)
top_table = table("light_path_tops", np.int64)
material_table = table("light_path_materials", np.int64)
source_table = table("light_path_sources", np.int64)
power_table = table("light_path_power", np.float64)
target_table = table("light_path_targets", TARGET)
time_table = table("light_path_times", np.float64)
vertex_table = table("light_path_vertices", VERTEX)
choice_table = table("light_path_choice", CHOICE)
