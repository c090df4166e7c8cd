# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of the parts of a benchmark, kept on disk until all of them are there: an interrupted run continues."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterable
from typing import TypeVar

import host

from . import references
from .progress import Progress

T = TypeVar("T")


def _sources() -> bytes:
    """Hash of the code that a result depends on."""
    digest = hashlib.sha256()
    for folder in ("sdf_lights", "scripts"):
        for path in sorted((host.REPOSITORY / folder).rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.digest()


class Parts:
    """Results by the name of a part, of one benchmark with the same ``options`` and the same code."""

    def __init__(self, options):
        # Options that change the measurement, not its output files.
        given = {
            name: value for name, value in vars(options).items() if name not in ("json", "out", "modules", "defaults")
        }
        key = hashlib.sha256(repr(sorted(given.items())).encode() + _sources()).hexdigest()
        self._path = references.folder() / f"unfinished-{key[:16]}.json"
        self._found = json.loads(self._path.read_text(encoding="utf-8")) if self._path.is_file() else {}

    def of(self, name: str, measure):
        """The result of a part, from the cache or measured by a function without arguments."""
        if name not in self._found:
            self._found[name] = measure()
            part = self._path.with_suffix(".part")
            part.write_text(json.dumps(self._found), encoding="utf-8")
            os.replace(part, self._path)
        return self._found[name]

    def finish(self) -> None:
        """All parts are there: the next run measures again."""
        self._path.unlink(missing_ok=True)


def in_parts(names: Iterable, measure: Callable[..., T], options) -> list[T]:
    """Results of ``measure(name)``, with a bar of the progress. A name may be a tuple of arguments.

    An interrupted run continues where it was: see ``Parts``.
    """
    rows = [name if isinstance(name, tuple) else (name,) for name in names]
    progress, parts, found = Progress(max(len(rows), 1)), Parts(options), []
    for row in rows:
        text = " ".join(str(item) for item in row if isinstance(item, (str, int)))
        progress.show(text)
        found.append(parts.of(text, lambda row=row: measure(*row)))
        progress.step()
    parts.finish()
    progress.close()
    return found
