# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the fixture ``blender_command`` runs in a Blender with a window, but without the window: kernels are
compiled."""

import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from sdf_lights.render.cpu import background

background.start(low=False)
while background.running():
    time.sleep(0.2)
