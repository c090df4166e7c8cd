# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nothing is silent: what a scene asks for and this engine lacks is told, in the report, before a render, and to
farms."""

import bpy
import pytest

from sdf_lights.blender import command_line, findings, scene_report

bpy.ops.preferences.addon_enable(module="cycles")


def collection(file, name: str):
    made = bpy.data.collections.new(name)
    file.scene.collection.children.link(made)
    return made


def fast_gi(file, **_):
    file.scene.cycles.use_fast_gi = True


def transparent_glass(file, **_):
    file.scene.render.film_transparent = file.scene.cycles.film_transparent_glass = True


def passes(file, **_):
    file.layer.use_pass_cryptomatte_object = file.layer.use_pass_shadow = True


def passes_of_our_own(file, **_):
    file.layer.cycles.denoising_store_passes = True


def many_shadows(file, light, **_):
    for index in range(13):
        other = light.copy()
        file.scene.collection.objects.link(other)
        other.light_linking.blocker_collection = collection(file, f"Blockers {index}")


def subdivision(floor, **_):
    modifier = floor.modifiers.new("Subdivision", "SUBSURF")
    owner = modifier if hasattr(modifier, "use_adaptive_subdivision") else floor.cycles
    owner.use_adaptive_subdivision = True


def shadow_terminator(floor, **_):
    floor.shadow_terminator_shading_offset = 0.2


def shadow_caustics(light, floor, **_):
    light.data.cycles.is_caustics_light = floor.cycles.is_caustics_caster = True


def custom_camera(file, **_):
    file.camera.data.type = "CUSTOM"


# What is done to the scene; the group of the sentence, and words in it.
CASES = {
    fast_gi: ("Scene", "Fast GI"),
    transparent_glass: ("Scene", "transparent glass"),
    passes: ("View Layers", "Shadow", "left out"),
    passes_of_our_own: ("View Layers", "Store Denoising Passes", "View Layer Properties > Passes"),
    many_shadows: ("Scene", "13 collections", "share collections"),
    subdivision: ("Objects", "'Floor'", "adaptive subdivision"),
    shadow_terminator: ("Objects", "'Floor'", "shadow terminator"),
    shadow_caustics: ("Scene", "Bulb", "noisier"),
    custom_camera: ("Camera", "'Camera'", "perspective"),
}


@pytest.fixture
def room(file, add, quad):
    """A floor under a light: nothing in it is to be told of."""
    floor = add("Floor", quad("Floor"))
    light = add("Bulb", bpy.data.lights.new("Bulb", "POINT"), (0.0, 0.0, 2.0))
    return dict(file=file, floor=floor, light=light)


def sentences(file) -> list[str]:
    bpy.context.view_layer.update()
    return scene_report.check(file.scene, bpy.context.evaluated_depsgraph_get())


def test_an_ordinary_scene_has_nothing_to_tell(room, file, synced):
    assert sentences(file) == [] and synced().warnings == []
    bpy.ops.wm.read_factory_settings(use_empty=False)
    bpy.context.scene.render.engine = "SDF_LIGHTS"
    assert scene_report.check(bpy.context.scene, bpy.context.evaluated_depsgraph_get()) == []


@pytest.mark.parametrize("change", CASES, ids=lambda change: change.__name__)
def test_it_is_told_once(room, file, synced, change):
    """In the report, and by a render."""
    change(**room)
    group, *words = CASES[change]
    (sentence,) = sentences(file)
    assert all(word in sentence for word in words), sentence
    assert findings.group_of(sentence) == group and sentence.endswith(".")
    assert synced().warnings == [sentence]


def test_a_switch_that_is_on_here_too_is_no_finding(room, file):
    file.layer.cycles.denoising_store_passes = file.layer.sdf_lights.use_pass_denoising_data = True
    file.layer.use_pass_normal = file.layer.use_pass_z = True
    assert sentences(file) == []


def test_hidden_things_are_no_findings(room, file, synced):
    shadow_terminator(**room)
    room["floor"].hide_render = True
    assert synced().warnings == []
    room["floor"].hide_render = False


# -- the report --------------------------------------------------------------------------------------------------------


def test_groups():
    found = findings.grouped(
        [
            "Material 'B': node 'X': odd.",
            "Object 'A' is odd.",
            "Scene 'S': odd.",
            "Something else.",
            "Material 'A': node 'Y': odd.",
            "Material 'B': node 'W': odd.",
            "Mesh 'M' is odd.",
            "Image “P” is odd.",
        ]
    )
    assert list(found) == ["Scene", "Objects", "Materials", "Images", "Others"]
    assert [sentence[9:12] for sentence in found["Materials"]] == ["'A'", "'B'", "'B'"]
    assert found["Materials"][1].endswith("'X': odd.") and found["Others"] == ["Something else."]
    assert len(findings.in_order(["Scene 'S': odd.", "World 'W': odd."])) == 2


def test_the_operator_fills_the_list(room, file, material):
    made, tree, output = material("Paint")
    node = tree.nodes.new("ShaderNodeScript")
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    tree.links.new(diffuse.outputs[0], output)
    tree.links.new(
        node.outputs.new("NodeSocketColor", "Out") if hasattr(node.outputs, "new") else node.outputs[0],
        diffuse.inputs["Color"],
    )
    room["floor"].data.materials.append(made)
    shadow_terminator(**room)
    other = bpy.data.objects.new("Other", room["floor"].data)
    file.scene.collection.objects.link(other)
    other.hide_viewport = True
    assert bpy.ops.sdf_lights.scene_check() == {"FINISHED"}
    report = scene_report._reports[file.scene.session_uid]
    assert list(report.groups) == ["Objects", "Materials"] and report.hidden == 1
    ((name, sentence),) = report.groups["Materials"]
    assert name in {"Floor", "Other"} and "'Paint'" in sentence
    assert report.groups["Objects"][0][0] == "Floor"


def test_the_operator_tells_of_what_stops_a_render(room, file):
    file.camera.scale = (0.0, 0.0, 0.0)
    (sentence,) = sentences(file)
    assert findings.group_of(sentence) == "Camera" and "scale" in sentence
    file.scene.camera = None
    assert bpy.ops.sdf_lights.scene_check() == {"FINISHED"}
    assert "no camera" in sentences(file)[0]


def test_lamps_are_told_of(room, file, add, lamp):
    broken = lamp()
    broken.sdf_lamp.source, broken.sdf_lamp.expression = "EXPRESSION", "spere(1)"
    add("Broken", broken)
    found = sentences(file)
    assert found and all("'Broken'" in sentence for sentence in found)
    assert all(findings.group_of(sentence) == "Lights" for sentence in found)


# -- farms -------------------------------------------------------------------------------------------------------------


def test_findings_are_printed_before_the_render(room, file, capfd):
    shadow_terminator(**room)
    fast_gi(**room)
    bpy.ops.render.render()
    told = "".join(capfd.readouterr())
    assert told.index("Fast GI is not supported") < told.index("shadow terminator is not supported")


@pytest.mark.parametrize("by", ["argument", "environment"])
def test_a_strict_render_fails(room, file, monkeypatch, by):
    if by == "argument":
        monkeypatch.setattr("sys.argv", ["blender", "--", "--sdf-strict"])
    else:
        monkeypatch.setenv("SDF_LIGHTS_STRICT", "1")
    assert bpy.ops.render.render() == {"FINISHED"}
    fast_gi(**room)
    shadow_terminator(**room)
    with pytest.raises(RuntimeError, match="2 items are not rendered as the scene says"):
        bpy.ops.render.render()


def test_only_arguments_after_the_dashes_are_ours(monkeypatch):
    monkeypatch.delenv("SDF_LIGHTS_STRICT", raising=False)
    for arguments, expected in (
        ([], False),
        (["--sdf-strict"], False),
        (["--", "--sdf-strict"], True),
        (["--", "--strict"], True),
    ):
        monkeypatch.setattr("sys.argv", ["blender", *arguments])
        assert command_line.strict() == expected
