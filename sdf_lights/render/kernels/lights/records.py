# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of the emitters: one list of all of them. Each kind of Blender's lights has its record in its own module.

An emitter is an index into ``light_emitters``: first the SDF lamps (emitter i is lamp i), then ``scene.lights`` in
their order, then the world, then the emissive triangles.
"""

import numpy as np

from ....jit import kernel, table

EMITTER = np.dtype(
    [
        ("kind", np.int32),
        ("index", np.int32),  # row in the table of that kind
        ("visibility", np.int32),  # bits of scene.Ray
        ("cast_shadow", np.int32),
        ("leaf", np.int32),  # index among the leaves of the light tree 0, in their order; −1: not in it
        ("infinite", np.int32),  # row in light_infinite; −1: not in it
        ("met", np.int32),  # as visibility, for scattered rays that hit it by chance
        ("alone", np.int32),  # 1: all its light is left to light sampling, if that can find it
        (
            "blockers",
            np.int32,
        ),  # kind of ray stopped by the opaque surfaces that cast its shadows: rays.SHADOW_OPAQUE, or a separate bit
        ("max_bounces", np.int32),  # of the objects that it lights
        ("beside_catchers", np.int32),  # 1: its light is missing where there are only shadow catchers
        ("camera_brightness", np.float64),  # factor for camera rays on a lamp
    ],
    align=True,
)

# Siblings are adjacent. Single precision fits a node into one cache line; probabilities are exact for the stored
# values.
NODE = np.dtype(
    [
        ("centroid", np.float32, 3),  # of the intensity
        ("spread", np.float32, 3),  # m², its mean square distance from there along each axis
        ("radius", np.float32),  # of a ball around the centroid that contains all emitters
        ("axis", np.float32, 3),
        ("cos_o", np.float32),  # cone that contains all normals
        ("cos_e", np.float32),
        ("intensity", np.float32),
        ("child", np.int32),  # first child, or ~emitter of a leaf
        ("order", np.int32),  # of the first leaf below
        ("two_sided", np.int32),
    ],
    align=True,
)

# The nodes of the light tree among which a point chooses first, in the order of their leaves.
MOST_NODES = 32
LIGHT_CUT = np.dtype(
    [
        ("root", np.int64),  # of the tree
        ("x", np.float64, 3),
        ("n", np.float64, 3),  # the point, and the normal there, of the cut
        ("count", np.int64),  # of nodes; 0: it belongs to no point yet
        ("total", np.float64),  # of the weights
        ("node", np.int64, MOST_NODES),
        ("order", np.int64, MOST_NODES),
        ("weight", np.float64, MOST_NODES),  # estimate of the irradiance
        ("doubt", np.float64, MOST_NODES),
    ],  # variance that the choice below is expected to add; 0 for a leaf
    align=True,
)

# A light tree: of the emitters that light some surfaces. Number 0 has all of them. Its infinite emitters are the rows
# from ``first`` to before ``end``.
TREE = np.dtype(
    [("root", np.int64), ("nodes", np.int64), ("first", np.int64), ("end", np.int64)],
    align=True,
)

# Position of an emitter in a tree other than number 0, as ``leaf`` and ``infinite`` of its own record.
PLACE = np.dtype([("leaf", np.int32), ("infinite", np.int32)], align=True)

INFINITE = np.dtype(
    [
        ("emitter", np.int64),
        ("irradiance", np.float64),
        ("importance", np.float64),  # part of the irradiance that counts in the selection of lights
        ("direction", np.float64, 3),
        ("directional", np.int64),
    ],
    align=True,
)

HEADER = np.dtype(
    [
        ("lamp_count", np.int64),
        ("light_count", np.int64),
        ("emitter_count", np.int64),
        ("tree_count", np.int64),
        ("instance_count", np.int64),
        ("portal_count", np.int64),
        ("open_tree", np.int64),  # of the medium of the world, which is no object
        ("world_emitter", np.int64),
        ("world_color", np.float64, 3),
        ("rotation", np.float64, (3, 3)),
        ("width", np.int64),
        ("height", np.int64),  # of the image; 0: there is none
        ("columns", np.int64),
        ("rows", np.int64),  # of the table from which the image is sampled
        ("graph", np.int64),  # 1: nodes multiply the radiance, and the table is only for sampling
        # Unit vector to the disc of a sun, 1 − cos of the angle to its edge, and its share of samples.
        ("sun", np.float64, 3),
        ("sun_width", np.float64),
        ("sun_share", np.float64),
    ],
    align=True,
)

TABLES = {
    "light_header": HEADER,  # one row
    "light_emitters": EMITTER,
    "light_nodes": NODE,
    "light_infinite": INFINITE,
    "light_trees": TREE,
    "light_tree_places": PLACE,  # (trees − 1) × emitters
    "light_tree_of": np.dtype(np.int32),  # of each instance, if there is more than one tree
    "light_links": np.dtype(
        np.int32
    ),  # (trees − 1) × instances: 1 if emission of the instance lights objects with the tree
    "light_triangle_offset": np.dtype(np.int64),  # of each instance into light_triangle_map; one more ends the last
    "light_triangle_map": np.dtype(np.int32),  # emitter of each triangle of instances that emit, or −1
    "light_image": np.dtype(np.float32),  # height × width × RGB
    "light_image_rows": np.dtype(np.float64),  # cumulative probability of rows, rows + 1
    "light_image_columns": np.dtype(np.float64),  # the same within each row, rows × (columns + 1)
}

WORKSPACE_TABLES = {"light_cut": LIGHT_CUT}
WORKSPACE_COUNTS = {"light_cut": 2}  # of the first surface of a path, and of the present one

HIT = np.dtype(
    [("emitter", np.int64), ("distance", np.float64), ("pdf", np.float64), ("radiance", np.float64, 3)], align=True
)

header_table = table("light_header", HEADER)
emitter_table = table("light_emitters", EMITTER)
node_table = table("light_nodes", NODE)
light_cut_table = table("light_cut", LIGHT_CUT)
infinite_table = table("light_infinite", INFINITE)
tree_table = table("light_trees", TREE)
place_table = table("light_tree_places", PLACE)
tree_of_table = table("light_tree_of", np.int32)
link_table = table("light_links", np.int32)
triangle_offset_table = table("light_triangle_offset", np.int64)
triangle_map_table = table("light_triangle_map", np.int32)
image_table = table("light_image", np.float32)
image_rows_table = table("light_image_rows", np.float64)
image_columns_table = table("light_image_columns", np.float64)


@kernel
def no_sample():
    """The result of a sampler if the light cannot reach the point."""
    return (0.0, 0.0, 0.0), 0.0, (0.0, 0.0, 0.0), 0.0, False
