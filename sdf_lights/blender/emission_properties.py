# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""``Light.sdf_lamp.emission``: the brightness of a lamp at each point."""

import bpy

from ..sdf.emission_presets import presets
from . import parameters
from .emission import EXPRESSION


def source_items() -> list[tuple]:
    """Items of an EnumProperty: every preset, and the artist's own text. Files store the numbers, so presets keep their
    order."""
    items = []
    for number, (name, preset) in enumerate(presets().items(), 1):
        about = preset.text.splitlines()[1].removeprefix("#").strip().rstrip(".")
        items.append((name.upper(), preset.title, about, number))
    return [*items, (EXPRESSION, "Expression", "Your own text of a few lines", 0)]


def changed(self, context):
    """Make the properties of the parameters that the emission declares."""
    parameters.update(self.id_data)


class SDFLIGHTS_LampEmission(bpy.types.PropertyGroup):
    """The brightness of a lamp at each point"""

    __slots__ = ()
    __annotations__ = parameters.overridable(
        {
            "source": bpy.props.EnumProperty(
                name="Emission",
                description="Brightness at each point of the lamp",
                items=source_items(),
                default="UNIFORM",
                update=changed,
            ),
            "expression": bpy.props.StringProperty(
                name="Expression",
                description="Brightness or color as a formula of the point p, the depth below the surface "
                "and the height from 0 to 1, such as exp(-20 * depth) or blackbody(mix(4000, 1500, height))",
                default="exp(-20 * depth)",
                update=changed,
            ),
            "text": bpy.props.PointerProperty(
                name="Text",
                description="Text block with the expression, if it has several lines",
                type=bpy.types.Text,
                update=changed,
            ),
        }
    )
