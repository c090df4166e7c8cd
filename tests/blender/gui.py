# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs a session (see window.py) in a Blender with a window, for tests and scripts."""

import json
import pathlib
import subprocess


def seen_by(command: list[str], session: pathlib.Path, folder: pathlib.Path, pictures: bool = False) -> dict:
    """The report of a session, which must end without an error; its files, and pictures, go into the folder."""
    path = folder / "report.json"
    done = subprocess.run(
        [*command, "--factory-startup", "--enable-event-simulate", "--window-geometry", "0", "0", "1240", "960",
         "--python", str(session), "--", str(path), *([str(folder)] if pictures else [])],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=900)
    assert path.is_file(), f"Blender ended with code {done.returncode}:\n{done.stdout}"
    found = json.loads(path.read_text(encoding="utf-8"))
    assert "error" not in found, found["error"] + done.stdout
    assert "Traceback" not in done.stdout, done.stdout
    return found
