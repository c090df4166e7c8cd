# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the Add menu of a node tree lists."""

from __future__ import annotations

from ...sdf.catalogue import category
from ...sdf.functions import COLOURS, DATA_WORDS, MATHEMATICS, POINTS
from ...sdf.shapes import SHAPES
from . import emission_nodes, scene, value_nodes
from .function_nodes import FUNCTION_NODES

# Of nodes by their menu: headers that Blender's default theme has for such nodes.
_HEADERS = {
    "Input": (0.51, 0.19, 0.29),
    "Shapes": (0.11, 0.45, 0.37),
    DATA_WORDS: (0.11, 0.45, 0.37),
    "Solids from Profiles": (0.11, 0.45, 0.37),
    "Profiles": (0.11, 0.45, 0.37),
    "Combine": (0.17, 0.40, 0.17),
    "Operators": (0.17, 0.40, 0.17),
    "Transforms": (0.24, 0.24, 0.51),
    "Points": (0.24, 0.24, 0.51),
    "Fields": (0.47, 0.27, 0.11),
    "Math": (0.14, 0.38, 0.51),
    "Emission": (0.43, 0.43, 0.11),
}
_BODY, _SHARE = 0.19, 0.5  # grey of Blender's nodes, and how much of the header is in a tint


def _menu_of(node: type) -> str:
    function = node.function
    shape = SHAPES.get(function.name) if function.makes_shape else None
    if shape is not None:
        kind = "Combine" if function.variadic else "Operators" if function.group == "Operators" else "Shapes"
        return f"{kind}/{category(shape)}"
    if function.group in ("Fields", MATHEMATICS, POINTS, COLOURS):
        return {"Fields": "Fields", MATHEMATICS: "Math", POINTS: "Points", COLOURS: "Emission"}[function.group]
    return function.group


def nodes_by_menu() -> dict[str, list[type]]:
    """Nodes of the Add menu, by menu; a name with a stroke is a submenu."""
    found: dict[str, list[type]] = {
        "Input": [
            value_nodes.SDFLIGHTS_Node_parameter,
            value_nodes.SDFLIGHTS_Node_number,
            value_nodes.SDFLIGHTS_Node_vector,
            value_nodes.SDFLIGHTS_Node_position,
            scene.SDFLIGHTS_Node_expression,
        ],
        "Output": [scene.SDFLIGHTS_Node_output],
    }
    for node in FUNCTION_NODES.values():
        found.setdefault(_menu_of(node), []).append(node)
    found["Transforms"][:0] = [scene.SDFLIGHTS_Node_object, scene.SDFLIGHTS_Node_place]
    found["Emission"][:0] = emission_nodes.CLASSES
    found["Fields"][:0] = [value_nodes.SDFLIGHTS_Node_distance, value_nodes.SDFLIGHTS_Node_field]
    found["Math"][:0] = [
        value_nodes.SDFLIGHTS_Node_math,
        value_nodes.SDFLIGHTS_Node_compare,
        value_nodes.SDFLIGHTS_Node_boolean,
        value_nodes.SDFLIGHTS_Node_combine,
        value_nodes.SDFLIGHTS_Node_separate,
    ]
    return found


def node_classes() -> list[type]:
    """All nodes of the Add menu, but groups."""
    return [node for nodes in nodes_by_menu().values() for node in nodes]


def _tint() -> None:
    for menu, nodes in nodes_by_menu().items():
        header = _HEADERS.get(menu.partition("/")[0])
        for node in nodes if header is not None else ():
            node.tint = tuple(_BODY + _SHARE * (component - _BODY) for component in header)


_tint()
