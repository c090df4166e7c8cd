# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Expressions as artists meet them: parameters as properties, mistakes in the panel, examples from the menu."""

import math

import bpy
import pytest

from sdf_lights.blender import lamp_panels, operators, parameters
from sdf_lights.blender.lamp import shape_of
from sdf_lights.render.errors import RenderError
from sdf_lights.sdf import expression
from sdf_lights.sdf.examples import examples
from sdf_lights.sdf.shapes import Box, Sphere, Torus
from tests.blender.layouts import Layout

TEXT = """\
size = slider(1, 0.5, 3)         # how large it is
count = integer(5, 1, 9)
open = toggle(True)              # whether it is open
turn = angle(45, -90, 90)
place = vector((0, 1, 2), -4, 4)
body = torus(size, 0.1) if open else sphere(size)
for i in range(count):
    body = body | translate(rotate_z(box(0.1), turn), place)
body
"""


@pytest.fixture
def written(file, add, lamp):
    """Function: the data of a lamp in the scene, with an expression; as a text block if it has several lines."""

    def run(text: str):
        data = lamp()
        data.sdf_lamp.source = "EXPRESSION"
        if "\n" in text:
            block = bpy.data.texts.new("Shape")
            block.write(text)
            data.sdf_lamp.text = block
        else:
            data.sdf_lamp.expression = text
        bpy.context.view_layer.objects.active = add("Lamp", data)
        return data

    return run


def drawn(data) -> list:
    found: list = []
    lamp_panels.draw_shape(Layout(found), data, None, 40)
    lamp_panels.draw_readout(Layout(found), data, None, 40)
    lamp_panels.draw_details(Layout(found), data, None)
    return found


def test_parameters_become_properties_with_limits_and_descriptions(written):
    data = written(TEXT)
    assert data["sdf_size"] == 1.0 and data["sdf_count"] == 5 and data["sdf_open"] is True
    assert data["sdf_turn"] == pytest.approx(math.pi / 4) and list(data["sdf_place"]) == [0.0, 1.0, 2.0]
    names = ("size", "count", "open", "turn", "place")
    about = {name: data.id_properties_ui(f"sdf_{name}").as_dict() for name in names}
    assert (about["size"]["min"], about["size"]["max"], about["size"]["default"]) == (0.5, 3.0, 1.0)
    assert about["size"]["description"] == "how large it is" and about["open"]["description"] == "whether it is open"
    assert (about["count"]["min"], about["count"]["max"]) == (1, 9)
    assert about["turn"]["subtype"] == "ANGLE" and about["turn"]["max"] == pytest.approx(math.pi / 2)
    assert about["place"]["subtype"] == "XYZ" and about["place"]["min"] == -4.0
    assert data.is_property_overridable_library('["sdf_size"]')


def test_values_reach_the_shape(written, synced):
    data = written(
        "size = slider(1, 0.5, 3)\nopen = toggle(True)\nturn = angle(90)\n"
        "torus(size, turn / 900) if open else sphere(size)"
    )
    assert shape_of(data.sdf_lamp) == Torus(1.0, 0.1)
    data["sdf_size"] = 2.0
    assert shape_of(data.sdf_lamp) == Torus(2.0, 0.1)
    data["sdf_turn"] = math.pi
    assert shape_of(data.sdf_lamp).minor_radius == pytest.approx(0.2)
    data["sdf_size"], data["sdf_open"] = 99.0, False  # held to the limits
    assert shape_of(data.sdf_lamp) == Sphere(3.0)
    assert synced().lamps[0].shape == Sphere(3.0)
    del data["sdf_size"]
    data["sdf_size"] = "wide"  # a script can put anything there
    assert shape_of(data.sdf_lamp) == Sphere(1.0)


def test_moving_a_slider_parses_and_compiles_nothing(written, monkeypatch):
    data = written("size = slider(1, 0.5, 3)\nlength(p) - size * (1 + 0.1 * sin(9 * p.x))")
    formula = shape_of(data.sdf_lamp).formula()
    monkeypatch.setattr(expression, "parse", lambda text: pytest.fail("parsed again"))
    data["sdf_size"] = 1.5
    assert shape_of(data.sdf_lamp).formula() is formula
    assert shape_of(data.sdf_lamp).parameters() == [1.5]


def test_parameters_are_animated_and_driven(written, file, synced):
    data = written("size = slider(1, 0.5, 3)\nplace = vector((0, 0, 0))\ntranslate(sphere(size), place)")
    for frame, size in ((1, 1.0), (11, 2.0)):
        data["sdf_size"] = size
        data.keyframe_insert('["sdf_size"]', frame=frame)
    driver = data.driver_add('["sdf_place"]', 2).driver
    driver.expression = "0.25"
    file.scene.frame_set(6)
    shape = synced().lamps[0].shape
    assert shape.child.radius == pytest.approx(1.5)
    assert shape.matrix[2][3] == pytest.approx(0.25)


def test_parameters_are_saved_with_the_file(written, tmp_path):
    data = written(TEXT)
    data["sdf_size"] = 2.5
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "lamp.blend"))
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "lamp.blend"))
    kept = bpy.data.lights["Lamp"]
    assert kept["sdf_size"] == 2.5 and kept.id_properties_ui("sdf_size").as_dict()["max"] == 3.0
    assert shape_of(kept.sdf_lamp).children[0] == Torus(2.5, 0.1)


def test_values_outlive_changes_of_the_text(written):
    data = written("size = slider(1, 0.5, 3)\nsphere(size)")
    data["sdf_size"] = 2.0
    text = data.sdf_lamp.text
    for content, present in (("sphere(1", True), ("sphere(1)", True), ("size = slider(1, 0.5, 3)\nbox(size)", True)):
        text.clear()
        text.write(content)
        parameters.update(data)
        assert ("sdf_size" in data) == present
    assert shape_of(data.sdf_lamp) == Box(2.0)
    text.clear()
    text.write("size = slider(0.1, 0.05, 0.75)\nsphere(size)")  # other limits
    assert parameters.missing(data.sdf_lamp)
    parameters.update(data)
    assert not parameters.missing(data.sdf_lamp)
    assert data["sdf_size"] == 0.75 and data.id_properties_ui("sdf_size").as_dict()["max"] == 0.75
    text.clear()
    text.write("size = integer(3, 2, 5)\nsphere(size)")  # another kind
    parameters.update(data)
    assert type(data["sdf_size"]) is int and data["sdf_size"] == 2


def test_unused_parameters_are_removed_on_demand(written):
    data = written("size = slider(1, 0.5, 3)\nsphere(size)")
    data["own"] = 1.0
    assert parameters.unused(data) == []
    data.sdf_lamp.text = None
    data.sdf_lamp.expression = "sphere(1"
    assert parameters.unused(data) == []  # it may be put right
    data.sdf_lamp.expression = "sphere(1)"
    assert parameters.unused(data) == ["sdf_size"]
    assert ("operator", "sdf_lights.parameters_remove") in [entry[:2] for entry in drawn(data)]
    assert bpy.ops.sdf_lights.parameters_remove() == {"FINISHED"}
    assert "sdf_size" not in data and data["own"] == 1.0
    assert data.sdf_lamp.use and shape_of(data.sdf_lamp) == Sphere(1.0)


def test_panel_shows_parameters_and_what_is_known_of_the_shape(written):
    found = drawn(written(TEXT))
    properties = [entry[1:] for entry in found if entry[0] == "prop"]
    assert ('["sdf_size"]', "Size") in properties and ('["sdf_place"]', "Place") in properties
    labels = [entry[1] for entry in found if entry[0] == "label"]
    assert "Field: distance never overestimated" in labels and any(label.startswith("Bounds: ") for label in labels)


def test_panel_shows_where_a_mistake_is_and_its_cure(written):
    data = written("size = slider(1, 0.5, 3)\nsphere(siez)")
    labels = [entry[1:] for entry in drawn(data) if entry[0] == "label"]
    assert labels == [
        ("Line 2, column 8:", "ERROR"),
        ("siez is not a known name", "BLANK1"),
        ("Did you mean size?", "BLANK1"),
        ("There is no shape", "NONE"),
    ]
    with pytest.raises(RenderError, match="In its expression: Line 2, column 8"):
        shape_of(data.sdf_lamp)


def test_panel_makes_the_properties_of_an_edited_text_block(written):
    data = written("size = slider(1, 0.5, 3)\nsphere(size)")
    data.sdf_lamp.text.clear()
    data.sdf_lamp.text.write("width = slider(1, 0.5, 3)\nbox(width)")
    drawn(data)
    assert "sdf_width" not in data and bpy.app.timers.is_registered(parameters._update_pending)
    parameters._update_pending()  # Blender does so between two redraws
    bpy.app.timers.unregister(parameters._update_pending)
    assert data["sdf_width"] == 1.0


def test_every_example_loads(written):
    data = written("sphere()")
    for name, example in examples().items():
        assert bpy.ops.sdf_lights.example_load(example=name.upper()) == {"FINISHED"}
        assert data.sdf_lamp.text.as_string() == example.text and data.sdf_lamp.text.name.startswith(example.title)
        shape_of(data.sdf_lamp)
        assert all(parameters.exists(data, declared) for declared in parameters.declarations(data.sdf_lamp))


def test_loading_an_example_can_be_undone(written):
    data = written("sphere()")
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.sdf_lights.example_load(example="METABALLS")
    bpy.ops.ed.undo_push(message="loaded")
    data["sdf_melt"] = 0.7
    bpy.ops.ed.undo_push(message="moved")
    bpy.ops.ed.undo()
    assert bpy.data.lights["Lamp"]["sdf_melt"] == 0.4
    bpy.ops.ed.undo()
    kept = bpy.data.lights["Lamp"]
    assert kept.sdf_lamp.text is None and "sdf_melt" not in kept and shape_of(kept.sdf_lamp) == Sphere()
    bpy.ops.ed.redo()
    assert bpy.data.lights["Lamp"].sdf_lamp.text.name == "Metaballs"


def test_an_example_is_added_as_a_lamp(file):
    bpy.ops.sdf_lights.lamp_add(source="EXAMPLE", example="CHAIN", power=50.0)
    data = bpy.context.object.data
    assert data.energy == 50.0 and data.sdf_lamp.use and data["sdf_links"] == 6
    assert [item[0] for item in operators.example_items()] == [name.upper() for name in examples()]


def test_an_expression_becomes_a_text_block(written):
    data = written("torus(1, 0.25)")
    assert bpy.ops.sdf_lights.expression_to_text() == {"FINISHED"}
    assert data.sdf_lamp.text.as_string() == "torus(1, 0.25)" and shape_of(data.sdf_lamp) == Torus(1.0, 0.25)


def test_linked_lights_are_left_alone(written, tmp_path, file):
    data = written("size = slider(1, 0.5, 3)\nsphere(size)")
    data["sdf_size"] = 2.0
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (source, target):
        target.lights = ["Lamp"]
    linked = bpy.data.lights["Lamp"]
    parameters.update(linked)
    assert not parameters.missing(linked.sdf_lamp) and shape_of(linked.sdf_lamp) == Sphere(2.0)
    override = linked.override_create()
    override["sdf_size"] = 2.5
    assert shape_of(override.sdf_lamp) == Sphere(2.5) and shape_of(linked.sdf_lamp) == Sphere(2.0)
