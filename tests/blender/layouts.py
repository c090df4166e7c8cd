# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a panel draws, for tests."""

import types


class Layout:
    """Takes what a panel draws, as Blender's layout does, and lists the text and the properties."""

    def __init__(self, drawn: list):
        self.drawn = drawn

    def __getattr__(self, name):
        if name in ("column", "row", "box"):
            return lambda **_: self
        if name == "prop":
            return lambda owner, path, **options: self.drawn.append(("prop", path, options.get("text")))
        if name == "label":
            return lambda text="", icon="NONE": self.drawn.append(("label", text, icon))

        def take(*arguments, **_):
            self.drawn.append((name, *arguments))
            return types.SimpleNamespace()

        return take
