# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Emission that varies, from Blender's properties to the scene and the picture."""

import bpy
import numpy as np
import pytest

from sdf_lights.blender import emission, emission_panel, parameters
from sdf_lights.blender.lamp import pattern_of
from sdf_lights.render.errors import RenderError
from sdf_lights.sdf.emission import EmissionExpression
from sdf_lights.sdf.emission_presets import presets
from sdf_lights.sdf.expression import ExpressionError
from sdf_lights.sdf.shapes import Sphere
from tests.blender.layouts import Layout

POINTS = np.random.default_rng(1).uniform(-0.3, 0.3, (50, 3))


def colours(found):
    return found.placed(Sphere(0.5)).evaluate(POINTS)


def drawn(data) -> list:
    found: list = []
    emission_panel.draw(Layout(found), data, 40)
    return found


@pytest.fixture
def data(file, add, lamp):
    """The data of a ball lamp of radius 0.5 in the scene."""
    made = lamp(radius=0.5)
    bpy.context.view_layer.objects.active = add("Lamp", made)
    return made


def test_lamps_are_uniform_at_first(data, synced):
    assert data.sdf_lamp.emission.source == "UNIFORM" and pattern_of(data.sdf_lamp) is None
    assert synced().lamps[0].emission is None


@pytest.mark.parametrize("name", presets())
def test_presets_with_their_parameters(data, synced, name):
    data.sdf_lamp.emission.source = name.upper()
    expression = EmissionExpression(presets()[name].text)
    for declared in expression.parameters:
        key = f"sdf_emission.{declared.name}"
        about = data.id_properties_ui(key).as_dict()
        assert about["description"] == declared.description
        assert (about["min"], about["max"]) == (declared.minimum, declared.maximum)
    if name != "uniform":
        assert synced().lamps[0].emission == expression.emission()


def test_a_parameter_reaches_the_scene(data, synced):
    data.sdf_lamp.emission.source = "SHELL"
    data["sdf_emission.thickness"] = 0.2
    expected = EmissionExpression("exp(-depth / 0.2)").emission()
    assert np.allclose(colours(synced().lamps[0].emission), colours(expected))
    data["sdf_emission.thickness"] = 50.0  # held to its limits
    assert np.allclose(colours(pattern_of(data.sdf_lamp)), colours(EmissionExpression("exp(-depth / 2)").emission()))


def test_an_animated_parameter(data, synced):
    data.sdf_lamp.emission.source = "SHELL"
    for frame, value in ((1, 0.1), (11, 0.3)):
        data["sdf_emission.thickness"] = value
        data.keyframe_insert('["sdf_emission.thickness"]', frame=frame)
    bpy.context.scene.frame_set(11)
    expected = EmissionExpression("exp(-depth / 0.3)").emission()
    assert np.allclose(colours(synced().lamps[0].emission), colours(expected))


def test_parameters_of_shape_and_emission_are_apart(data, synced):
    lamp = data.sdf_lamp
    lamp.source, lamp.expression = "EXPRESSION", "sphere(0.4)"
    lamp.text = bpy.data.texts.new("Shape")
    lamp.text.write("size = slider(0.4, 0.1, 1)\nsphere(size)")
    lamp.emission.source = "CORE"
    parameters.update(data)
    assert data["sdf_size"] == pytest.approx(0.4) and data["sdf_emission.size"] == pytest.approx(0.2)
    data["sdf_size"] = 0.6
    scene = synced()
    assert scene.lamps[0].shape == Sphere(0.6)
    assert scene.lamps[0].emission == EmissionExpression(presets()["core"].text).emission()
    assert parameters.unused(data) == []
    lamp.emission.source = "UNIFORM"
    assert sorted(parameters.unused(data)) == ["sdf_emission.sharpness", "sdf_emission.size"]
    parameters.remove_unused(data)
    assert "sdf_size" in data and "sdf_emission.size" not in data


def test_an_expression_in_one_line_or_in_a_text_block(data, synced):
    settings = data.sdf_lamp.emission
    settings.source, settings.expression = "EXPRESSION", "height * (1, 0, 0)"
    assert np.allclose(colours(synced().lamps[0].emission)[:, 0], POINTS[:, 2] + 0.5)
    settings.text = bpy.data.texts.new("Glow")
    settings.text.write("a = slider(2, 0, 5)  # how bright\na * depth")
    parameters.update(data)
    assert data["sdf_emission.a"] == 2.0
    assert ("prop", '["sdf_emission.a"]', "A") in drawn(data)


def test_temperatures_have_blenders_unit(data):
    data.sdf_lamp.emission.source = "FLAME"
    for name in ("bottom", "top"):
        assert data.id_properties_ui(f"sdf_emission.{name}").as_dict()["subtype"] == "COLOR_TEMPERATURE"
    assert data.id_properties_ui("sdf_emission.fade").as_dict()["subtype"] == "NONE"
    shown = {path: text for kind, path, text in (entry for entry in drawn(data) if entry[0] == "prop")}
    assert shown['["sdf_emission.bottom"]'] == "Bottom Temperature" and shown['["sdf_emission.fade"]'] == "Fade"


def test_a_preset_becomes_a_text(data):
    data.sdf_lamp.emission.source = "FLAME"
    data["sdf_emission.top"] = 3000.0
    before = pattern_of(data.sdf_lamp)
    assert bpy.ops.sdf_lights.emission_to_text() == {"FINISHED"}
    settings = data.sdf_lamp.emission
    assert settings.source == "EXPRESSION" and settings.text.as_string().rstrip() == presets()["flame"].text.rstrip()
    assert pattern_of(data.sdf_lamp) == before and data["sdf_emission.top"] == 3000.0


def test_a_mistake_is_said_in_the_panel_and_by_the_render(data, synced):
    settings = data.sdf_lamp.emission
    settings.source, settings.expression = "EXPRESSION", "exp(-dept)"
    with pytest.raises(RenderError, match="In its emission: Line 1, column 6: dept is not a known name") as caught:
        pattern_of(data.sdf_lamp)
    assert isinstance(caught.value.__cause__, ExpressionError)
    assert any(entry[0] == "label" and entry[2] == "ERROR" for entry in drawn(data))
    scene = synced()
    assert not scene.lamps and "Lamp 'Lamp' is left out. In its emission: Line 1" in scene.warnings[0]


@pytest.mark.parametrize("name", presets())
def test_the_panel_draws(data, name):
    data.sdf_lamp.emission.source = name.upper()
    shown = [entry[1] for entry in drawn(data) if entry[0] == "prop"]
    declared = emission.declarations(data.sdf_lamp.emission)
    assert shown == ["source", *(f'["sdf_{declaration.name}"]' for declaration in declared)]


def test_a_lamp_shows_its_emission(data, file, pictures):
    """Seen from the side, a ball that is red below and blue above."""
    data.sdf_lamp.emission.source = "EXPRESSION"
    data.sdf_lamp.emission.expression = "ramp_constant(height, 0, (1, 0, 0), 0.5, (0, 0, 1))"
    bpy.data.objects["Lamp"].location = (0.0, 0.0, 1.0)
    (layer,) = pictures().values()
    picture = layer["Combined"]
    height = picture.shape[0]
    lower, upper = picture[: height // 2 - 1], picture[height // 2 + 1 :]
    assert lower[..., 0].max() > 0.1 and upper[..., 2].max() > 0.1
    assert lower[..., 2].max() < 1e-6 and upper[..., 0].max() < 1e-6


def test_blackbody_is_that_of_blender(data):
    """Within half a per cent of the brightness, at all temperatures that Blender takes."""
    data.use_temperature = True
    temperatures = np.geomspace(800, 20000, 60)
    ours = (
        EmissionExpression("blackbody(p.x)")
        .emission()
        .placed(Sphere(0.5))
        .evaluate(np.repeat(temperatures[:, None], 3, axis=1))
    )
    for temperature, colour in zip(temperatures, ours):
        data.temperature = temperature
        assert colour == pytest.approx(tuple(data.temperature_color), abs=0.008 if temperature < 1000 else 0.005)
