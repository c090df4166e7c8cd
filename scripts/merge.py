# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Joins OpenEXR files of renders that shared the samples of a frame."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from sdf_lights.render.merge_files import main

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
