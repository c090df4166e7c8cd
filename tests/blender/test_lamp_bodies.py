# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender does by the bounds of an object, with lamps: their bodies, Apply Scale, Origin to Geometry, and what
other engines see. The window is in test_native_gui.py."""

import bpy
import numpy as np
import pytest

from sdf_lights.blender import fallback
from sdf_lights.blender.lamp import pattern_of, shape_of
from sdf_lights.blender.lamp_transforms import apply_scale, origin_to_geometry
from sdf_lights.blender.viewport.bodies import points_of
from sdf_lights.render.errors import RenderError
from sdf_lights.sdf.expression import evaluate


@pytest.mark.parametrize(
    "text",
    ["torus(0.5, 0.001)", "box((1, 1, 0.001))", "sphere(3)", "menger_sponge(0.5)", "translate(box(1), (5, 0, 0))"],
)
def test_points_are_on_the_surface_and_reach_to_its_ends(text):
    shape = evaluate(text)
    points, box = points_of(shape), np.stack(shape.bounds())
    assert len(points) > 100
    size = np.linalg.norm(box[1] - box[0])
    assert np.abs(shape.distance(points)).max() < 0.01 * size
    assert np.abs(np.stack([points.min(axis=0), points.max(axis=0)]) - box).max() < 0.02 * size


def test_blender_has_no_place_for_operators_of_the_names_of_its_own(registered):
    """If this fails, the lamps' operators can take the places of Blender's."""
    for idname in ("view3d.view_selected", "object.transform_apply", "object.origin_set", "view3d.select_box"):
        module, name = idname.split(".")
        kind = type(f"{module.upper()}_OT_{name}", (bpy.types.Operator,), {"bl_idname": idname, "bl_label": "Own"})
        with pytest.raises(RuntimeError, match="could not be unregistered|built-in"):
            bpy.utils.register_class(kind)


@pytest.fixture
def change_stays_in_place(add, lamp, file):
    """Function: apply a change to a lamp with this text or primitive, and say whether shape and pattern stay in the
    world."""

    def run(change, text="", shape="SPHERE", emission="UNIFORM", scale=(1.0, 1.0, 1.0)):
        light = lamp(shape=shape)
        if text:
            light.sdf_lamp.source, light.sdf_lamp.text = "EXPRESSION", bpy.data.texts.new("Shape")
            light.sdf_lamp.text.write(text)
        light.sdf_lamp.emission.source = emission
        obj = add("Lamp", light, location=(1.0, 2.0, 3.0), rotation=(0.3, 0.2, 0.1), scale=scale)
        child = add("Child", None, location=(1.0, 0.0, 0.0))
        child.parent = obj
        bpy.context.view_layer.update()
        places = np.random.default_rng(0).uniform(-3.0, 3.0, (4000, 3)) + obj.location

        def seen():
            bpy.context.view_layer.update()
            inverse = np.linalg.inv(np.array(obj.matrix_world))
            own, found = places @ inverse[:3, :3].T + inverse[:3, 3], shape_of(light.sdf_lamp)
            inside, pattern = found.distance(own) <= 0.0, pattern_of(light.sdf_lamp)
            glow = np.ones((len(own), 3)) if pattern is None else pattern.placed(found).evaluate(own)
            return inside, np.where(inside[:, None], glow, 0.0), np.array(child.matrix_world)

        before = seen()
        change(obj)
        for a, b, limit in zip(before, seen(), (0.001, 0.002, 1e-6)):
            assert np.mean(np.abs(np.float64(a) - b)) <= limit
        return obj

    return run


@pytest.mark.parametrize(
    "about",
    [
        dict(shape="BOX", scale=(2.0, 3.0, 0.5)),
        dict(shape="CYLINDER", scale=(2.0, 2.0, -3.0)),
        dict(shape="GYROID", scale=(0.5, 0.5, 0.5)),
        dict(shape="TORUS_KNOT", scale=(3.0, 3.0, 3.0), emission="SHELL"),
        dict(shape="SPHERE", scale=(2.0, 2.0, 2.0), emission="FLAME"),
        dict(text="r = slider(0.4, 0.1, 2)\nn = slider(2, 1, 5)\nsphere(r) - box(r / n)", scale=(1.5, 1.5, 1.5)),
    ],
)
def test_a_scale_becomes_sizes(change_stays_in_place, about):
    assert tuple(change_stays_in_place(apply_scale, **about).scale) == (1.0, 1.0, 1.0)


@pytest.mark.parametrize(
    "about, words",
    [
        (dict(shape="TORUS", scale=(1.0, 2.0, 1.0)), "one size for directions"),
        (dict(text="r = slider(0.4, 0.1, 0.5)\nsphere(r)", scale=(2.0, 2.0, 2.0)), "narrow limits"),
        (dict(text="sphere(0.4)", scale=(2.0, 2.0, 2.0)), "sizes that are not parameters"),
        (dict(shape="BOX", scale=(1.0, 2.0, 1.0), emission="CORE"), "pattern"),
    ],
)
def test_a_scale_that_cannot_become_sizes_stays_with_the_reason(change_stays_in_place, about, words):
    with pytest.raises(RenderError, match=words):
        change_stays_in_place(apply_scale, **about)
    assert tuple(bpy.data.objects["Lamp"].scale) == pytest.approx(about["scale"])


@pytest.mark.parametrize(
    "about", [dict(shape="HEMISPHERE"), dict(text="q = p - (1, 0, 0)\nfield(length(q) - 0.5) & box(5)  # a ball")]
)
def test_the_origin_comes_to_the_middle_of_the_body(change_stays_in_place, about):
    obj = change_stays_in_place(origin_to_geometry, **about)
    points = points_of(shape_of(obj.data.sdf_lamp))
    assert points.min(axis=0) + points.max(axis=0) == pytest.approx([0.0, 0.0, 0.0], abs=0.02)
    assert origin_to_geometry(obj) is False


def test_other_engines_get_size_and_colour_and_keep_nodes_of_the_user(file, add, lamp):
    light = lamp(radius=0.4)
    light.sdf_lamp.emission.source = "FLAME"
    fallback.follow(light)
    node = fallback._own_node(light)
    red, green, blue, _ = node.inputs["Color"].default_value
    assert light.shadow_soft_size == pytest.approx(0.4) and red == pytest.approx(1.0) and red > green > blue
    # The mean of the channels is that of the light without a pattern.
    assert node.inputs["Strength"].default_value * (red + green + blue) == pytest.approx(3.0, rel=0.02)
    other = lamp("Other")
    tree = fallback.use_nodes(other)
    tree.nodes.new("ShaderNodeLightFalloff")
    other.sdf_lamp.emission.source = "FLAME"
    fallback.follow(other)
    assert fallback._own_node(other) is None
