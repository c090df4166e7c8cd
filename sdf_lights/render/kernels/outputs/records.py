# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the passes of this folder need of a scene, of a film and of a thread.

``outputs`` of the block has a bit for each kind of pass that the film has. The sums of a sample are ``output_sums``: those of
light before its path divides, those of light after that, each ``light_columns`` long, and those of data.
"""

import numpy as np

from ....jit import table
from ...passes import DATA_SUMS, LIGHT_SUMS

LIGHT, LOBES, DATA = 1, 2, 4  # bits of ``outputs``

# How the first scattering of a path divides its light: the parts of diffuse and of glossy lobes, the rest being that of
# transmission; 1 where a medium has scattered it.
FIRST_SCATTERING = np.dtype([("diffuse", "f8", 3), ("glossy", "f8", 3), ("in_medium", "i8")], align=True)

# A column of light or data by the index of its name; −1: the film has it not.
LIGHT_NAMES = {name: index for index, name in enumerate(LIGHT_SUMS)}
DATA_NAMES = {name: index for index, name in enumerate(DATA_SUMS)}

TABLES = {
    "film_light": np.dtype(np.float64),
    "film_data": np.dtype(np.float64),
    "light_places": np.dtype(np.int64),
    "data_places": np.dtype(np.int64),
    "data_numbers": np.dtype(np.int64),  # of each column of data: 1 where it is of the first sample alone
    "output_code": np.dtype(np.int64),
}
SCALARS = [
    ("outputs", np.int64),
    ("light_columns", np.int64),
    ("data_columns", np.int64),
    ("uv_attribute", np.int64),
    ("mist_start", np.float64),
    ("mist_inverse_depth", np.float64),
    ("mist_power", np.float64),
]
WORKSPACE_TABLES = {"first_scatterings": FIRST_SCATTERING, "output_sums": np.dtype(np.float64)}

film_light_table = table("film_light", np.float64)
film_data_table = table("film_data", np.float64)
light_place_table = table("light_places", np.int64)
data_place_table = table("data_places", np.int64)
data_number_table = table("data_numbers", np.int64)
code_table = table("output_code", np.int64)
first_scattering_table = table("first_scatterings", FIRST_SCATTERING)
output_sum_table = table("output_sums", np.float64)
