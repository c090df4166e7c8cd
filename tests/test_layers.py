# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Who may import what, that no modules import each other in a circle, and what every source file starts with."""

import ast
import functools
import pathlib
import subprocess
import sys
import textwrap

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
PACKAGE = REPOSITORY / "sdf_lights"

# Each layer may import itself and those before it. Modules directly in the package belong to the first layer.
LAYERS = ("base", "graph", "sdf", "emitter", "render", "blender")
BLENDER_MODULES = {
    "bpy",
    "bpy_extras",
    "mathutils",
    "gpu",
    "gpu_extras",
    "bl_ui",
    "bl_operators",
    "bl_math",
    "blf",
    "bmesh",
    "addon_utils",
    "idprop",
    "nodeitems_utils",
}
# What a layer may use from outside: Python's own library aside.
LIBRARIES = {
    "base": {"numpy", "numba", "llvmlite"},
    "graph": {"numpy", "numba", "llvmlite"},
    "sdf": {"numpy"},
    "emitter": {"numpy", "numba"},
    "render": {"numpy", "numba", "moderngl", "OpenImageIO"},
    "blender": {"numpy", "OpenImageIO"} | BLENDER_MODULES,
}


def layer_of(path: pathlib.Path) -> str:
    parts = path.relative_to(PACKAGE).parts
    return parts[0] if len(parts) > 1 else "base"


def imports(path: pathlib.Path, source: str) -> list[tuple[str, int]]:
    """(what, line) for everything that ``source`` imports: a layer as ``layer:NAME``, else a top-level module."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found += [(alias.name.partition(".")[0], node.lineno) for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            found.append((node.module.partition(".")[0], node.lineno))
        elif isinstance(node, ast.ImportFrom):
            base = path.parents[node.level - 1].joinpath(*(node.module or "").split("."))
            for alias in node.names:
                target = base / alias.name if base.is_dir() else base
                if target == PACKAGE or PACKAGE not in target.parents:
                    found.append(("outside the package", node.lineno))
                else:
                    # A module directly in the package has no folder of its own.
                    first = target.relative_to(PACKAGE).parts[0]
                    found.append((f"layer:{first if (PACKAGE / first).is_dir() else 'base'}", node.lineno))
    return found


def violations(path: pathlib.Path, source: str) -> list[str]:
    layer = layer_of(path)
    allowed = {f"layer:{name}" for name in LAYERS[: LAYERS.index(layer) + 1]} | LIBRARIES[layer]
    place = path.relative_to(REPOSITORY).as_posix()
    return [
        f"{place}:{line} imports {what.removeprefix('layer:')}"
        for what, line in imports(path, source)
        if what not in allowed and what not in sys.stdlib_module_names
    ]


SOURCES = sorted(PACKAGE.rglob("*.py"))


def test_package_has_only_the_layers():
    folders = {path.name for path in PACKAGE.iterdir() if path.is_dir() and path.name != "__pycache__"}
    assert folders <= set(LAYERS)


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.relative_to(PACKAGE).as_posix())
def test_imports_only_its_own_layer_and_those_below(path):
    assert violations(path, path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    "line",
    [
        "import bpy",
        "from mathutils import Vector",
        "from ..blender import sync",
        "from .. import blender",
        "from ..render.scene import Scene",
        "import sdf_lights.vec",
        "from ... import something",
        "import scipy",
    ],
)
def test_a_wrong_import_is_found(line):
    """Also inside a function, where it would go unnoticed until the call."""
    source = f"def late():\n{textwrap.indent(line, '    ')}\n"
    assert violations(PACKAGE / "sdf" / "module.py", source)


def test_root_package_imports_nothing_at_module_level():
    tree = ast.parse((REPOSITORY / "__init__.py").read_text(encoding="utf-8"))
    assert [type(node).__name__ for node in tree.body if isinstance(node, (ast.Import, ast.ImportFrom))] == []
    assert {node.name for node in tree.body if isinstance(node, ast.FunctionDef)} >= {"register", "unregister"}


def test_everything_below_blender_imports_where_bpy_is_missing():
    modules = [
        ".".join(path.relative_to(REPOSITORY).with_suffix("").parts).removesuffix(".__init__")
        for path in SOURCES
        if layer_of(path) != "blender"
    ]
    code = f"""
        import importlib, sys
        sys.path.insert(0, {str(REPOSITORY)!r})
        for name in {sorted(BLENDER_MODULES)!r}:
            sys.modules[name] = None
        for name in {modules!r}:
            importlib.import_module(name)
    """
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr


# Folders beside the package, and what each may import of the others. ``scripts`` is on the import path itself.
BESIDE = {
    "support": {"sdf_lights", "support"},
    "scripts": {"sdf_lights", "support", "scripts"},
    "tests": {"sdf_lights", "support", "scripts", "tests"},
}


def module_of(path: pathlib.Path) -> str:
    """Full name of a source file, with the folder that it is in first."""
    parts = path.relative_to(REPOSITORY).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


ALL_SOURCES = SOURCES + sorted(path for folder in BESIDE for path in (REPOSITORY / folder).rglob("*.py"))
MODULES = {module_of(path): path for path in ALL_SOURCES}


def imported(path: pathlib.Path, source: str) -> set[str]:
    """Modules of the repository that ``source`` imports, also inside functions."""
    here = module_of(path).split(".")
    package = here if path.name == "__init__.py" else here[:-1]
    found = set()

    def note(name: str) -> None:
        candidates = (name, f"scripts.{name}") if package[0] in ("scripts", "tests") else (name,)
        found.update(candidate for candidate in candidates if candidate in MODULES)

    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            for alias in node.names:
                note(alias.name)
        elif isinstance(node, ast.ImportFrom):
            base = (
                ".".join([*package[: len(package) - node.level + 1], node.module or ""]).strip(".")
                if node.level
                else node.module
            )
            for alias in node.names:
                # What a package's own file defines is the package; all else is a module in it.
                inner = f"{base}.{alias.name}"
                note(inner if inner in MODULES or f"scripts.{inner}" in MODULES else base)
    return found - {module_of(path)}


@functools.cache
def import_graph() -> dict[str, set[str]]:
    return {name: imported(path, path.read_text(encoding="utf-8")) for name, path in MODULES.items()}


def circles(graph: dict[str, set[str]]) -> list[list[str]]:
    """Groups of modules that reach one another (Tarjan 1972)."""
    index, lowest, stack, found = {}, {}, [], []

    def visit(name: str) -> None:
        index[name] = lowest[name] = len(index)
        stack.append(name)
        for other in sorted(graph.get(name, ())):
            if other not in index:
                visit(other)
            if other in stack:
                lowest[name] = min(lowest[name], lowest[other])
        if lowest[name] == index[name]:
            group = stack[stack.index(name) :]
            del stack[stack.index(name) :]
            if len(group) > 1:
                found.append(sorted(group))

    for name in graph:
        if name not in index:
            visit(name)
    return found


def test_no_modules_import_each_other_in_a_circle():
    """Also not inside functions, and not between tests, scripts and what they share."""
    assert circles(import_graph()) == []


def test_a_circle_is_found():
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == [["a", "b", "c"]]
    tree, reading = PACKAGE / "blender/nodes/tree.py", "sdf_lights.blender.nodes.reading"
    assert imported(tree, "def late():\n    from .reading import problems_of\n") == {reading}


def test_tests_and_benchmarks_share_support_and_nothing_else():
    """Benchmarks import no test, and what is shared imports neither."""
    wrong = [
        f"{name} imports {other}"
        for name, imports in import_graph().items()
        if name.partition(".")[0] in BESIDE
        for other in imports
        if other.partition(".")[0] not in BESIDE[name.partition(".")[0]]
    ]
    assert wrong == []


# Of what is in ``emitter``, each may import itself and those before it.
PARTS_OF_LAMPS = (
    "primitives",
    "hashing",
    "intersection",
    "emission",
    "tree",
    "lamps",
    "building",
    "sampling",
    "arrays",
)


def test_parts_of_lamps_import_downwards():
    def part(name: str) -> int:
        return PARTS_OF_LAMPS.index(name.removeprefix("sdf_lights.emitter.").partition(".")[0])

    wrong = [
        f"{name} imports {other}"
        for name, imports in import_graph().items()
        for other in imports
        if name.startswith("sdf_lights.emitter.")
        and other.startswith("sdf_lights.emitter.")
        and part(other) > part(name)
    ]
    assert wrong == []


# Of what is in ``render``: kernels know no back end, and back ends do not know each other.
RENDER = PACKAGE.name + ".render."
BACK_ENDS = ("cpu", "gpu", "reference")


def test_kernels_know_no_back_end_and_back_ends_not_each_other():
    wrong = [
        f"{name} imports {other}"
        for name, imports in import_graph().items()
        for other in imports
        if (part := name.removeprefix(RENDER).partition(".")[0]) in ("kernels", *BACK_ENDS)
        and name.startswith(RENDER)
        and other.startswith(RENDER)
        and (theirs := other.removeprefix(RENDER).partition(".")[0]) in BACK_ENDS
        and theirs != part
    ]
    assert wrong == []


HEADER = ["SPDX-FileCopyrightText: 2026 SDF Lights authors", "SPDX-License-Identifier: GPL-3.0-or-later"]


def tracked(*suffixes: str) -> list[pathlib.Path]:
    names = subprocess.run(
        ["git", "ls-files"], cwd=REPOSITORY, capture_output=True, text=True, check=True
    ).stdout.split("\n")
    return [REPOSITORY / name for name in names if name.endswith(suffixes) and (REPOSITORY / name).is_file()]


def test_every_source_file_names_its_licence():
    shell = [path for path in tracked("") if path.suffix in ("", ".sh") and path.read_bytes()[:2] == b"#!"]
    without = []
    for path in [*tracked(".py", ".glsl", ".comp", ".frag", ".vert"), *shell]:
        head = path.read_text(encoding="utf-8").splitlines()[:4]
        if not all(any(line.endswith(wanted) for line in head) for wanted in HEADER):
            without.append(path.relative_to(REPOSITORY).as_posix())
    assert without == []
