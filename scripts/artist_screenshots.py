# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes the screenshots of docs/lamps.md again: runs the tests' sessions in a Blender with a window.

    SDF_LIGHTS_BLENDER="xvfb-run -a blender" scripts/artist_screenshots [SESSION …]

Needs ImageMagick's `import`.
"""

from __future__ import annotations

import argparse
import os
import pathlib
import shlex
import shutil
import sys
import tempfile

REPOSITORY = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(REPOSITORY))

from tests.blender.gui import seen_by  # noqa: E402  (found on the path set above)

PICTURES = {  # of a session: files in docs/images by the picture's name
    "nodes": {"node_emission": "lamp_nodes_emission"},
    "panels": {"preset_browser": "lamp_presets", "expression_error": "lamp_error"}}


def main(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="artist_screenshots", description=__doc__.splitlines()[0])
    parser.add_argument("sessions", nargs="*", metavar="SESSION", help=f"of {', '.join(PICTURES)}; default: all")
    options = parser.parse_args(arguments)
    command = shlex.split(os.environ.get("SDF_LIGHTS_BLENDER", "blender"))
    for name in options.sessions or PICTURES:
        if name not in PICTURES:
            parser.error(f"there is no session {name!r}: choose from {', '.join(PICTURES)}")
        with tempfile.TemporaryDirectory() as folder:
            seen_by(command, REPOSITORY / "tests" / "blender" / f"{name}_session.py", pathlib.Path(folder), pictures=True)
            for picture, file in PICTURES[name].items():
                shutil.copyfile(pathlib.Path(folder) / f"{picture}.png", REPOSITORY / "docs" / "images" / f"{file}.png")


if __name__ == "__main__":
    main(sys.argv[1:])
