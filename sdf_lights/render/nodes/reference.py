# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of all value nodes: ``python -m sdf_lights.render.nodes.reference`` prints it as Markdown."""

from __future__ import annotations

import inspect
import re

from . import DEFINITIONS
from .definition import MODES

# Names in Blender's menus that do not follow from the identifier.
_NAMES = {
    "BrightContrast": "Brightness/Contrast",
    "CombineHSV": "Combine HSV (Legacy)",
    "CombineRGB": "Combine RGB (Legacy)",
    "HairInfo": "Curves Info",
    "HueSaturation": "Hue/Saturation/Value",
    "InputBool": "Boolean",
    "InputInt": "Integer",
    "InputSceneTime": "Scene Time",
    "InputVector": "Vector",
    "Invert": "Invert Color",
    "MixRGB": "Mix (Legacy)",
    "NewGeometry": "Geometry",
    "RGB": "Color",
    "RGBCurve": "RGB Curves",
    "RGBToBW": "RGB to BW",
    "SeparateHSV": "Separate HSV (Legacy)",
    "SeparateRGB": "Separate RGB (Legacy)",
    "Squeeze": "Squeeze Value (Legacy)",
    "TexCoord": "Texture Coordinate",
    "TexPointDensity": "Point Density",
    "UVMap": "UV Map",
    "ValToRGB": "Color Ramp",
    "VectorCurve": "Vector Curves",
    "VertexColor": "Color Attribute",
}


def name_of(node: str) -> str:
    """The name that Blender shows for a bl_idname."""
    short = re.sub(r"^(Shader|Function|Geometry)Node", "", node)
    if short in _NAMES:
        return _NAMES[short]
    texture = short.startswith("Tex")
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", short.removeprefix("Tex") if texture else short)
    return f"{spaced} Texture" if texture else spaced


def rows() -> list[tuple[str, str, str]]:
    """(name, modes, remark) of each node, by name."""
    return sorted(
        (
            name_of(node),
            ", ".join(MODES[node]).replace("_", " ").lower(),
            " ".join((inspect.getdoc(definition) or "").split()),
        )
        for node, definition in DEFINITIONS.items()
    )


def markdown() -> str:
    """The table of nodes for docs/materials.md."""
    return "\n".join(["| node | modes | |", "|---|---|---|", *(f"| {' | '.join(row)} |" for row in rows())])


if __name__ == "__main__":
    print(markdown())
