# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Public functions, classes and methods say what they are, the shapes of the arrays that they take, and their
errors."""

import ast
import importlib
import inspect
import pathlib
import re

import pytest

PACKAGE = pathlib.Path(__file__).resolve().parents[1] / "sdf_lights"
# Blender runs the files in ``presets/sdf_lights``; they define nothing.
PUBLIC = sorted(path for path in PACKAGE.rglob("*.py") if PACKAGE / "blender/presets/sdf_lights" not in path.parents)
# Methods of Blender's classes, which Blender documents.
BLENDERS = {
    "bpy.types": "cancel copy description draw draw_buttons draw_header draw_header_preset draw_label execute free init invoke "
    "modal poll render update update_render_passes valid_socket_type view_draw view_update",
    "gizmos": "draw_prepare draw_select refresh setup test_select",
    "this add-on's base classes": "draw_properties draw_settings register unregister",
}
OF_BLENDER = set(" ".join(BLENDERS.values()).split())
# The shape of an array, as (n, 3) or 4 × 4, or the docstring that has it.
SHAPE = re.compile(r"\([^()]*,[^()]*\)|\(…\)|\d\s*×\s*\d|(?:As|as|See|Replaces)\s(?:for\s|in\s)?``")
# Errors of expressions are documented once, by ``expression.Expression``; abstract methods raise none to callers.
EXPRESSION_ERRORS = {"self.error", "self.mismatch", "self.unknown", "Misuse", "ExpressionError", "NotImplementedError"}


def undocumented(module) -> list[str]:
    """Names without a docstring. A method may inherit it, and a property that of the attribute it stands for."""
    found = []
    for name, value in vars(module).items():
        function = inspect.unwrap(getattr(value, "py_func", value)) if callable(value) else None
        if function is None or name.startswith("_") or getattr(function, "__module__", None) != module.__name__:
            continue
        if name in OF_BLENDER and module.__name__.startswith("sdf_lights.blender"):
            continue
        if getattr(function, "__name__", name).startswith("_"):  # made of the functions that an interface documents
            continue
        if not inspect.getdoc(function):
            found.append(name)
        if inspect.isclass(value):
            found += [f"{name}.{member}" for member in undocumented_members(value)]
    return found


def undocumented_members(kind: type) -> list[str]:
    attributes = {name for base in kind.__mro__[1:] for name in getattr(base, "__annotations__", {})}
    return [
        name
        for name, member in vars(kind).items()
        if not name.startswith("_")
        and not (name in OF_BLENDER and kind.__module__.startswith("sdf_lights.blender"))
        and (inspect.isfunction(member) or isinstance(member, (property, classmethod, staticmethod)))
        and not inspect.getdoc(getattr(kind, name) if not isinstance(member, property) else member)
        and not any(inspect.getdoc(getattr(base, name, None)) for base in kind.__mro__[1:] if hasattr(base, name))
        and name not in attributes
    ]


@pytest.mark.parametrize("path", PUBLIC, ids=lambda path: path.relative_to(PACKAGE).as_posix())
def test_everything_public_has_a_docstring(path):
    name = ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__")
    assert undocumented(importlib.import_module(name)) == []


def test_what_lacks_one_is_found():
    module = type(pytest)("made_here")
    exec(
        "def told():\n    'What it does.'\ndef untold(): pass\nclass Kind:\n    'It.'\n    def way(self): pass",
        vars(module),
    )
    for name in ("told", "untold", "Kind"):
        vars(module)[name].__module__ = "made_here"
    assert undocumented(module) == ["untold", "Kind.way"]


def public_functions(source: str) -> list[ast.FunctionDef]:
    """Public functions and methods that have a docstring of their own. Others inherit one, or the tests above find
    them."""
    return [
        node
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_") and ast.get_docstring(node)
    ]


def without_shapes(source: str) -> list[str]:
    """Functions with an array among their arguments whose docstring has no shape."""
    return [
        node.name
        for node in public_functions(source)
        if any(
            argument.annotation and ast.unparse(argument.annotation).startswith("np.ndarray")
            for argument in [*node.args.args, *node.args.kwonlyargs]
        )
        and not SHAPE.search(ast.get_docstring(node))
    ]


def without_errors(source: str) -> list[str]:
    """Functions that raise errors of which their docstring does not tell."""
    found = []
    for node in public_functions(source):
        raised = {
            ast.unparse(item.exc.func if isinstance(item.exc, ast.Call) else item.exc)
            for item in ast.walk(node)
            if isinstance(item, ast.Raise) and item.exc is not None
        }
        # A name in lower case is an error that was caught.
        errors = {name for name in raised - EXPRESSION_ERRORS if not name[0].islower() or "." in name}
        if errors and not re.search(r"[Rr]aise|Error", ast.get_docstring(node)):
            found.append(node.name)
    return found


@pytest.mark.parametrize("path", PUBLIC, ids=lambda path: path.relative_to(PACKAGE).as_posix())
def test_docstrings_have_the_shapes_of_arrays_and_the_errors(path):
    source = path.read_text(encoding="utf-8")
    assert without_shapes(source) == []
    assert without_errors(source) == []


def test_missing_shapes_and_errors_are_found():
    source = """
def shaped(a: np.ndarray):
    'The sum of a (n, 3).'
def bare(a: np.ndarray | None):
    'The sum of a.'
def silent(a):
    'The sum.'
    raise ValueError(a)
def told(a):
    'The sum. Raises ValueError.'
    raise ValueError(a)
"""
    assert without_shapes(source) == ["bare"]
    assert without_errors(source) == ["silent"]
