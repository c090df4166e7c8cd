# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Graphs compiled to programs: what they compute, and that nothing unused is compiled."""

import numpy as np
import pytest

from sdf_lights.graph.formula import CALL, order
from sdf_lights.render.kernels.shading import material_compiler, material_records
from sdf_lights.render.kernels.shading.records import (
    CLOSURES,
    DEPENDS_ON_VIEW,
    HAS_EMISSION,
    HAS_SURFACE,
    HAS_TRANSPARENCY,
    LAMBERT,
    MICROFACET,
    NEEDS_DERIVATIVES,
    NEEDS_OBJECT_NORMAL,
)
from sdf_lights.render.material import Node
from sdf_lights.render.scene import Scene
from support.graphs import PLACE, Graph
from tests.render.shading.surfaces import Surface

RED, BLUE = (0.7, 0.1, 0.1), (0.1, 0.1, 0.7)
HALF = np.full((2, 2, 4), 0.25, np.float32)


def mix(factor, a, b):
    return Node("mix_closure", {"factor": factor, "a": a, "b": b})


GRAPH = Graph()
COLOR, ALPHA = (GRAPH.image(0, output=output) for output in ("Color", "Alpha"))


def textured(node, *images):
    return Surface(node, images or [HALF], GRAPH.parameters)


def roots(surface, shadow=False):
    """Formulas that fill the registers."""
    graph = surface.record["shadow_graph" if shadow else "graph"]
    return () if graph == material_records.NO_GRAPH else surface.graphs.structures[graph]


def calls(surface, shadow=False):
    """Names of the functions that fill the registers."""
    return [node.value.name for node in order(*roots(surface, shadow)) if node.kind == CALL]


def lobes(surface, shadow=False):
    first, end = surface.record["shadow_lobes" if shadow else "lobes"]
    return [int(kind) for kind in surface.tables["lobes"]["kind"][first:end]]


def test_what_weighs_nothing_is_left_out_with_all_that_leads_on_from_it():
    nothing = Node(
        "add_closure", {"a": mix(0.5, Node("diffuse", {"color": RED}), Node("holdout")), "b": Node("glossy")}
    )
    surface = Surface(mix(0.0, Node("diffuse", {"color": BLUE}), nothing))
    assert len(lobes(surface)) == 1


def test_constants_cost_no_code():
    glossy = Node("glossy", {"color": BLUE}, {"distribution": "GGX"})
    surface = Surface(mix(0.25, Node("diffuse", {"color": RED}), glossy))
    assert roots(surface) == ()
    assert surface.record["flags"] == HAS_SURFACE
    surface.shade(0.5)
    assert surface.closures["weight"][0] == pytest.approx(np.multiply(RED, 0.75))
    assert surface.closures["weight"][1] == pytest.approx(np.multiply(BLUE, 0.25))


def test_a_textured_mix_factor_weighs_both_sides():
    surface = textured(mix(ALPHA, Node("diffuse", {"color": RED}), Node("emission", {"color": BLUE})))
    surface.shade(0.5)
    assert surface.closures["weight"][0] == pytest.approx(np.multiply(RED, 0.75))
    assert surface.hit["emission"] == pytest.approx(np.multiply(BLUE, 0.25))
    assert surface.record["flags"] == HAS_SURFACE | HAS_EMISSION


def test_a_closure_reached_twice_is_one_lobe():
    shared = Node("diffuse", {"color": RED})
    both = Node("add_closure", {"a": mix(0.5, shared, None), "b": mix(ALPHA, None, shared)})
    surface = textured(both)
    surface.shade(0.5)
    assert lobes(surface) == [material_records.LOBE_DIFFUSE]
    assert surface.closures["weight"][0] == pytest.approx(np.multiply(RED, 0.5 + 0.25))


def test_what_no_lobe_needs_is_not_compiled():
    unused = Node("emission", {"color": COLOR})
    assert roots(textured(mix(0.0, Node("diffuse"), unused))) == ()
    metal = Node("principled", {"metallic": 1.0, "transmission_weight": ALPHA, "coat_tint": COLOR})
    surface = textured(metal).shade(0.5)
    assert roots(surface) == ()
    assert list(surface.closures["kind"]) == [MICROFACET]


def test_an_image_with_two_outputs_is_read_once():
    graph = Graph()
    outputs = graph.node(
        "ShaderNodeTexImage",
        {"Vector": PLACE},
        dict(image=0, interpolation="Linear", extension="REPEAT", projection="FLAT"),
    )
    surface = Surface(
        Node("principled", {"base_color": outputs["Color"], "alpha": outputs["Alpha"]}), [HALF], graph.parameters
    )
    assert calls(surface) == ["image"]


def test_shadow_rays_run_only_what_transparency_needs():
    node = Node("principled", {"base_color": COLOR, "roughness": GRAPH.image(1).x, "alpha": ALPHA})
    surface = textured(node, HALF, HALF)
    assert calls(surface, shadow=True) == ["image"] and len(calls(surface)) == 2
    assert lobes(surface, shadow=True) == [material_records.LOBE_ALPHA]
    assert surface.transparency() == pytest.approx(0.75)
    glass = Surface(mix(0.5, Node("transparent", {"color": RED}), Node("glass")))
    assert glass.transparency() == pytest.approx(np.multiply(RED, 0.5))
    opaque = Surface(Node("diffuse"))
    assert not opaque.record["flags"] & HAS_TRANSPARENCY and not opaque.transparency().any()


def test_emission_is_estimated_for_light_sampling():
    surface = textured(Node("emission", {"color": COLOR, "strength": 3.0}))
    assert surface.record["emission"] == pytest.approx([0.75] * 3)
    surface = Surface(mix(0.5, Node("emission", {"color": RED, "strength": 2.0}), Node("diffuse")))
    assert surface.record["emission"] == pytest.approx(RED)


def test_emission_lies_below_the_coat():
    node = Node(
        "principled",
        {
            "emission_color": RED,
            "emission_strength": 2.0,
            "coat_weight": 1.0,
            "coat_roughness": 0.0,
            "coat_tint": BLUE,
            "alpha": 0.5,
        },
    )
    surface = Surface(node).shade(1.0)
    assert surface.hit["emission"] == pytest.approx(0.5 * 2.0 * np.multiply(RED, BLUE) * 0.96, rel=1e-3)
    assert surface.hit["transparency"] == pytest.approx([0.5] * 3)


def test_holdout_counts_with_its_weight():
    assert Surface(mix(0.25, Node("holdout"), Node("diffuse"))).shade(1.0).hit["holdout"] == pytest.approx(0.75)


@pytest.mark.parametrize(
    "normal, flags",
    [
        (GRAPH.normal_map(COLOR), NEEDS_OBJECT_NORMAL),
        (GRAPH.normal_map(COLOR, space="OBJECT"), 0),
        (GRAPH.normal_map(COLOR, space="WORLD"), 0),
        (GRAPH.bump(ALPHA), NEEDS_DERIVATIVES | DEPENDS_ON_VIEW),
        (GRAPH.bump(2.0), 0),
    ],
)
def test_flags_say_what_a_surface_needs(normal, flags):
    assert textured(Node("diffuse", {"normal": normal})).record["flags"] == flags | HAS_SURFACE


def test_materials_that_differ_in_numbers_share_their_code():
    # Also numbers that are equal by chance, or equal to one of the formula's own, as 0.5 is.
    scales = ((2.0, 2.0, 2.0), (3.0, 4.0, 2.0), (0.5, 0.5, 3.0), (1.0, 1.0, 1.0))
    graphs = [Graph() for _ in scales]
    materials = [
        graph.material("m", Node("diffuse", {"color": graph.image(0, graph.mapping(PLACE, scale=x))}))
        for graph, x in zip(graphs, scales)
    ]
    scene = Scene(camera=None, width=1, height=1, materials=materials)
    tables, packed = material_compiler.pack_materials(scene)
    assert len(set(tables["materials"]["graph"][:-1].tolist())) == 1
    # A scale of 1 costs nothing.
    sizes = [len(order(*packed.structures[index])) for index in tables["materials"]["graph"]]
    assert sizes[-1] < sizes[0]


def test_values_and_closures_in_each_others_place():
    surface = textured(COLOR).shade(1.0)  # a colour is emitted
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
    assert len(material_compiler.pack_materials(scene)[0]["materials"]) == 1
