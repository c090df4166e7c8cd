# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes screenshots of the documents again, in a Blender with a window.

    SDF_LIGHTS_BLENDER="xvfb-run -a blender" scripts/artist_screenshots [SESSION …]

Needs ImageMagick's `import`.
"""

from __future__ import annotations

import argparse
import pathlib
import shutil
import sys
import tempfile

from host import NO_WINDOW, REPOSITORY, windowed_blender
from sessions import seen_by

PICTURES = {  # of a session: files in docs/images by the picture's name
    "screenshots": {
        "sidebar": "lamp_sidebar",
        "mistake": "lamp_mistake",
        "error": "lamp_error",
        "nodes": "lamp_nodes",
        "nodes_mistake": "lamp_nodes_mistake",
        "solid": "viewport_solid",
        "rendered": "viewport_rendered",
    },
    "nodes": {"node_emission": "lamp_nodes_emission"},  # these three are sessions of the tests
    "panels": {"preset_browser": "lamp_presets"},
    "native": {"arrow_label": "lamp_arrow", "last_good": "lamp_last_good", "warnings": "lamp_warnings"},
}


def main(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="artist_screenshots", description=__doc__.splitlines()[0])
    parser.add_argument("sessions", nargs="*", metavar="SESSION", help=f"of {', '.join(PICTURES)}; default: all")
    options = parser.parse_args(arguments)
    command = windowed_blender()
    if command is None:
        parser.error(NO_WINDOW)
    for name in options.sessions or PICTURES:
        if name not in PICTURES:
            parser.error(f"there is no session {name!r}: choose from {', '.join(PICTURES)}")
        with tempfile.TemporaryDirectory() as folder:
            session = next(REPOSITORY.glob(f"*/**/{name}_session.py"))
            seen_by(command, session, pathlib.Path(folder), folder)
            for picture, file in PICTURES[name].items():
                shutil.copyfile(pathlib.Path(folder) / f"{picture}.png", REPOSITORY / "docs" / "images" / f"{file}.png")


if __name__ == "__main__":
    main(sys.argv[1:])
