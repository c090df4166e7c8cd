# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A program has code for what its scene has, and for nothing else."""

import importlib
import pkgutil
import re

import numpy as np
import pytest

from sdf_lights import jit
from sdf_lights.render import motion
from sdf_lights.render.film import Film
from sdf_lights.render.gpu import thread_arrays
from sdf_lights.render.gpu.packed_scene import GpuScene
from sdf_lights.render.kernels import media, subsurface
from sdf_lights.render.medium import Medium, Scattering
from sdf_lights.render.scene import Primitive
from support import scenes
from support.scenes import media as media_scenes
from support.scenes.media import MEDIA_SCENES, VARYING_SCENES
from support.scenes.strands import fur

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")

SCENES = scenes.SCENES | MEDIA_SCENES


def kernels_of(package) -> set[str]:
    """Names in GLSL of all kernels of a package."""
    found = set()
    for item in pkgutil.iter_modules(package.__path__):
        module = importlib.import_module(f"{package.__name__}.{item.name}")
        own = [kernel for kernel in vars(module).values() if hasattr(kernel, "__wrapped__")]
        found |= {f"{item.name}_{kernel.__name__.strip('_')}" for kernel in own if kernel.__module__ == module.__name__}
    return found


def kernels(scene) -> set[str]:
    """Those of media and of ways below surfaces that are in a scene's program."""
    source = GpuScene(scene, Film(scene, ())).source()
    assert scene.warnings == []
    return set(re.findall(r"^\w+ (\w+)\(", source, re.MULTILINE)) & (kernels_of(media) | kernels_of(subsurface))


@pytest.mark.parametrize("name", ["torus_room", "glass", "rare", "transparent", "varying_lamps"])
def test_scenes_without_media_and_subsurface_have_no_code_for_them(name):
    assert kernels(SCENES[name](8, 6)) == set()


def test_media_alone():
    found = kernels(SCENES["fog_lamp"](8, 6))
    assert {"stack_bounds", "travel_enter", "in_scattering_light_ray"} <= found
    assert not found & {"walk_walk", "disk_scatter", "exits_emerge"}


def test_media_that_vary():
    """Only they have the code for it, and only a world that varies has sections of rays."""
    varying = re.compile(r"point|cells|tracking|varying")
    assert not [name for name in kernels(SCENES["smoke"](8, 6)) if varying.match(name)]
    smoke, fog = (kernels(VARYING_SCENES[name](8, 6)) for name in ("varying_smoke", "thinning_fog"))
    assert {"point_evaluate", "cells_section", "tracking_faded"} <= smoke & fog
    unused = scenes.torus_room(8, 6)
    unused.materials += VARYING_SCENES["varying_smoke"](8, 6).materials
    assert kernels(unused) == set()
    assert "in_scattering_light_ray" not in smoke | fog  # where all media vary
    assert "cells_divide_world_ray" in fog and "cells_plan_world" not in smoke


def test_graphs_of_media_run_beside_those_of_surfaces():
    """In a second workspace, which has no code for the others; and the registers of both are variables."""
    scene = SCENES["textured"](8, 6)
    parts = (Scattering((0.1, 0.2, 0.3)), Scattering((0.1, 0.1, 0.1), 0.5))
    scene.world.medium = media_scenes.varying(Medium((0.0, 0.0, 0.1), parts), media_scenes.THINNING)
    packed = GpuScene(scene, Film(scene, ()))
    assert packed.graphs.registers() > thread_arrays.SHORT
    source = packed.source()
    surfaces, volumes = (set(re.findall(rf"case (\d+): {prefix}graph_\d+\(", source)) for prefix in ("", "secondary_"))
    assert len(surfaces) > 0 and len(volumes) == 1 and not surfaces & volumes
    read = re.findall(r"return vec3\(point_amount\((\w+)\[", source)
    assert set(read) == {"secondary_registers_rows"}


def test_each_method_below_surfaces_alone():
    found = kernels(SCENES["subsurface"](8, 6))
    assert "walk_walk" in found and "disk_scatter" not in found and "stack_bounds" not in found
    scene = SCENES["subsurface_profile"](8, 6)
    [jade] = [index for index, material in enumerate(scene.materials) if material.name == "jade"]
    scene.materials[jade] = scene.materials[0]  # light walks through that one alone
    found = kernels(scene)
    assert "disk_scatter" in found and "walk_walk" not in found


def test_only_scenes_with_curves_and_spheres_have_code_for_them():
    """And only for the kinds that they have."""

    def source(scene) -> str:
        return GpuScene(scene, Film(scene, ())).source()

    plain = source(scenes.torus_room(8, 6))
    assert "#define STRANDS" not in plain and "surface_fill" not in plain and "hit_ribbon" not in plain
    for kind in tuple(Primitive)[1:]:
        furry = source(fur(8, 6, (kind,)))
        assert "surface_fill" in furry and f"#define HAS_{kind.name} {int(kind)}\n" in furry
        assert furry.count("#define HAS_") == 1


def test_only_films_with_such_passes_have_code_for_them():
    """For the light by lobes, and for properties of surfaces; nor have scenes with shadow catchers more than they
    need."""

    def found(*passes: str, catcher: bool = False) -> set[str]:
        scene = scenes.torus_room(8, 6)
        scene.instances[0].catcher = catcher
        source = GpuScene(scene, Film(scene, passes)).source()
        return {name for name in ("light_divide", "data_add_surface", "catchers_catch") if f" {name}(" in source}

    assert found("Combined", "Depth") == set()
    assert found("Volume Direct") == {"light_divide"}
    assert found("Mist") == {"data_add_surface"}
    assert found(catcher=True) == {"catchers_catch"}


def test_one_program_for_all_times():
    """Of a scene in which everything moves; not of another scene."""

    def packed(scene, time: float) -> GpuScene:
        return GpuScene(motion.at(scene, time), Film(scene, ()), moves=True)

    scene = scenes.moving(8, 6)
    first, second = packed(scene, 0.2), packed(scene, 0.7)
    source = first.source()
    assert first.shares_program_with(second) and second.source() == source
    words = [part.tables.pack(part.scalars)[0] for part in (first, second)]
    assert not np.array_equal(*words)
    scene.lamps.pop()
    assert not first.shares_program_with(packed(scene, 0.2))
