# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs a session (see window.py) in a Blender with a window, for tests, benchmarks and pictures."""

from __future__ import annotations

import json
import os
import pathlib
import subprocess

PATIENCE = 1200.0  # seconds: kernels may have to be compiled


class SessionError(Exception):
    """The error of a session, with all output of Blender."""


def seen_by(
    command: list[str],
    session: pathlib.Path,
    folder: pathlib.Path,
    *arguments: str,
    size: tuple[int, int] = (1240, 960),
    real_keys: bool = False,
    environment: dict[str, str] | None = None,
) -> dict:
    """The report of a session, with the exit ``code`` of Blender and its output ``printed``.

    ``command`` opens a Blender with a window of this ``size`` in pixels. The session's arguments are the path of the
    report, which is in ``folder``, and then ``arguments``. Simulated events exclude real ones: ``real_keys`` is for a
    session without them. ``environment``: additional environment variables. Raises SessionError if the session did not
    finish, or an exception reached Blender.
    """
    path = folder / "report.json"
    events = [] if real_keys else ["--enable-event-simulate"]
    done = subprocess.run(
        [
            *command,
            "--factory-startup",
            *events,
            "--window-geometry",
            "0",
            "0",
            *map(str, size),
            "--python",
            str(session),
            "--",
            str(path),
            *arguments,
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=PATIENCE,
        env=os.environ | (environment or {}),
    )
    if not path.is_file():
        raise SessionError(f"Blender ended with code {done.returncode}:\n{done.stdout}")
    report = json.loads(path.read_text(encoding="utf-8"))
    if "traceback" in report or "Traceback" in done.stdout:
        raise SessionError(report.get("traceback", "") + done.stdout)
    return report | {"code": done.returncode, "printed": done.stdout}
