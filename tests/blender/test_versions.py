# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of every version of the settings open, and mean what they meant; what changes brings older ones up."""

import json
import pathlib

import bpy
import numpy as np
import pytest
import version_files

from sdf_lights.blender import versions

SOURCES = {"PRIMITIVE", "EXPRESSION", "NODES", "OBJECT", "IMAGE", "NETWORK"}
FOLDER = pathlib.Path(__file__).parent / "files"
FILES = sorted(FOLDER.glob("*.blend"))


def _readable(kind: str) -> list:
    """Files of a kind; Blender opens those of its own version and of older ones."""
    found = []
    for path in FILES:
        if path.stem.startswith(kind):
            version = tuple(map(int, path.stem.rpartition("blender")[2].split(".")))
            newer = pytest.mark.skipif(version > bpy.app.version[:2], reason="saved by a later Blender")
            found.append(pytest.param(path, id=path.stem, marks=newer))
    return found


def _kept(path: pathlib.Path) -> dict:
    """What was kept of a file, with the version that its settings have now."""
    kept = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
    scenes = [kept["scene"]] if "scene" in kept else [scene["settings"] for scene in kept["scenes"].values()]
    for settings in (*scenes, *kept["lamps"].values()):
        settings["version"] = versions.VERSION
    return kept


def _compare(found, kept, place: str) -> None:
    """What was kept is there; settings that are new since then may be there, too."""
    if isinstance(kept, dict):
        for name, value in kept.items():
            assert name in found, f"{place}: {name} is gone"
            _compare(found[name], value, f"{place}.{name}")
    elif isinstance(kept, (list, float)):
        np.testing.assert_allclose(found, kept, rtol=1e-5, atol=1e-6, err_msg=place)
    else:
        assert found == kept, place


@pytest.mark.parametrize("path", _readable("settings"))
def test_a_file_of_an_older_version_means_what_it_meant(registered, path):
    bpy.ops.wm.open_mainfile(filepath=str(path))
    kept, found = _kept(path), version_files.contents()
    assert len(kept["lamps"]) > 100 and found["lamps"].keys() == kept["lamps"].keys()
    _compare(found, kept, path.stem)


@pytest.mark.slow
@pytest.mark.parametrize("path", _readable("scenes"))
def test_small_scenes_of_an_older_version_look_as_they_did(registered, path):
    """Every source of lamps, every setting, set or not, view layers, passes, and the means of renders. A new
    sampler has other noise: the tolerance is three standard deviations of the difference of two means."""
    bpy.ops.wm.open_mainfile(filepath=str(path))
    kept, found = _kept(path), version_files.scenes_contents()
    assert {lamp["source"] for lamp in kept["lamps"].values()} == SOURCES
    means = [{name: scene.pop("means") for name, scene in each["scenes"].items()} for each in (found, kept)]
    assert found["lamps"].keys() == kept["lamps"].keys() and means[0].keys() == means[1].keys()
    _compare(found, kept, path.stem)
    for name, layers in means[1].items():
        for layer, mean in layers.items():
            assert min(mean) > 0.0
            np.testing.assert_allclose(means[0][name][layer], mean, rtol=0.01, err_msg=f"{name} {layer}")


def test_there_is_a_file_of_this_version():
    for kind in version_files.FILES:
        assert any(path.stem.startswith(f"{kind}{versions.VERSION}-") for path in FILES), kind


def _blend(tmp_path, lamp) -> str:
    data = lamp("Old")
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Old", data))
    path = str(tmp_path / "old.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, check_existing=False)
    assert data.sdf_lamp.version == bpy.context.scene.sdf_lights.version == versions.VERSION
    return path


@pytest.mark.parametrize("how", ["opened", "appended", "linked"])
def test_what_is_older_is_brought_up_once(file, lamp, tmp_path, monkeypatch, how):
    path, calls = _blend(tmp_path, lamp), []
    monkeypatch.setattr(versions, "VERSION", versions.VERSION + 1)
    monkeypatch.setitem(versions.STEPS, versions.VERSION - 1, lambda owner: calls.append(owner.name))
    if how == "opened":
        bpy.ops.wm.open_mainfile(filepath=path)
    else:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        calls.clear()
        with bpy.data.libraries.load(path, link=how == "linked") as (_, wanted):
            wanted.lights = ["Old"]
    assert calls.count("Old") == 1
    if how == "appended":
        assert bpy.data.lights["Old"].sdf_lamp.version == versions.VERSION
        versions.bring_up()
        assert calls.count("Old") == 1


def test_what_a_later_version_has_saved_is_told(synced, add, lamp):
    data = lamp("Later")
    add("Later", data)
    data.sdf_lamp.version = versions.VERSION + 1
    told = [sentence for sentence in synced().warnings if "later version" in sentence]
    assert told == [
        "Light 'Later' was saved by a later version of SDF Lights: unknown settings are ignored; update the extension."
    ]
