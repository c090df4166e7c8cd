# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The source of the report's images, stored in them as PNG text: a result and the hash of its numbers.

Plots are drawn from a result alone. Pictures are drawn from renders that are too large to be kept with it. They count
as those of a result if it has the hash of these renders.
"""

from __future__ import annotations

import pathlib
import struct
from collections.abc import Iterator

from .results import Result

KEY = "Result"
SIGNATURE = b"\x89PNG\r\n\x1a\n"


def _chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Type and content of each chunk of a PNG file (W3C, Portable Network Graphics, section 5.3)."""
    place = len(SIGNATURE)
    while place < len(data):
        size, kind = struct.unpack_from(">I4s", data, place)
        yield kind, data[place + 8 : place + 8 + size]
        place += size + 12


def of(result: Result) -> str:
    """The record of an image drawn from a result."""
    return f"{result.name} {result.digest}"


def read(image: pathlib.Path) -> str | None:
    """The record in an image, or None."""
    data = image.read_bytes()
    if not data.startswith(SIGNATURE):
        raise ValueError(f"{image} is no PNG file")
    for kind, content in _chunks(data):
        key, _, text = content.partition(b"\0")
        if kind == b"tEXt" and key == KEY.encode("latin-1"):
            return text.decode("latin-1")
    return None


def compared(results: dict[str, Result], images: pathlib.Path) -> tuple[list[str], list[str]]:
    """Names of the report's images without a record, and of those with a different one."""
    known = {of(result) for result in results.values()}
    said = {path.name: read(path) for path in sorted(images.glob("report_*.png"))}
    return (
        [name for name, text in said.items() if text is None],
        [name for name, text in said.items() if text is not None and text not in known],
    )
