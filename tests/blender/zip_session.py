# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What test_zip runs inside a Blender: install an older version, update it, render, disable, enable, render, remove.

    python zip_session.py OLDER.zip ZIP REPORT.json          in Blender's Python module
    blender --python zip_session.py -- OLDER.zip ZIP REPORT.json

BLENDER_USER_RESOURCES names an empty folder. The report says what was seen at each step; judging it is the test's part.
"""

import importlib
import importlib.machinery
import json
import os
import pathlib
import sys
import tomllib
import traceback

import bpy

BUNDLED = {"numba", "llvmlite", "moderngl", "glcontext"}
EXTENSION = "bl_ext.user_default.sdf_lights"
RESOURCES = pathlib.Path(os.environ["BLENDER_USER_RESOURCES"]).resolve()


class BundledOnly:
    """Finds the bundled packages nowhere but in what Blender took out of the zip, as on a machine of a user."""

    @staticmethod
    def find_spec(name, path=None, target=None):
        if name not in BUNDLED:
            return None
        own = [entry for entry in sys.path if RESOURCES in pathlib.Path(entry).resolve().parents]
        spec = importlib.machinery.PathFinder.find_spec(name, own)
        if spec is None:
            raise ModuleNotFoundError(f"No module named {name!r} in the extension", name=name)
        return spec


def make_scene() -> None:
    """A sphere lamp above a floor, seen from the side; any engine but SDF Lights sees a point light."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module=EXTENSION)  # factory settings disable it
    scene = bpy.context.scene
    floor = bpy.data.meshes.new("Floor")
    floor.from_pydata([(-4, -4, 0), (4, -4, 0), (4, 4, 0), (-4, 4, 0)], [], [(0, 1, 2, 3)])
    light = bpy.data.lights.new("Lamp", "POINT")
    light.energy = 100.0
    light.sdf_lamp.use = True
    light.sdf_lamp.shape = "SPHERE"
    light.sdf_lamp.sphere.radius = 0.5
    lamp = bpy.data.objects.new("Lamp", light)
    lamp.location = (0.0, 0.0, 1.0)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.0, -5.0, 1.0), (1.5707963, 0.0, 0.0)
    for thing in (bpy.data.objects.new("Floor", floor), lamp, camera):
        scene.collection.objects.link(thing)
    scene.camera = camera
    scene.render.engine = "SDF_LIGHTS"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 24, 16, 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.sdf_lights.samples = 4
    scene.sdf_lights.noise_threshold = 0.0


def render() -> list[float]:
    """The picture's values, row 0 at the bottom, RGBA."""
    path = str(RESOURCES / "picture.exr")
    bpy.context.scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    picture = bpy.data.images.load(path)
    values = list(picture.pixels)
    bpy.data.images.remove(picture)
    os.remove(path)
    return values


def state() -> dict:
    """What of the add-on Blender knows at this moment."""
    engines = [
        kind for kind in bpy.types.RenderEngine.__subclasses__() if getattr(kind, "bl_idname", "") == "SDF_LIGHTS"
    ]
    return dict(
        engine=any(kind.is_registered for kind in engines),
        lamp="sdf_lamp" in bpy.types.Light.bl_rna.properties,
        settings="sdf_lights" in bpy.types.Scene.bl_rna.properties,
        enabled=EXTENSION in bpy.context.preferences.addons,
    )


def installed() -> dict:
    """The version on disk, and the Python files at the top of its folder."""
    folder = RESOURCES / "extensions" / "user_default" / "sdf_lights"
    about = tomllib.loads((folder / "blender_manifest.toml").read_text(encoding="utf-8"))
    return dict(version=about["version"], files=sorted(path.name for path in folder.glob("*.py")))


def session(older: str, zip_path: str) -> dict:
    report = dict(blender=bpy.app.version_string, background=bpy.app.background)
    sys.meta_path.insert(0, BundledOnly)
    bpy.ops.extensions.package_install_files(filepath=older, repo="user_default", enable_on_install=True)
    report["older"] = state() | installed()
    bpy.context.preferences.addons[EXTENSION].preferences.threads = 3
    bpy.ops.extensions.package_install_files(filepath=zip_path, repo="user_default", enable_on_install=True)
    report["installed"] = state() | installed()
    report["compiles"] = importlib.import_module(f"{EXTENSION}.sdf_lights.render.cpu.background").needed()
    report["threads"] = bpy.context.preferences.addons[EXTENSION].preferences.threads
    make_scene()
    report["picture"] = render()
    report["modules"] = {name: getattr(sys.modules.get(name), "__file__", None) for name in sorted(BUNDLED)}
    report["files"] = sorted(path.relative_to(RESOURCES).as_posix() for path in RESOURCES.rglob("*.kernel"))

    bpy.ops.preferences.addon_disable(module=EXTENSION)
    report["disabled"] = state()
    bpy.ops.preferences.addon_enable(module=EXTENSION)
    report["enabled"] = state()
    make_scene()
    report["picture again"] = render()

    repositories = bpy.context.preferences.extensions.repos
    index = next(i for i, repository in enumerate(repositories) if repository.module == "user_default")
    bpy.ops.extensions.package_uninstall(repo_index=index, pkg_id="sdf_lights")
    report["removed"] = state()
    report["left"] = sorted(
        path.relative_to(RESOURCES).as_posix() for path in (RESOURCES / "extensions").rglob("sdf_lights/*.py")
    )
    return report


def main() -> None:
    older, zip_path, report_path = sys.argv[sys.argv.index("--") + 1 if "--" in sys.argv else 1 :]
    try:
        report = session(older, zip_path)
    except Exception:
        report = dict(error=traceback.format_exc())
    pathlib.Path(report_path).write_text(json.dumps(report), encoding="utf-8")
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)  # quitting a Blender that has a window asks about unsaved work


main()
