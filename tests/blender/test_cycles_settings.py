# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of Cycles that are taken over: which, when, and when not."""

import dataclasses
import pathlib

import bpy
import pytest

from sdf_lights.blender import cycles, cycles_table, properties, sampling_presets
from sdf_lights.blender.naming import ENGINE
from sdf_lights.render.settings import Filter, Settings

pytest.importorskip("_cycles")

# What only this engine has.
OUR_OWN = {"device", "lamp_sampling", "indirect_paths", "guided_samples", "lamp_paths", "path_reuse", "caustic_paths"}

MADE = {
    "samples": 77,
    "adaptive_threshold": 0.02,
    "adaptive_min_samples": 40,
    "time_limit": 12.0,
    "seed": 5,
    "use_animated_seed": True,
    "max_bounces": 9,
    "diffuse_bounces": 3,
    "glossy_bounces": 2,
    "transmission_bounces": 7,
    "volume_bounces": 1,
    "transparent_max_bounces": 6,
    "sample_clamp_direct": 2.0,
    "sample_clamp_indirect": 4.0,
    "caustics_reflective": False,
    "caustics_refractive": True,
    "blur_glossy": 0.75,
    "pixel_filter_type": "GAUSSIAN",
    "filter_width": 2.0,
    "film_exposure": 1.5,
    "use_denoising": True,
    "preview_samples": 0,
    "preview_adaptive_threshold": 0.05,
    "preview_adaptive_min_samples": 0,
    "use_preview_denoising": True,
    "use_layer_samples": "BOUNDED",
}

FINAL = dict(
    samples=77,
    noise_threshold=pytest.approx(0.1),
    min_samples=40,
    time_limit=12.0,
    seed=5,
    animate_seed=True,
    max_bounces=9,
    diffuse_bounces=3,
    glossy_bounces=2,
    transmission_bounces=7,
    volume_bounces=1,
    transparent_bounces=6 if bpy.app.version >= (5, 0) else 7,
    clamp_direct=6.0,
    clamp_indirect=12.0,
    caustics_reflective=False,
    caustics_refractive=True,
    filter_glossy=0.75,
    filter=Filter.GAUSSIAN,
    filter_width=2.0,
    exposure=1.5,
    denoise=True,
)

VIEWPORT = FINAL | dict(samples=1 << 24, noise_threshold=pytest.approx(0.25), min_samples=40, time_limit=0.0)


@pytest.fixture
def scene(registered):
    """The scene of a file that was never rendered by this engine."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="cycles")
    return bpy.context.scene


def make(scene) -> None:
    for name, value in MADE.items():
        setattr(scene.cycles, name, value)


def saved(scene, tmp_path, engine: str):
    """The scene, saved with an engine and opened again."""
    scene.render.engine = engine
    path = str(tmp_path / "file.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    return bpy.context.scene


def has(settings: Settings, expected: dict) -> None:
    found = dataclasses.asdict(settings)
    assert {name: found[name] for name in expected} == expected


def is_ours(settings: Settings, **changes) -> None:
    """Our defaults, but for the changes. Blender's numbers are of single precision."""
    has(settings, dataclasses.asdict(Settings(**changes)) | dict(noise_threshold=pytest.approx(0.01)))


def test_every_setting_of_ours_has_its_row():
    """A new setting is in the table of cycles_table.py, or is named above as ours alone."""
    rows = [row.ours for row in cycles_table.ROWS if row.ours]
    ours = {field.name for field in dataclasses.fields(Settings)} - properties.BLENDERS_OWN.keys() - OUR_OWN
    viewport = {f"viewport.{name}" for name in properties.VIEWPORT} - {"viewport.time_limit"}
    assert len(rows) == len(set(rows)) and set(rows) == ours | viewport | {"layer_samples"}


def test_every_setting_of_cycles_is_in_the_table(scene):
    listed = [name for row in cycles_table.ROWS for name in row.cycles]
    assert len(listed) == len(set(listed))
    found = set(scene.cycles.bl_rna.properties.keys()) - {"rna_type", "name"}
    assert {name for name in found if not name.startswith(cycles_table.UNRELATED)} <= set(listed)
    for row in cycles_table.ROWS:
        assert row.read is None or set(row.cycles) <= found, row


def test_a_file_of_cycles_is_rendered_with_its_settings(scene, tmp_path):
    """As ``blender -b FILE -E SDF_LIGHTS`` does: nothing writes the settings, nor has to."""
    make(scene)
    scene = saved(scene, tmp_path, "CYCLES")
    scene.render.engine = ENGINE
    has(properties.settings_of(scene), FINAL)
    has(properties.settings_of(scene, viewport=True), VIEWPORT)
    evaluated = bpy.context.evaluated_depsgraph_get().scene_eval
    has(properties.settings_of(evaluated), FINAL)
    assert scene.sdf_lights.origin == "UNKNOWN" and scene.sdf_lights.samples == Settings().samples


def test_defaults_of_cycles_are_settings_too(scene, tmp_path):
    scene = saved(scene, tmp_path, "CYCLES")
    scene.render.engine = ENGINE
    has(
        properties.settings_of(scene),
        dict(
            samples=4096,
            noise_threshold=pytest.approx(0.05),
            min_samples=64,
            clamp_indirect=30.0,
            animate_seed=False,
            denoise=True,
        ),
    )
    viewport = properties.settings_of(scene, viewport=True)
    has(viewport, dict(samples=1024, noise_threshold=pytest.approx(0.5), min_samples=32, denoise=False))


def test_settings_are_copied_once(scene, tmp_path):
    """By what tells of a new engine in a window, or by saving; later changes stay."""
    make(scene)
    scene = saved(scene, tmp_path, "CYCLES")
    scene.render.engine = ENGINE
    cycles._engine_changed()
    assert scene.sdf_lights.origin == "CYCLES"
    has(properties.settings_of(scene), FINAL)
    scene.sdf_lights.samples, scene.cycles.seed = 3, 99
    scene.render.engine = "CYCLES"
    scene = saved(scene, tmp_path, ENGINE)
    has(properties.settings_of(scene), FINAL | dict(samples=3))
    assert bpy.ops.sdf_lights.cycles_settings_copy() == {"FINISHED"}
    has(properties.settings_of(scene), FINAL | dict(seed=99))


def test_a_copy_can_be_undone(scene):
    scene.render.engine = ENGINE
    cycles._engine_changed()
    before = properties.settings_of(scene).samples
    scene.cycles.samples = before + 1
    assert {"REGISTER", "UNDO"} <= cycles.SDFLIGHTS_OT_cycles_settings_copy.bl_options
    bpy.ops.ed.undo_push(message="Before")
    assert bpy.ops.sdf_lights.cycles_settings_copy() == {"FINISHED"}
    assert properties.settings_of(bpy.context.scene).samples == before + 1
    bpy.ops.ed.undo_push(message="Copy")
    bpy.ops.ed.undo()
    assert properties.settings_of(bpy.context.scene).samples == before
    bpy.ops.ed.redo()
    assert properties.settings_of(bpy.context.scene).samples == before + 1


def test_saving_settles(scene, tmp_path):
    make(scene)
    scene = saved(scene, tmp_path, "CYCLES")
    scene = saved(scene, tmp_path, ENGINE)
    assert scene.sdf_lights.origin == "CYCLES"
    has(properties.settings_of(scene), FINAL)


def test_what_a_script_sets_stays(scene, tmp_path):
    """Whether before or after the engine is chosen, as with ``--python-expr`` on a farm."""
    make(scene)
    for first in (True, False):
        scene = saved(scene, tmp_path, "CYCLES")
        if first:
            scene.sdf_lights.samples = 16
        scene.render.engine = ENGINE
        if not first:
            scene.sdf_lights.samples = 16
        has(properties.settings_of(scene), FINAL | dict(samples=16))
        assert scene.sdf_lights.origin == ("UNKNOWN" if first else "CYCLES")
        bpy.ops.wm.read_factory_settings(use_empty=True)
        scene = bpy.context.scene
        make(scene)


def test_a_script_may_choose_one_engine_after_the_other(scene):
    scene.render.engine = "CYCLES"
    make(scene)
    scene.render.engine = ENGINE
    has(properties.settings_of(scene), FINAL)
    fresh = bpy.data.scenes.new("Fresh")
    make(fresh)
    fresh.render.engine = ENGINE
    has(properties.settings_of(fresh), FINAL)


def test_scenes_of_ours_keep_our_defaults(scene, tmp_path):
    scene.render.engine = ENGINE
    is_ours(properties.settings_of(scene))
    cycles._engine_changed()
    assert scene.sdf_lights.origin == "OWN"
    make(scene)
    is_ours(properties.settings_of(scene))
    scene = saved(scene, tmp_path, "CYCLES")
    scene.render.engine = ENGINE
    is_ours(properties.settings_of(scene))


@pytest.mark.parametrize("engine", [ENGINE, "CYCLES"])
def test_old_files_of_ours_keep_their_values(scene, tmp_path, engine):
    """Such a file has no origin, but settings: of another version that knew nothing of Cycles'."""
    make(scene)
    scene.sdf_lights.samples = 16
    scene.render.engine = engine
    bpy.app.handlers.save_pre.remove(cycles._saving)
    try:
        scene = saved(scene, tmp_path, engine)
    finally:
        bpy.app.handlers.save_pre.append(cycles._saving)
    assert scene.sdf_lights.origin == "OWN"
    scene.render.engine = ENGINE
    is_ours(properties.settings_of(scene), samples=16)


def test_old_files_had_one_switch_for_caustics(scene):
    settings = scene.sdf_lights
    stored = (
        settings.bl_system_properties_get(do_create=True) if hasattr(settings, "bl_system_properties_get") else settings
    )
    stored["caustics"] = False
    cycles._loaded()
    assert not settings.caustics_reflective and not settings.caustics_refractive and settings.origin == "OWN"
    settings.caustics_reflective = True
    cycles._loaded()
    assert settings.caustics_reflective


@pytest.mark.parametrize(
    ("rule", "asked", "expected"),
    [("USE", 0, 77), ("USE", 12, 12), ("USE", 99, 99), ("BOUNDED", 12, 12), ("BOUNDED", 99, 77), ("IGNORE", 12, 77)],
)
def test_samples_of_a_view_layer(file, synced, rule, asked, expected):
    file.scene.sdf_lights.samples, file.scene.sdf_lights.layer_samples = 77, rule
    file.layer.samples = asked
    assert synced().settings.samples == expected


def test_a_view_layer_may_stay_noisy(file, synced):
    bpy.ops.preferences.addon_enable(module="cycles")
    file.scene.sdf_lights.denoise = True
    assert synced().settings.denoise
    file.layer.cycles.use_denoising = False
    assert not synced().settings.denoise


def test_without_the_add_on_of_cycles_it_is_told(scene, tmp_path):
    make(scene)
    scene = saved(scene, tmp_path, "CYCLES")
    scene.render.engine = ENGINE
    assert cycles.missing(scene) == ""
    bpy.ops.preferences.addon_disable(module="cycles")
    try:
        assert "enable the add-on" in cycles.missing(scene)
        is_ours(properties.settings_of(scene))
    finally:
        bpy.ops.preferences.addon_enable(module="cycles")


@pytest.mark.parametrize("name", ["sampling", "viewport_sampling"])
def test_presets_of_sampling(file, name):
    panel = getattr(bpy.types, f"SDFLIGHTS_PT_{name}_presets")
    group = file.scene.sdf_lights.viewport if name.startswith("viewport") else file.scene.sdf_lights
    folders = bpy.utils.preset_paths(panel.preset_subdir)
    files = {path.stem: path for folder in folders for path in pathlib.Path(folder).glob("*.py")}
    assert {"Preview", "Default", "Final"} <= set(files)
    samples = []
    for preset in ("Preview", "Final", "Default"):
        assert bpy.ops.script.execute_preset(filepath=str(files[preset]), menu_idname=panel.__name__) == {"FINISHED"}
        samples.append(group.samples)
    assert samples[0] < samples[2] < samples[1]
    defaults = properties.VIEWPORT if name.startswith("viewport") else dataclasses.asdict(Settings())
    for value in getattr(sampling_presets, f"SDFLIGHTS_OT_{name}_preset_add").preset_values:
        setting = value.removeprefix("settings.")
        assert getattr(group, setting) == pytest.approx(defaults[setting]), setting
