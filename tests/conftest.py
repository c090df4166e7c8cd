# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What every test has: the repository on the import path and a folder for compiled kernels that stays between runs."""

import os
import pathlib
import sys

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]

if str(REPOSITORY) not in sys.path:
    sys.path.insert(0, str(REPOSITORY))

# Kernels compiled by the tests stay in the checkout: a run never sees, or fills, the user's own cache.
os.environ.setdefault("SDF_LIGHTS_CACHE", str(REPOSITORY / "build" / "kernels"))
