# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that is registered as a back end, a light, a BSDF … has the functions of ``interfaces``, with their
parameters."""

import importlib
import inspect
import types

import pytest

from sdf_lights import jit
from sdf_lights.render import interfaces
from sdf_lights.render.cpu.renderer import CpuRenderer
from sdf_lights.render.gpu.renderer import GpuRenderer
from sdf_lights.render.kernels import film, lights, samplers
from sdf_lights.render.kernels.lights import kinds
from sdf_lights.render.kernels.shading import special
from sdf_lights.render.light_paths import LightPathsByCpu
from sdf_lights.render.reference.renderer import ReferenceRenderer
from sdf_lights.render.session import choose_back_end
from sdf_lights.render.settings import Device
from support import scenes

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")

REGISTERED = [
    *((back_end, interfaces.BackEnd) for back_end in (CpuRenderer, GpuRenderer, ReferenceRenderer)),
    *((back_end, interfaces.InteractiveBackEnd) for back_end in (CpuRenderer, ReferenceRenderer)),
    (LightPathsByCpu, interfaces.LightPathTracer),
    *((module, interfaces.Light) for module in kinds.KINDS.values()),
    *((module, interfaces.Bsdf) for module in dict.fromkeys(special.CLOSURES.values())),
    (lights, interfaces.LightSampler),
    *((importlib.import_module(f"{samplers.__name__}.{name}"), interfaces.Sampler) for name in samplers.NAMES),
    (film, interfaces.Film),
]


def mismatches(thing, interface) -> list[str]:
    """What of the functions of an ``interface`` a module or class lacks, or takes other parameters for."""
    found = []
    for name, wanted in vars(interface).items():
        if not isinstance(wanted, types.FunctionType) or name.startswith("_"):
            continue
        own = getattr(thing, name, None)
        if own is None:
            found.append(f"{thing.__name__} has no {name}")
            continue
        parameters = list(inspect.signature(inspect.unwrap(own)).parameters)
        expected = list(inspect.signature(wanted).parameters)
        if isinstance(thing, types.ModuleType):
            expected.remove("self")
        if parameters != expected:
            found.append(f"{thing.__name__}.{name} takes {parameters}, not {expected}")
    return found


@pytest.mark.parametrize("thing, interface", REGISTERED, ids=lambda item: item.__name__.rpartition(".")[2])
def test_what_is_registered_fulfils_its_interface(thing, interface):
    assert [
        problem
        for base in interface.__mro__
        if base.__module__ == interfaces.__name__
        for problem in mismatches(thing, base)
    ] == []


@pytest.mark.parametrize("device", Device)
def test_viewports_get_back_ends_that_can_be_interrupted(device):
    """``interactive`` asks ``choose_back_end``, which never gives the GPU."""
    scene = scenes.world_color(8, 6)
    scene.settings.device = device
    assert mismatches(choose_back_end(scene), interfaces.InteractiveBackEnd) == []


def test_a_mismatch_is_found():
    assert mismatches(GpuRenderer, interfaces.InteractiveBackEnd)
    assert mismatches(samplers.chosen, interfaces.Light)


def test_every_table_of_a_light_is_in_the_block():
    for module in kinds.KINDS.values():
        assert lights.TABLES[module.TABLE] == module.RECORD
