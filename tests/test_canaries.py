# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of Numba and of Blender that are overridden or private: what this project relies on is still there.

Where one of these fails after an update, the code that it names has to be looked at before anything else.
"""

import ast
import importlib
import inspect
import pathlib

import pytest

from sdf_lights import jit
from sdf_lights.blender.engine import SDFLightsRenderEngine as Engine

numba = pytest.importorskip("numba")
bpy = pytest.importorskip("bpy")

from sdf_lights import kernel_compiler, machine_code  # noqa: E402  (the first needs Numba)


def overridden():
    """(class, method) of each class of these modules below one of Numba's, for what that has, too."""
    for cls in vars(kernel_compiler).values():
        if inspect.isclass(cls) and cls.__module__ == kernel_compiler.__name__:
            for base in cls.__mro__[1:]:
                if base.__module__.startswith("numba."):
                    for name, value in vars(cls).items():
                        if inspect.isfunction(value) and hasattr(base, name):
                            yield cls, base, name
                    break


def test_some_parts_of_numba_are_overridden():
    assert {base.__name__ for _, base, _ in overridden()} >= {
        *("JITCodeLibrary", "Compiler", "CFunc", "JITCPUCodegen"),
    }


@pytest.mark.parametrize(
    "cls, base, name", [pytest.param(*found, id=f"{found[1].__name__}.{found[2]}") for found in overridden()]
)
def test_methods_of_numba_take_what_they_took(cls, base, name):
    theirs, ours = (inspect.signature(getattr(owner, name)).parameters.values() for owner in (base, cls))
    variadic = any(p.kind in (p.VAR_POSITIONAL, p.VAR_KEYWORD) for p in ours)
    required = [p for p in theirs if p.default is p.empty and p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    assert variadic or len(required) <= len(ours)


# -- what is private ---------------------------------------------------------------------------------------------------


def square(x):
    return x * x


def of_numba() -> dict[str, tuple]:
    """Names that begin with an underscore, or that no documentation has, of things of Numba as they are made; by the
    thing."""
    from numba.core import types
    from numba.core.ccallback import CFunc
    from numba.core.registry import CPUDispatcher, cpu_target

    codegen = cpu_target.target_context.codegen()
    library, dispatcher = codegen.create_library("canary"), CPUDispatcher(square)
    dispatcher.compile((types.float64,))
    (result,) = dispatcher.overloads.values()
    array = cpu_target.target_context.make_array(types.Array(types.float64, 1, "C"))
    names = {
        "a library of code": "_codegen _raise_if_finalized _finalize_dynamic_globals _finalized _final_module"
        " _ensure_finalized _linking_libraries _get_module_for_linking _optimize_functions enable_object_caching finalize"
        " get_pointer_to_function _get_compiled_object",
        "its code generator": "_data_layout _function_pass_manager set_env _get_host_cpu_name _get_host_cpu_features",
        "a dispatcher": "compile overloads get_call_template typeof_pyval",
        "what it compiles": "_find_referenced_environments environment fndesc library",
        "how that is called": "llvm_cpython_wrapper_name llvm_cfunc_wrapper_name",
        "what it needs of Python": "env_name consts",
        "a function for C": "_compile_uncached compile",
        "an array": "_getvalue",
    }
    things = (
        library,
        codegen,
        dispatcher,
        result,
        result.fndesc,
        result.environment,
        CFunc(square, ((types.float64,), types.float64), {}, {}),
        array,
    )
    return {name: (thing, text.split()) for (name, text), thing in zip(names.items(), things)}


@pytest.mark.parametrize("name", list(of_numba()))
def test_private_parts_of_numba_are_there(name):
    thing, wanted = of_numba()[name]
    assert [part for part in wanted if not hasattr(thing, part)] == []


def test_no_other_private_part_of_numba_is_used():
    """Whoever uses one more of them names it above."""
    known = {part for _, wanted in of_numba().values() for part in wanted} | {"_numba_type_"}
    tree = ast.parse(inspect.getsource(kernel_compiler))
    used = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute) and node.attr[0] == "_"}
    own = {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)} - known
    assert {name for name in used - own if not name.endswith("__")} <= known


def test_numba_asks_kernels_for_their_type():
    """How one kernel calls another: by an attribute that Numba looks for."""

    class Kernel:
        _numba_type_ = numba.types.intp

    assert numba.typeof(Kernel()) is numba.types.intp


@pytest.mark.parametrize(
    "name", ["numba_do_raise", "NRT_MemInfo_alloc_aligned", "PyErr_Clear", "PyExc_MemoryError", "pow"]
)
def test_what_numba_calls_is_found_without_it(name):
    """As Numba itself registers it with LLVM."""
    from llvmlite import binding

    kernel_compiler.codegen()
    assert machine_code.process_symbol(name) == binding.address_of_symbol(name) != 0


# what Numba does for code that kernels do not have: closures, ``with``, exceptions, lists of literals, overloads
LEFT_OUT = {
    "WithLifting",
    "InlineClosureLikes",
    "RewriteSemanticConstants",
    "RewriteDynamicRaises",
    "MakeFunctionToJitFunction",
    "InlineInlinables",
    "FindLiterallyCalls",
    "LiteralUnroll",
    "LiteralPropagationSubPipelinePass",
    "InlineOverloads",
    "NoPythonSupportedFeatureValidation",
    "DumpParforDiagnostics",
}


def test_the_passes_that_kernels_go_through_are_those_of_numba():
    """In Numba's order; a pass of which nobody knew has to be looked at, and taken or left out."""
    from numba.core.compiler import Compiler, Flags
    from numba.core.registry import cpu_target

    def passes(cls) -> list[str]:
        target = cpu_target.target_context
        library = target.codegen().create_library("canary")
        compiler = cls(cpu_target.typing_context, target, library, (), None, Flags(), {})
        return [part.__name__ for pipeline in compiler.define_pipelines() for part, _ in pipeline.passes]

    theirs, ours = passes(Compiler), passes(kernel_compiler._Compiler)
    rest = iter(theirs)
    assert [name for name in ours if name not in rest] == []  # each comes after the one before
    assert set(theirs) - set(ours) == LEFT_OUT


def modules_of_blender() -> list[tuple[str, str]]:
    """(module, name) of what the add-on takes from the Python modules that Blender ships, bpy itself apart."""
    found = set()
    for path in (pathlib.Path(jit.__file__).parent / "blender").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
                if node.module.partition(".")[0] in ("bl_ui", "bl_operators", "bpy_extras", "gpu_extras", "mathutils"):
                    found |= {(node.module, alias.name) for alias in node.names}
    return sorted(found)


@pytest.mark.parametrize("module, name", modules_of_blender())
def test_modules_that_blender_ships_have_what_is_imported(module, name):
    assert hasattr(importlib.import_module(module), name)


def test_menus_headers_and_draw_handlers_can_be_added_to():
    menus = set()
    for path in (pathlib.Path(jit.__file__).parent / "blender").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Attribute) and node.attr == "append" and isinstance(node.value, ast.Attribute):
                if "_MT_" in node.value.attr or "_HT_" in node.value.attr:
                    menus.add(node.value.attr)
    assert len(menus) >= 4
    for name in menus:
        assert callable(getattr(bpy.types, name).append) and callable(getattr(bpy.types, name).remove), name
    assert callable(bpy.types.SpaceView3D.draw_handler_add) and callable(bpy.types.SpaceView3D.draw_handler_remove)


def test_panels_say_which_engines_they_are_for():
    """Blender's own panels are given to this engine by a set that each of them has."""
    from sdf_lights.blender import panels

    found = list(panels.stock_panels())
    assert len(found) > 50 and all(isinstance(panel.COMPAT_ENGINES, set) for panel in found)
    names = {panel.__name__ for panel in bpy.types.Panel.__subclasses__()}
    assert not {name for name in panels._EEVEE if name not in names}


def test_blender_still_calls_and_offers_what_the_engine_uses():
    known = {function.identifier for function in bpy.types.RenderEngine.bl_rna.functions}
    used = ("begin_result", "end_result", "update_result", "update_stats", "update_progress", "report", "register_pass")
    assert [name for name in (*used, "test_break", "error_set") if name not in known] == []
    own = [name for name in ("render", "view_update", "view_draw", "update_render_passes") if hasattr(Engine, name)]
    assert own and set(own) <= known
