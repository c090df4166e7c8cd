# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the preferences offer: the report of a problem, compiled kernels, the log."""

import logging
import sys

import bpy
import pytest

from sdf_lights import kernel_cache
from sdf_lights.blender import command_line, feedback, preferences, problem_report
from sdf_lights.blender.sync import frame_settings
from sdf_lights.render.settings import Device


def test_a_report_has_versions_settings_and_warnings(file):
    scene = file.scene
    scene.sdf_lights.max_bounces = 3
    feedback.record(scene.name, ["Material 'Wood': node 'Script' is not modelled."], "the CPU")
    text = problem_report.report(scene)
    for part in (bpy.app.version_string, "numpy ", "Max Bounces: 3", "Material 'Wood'", "1 warning", "the CPU"):
        assert part in text
    assert "of an unknown version" not in text and "Filter Glossy:" not in text
    feedback.record(scene.name, [], "")
    assert "Last render: none, no warnings" in problem_report.report(scene)


def test_a_report_is_copied(file, capfd):
    assert bpy.ops.sdf_lights.report_copy() == {"FINISHED"}
    assert "SDF Lights" in capfd.readouterr().out


def test_kernels_are_cleared_and_nothing_else(file, tmp_path, monkeypatch):
    monkeypatch.setenv("SDF_LIGHTS_CACHE", str(tmp_path))
    files = kernel_cache.Files(tmp_path / "version" / "module", "kernel")
    files.save("key", b"code")
    (tmp_path / "letter.txt").write_text("mine")
    assert kernel_cache.size(tmp_path) == files.path("key").stat().st_size > 0
    assert bpy.ops.sdf_lights.kernels_clear() == {"FINISHED"}
    assert kernel_cache.size(tmp_path) == 0 and files.load("key") is None
    assert (tmp_path / "letter.txt").read_text() == "mine"


def test_the_log_has_the_levels_of_logging():
    levels = preferences.SDFLIGHTS_Preferences.bl_rna.properties["log_level"].enum_items.keys()
    assert {level.lower() for level in levels} == set(command_line.LEVELS)
    before = command_line.LOG.level
    try:
        command_line.write_log("info")
        assert command_line.LOG.level == logging.INFO
    finally:
        command_line.LOG.setLevel(before)


@pytest.fixture
def preferred(file):
    """The preferences of the add-on, as if the user had enabled it."""
    addons = bpy.context.preferences.addons
    addon = addons.new()
    addon.module = preferences.ROOT
    yield addon.preferences
    addons.remove(addon)


@pytest.mark.parametrize(
    "wanted, threads, expected", [(0, 0, 0), (3, 0, 3), (3, 2, 2), (3, 8, 3)], ids=["neither", "user", "fewer", "more"]
)
def test_this_computer_has_a_device_and_threads_of_its_own(preferred, file, wanted, threads, expected):
    render = file.scene.render
    render.threads_mode, render.threads = ("FIXED", threads) if threads else ("AUTO", render.threads)
    assert frame_settings(file.scene).device is Device.REFERENCE
    preferred.device, preferred.threads = "CPU", wanted
    for viewport in (False, True):
        settings = frame_settings(file.scene, viewport)
        assert settings.device is Device.CPU and settings.threads == expected
    preferred.device = "SCENE"
    assert frame_settings(file.scene).device is Device.REFERENCE


def test_a_new_file_has_the_overlay_of_the_preferences(preferred, file, tmp_path):
    path = str(tmp_path / "old.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    preferred.overlay.brightness, preferred.overlay.resolution = "LIGHT", "2"

    def overlay() -> tuple:
        settings = bpy.context.scene.sdf_lights_overlay
        return settings.show_lamps, settings.brightness, settings.resolution, settings.coarse_motion

    bpy.ops.wm.read_homefile(use_empty=True)
    assert overlay() == (True, "LIGHT", "2", True)
    bpy.ops.wm.open_mainfile(filepath=path)  # a file keeps its own
    assert overlay() == (True, "SHAPE", "1", True)


def test_the_command_line_goes_before_preferences(preferred, file, monkeypatch):
    preferred.device, preferred.threads = "GPU", 2
    monkeypatch.setattr(sys, "argv", ["blender", "--", "--sdf-device", "cpu", "--sdf-threads", "5"])
    settings = frame_settings(file.scene)
    command_line.apply(settings)
    assert settings.device is Device.CPU and settings.threads == 5
