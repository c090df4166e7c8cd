# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sentences about parts of the scene that are not rendered as the scene says, grouped by subject.

Each sentence begins with the kind of its subject: "Material 'Wood': node …".
"""

from __future__ import annotations

import re

_GROUPS = {
    "Scene": ("Scene",),
    "View Layers": ("View layer",),
    "Camera": ("Camera",),
    "World": ("World",),
    "Lights": ("Light", "Lamp", "Area light", "The SDF lamp"),
    "Objects": ("Object", "Mesh"),
    "Materials": ("Material",),
    "Images": ("Image",),
}
_OTHERS = "Others"


def group_of(sentence: str) -> str:
    """Title of the group of a sentence."""
    for title, words in _GROUPS.items():
        if re.match(rf"(?:{'|'.join(words)}) ['“\"]", sentence):
            return title
    return _OTHERS


def grouped(sentences: list[str]) -> dict[str, list[str]]:
    """Sentences by the titles of their groups, in the order of the groups. Sentences about one subject stand
    together."""
    found: dict[str, list[str]] = {title: [] for title in (*_GROUPS, _OTHERS)}
    for sentence in sentences:
        found[group_of(sentence)].append(sentence)
    return {title: sorted(items, key=_subject) for title, items in found.items() if items}


def in_order(sentences: list[str]) -> list[str]:
    """The sentences, by group."""
    return [sentence for items in grouped(sentences).values() for sentence in items]


def _subject(sentence: str) -> str:
    return sentence.partition(":")[0]


def failure(count: int) -> str:
    """The last sentence of a strict render."""
    things = "1 item is" if count == 1 else f"{count} items are"
    return f"{things} not rendered as the scene says, and --sdf-strict forbids this: see the warnings above."
