# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What panels tell of lamps: readouts, warnings with their culprit, texts that change; and the arrows of primitives."""

import math

import bpy
import numpy as np
import pytest

from sdf_lights.blender import feedback, gizmos, live_text, parameters, readout
from sdf_lights.blender.lamp import pattern_of, shape_of
from sdf_lights.blender.naming import ENGINE
from sdf_lights.blender.properties import PRIMITIVES
from sdf_lights.sdf.expression import evaluate


@pytest.mark.parametrize("text", ["rotate_x(twist(torus(0.5, 0.2), 90), 30)", "gyroid() & sphere(0.5)", "mandelbulb()"])
def test_estimates_of_volumes_are_as_good_as_they_say(text):
    shape = evaluate(text)
    found = readout.estimate(shape, None, 0.3)
    points = np.random.default_rng(9).uniform(*shape.bounds(), (60_000, 3))
    share = (shape.distance(points) <= 0.0).mean()
    box = np.prod(np.subtract(*shape.bounds()[::-1]))
    error = math.hypot(found.error, math.sqrt(share * (1.0 - share) / len(points)) * box)
    assert found.value == pytest.approx(share * box, abs=4.0 * error)


def test_readout(file, lamp):
    light = lamp(shape="SPHERE", radius=0.5, power=80.0)
    light.exposure = 1.0
    lines = readout.facts(shape_of(light.sdf_lamp), np.diag([2.0, 1.0, 1.0, 1.0]), light)
    assert lines == ["Volume: 1.047 m³", "Power: 160 W", "Bounds: 2 × 1 × 1 m"]
    details = readout.details(shape_of(light.sdf_lamp))
    assert list(details) == ["Field: exact distance", "Tree: 1 part", "Rays: closed form, 1 instruction"]
    light.sdf_lamp.normalize, light.sdf_lamp.density = False, 3.0
    lines = readout.facts(shape_of(light.sdf_lamp), np.eye(4), light)
    assert lines[1] == f"Power: {4 * math.pi * 6.0 * math.pi / 6:.4g} W"


def test_readout_of_an_emission_that_varies(file, lamp):
    """Of a ball of radius 0.5, the mean height is a half."""
    light = lamp(shape="SPHERE", radius=0.5)
    light.sdf_lamp.normalize, light.sdf_lamp.density = False, 3.0
    light.sdf_lamp.emission.source, light.sdf_lamp.emission.expression = "EXPRESSION", "height"
    shape, pattern = shape_of(light.sdf_lamp), pattern_of(light.sdf_lamp)
    readout._found[shape, pattern] = found = readout.estimate(shape, pattern, 0.3)
    assert found.glow == pytest.approx(0.5, abs=4.0 * 0.23 / math.sqrt(1000))
    assert readout.facts(shape, np.eye(4), light, pattern)[1] == (
        f"Power: about {4 * math.pi * 3.0 * found.value * found.glow:.4g} W"
    )


def test_feedback_tells_of_emissions(file, add, lamp):
    data = lamp()
    data.sdf_lamp.emission.source, data.sdf_lamp.emission.expression = "EXPRESSION", "exp(-dept)"
    add("Dim", data)
    ((name, sentence),) = feedback.of_lamps(file.scene)
    assert name == "Dim" and sentence.startswith("Lamp 'Dim': In its emission: Line 1, column 6")


def test_the_tab_is_there_for_lamps_with_every_engine(file, add, lamp):
    panels = [
        getattr(bpy.types, name) for name in ("SDFLIGHTS_PT_view3d", "SDFLIGHTS_PT_presets", "SDFLIGHTS_PT_feedback")
    ]
    light = add("Lamp", lamp())
    other = add("Plain", bpy.data.lights.new("Plain", "POINT"))
    for engine, of_other in ((ENGINE, True), ("CYCLES", False), ("BLENDER_WORKBENCH", False)):
        file.scene.render.engine = engine
        for obj, there in ((light, True), (other, of_other), (None, of_other)):
            bpy.context.view_layer.objects.active = obj
            assert all(panel.poll(bpy.context) == there for panel in panels), (engine, obj)


def test_feedback_names_the_culprit(file, add, lamp):
    broken = lamp("Broken Data")
    broken.sdf_lamp.source, broken.sdf_lamp.expression = "EXPRESSION", "spere(1)"
    add("Broken", broken)
    add("Fine", lamp())
    found = feedback.of_lamps(file.scene)
    assert [name for name, _ in found] == ["Broken"] and "did you mean sphere?" in found[0][1]
    assert feedback.culprit("Lamp 'Broken' is left out.") == "Broken"
    assert feedback.culprit("Light 'Broken Data' is odd.") == "Broken"
    assert feedback.culprit("Nothing 'Nowhere' here") == ""
    assert bpy.ops.sdf_lights.culprit_select(name="Broken") == {"FINISHED"}
    assert bpy.context.object.name == "Broken" and bpy.context.selected_objects == [bpy.context.object]


def test_feedback_keeps_what_the_last_render_said(stage, add, lamp, file):
    broken = lamp()
    broken.sdf_lamp.source, broken.sdf_lamp.expression = "EXPRESSION", "box("
    add("Broken", broken)
    bpy.ops.render.render()
    said = feedback._last[file.scene.name]
    assert any("'Broken'" in sentence for sentence in said)
    assert bpy.ops.sdf_lights.feedback_clear() == {"FINISHED"} and not feedback._last


def test_lamps_follow_their_text_while_it_is_typed(file, lamp):
    light = lamp()
    text = bpy.data.texts.new("Text")
    text.write("sphere(0.5)")
    light.sdf_lamp.source, light.sdf_lamp.text = "EXPRESSION", text
    live_text.look()
    text.clear()
    text.write("size = slider(1, 0.1, 3)\nsphere(size)")
    assert "sdf_size" not in light.keys()
    assert live_text.look() > 0.0 and live_text.changed_texts() == set()
    assert light["sdf_size"] == 1.0 and parameters.declarations(light.sdf_lamp)


def test_the_line_of_a_mistake_is_found(file, add, lamp):
    light = lamp()
    text = bpy.data.texts.new("Text")
    text.write("a = 1\nb = 2\nbox(a, spere)\n")
    light.sdf_lamp.source, light.sdf_lamp.text = "EXPRESSION", text
    bpy.context.view_layer.objects.active = add("Lamp", light)
    assert bpy.ops.sdf_lights.expression_show() == {"FINISHED"}
    assert (text.current_line_index, text.current_character) == (2, 7)


@pytest.mark.parametrize("name", PRIMITIVES)
def test_arrows_are_of_lengths_that_the_shape_has(name):
    lengths = {about.name: about for about in PRIMITIVES[name].fields() if about.unit == "LENGTH"}
    listed = gizmos.handles(name)
    assert listed and {handle.name for handle in listed} <= set(lengths)
    assert all((handle.component >= 0) == (lengths[handle.name].size == 3) for handle in listed)


@pytest.mark.parametrize("name", PRIMITIVES)
def test_an_arrow_that_is_dragged_too_far_leaves_a_shape(name):
    kind = PRIMITIVES[name]
    values = {about.name: about.default for about in kind.fields()}
    for handle in gizmos.handles(name):
        for wanted in (-5.0, 0.0, 1e-4, 100.0):
            value = gizmos.held(name, values, handle, wanted)
            shape = kind(**gizmos._with(values, handle, value))
            assert not shape.validate()
            if not kind(**gizmos._with(values, handle, wanted)).validate():
                assert value == wanted


def test_an_arrow_stops_where_the_shape_would_end():
    values = {about.name: about.default for about in PRIMITIVES["box_frame"].fields()}
    (handle,) = (handle for handle in gizmos.handles("box_frame") if handle.name == "thickness")
    limit = gizmos.held("box_frame", values, handle, 50.0)
    assert PRIMITIVES["box_frame"](**values | {"thickness": 1.01 * limit}).validate()


def test_arrows_of_a_box_end_on_its_faces():
    assert [(h.component, h.axis, h.factor) for h in gizmos.handles("box")] == [(0, 0, 1.0), (1, 1, 1.0), (2, 2, 1.0)]
    assert [(h.name, h.axis, h.factor) for h in gizmos.handles("cylinder")] == [("radius", 0, 1.0), ("height", 2, 2.0)]
