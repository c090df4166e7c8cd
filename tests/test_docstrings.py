# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Public functions, classes and methods say what they are, but for those of ``blender/``, whose names and calls are Blender's."""

import importlib
import inspect
import pathlib

import pytest

PACKAGE = pathlib.Path(__file__).resolve().parents[1] / "sdf_lights"
PUBLIC = sorted(
    path
    for pattern in ("*.py", "graph/*.py", "sdf/**/*.py", "emitter/**/*.py", "render/**/*.py")
    for path in PACKAGE.glob(pattern)
)


def undocumented(module) -> list[str]:
    """Names without a docstring. A method may inherit it, and a property that of the attribute it stands for."""
    found = []
    for name, value in vars(module).items():
        function = inspect.unwrap(getattr(value, "py_func", value)) if callable(value) else None
        if function is None or name.startswith("_") or getattr(function, "__module__", None) != module.__name__:
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
