# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Graphs compiled to programs: what they compute, and that nothing unused is compiled."""

import numpy as np
import pytest

from sdf_lights.render.cpu.shading import program
from sdf_lights.render.cpu.shading.records import (
    CLOSURES, HAS_EMISSION, HAS_SURFACE, HAS_TRANSPARENCY, LAMBERT, MICROFACET, NEEDS_DERIVATIVES, NEEDS_OBJECT,
    NEEDS_TANGENT, NEEDS_UV)
from sdf_lights.render.material import Material, Node
from sdf_lights.render.scene import Scene
from tests.render.shading.surfaces import Surface

RED, BLUE = (0.7, 0.1, 0.1), (0.1, 0.1, 0.7)
HALF = np.full((2, 2, 4), 0.25, np.float32)


def mix(factor, a, b):
    return Node("mix_closure", {"factor": factor, "a": a, "b": b})


def image(output="color", **settings):
    return Node("image", {}, {"image": 0, "output": output, **settings})


def instructions(surface, shadow=False):
    first, end = surface.record["shadow_instructions" if shadow else "instructions"]
    return [int(op) for op in surface.tables["instructions"]["op"][first:end]]


def lobes(surface, shadow=False):
    first, end = surface.record["shadow_lobes" if shadow else "lobes"]
    return [int(kind) for kind in surface.tables["lobes"]["kind"][first:end]]


def test_constants_cost_no_instruction():
    glossy = Node("glossy", {"color": BLUE}, {"distribution": "GGX"})
    surface = Surface(mix(0.25, Node("diffuse", {"color": RED}), glossy))
    assert instructions(surface) == []
    assert surface.record["flags"] == HAS_SURFACE
    surface.shade(0.5)
    assert surface.closures["weight"][0] == pytest.approx(np.multiply(RED, 0.75))
    assert surface.closures["weight"][1] == pytest.approx(np.multiply(BLUE, 0.25))


def test_a_textured_mix_factor_weighs_both_sides():
    surface = Surface(mix(image("alpha"), Node("diffuse", {"color": RED}), Node("emission", {"color": BLUE})), [HALF])
    surface.shade(0.5)
    assert surface.closures["weight"][0] == pytest.approx(np.multiply(RED, 0.75))
    assert surface.hit["emission"] == pytest.approx(np.multiply(BLUE, 0.25))
    assert surface.record["flags"] == HAS_SURFACE | HAS_EMISSION | NEEDS_UV


def test_a_closure_reached_twice_is_one_lobe():
    shared = Node("diffuse", {"color": RED})
    both = Node("add_closure", {"a": mix(0.5, shared, None), "b": mix(image("alpha"), None, shared)})
    surface = Surface(both, [HALF])
    surface.shade(0.5)
    assert lobes(surface) == [program.LOBE_DIFFUSE]
    assert surface.closures["weight"][0] == pytest.approx(np.multiply(RED, 0.5 + 0.25))


def test_what_no_lobe_needs_is_not_compiled():
    unused = Node("emission", {"color": image()})
    assert instructions(Surface(mix(0.0, Node("diffuse"), unused), [HALF])) == []
    metal = Node("principled", {"metallic": 1.0, "transmission_weight": image("alpha"), "coat_tint": image()})
    surface = Surface(metal, [HALF]).shade(0.5)
    assert instructions(surface) == []
    assert list(surface.closures["kind"]) == [MICROFACET]


def test_an_image_with_two_outputs_is_read_once():
    surface = Surface(Node("principled", {"base_color": image(), "alpha": image("alpha")}), [HALF])
    assert instructions(surface).count(program.OP_IMAGE) == 1


def test_shadow_rays_run_only_what_transparency_needs():
    rough = Node("image", {}, {"image": 1})
    node = Node("principled", {"base_color": image(), "roughness": rough, "alpha": image("alpha")})
    surface = Surface(node, [HALF, HALF])
    assert instructions(surface, shadow=True) == [program.OP_UV, program.OP_IMAGE]
    assert lobes(surface, shadow=True) == [program.LOBE_ALPHA]
    assert surface.transparency() == pytest.approx(0.75)
    glass = Surface(mix(0.5, Node("transparent", {"color": RED}), Node("glass")))
    assert glass.transparency() == pytest.approx(np.multiply(RED, 0.5))
    opaque = Surface(Node("diffuse"))
    assert not opaque.record["flags"] & HAS_TRANSPARENCY and not opaque.transparency().any()


def test_emission_is_estimated_for_light_sampling():
    surface = Surface(Node("emission", {"color": image(), "strength": 3.0}), [HALF])
    assert surface.record["emission"] == pytest.approx([0.75] * 3)
    surface = Surface(mix(0.5, Node("emission", {"color": RED, "strength": 2.0}), Node("diffuse")))
    assert surface.record["emission"] == pytest.approx(RED)


def test_emission_lies_below_the_coat():
    node = Node("principled", {
        "emission_color": RED, "emission_strength": 2.0, "coat_weight": 1.0, "coat_roughness": 0.0, "coat_tint": BLUE,
        "alpha": 0.5})
    surface = Surface(node).shade(1.0)
    assert surface.hit["emission"] == pytest.approx(0.5 * 2.0 * np.multiply(RED, BLUE) * 0.96, rel=1e-3)
    assert surface.hit["transparency"] == pytest.approx([0.5] * 3)


def test_holdout_counts_with_its_weight():
    assert Surface(mix(0.25, Node("holdout"), Node("diffuse"))).shade(1.0).hit["holdout"] == pytest.approx(0.75)


@pytest.mark.parametrize("node, flags", [
    (Node("normal_map", {"color": image()}), NEEDS_TANGENT | NEEDS_OBJECT | NEEDS_UV),
    (Node("normal_map", {}, {"space": "OBJECT"}), NEEDS_OBJECT),
    (Node("normal_map", {}, {"space": "WORLD"}), 0),
    (Node("bump", {"height": image("alpha")}), NEEDS_UV | NEEDS_DERIVATIVES),
    (Node("bump", {"height": 2.0}), 0),
])
def test_flags_say_what_a_surface_needs(node, flags):
    assert Surface(Node("diffuse", {"normal": node}), [HALF]).record["flags"] == flags | HAS_SURFACE


def test_values_and_closures_in_each_others_place():
    surface = Surface(image(), [HALF]).shade(1.0)  # a colour is emitted
    assert surface.hit["emission"] == pytest.approx([0.25] * 3)
    surface = Surface(Node("diffuse", {"color": Node("glossy"), "normal": Node("diffuse")})).shade(1.0)
    assert surface.closures["weight"][0] == pytest.approx([0.8] * 3)
    assert len(surface.scene.warnings) == 2 and "'color'" in "".join(surface.scene.warnings)


def test_odd_values_are_replaced_and_told():
    surface = Surface(Node("diffuse", {"color": (float("nan"), 0.0, 0.0), "roughness": "rough"})).shade(1.0)
    assert surface.hit["closure_count"] == 0
    assert len(surface.scene.warnings) == 2


def test_too_many_lobes_become_grey():
    node = Node("diffuse")
    for _ in range(CLOSURES + 5):
        node = Node("add_closure", {"a": node, "b": Node("diffuse")})
    surface = Surface(node).shade(1.0)
    assert list(surface.closures["kind"]) == [LAMBERT]
    assert "too many nodes" in surface.scene.warnings[0] and "'test'" in surface.scene.warnings[0]


def test_a_long_chain_of_shared_mixes_compiles_at_once():
    node = Node("diffuse", {"color": RED})
    for _ in range(3000):
        node = mix(0.5, node, node)
    surface = Surface(node).shade(1.0)
    assert surface.closures["weight"][0] == pytest.approx(RED)


def test_scene_without_materials_has_a_default_one():
    scene = Scene(camera=None, width=1, height=1)
    assert len(program.pack_materials(scene)["materials"]) == 1


def test_uv_layers_start_with_the_active_one():
    node = Node("principled", {
        "base_color": Node("image", {"vector": Node("uv", {}, {"uv_map": "B"})}, {"image": 0}),
        "normal": Node("normal_map", {}, {"uv_map": "A"})})
    scene = Scene(camera=None, width=1, height=1, materials=[Material("m", node)])
    assert program.uv_layers(scene) == ["", "A", "B"]
