# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The data that the passes of this folder need of a scene, of a film and of a thread.

``outputs`` of the block has a bit for each kind of pass of the film. The sums of a sample are ``output_sums``: those of
light before its path splits, those of light after that, each ``light_columns`` long, and those of data.
"""

import numpy as np

from ....jit import table
from ...passes import DATA_SUMS, LIGHT_SUMS
from ..camera import CAMERA

LIGHT, LOBES, DATA, MATTES, CATCHERS, VECTORS = (
    1,
    2,
    4,
    8,
    16,
    32,
)  # bits of ``outputs``; DATA is also set with MATTES, CATCHERS or VECTORS

# How the first scattering of a path divides its light: the parts of diffuse and of glossy lobes; the rest is
# transmission. 1 if a medium has scattered it.
FIRST_SCATTERING = np.dtype([("diffuse", "f8", 3), ("glossy", "f8", 3), ("in_medium", "i8")], align=True)

# Of Cryptomatte: the object numbers of an instance; and the hits of a sample: an instance, its material, and their
# coverage of the sample. The first row has their number.
INSTANCE_MATTE = np.dtype([("object", "f8"), ("asset", "f8")])
MATTE_HIT = np.dtype([("instance", "i8"), ("material", "i8"), ("weight", "f8")])
MOST_HITS = 64

# Of the pass Vector. For an instance, for the previous frame and the next one: from the world at the frame to the world
# there, and from shifts of the mesh to those of the world. ``shifts``: the first of those of its vertices, or −1.
VECTOR_INSTANCE = np.dtype(
    [("pose", "f8", (2, 3, 4)), ("turn", "f8", (2, 3, 4)), ("shifts", "i8"), ("vertex_count", "i8")], align=True
)
SHIFT = np.dtype([("d", "f4", (3,))])
VECTOR_TABLES = {"vector_cameras": CAMERA, "vector_instances": VECTOR_INSTANCE, "vector_shifts": SHIFT}

# A column of light or data by the index of its name; −1: the film lacks it.
LIGHT_NAMES = {name: index for index, name in enumerate(LIGHT_SUMS)}
DATA_NAMES = {name: index for index, name in enumerate(DATA_SUMS)}

TABLES = {
    "film_light": np.dtype(np.float64),
    "film_data": np.dtype(np.float64),
    "light_places": np.dtype(np.int64),
    "data_places": np.dtype(np.int64),
    "data_numbers": np.dtype(np.int64),  # of each column of data: 1 if it is of the first sample alone
    # Columns of light by emitter, and by instance; −1: none. Empty if the film has no such pass.
    "emitter_groups": np.dtype(np.int64),
    "instance_groups": np.dtype(np.int64),
    "emitter_passes": np.dtype(np.int64),
    "aov_places": np.dtype(np.int64),
    "film_mattes": np.dtype(np.float64),
    "matte_places": np.dtype(np.int64),  # of objects, materials and assets
    "instance_mattes": INSTANCE_MATTE,
    "material_mattes": np.dtype(np.float64),
    "output_code": np.dtype(np.int64),
    **VECTOR_TABLES,
}
SCALARS = [
    ("outputs", np.int64),
    ("light_columns", np.int64),
    ("data_columns", np.int64),
    ("matte_kinds", np.int64),
    ("matte_slots", np.int64),
    ("caught_light", np.int64),  # column of the light of paths that have hit a shadow catcher
    ("uv_attribute", np.int64),
    ("occlusion_distance", np.float64),
    ("background_moves", np.int64),
    ("mist_start", np.float64),
    ("mist_inverse_depth", np.float64),
    ("mist_power", np.float64),
]
WORKSPACE_TABLES = {"first_scatterings": FIRST_SCATTERING, "output_sums": np.dtype(np.float64), "matte_hits": MATTE_HIT}

film_light_table = table("film_light", np.float64)
film_data_table = table("film_data", np.float64)
light_place_table = table("light_places", np.int64)
data_place_table = table("data_places", np.int64)
data_number_table = table("data_numbers", np.int64)
emitter_group_table = table("emitter_groups", np.int64)
instance_group_table = table("instance_groups", np.int64)
emitter_pass_table = table("emitter_passes", np.int64)
aov_place_table = table("aov_places", np.int64)
film_matte_table = table("film_mattes", np.float64)
matte_place_table = table("matte_places", np.int64)
instance_matte_table = table("instance_mattes", INSTANCE_MATTE)
material_matte_table = table("material_mattes", np.float64)
matte_hit_table = table("matte_hits", MATTE_HIT)
code_table = table("output_code", np.int64)
first_scattering_table = table("first_scatterings", FIRST_SCATTERING)
output_sum_table = table("output_sums", np.float64)
vector_camera_table = table("vector_cameras", CAMERA)
vector_instance_table = table("vector_instances", VECTOR_INSTANCE)
shift_table = table("vector_shifts", SHIFT)
