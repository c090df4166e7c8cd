# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where no object has been met, as in worlds and lights, nodes read no table of objects: there may be none."""

import importlib
import inspect
import pkgutil

import numpy as np
import pytest

from sdf_lights.graph.formula import Vector, call, constant, parameter
from sdf_lights.graph.functions import Function
from sdf_lights.graph.substitution import without_objects
from sdf_lights.render import nodes
from sdf_lights.render.cpu.block import BLOCK
from sdf_lights.render.kernels import camera, textures
from sdf_lights.render.kernels.camera import pack_camera
from sdf_lights.render.kernels.emission_graphs import world_map
from sdf_lights.render.kernels.shading.material_compiler import pack_materials
from sdf_lights.render.material import Material, Node
from sdf_lights.render.nodes import lookups
from sdf_lights.render.nodes.variables import BARYCENTRIC, POSITION, as_vector
from sdf_lights.render.scene import Camera, Scene, World

# Tables that ``world_map`` has; "texels" are those that an image points at.
EVERYWHERE = {"constants", "texels", *camera.TABLES, *textures.TABLES}


def functions() -> list[Function]:
    """All that modules of nodes have in names of their own, in lists or in dictionaries."""
    found = []
    for module in pkgutil.iter_modules(nodes.__path__):
        for value in vars(importlib.import_module(f"{nodes.__name__}.{module.name}")).values():
            values = value.values() if isinstance(value, dict) else value if isinstance(value, list) else [value]
            found += [entry for entry in values if isinstance(entry, Function) and entry.scene]
    return list(dict.fromkeys(found))


def tables_of(kernel, seen: set) -> set[str]:
    """Names of the tables that a kernel reads, by itself or by those that it calls."""
    if hasattr(kernel, "table_name"):
        return {kernel.table_name}
    function = inspect.unwrap(getattr(kernel, "py_func", kernel))
    code = getattr(function, "__code__", None)
    if code is None or code in seen or not getattr(function, "__module__", "").startswith("sdf_lights"):
        return set()
    seen.add(code)
    values = (function.__globals__.get(name) for name in code.co_names)
    return set().union(*(tables_of(value, seen) for value in values if callable(value)))


@pytest.mark.parametrize("function", functions(), ids=lambda function: f"{function.name} {function.static}")
def test_functions_that_read_more_than_a_world_has_are_of_objects(function):
    read = tables_of(function.kernel, set())
    assert read
    assert function.of_object or read <= EVERYWHERE


def test_what_is_told_of_objects_is_nothing_and_their_space_is_the_worlds():
    place = parameter(0)
    told = [
        *call(lookups.OBJECT_INFO),
        *call(lookups.ATTRIBUTE, place, *BARYCENTRIC),
        *call(lookups.WIREFRAME, *POSITION),
    ]
    assert without_objects(told) == [constant(0.0)] * len(told)
    there = call(lookups.TO_OBJECT["POINT"], *(2.0 * axis for axis in POSITION))
    back = call(lookups.FROM_OBJECT["NORMAL"], *there)
    assert without_objects(back) == [2.0 * axis for axis in POSITION]


def test_the_map_of_a_world_knows_the_camera_and_no_objects():
    """Once, this read memory that was not there."""
    seen = as_vector(call(lookups.TO_CAMERA["VECTOR"], *POSITION))
    info = call(lookups.OBJECT_INFO)
    attribute = call(lookups.ATTRIBUTE, constant(0.0), *BARYCENTRIC)
    color = Vector(abs(seen.x) + info[0], abs(seen.x) + attribute[0], abs(seen.x))
    world = World(emission=Material("World", Node("emission", {"color": color})))
    matrix = np.eye(4)
    matrix[:3, :3] = [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]  # what is to its right is the world's y
    scene = Scene(camera=Camera(matrix), width=2, height=1, world=world)
    tables, graphs = pack_materials(scene)
    found = world_map(tables | pack_camera(scene), graphs, BLOCK, 0).values
    rows, columns = found.shape
    latitude = np.pi * ((np.arange(rows) + 0.5) / rows - 0.5)
    longitude = 2.0 * np.pi * (0.5 - (np.arange(columns) + 0.5) / columns)
    np.testing.assert_allclose(found, np.abs(np.outer(np.cos(latitude), np.sin(longitude))), atol=1e-6)
