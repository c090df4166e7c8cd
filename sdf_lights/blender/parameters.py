# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Parameters of an expression, a node tree or an emission, as custom properties of the Light.

Only custom properties can get limits, defaults and descriptions while Blender runs. They are saved, undone, animated,
driven and overridden like all others. Their names begin with ``PREFIX``, which separates them from the user's own.

A property is made when an expression is set. If a text block has changed, it is made when a panel is drawn next.
Rendering does not need it: without it the parameter has its default. A parameter that is no longer declared keeps its
value until the user removes it, so a restored line finds it again.
"""

from __future__ import annotations

import functools
import math

import bpy

from ..sdf.expression import Declaration, Expression
from ..sdf.syntax import ExpressionError
from . import emission, sources
from .nodes.reading import declarations_of, has_emission, texts_in, things_in

PREFIX = "sdf_"


def overridable(annotations: dict) -> dict:
    """Properties of a group that library overrides may change."""
    return {
        name: made.function(**made.keywords | {"override": {"LIBRARY_OVERRIDABLE"}})
        for name, made in annotations.items()
    }


def new_text(title: str, text: str) -> bpy.types.Text:
    """A text block for a lamp. Files drop it when no lamp uses it any more. Blender keeps its own text blocks for
    ever."""
    made = bpy.data.texts.new(title)
    made.write(text)
    made.use_fake_user = False
    return made


def text_of(lamp) -> str:
    """Text of a lamp's expression: that of its text block, if there is one."""
    return lamp.text.as_string() if lamp.text is not None else lamp.expression


@functools.lru_cache(maxsize=64)
def parsed(text: str) -> Expression | ExpressionError:
    """The expression, or its error. Cached, because panels ask at every redraw."""
    try:
        return Expression(text)
    except ExpressionError as error:
        return error


def declarations(lamp) -> tuple[Declaration, ...]:
    """The parameters that the lamp's expression or nodes declare; none if the expression has a mistake."""
    if lamp.source == "NODES":
        return declarations_of(lamp.nodes)
    expression = parsed(text_of(lamp)) if lamp.source == "EXPRESSION" else None
    return expression.parameters if isinstance(expression, Expression) else ()


def emission_is_in_nodes(lamp) -> bool:
    """Whether the lamp's node tree also defines its emission. Then the pattern of the panel is not used."""
    return lamp.source == "NODES" and has_emission(lamp.nodes)


def all_declarations(lamp) -> tuple[Declaration, ...]:
    """The parameters of the shape, and those of a separate emission."""
    if emission_is_in_nodes(lamp):
        return declarations(lamp)
    return (*declarations(lamp), *emission.declarations(lamp.emission))


def path(declaration: Declaration) -> str:
    """RNA path of the property, from the Light."""
    return f'["{PREFIX}{declaration.name}"]'


def exists(light: bpy.types.Light, declaration: Declaration) -> bool:
    """Whether the light has the property of a declared parameter."""
    return PREFIX + declaration.name in light.keys()


def values(lamp) -> dict[str, float | tuple[float, ...]]:
    """Values of the shape's parameters that have a property, as ``Expression.shape`` takes them."""
    return values_of(lamp.id_data, declarations(lamp))


def values_of(light: bpy.types.Light, declared: tuple[Declaration, ...]) -> dict[str, float | tuple[float, ...]]:
    """Values of the declared parameters that have a property, by name."""
    found = {}
    for declaration in declared:
        value = light.get(PREFIX + declaration.name)
        try:
            found[declaration.name] = declaration.held(math.degrees(value) if declaration.kind == "angle" else value)
        except (TypeError, ValueError, OverflowError):
            pass  # missing, or of another kind: scripts can store anything there
    return found


def missing(lamp) -> bool:
    """Whether ``update`` has something to do."""
    return lamp.id_data.is_editable and (
        any(_differs(lamp.id_data, declared) for declared in all_declarations(lamp))
        or sources.is_behind(lamp, data_of(lamp))
    )


def data_of(lamp) -> frozenset[tuple[str, str]]:
    """Kinds and names of data in the texts of a lamp."""
    texts = [parsed(text_of(lamp))] if lamp.source == "EXPRESSION" else []
    if not emission_is_in_nodes(lamp):
        texts.append(emission.parsed(emission.text_of(lamp.emission)))
    found = frozenset().union(*(text.data for text in texts if not isinstance(text, ExpressionError)))
    return found | texts_in(lamp.nodes) if lamp.source == "NODES" else found


def things_of(light: bpy.types.Light) -> set[bpy.types.ID]:
    """Objects and images that the shape or the emission of a lamp is made of."""
    lamp = light.sdf_lamp
    found: set[bpy.types.ID | None] = set()
    if lamp.source == "OBJECT":
        found.add(lamp.object)
    elif lamp.source == "IMAGE":
        found.add(lamp.image)
    elif lamp.source == "NODES":
        found.update(things_in(lamp.nodes))
    resolver = sources.FileResolver(lamp)
    found.update(resolver.thing(kind, name) for kind, name in data_of(lamp))
    return found - {None}


def pin(light: bpy.types.Light) -> None:
    """Lets a lamp hold on to the data that its texts name."""
    if light.is_editable:
        sources.pin(light.sdf_lamp, data_of(light.sdf_lamp))


def unused(light: bpy.types.Light) -> list[str]:
    """Names of properties that are no longer declared. Empty while one of the texts has a mistake."""
    lamp = light.sdf_lamp
    if lamp.source == "EXPRESSION" and isinstance(parsed(text_of(lamp)), ExpressionError):
        return []
    if isinstance(emission.parsed(emission.text_of(lamp.emission)), ExpressionError):
        return []
    declared = {PREFIX + declaration.name for declaration in all_declarations(lamp)}
    return [key for key in light.keys() if key.startswith(PREFIX) and key not in declared and key not in _OWN]


def remove_unused(light: bpy.types.Light) -> None:
    """Remove the properties that ``unused`` lists."""
    for key in unused(light):
        del light[key]
    light.update_tag()


# Properties of the add-on itself: up to Blender 4.5 they are listed among the custom ones.
_OWN = frozenset({"sdf_lamp"})


def update(light: bpy.types.Light) -> None:
    """Make the properties of all declared parameters, with their limits."""
    if not light.is_editable:
        return
    pin(light)
    declared = all_declarations(light.sdf_lamp)
    held = values_of(light, declared)
    for declaration in declared:
        if _differs(light, declaration):
            _make(light, declaration, held.get(declaration.name, declaration.default))


def _stored(declaration: Declaration, value):
    """A value as the property stores it: angles in radians, which Blender shows in degrees."""
    if declaration.kind == "vector":
        return [float(component) for component in value]
    kind = {"integer": int, "toggle": bool, "angle": math.radians}.get(declaration.kind, float)
    return kind(value)


def is_temperature(declaration: Declaration) -> bool:
    """Whether the description of a parameter says that it is in kelvins."""
    return declaration.kind == "slider" and declaration.description.rstrip(" .").endswith("in kelvins")


def label_of(declaration: Declaration) -> str:
    """Name of a parameter in panels."""
    label = declaration.name.removeprefix(emission.PREFIX).replace("_", " ").title()
    return f"{label} Temperature" if is_temperature(declaration) and "Temp" not in label else label


def _ui(declaration: Declaration) -> dict:
    """The user interface data of the property."""
    about = {"description": declaration.description, "subtype": "NONE"}
    if declaration.kind == "toggle":
        return about | {"default": bool(declaration.default)}
    low, high = (
        _stored(declaration, (limit,) * 3 if declaration.kind == "vector" else limit)
        for limit in (declaration.minimum, declaration.maximum)
    )
    if declaration.kind == "vector":
        low, high, about["subtype"] = low[0], high[0], "XYZ"
    if declaration.kind == "angle":
        about["subtype"] = "ANGLE"
    elif is_temperature(declaration):
        about["subtype"] = "COLOR_TEMPERATURE"
    return about | {
        "default": _stored(declaration, declaration.default),
        "min": low,
        "max": high,
        "soft_min": low,
        "soft_max": high,
    }


def _differs(light: bpy.types.Light, declaration: Declaration) -> bool:
    if not exists(light, declaration) or _is_other_kind(light, declaration):
        return True
    ui = light.id_properties_ui(PREFIX + declaration.name).as_dict()
    return any(ui.get(name, "") != value for name, value in _ui(declaration).items())


def _is_other_kind(light: bpy.types.Light, declaration: Declaration) -> bool:
    stored, wanted = light[PREFIX + declaration.name], _stored(declaration, declaration.default)
    if isinstance(wanted, list):
        return not hasattr(stored, "to_list") or len(stored) != len(wanted) or stored.typecode != "d"
    return type(stored) is not type(wanted)


def _make(light: bpy.types.Light, declaration: Declaration, value) -> None:
    key = PREFIX + declaration.name
    if exists(light, declaration) and _is_other_kind(light, declaration):
        del light[key]  # a property keeps its type
    light[key] = _stored(declaration, value)
    light.id_properties_ui(key).update(**_ui(declaration))
    light.property_overridable_library_set(f'["{key}"]', True)
    light.update_tag()


_pending: set[str] = set()


def update_soon(light: bpy.types.Light) -> None:
    """Call ``update`` as soon as Blender is not drawing. Drawing may not change data."""
    if not _pending:
        bpy.app.timers.register(_update_pending, first_interval=0.0)
    _pending.add(light.name_full)


def _update_pending() -> None:
    for light in bpy.data.lights:
        if light.name_full in _pending:
            update(light)
    _pending.clear()
