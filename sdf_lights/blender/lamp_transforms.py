# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Apply Scale and Origin to Geometry for lamps, whose data are numbers and text instead of vertices.

Blender's own operators skip lights silently, and Blender refuses add-on operators of the same name. So these operators
stand beside them in the same menus. The effect of changed numbers is tested, not derived: a change is accepted if the
lamp is the same as before at a few thousand points.
"""

from __future__ import annotations

import ast
import itertools
from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

import bpy
import numpy as np
from mathutils import Matrix

from ..render.errors import RenderError
from ..sdf.emission import Emission
from ..sdf.shapes import Shape
from ..sdf.syntax import ExpressionError, parse
from . import emission, parameters
from .lamp import pattern_of, shape_of
from .nodes import editor, reading
from .properties import OF_DATA, PRIMITIVES, values_of
from .sources import FileResolver

_MOST_TRIED = 600  # combinations of factors
_POINTS, _FEW = 3000, 100
_BESIDE = 0.02  # of the shape's size: distance from the surface at which both are compared
_DIFFERENT = 0.002  # fraction of the points that marks a different shape


class _Numbers(NamedTuple):
    """Numbers of a lamp that may be lengths. ``certain``: all of them are lengths. ``make`` builds the shape or pattern
    from them."""

    values: dict[str, object]
    limits: Mapping[str, tuple[float, float]]
    certain: bool
    make: Callable[[dict], object]
    write: Callable[[dict], None]


# -- the same lamp -----------------------------------------------------------------------------------------------------


def _points(shape: Shape) -> np.ndarray:
    """Points (n, 3) beside the surface of a shape, in random order."""
    from .viewport.bodies import points_of

    found = points_of(shape)
    if not len(found):
        raise RenderError("Its shape cannot be measured.")
    random = np.random.default_rng(0)
    size = float((found.max(axis=0) - found.min(axis=0)).max())
    return found[random.integers(len(found), size=_POINTS)] + _BESIDE * size * random.normal(size=(_POINTS, 3))


def _is_same(old: np.ndarray, new: Shape, points: np.ndarray) -> bool:
    """Whether the inside of a shape agrees with ``old`` (n,) at points (n, 3)."""
    for part in (slice(0, _FEW), slice(None)):
        wrong = (new.distance(points[part]) <= 0.0) != old[part]
        if np.mean(wrong) > _DIFFERENT:
            return False
    return True


def _glow(pattern: Emission | None, shape: Shape, points: np.ndarray) -> np.ndarray:
    """Relative emission (n, 3) of a lamp."""
    return np.ones((len(points), 3)) if pattern is None else pattern.placed(shape).evaluate(points)


# -- scale -------------------------------------------------------------------------------------------------------------


def _choices(value, scale: np.ndarray, certain: bool) -> list:
    """Possible values of a number under a scale (3,)."""
    sizes = sorted(set(np.abs(scale).tolist()))
    if isinstance(value, tuple):
        return [tuple(np.abs(scale) * value)] + ([] if certain else [value])
    if certain:
        return [size * value for size in sizes]
    return [value, *(size * value for size in sizes), *(value / size for size in sizes)]


def _fitting(numbers: _Numbers, scale: np.ndarray) -> Iterator[dict]:
    """Possible numbers for the same shape under a scale."""
    choices = [_choices(value, scale, numbers.certain) for value in numbers.values.values()]
    # First try: all of them are lengths, if that is possible.
    order = sorted(
        itertools.islice(itertools.product(*(range(len(choice)) for choice in choices)), _MOST_TRIED),
        key=lambda picks: sum(pick != min(1, len(choice) - 1) for pick, choice in zip(picks, choices)),
    )
    for picks in order:
        found = {name: choice[pick] for name, choice, pick in zip(numbers.values, choices, picks)}
        if all(
            low <= component <= high
            for name, (low, high) in numbers.limits.items()
            for component in np.atleast_1d(found[name])
        ):
            yield found


def _numbers_of_shape(light: bpy.types.Light, matrix: np.ndarray) -> _Numbers:
    lamp = light.sdf_lamp
    if lamp.source == "PRIMITIVE":
        name = lamp.shape.lower()
        kind, group = PRIMITIVES[name], getattr(lamp, name)
        lengths = [about for about in kind.fields() if about.unit == "LENGTH"]
        values = values_of(group, name)

        def write(found):
            for key, value in found.items():
                setattr(group, key, value)

        return _Numbers(
            {about.name: values[about.name] for about in lengths},
            {about.name: (about.minimum, about.maximum) for about in lengths},
            True,
            lambda found: kind(**values | found),
            write,
        )
    if lamp.source == "NODES":
        return _declared(
            light, parameters.declarations(lamp), lambda values: reading.shape_of(lamp.nodes, values, matrix, lamp)
        )
    expression = parameters.parsed(parameters.text_of(lamp))
    return _declared(light, parameters.declarations(lamp), lambda values: expression.shape(values, FileResolver(lamp)))


def _declared(light: bpy.types.Light, declared, make, prefix: str = "") -> _Numbers:
    held = parameters.values_of(light, declared)
    values = {about.name: held.get(about.name, about.default) for about in declared}
    free = {about.name: about for about in declared if about.kind in ("slider", "vector")}

    def write(found):
        parameters.update(light)
        for name, value in found.items():
            light[parameters.PREFIX + name] = value

    return _Numbers(
        {name: values[name] for name in free},
        {name: (about.minimum, about.maximum) for name, about in free.items()},
        False,
        lambda found: make({name.removeprefix(prefix): value for name, value in (values | found).items()}),
        write,
    )


def apply_scale(obj: bpy.types.Object) -> None:
    """Apply the scale of the object to the sizes of the lamp's shape. Raises RenderError with the reason if that
    fails."""
    light, scale = obj.data, np.array(obj.scale)
    lamp = light.sdf_lamp
    if light.users > 1:
        raise RenderError(f"{light.users} objects share its data: make it single user first.")
    if not light.is_editable:
        raise RenderError("Its data are linked from another file: make a library override first.")
    if not np.all(np.abs(scale) > 1e-9):
        raise RenderError("It is scaled to zero.")
    if lamp.source in OF_DATA:
        cures = {"OBJECT": ": apply the scale there", "IMAGE": ": set its width", "NETWORK": ", which has one size"}
        raise RenderError(f"Its shape is that of {OF_DATA[lamp.source]}{cures[lamp.source]}.")
    matrix = np.array(obj.matrix_world)
    old, pattern = shape_of(lamp, matrix), pattern_of(lamp, matrix)
    points = _points(old)
    inside = old.distance(points) <= 0.0
    numbers = _numbers_of_shape(light, matrix)
    found = shape = None
    for found in _fitting(numbers, scale):
        try:
            shape = numbers.make(found)
            if not shape.validate() and _is_same(inside, shape, points * scale):
                break
        except (ArithmeticError, ExpressionError, RenderError, ValueError):
            pass
    else:
        raise RenderError(_why_not(lamp, old, scale, numbers))
    glow = _glow_under(light, pattern, old, shape, points[inside], scale)
    numbers.write(found)
    if glow is not None:
        glow[0].write(glow[1])
    _without_scale(obj)
    light.update_tag()


def _glow_under(light, pattern, old: Shape, new: Shape, points: np.ndarray, scale: np.ndarray):
    """The numbers of a pattern and their values under a scale; None if nothing changes. Raises RenderError."""
    wanted = _glow(pattern, old, points)

    def is_same(changed) -> bool:
        return bool(np.allclose(_glow(changed, new, points * scale), wanted, rtol=0.02, atol=0.01 * wanted.max()))

    if pattern is None or is_same(pattern):
        return None
    settings = light.sdf_lamp.emission
    parsed = emission.parsed(emission.text_of(settings))
    if not parameters.emission_is_in_nodes(light.sdf_lamp):
        numbers = _declared(
            light,
            emission.declarations(settings),
            lambda values: parsed.emission(values, FileResolver(light.sdf_lamp)),
            emission.PREFIX,
        )
        for found in _fitting(numbers, scale):
            if is_same(numbers.make(found)):
                return numbers, found
    raise RenderError(
        "Its pattern is measured along each axis or in metres, and no numbers adapt it to another scale: keep the "
        "scale."
    )


def _why_not(lamp, shape: Shape, scale: np.ndarray, numbers: _Numbers) -> str:
    if numbers.certain:
        if len(set(np.abs(scale).round(6))) > 1:
            return (
                f"A {shape.label()} has one size for directions that are scaled differently: scale all axes by the "
                "same factor, or keep the scale."
            )
        return f"The sizes of a {shape.label()} cannot be that large or small: keep the scale."
    where = "node tree" if lamp.source == "NODES" else "expression"
    return (
        f"Its {where} has sizes that are not parameters, or parameters with narrow limits: change them there, or keep "
        "the scale."
    )


def _without_scale(obj: bpy.types.Object) -> None:
    """Set the scale to one. Children keep their world position."""
    before = obj.matrix_basis.copy()
    obj.scale = (1.0, 1.0, 1.0)
    change = obj.matrix_basis.inverted() @ before
    for child in obj.children:
        child.matrix_parent_inverse = change @ child.matrix_parent_inverse


# -- origin ------------------------------------------------------------------------------------------------------------


def _moved(text: str, offset: np.ndarray) -> Iterator[str]:
    """Possible texts of the shape moved by ``offset``."""
    shift = "({})".format(", ".join(f"{component + 0.0:.6g}" for component in offset))
    body = parse(text).tree.body
    if body and isinstance(body[-1], ast.Expr):
        last, lines = body[-1].value, text.splitlines()
        before = "\n".join([*lines[: last.lineno - 1], lines[last.lineno - 1][: last.col_offset]])
        inside = "\n".join(lines[last.lineno - 1 : last.end_lineno])
        end = len(inside) - len(lines[last.end_lineno - 1]) + last.end_col_offset
        after = "\n".join([inside[end:], *lines[last.end_lineno :]])
        yield f"{before}translate({inside[last.col_offset : end]}, {shift}){after}"
    if "\n" in text.strip():
        yield f"p = p - {shift}\n{text}"


def origin_to_geometry(obj: bpy.types.Object) -> bool:
    """Move the origin of a lamp to the middle of its body, which stays in its place. Returns False if the origin is
    already there.

    Raises RenderError with the reason if that fails.
    """
    from .viewport.bodies import points_of

    light, matrix = obj.data, np.array(obj.matrix_world)
    lamp = light.sdf_lamp
    if light.users > 1:
        raise RenderError(f"{light.users} objects share its data: make it single user first.")
    if not light.is_editable:
        raise RenderError("Its data are linked from another file: make a library override first.")
    shape, pattern = shape_of(lamp, matrix), pattern_of(lamp, matrix)
    # Boxes of primitives are tight.
    box, near = (np.stack(shape.bounds()), 1e-4) if lamp.source == "PRIMITIVE" else (points_of(shape), 5e-3)
    if not len(box):
        raise RenderError("Its shape cannot be measured.")
    middle = 0.5 * (box.min(axis=0) + box.max(axis=0))
    if np.all(np.abs(middle) <= near * np.linalg.norm(box.max(axis=0) - box.min(axis=0))):
        return False
    if lamp.source == "NODES":
        raise RenderError("Its node tree sets the position of its parts: put a Translate node before Lamp Output.")
    points = _points(shape)
    inside, values = shape.distance(points) <= 0.0, parameters.values(lamp)
    written = editor.expression_of(light)
    for text in _moved(written, -middle):
        changed = parameters.parsed(text)
        if isinstance(changed, ExpressionError):
            continue
        moved = changed.shape(values, FileResolver(lamp))
        if _is_same(inside, moved, points - middle):
            break
    else:
        raise RenderError("Its text sets the position of its parts: move them there.")
    glow = _glow(pattern, shape, points[inside])
    if not np.allclose(_glow(pattern, moved, points[inside] - middle), glow, rtol=0.02, atol=0.01 * glow.max()):
        raise RenderError("Its pattern depends on the origin, so it would move: keep the origin.")
    if lamp.source == "PRIMITIVE" or lamp.text is not None or "\n" in text:
        lamp.text = parameters.new_text(light.name, text)
    else:
        lamp.expression = text
    lamp.source = "EXPRESSION"
    shift = Matrix.Translation(middle.tolist())
    obj.matrix_basis = obj.matrix_basis @ shift
    for child in obj.children:
        child.matrix_parent_inverse = shift.inverted() @ child.matrix_parent_inverse
    light.update_tag()
    return True


# -- operators ---------------------------------------------------------------------------------------------------------


class _LampsOperator:
    """An operator on the selected lamps. It reports for each lamp why it failed."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT" and any(map(_is_lamp, context.selected_objects))

    def execute(self, context):
        done = 0
        for obj in filter(_is_lamp, context.selected_objects):
            try:
                done += type(self).change(obj) is not False
            except RenderError as error:
                self.report({"ERROR"}, f"Lamp '{obj.name}' stays as it is. {error}")
        return {"FINISHED"} if done else {"CANCELLED"}


def _is_lamp(obj: bpy.types.Object) -> bool:
    return obj.type == "LIGHT" and obj.data.sdf_lamp.use


class SDFLIGHTS_OT_scale_apply(_LampsOperator, bpy.types.Operator):
    """Apply the scale of the selected lamps to the sizes of their shapes, and set the scale to 1"""

    bl_idname = "sdf_lights.scale_apply"
    bl_label = "Scale of SDF Lamps"
    change = staticmethod(apply_scale)


class SDFLIGHTS_OT_origin_to_geometry(_LampsOperator, bpy.types.Operator):
    """Move the origins of the selected lamps to the middle of their bodies"""

    bl_idname = "sdf_lights.origin_to_geometry"
    bl_label = "Origin of SDF Lamps to Geometry"
    change = staticmethod(origin_to_geometry)


def draw_apply(self, context):
    """Entry in Object > Apply, if lamps are selected."""
    if SDFLIGHTS_OT_scale_apply.poll(context):
        self.layout.separator()
        self.layout.operator(SDFLIGHTS_OT_scale_apply.bl_idname)


def draw_object(self, context):
    """Entry in Object, if lamps are selected."""
    if SDFLIGHTS_OT_origin_to_geometry.poll(context):
        self.layout.separator()
        self.layout.operator(SDFLIGHTS_OT_origin_to_geometry.bl_idname)


CLASSES = (SDFLIGHTS_OT_scale_apply, SDFLIGHTS_OT_origin_to_geometry)

_ENTRIES = ((bpy.types.VIEW3D_MT_object_apply, draw_apply), (bpy.types.VIEW3D_MT_object, draw_object))


def register():
    for menu, draw in _ENTRIES:
        menu.append(draw)


def unregister():
    for menu, draw in _ENTRIES:
        menu.remove(draw)
