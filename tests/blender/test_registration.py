# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Registering, unregistering, and the properties that come of it."""

import dataclasses
import os
import pathlib
import subprocess
import sys

import bpy
import pytest

from sdf_lights.blender import passes, properties
from sdf_lights.blender.naming import ENGINE
from sdf_lights.render.passes import PASSES
from sdf_lights.render.settings import Settings
from sdf_lights.sdf.shapes import SHAPES, Sphere

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]


def traces() -> set[str]:
    """Everything in Blender that has our name."""
    found = {name for name in dir(bpy.types) if name.lower().startswith("sdflights")}
    for kind in (bpy.types.Scene, bpy.types.Light, bpy.types.ViewLayer):
        found |= {f"{kind.__name__}.{name}" for name in kind.bl_rna.properties.keys() if name.startswith("sdf_")}
    for base in (bpy.types.PropertyGroup, bpy.types.Panel, bpy.types.Operator, bpy.types.Menu, bpy.types.RenderEngine):
        found |= {
            kind.__name__
            for kind in base.__subclasses__()
            if "sdflights" in kind.__name__.lower() and getattr(kind, "is_registered", False)
        }
    found |= {
        panel.__name__ for panel in bpy.types.Panel.__subclasses__() if ENGINE in getattr(panel, "COMPAT_ENGINES", ())
    }
    found |= {
        str(handler)
        for handlers in (bpy.app.handlers.load_post, bpy.app.handlers.save_pre)
        for handler in handlers
        if "sdf_lights" in handler.__module__
    }
    found |= set(bpy.utils.preset_paths("sdf_lights/sampling"))
    found |= {str(draw) for draw in bpy.types.VIEW3D_MT_light_add._dyn_ui_initialize() if "sdf" in draw.__module__}
    return found


def test_registering_twice_and_leaving_nothing_behind(registered):
    everything = traces()
    assert any("draw_menu" in name for name in everything)
    assert {"Scene.sdf_lights", "Light.sdf_lamp", "ViewLayer.sdf_lights", "SDFLightsRenderEngine"} <= everything
    registered.register()
    assert traces() == everything
    registered.unregister()
    assert traces() == set()
    registered.unregister()
    registered.register()
    assert traces() == everything


def test_enabling_does_not_wait_for_numba(tmp_path):
    code = (
        "import sys, time; import bpy, numpy; started = time.process_time(); "
        "import sdf_lights.blender as b; b.register(); "
        "spent = time.process_time() - started; found = 'numba' in sys.modules; started = time.process_time(); "
        "import numba; print(spent, time.process_time() - started, found, flush=True); "
        "import os; os._exit(0)"
    )  # Blender's own way out is slow
    # The second start counts: as in Blender, the modules' bytecode is on disk by then.
    bytecode = {"PYTHONDONTWRITEBYTECODE": "", "PYTHONPYCACHEPREFIX": str(tmp_path)}
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", code],
            capture_output=True,
            text=True,
            timeout=60,
            cwd=REPOSITORY,
            env=os.environ | {"PYTHONPATH": str(REPOSITORY)} | bytecode,
        )
        spent, numba, has_numba = done.stdout.split()[-3:]
        assert has_numba == "False"
    # Most of it is for making the classes of the shapes and nodes. Measured: 1.0 to 1.5 times what Numba alone takes.
    assert float(spent) < 2.5 * float(numba)


def test_registering_prints_nothing(tmp_path):
    code = (
        "import warnings; warnings.simplefilter('error'); import bpy; bpy.app.debug_python = True; "
        "import sdf_lights.blender as b; print('BEGIN'); b.register(); b.unregister(); b.register(); print('END', flush=True); "
        "import os; os._exit(0)"
    )
    environment = os.environ | {"PYTHONPATH": str(REPOSITORY)}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, cwd=tmp_path, env=environment
    )
    assert done.stdout.partition("BEGIN")[2].split() == ["END"] and not done.stderr, done.stdout + done.stderr


def test_every_setting_has_a_property_with_its_limits(file):
    group = file.scene.sdf_lights
    for field in dataclasses.fields(Settings):
        if field.name in properties.BLENDERS_OWN:
            continue
        prop = group.bl_rna.properties[field.name]
        assert prop.description == field.metadata["description"] and not prop.description.endswith(".")
        if prop.type == "ENUM" and not field.metadata["developer"]:
            assert all(item.description and not item.description.endswith(".") for item in prop.enum_items)
        if prop.type in {"INT", "FLOAT"}:
            assert prop.default == pytest.approx(field.default)
            if field.metadata["minimum"] is not None:
                assert prop.hard_min == pytest.approx(field.metadata["minimum"])
            if field.metadata["maximum"] is not None:
                assert prop.hard_max == pytest.approx(field.metadata["maximum"])


def test_settings_are_read_back(file):
    group, render = file.scene.sdf_lights, file.scene.render
    group.samples, group.device, group.filter, group.caustics_reflective = 7, "CPU", "GAUSSIAN", False
    group.viewport.samples, group.viewport.denoise = 3, True
    render.film_transparent, render.threads_mode, render.threads = True, "FIXED", 5
    final, viewport = properties.settings_of(file.scene), properties.settings_of(file.scene, viewport=True)
    assert (final.samples, final.device.value, final.filter.value, final.caustics_reflective) == (
        7,
        "CPU",
        "GAUSSIAN",
        False,
    )
    assert (final.transparent_film, final.threads, final.denoise) == (True, 5, False)
    assert (viewport.samples, viewport.denoise, viewport.device.value) == (3, True, "CPU")


def test_every_shape_parameter_has_a_property(lamp, file):
    group = lamp().sdf_lamp
    items = group.bl_rna.properties["shape"].enum_items
    assert {item.identifier.lower() for item in items} == set(properties.PRIMITIVES)
    assert len({item.value for item in items}) == len(properties.PRIMITIVES)
    for name, shape in properties.PRIMITIVES.items():
        for about in shape.fields():
            prop = getattr(group, name).bl_rna.properties[about.name]
            assert prop.name == about.label and prop.description == about.description
            assert (tuple(prop.default_array) if about.size == 3 else prop.default) == pytest.approx(about.default)
    assert "union" in SHAPES and "union" not in properties.PRIMITIVES


def test_shapes_are_offered_in_groups_and_only_those_that_have_an_end(registered):
    listed = properties.SDFLIGHTS_LampSettings.bl_rna.properties["shape"].enum_items_static_ui
    titles = [item.name for item in listed if not item.identifier]
    assert titles[0] == "Basic" and len(set(titles)) == len(titles) > 5
    assert "half_space" in SHAPES and "half_space" not in properties.PRIMITIVES
    sides = properties.SDFLIGHTS_LampSettings.bl_rna.properties["prism"].fixed_type.properties["sides"]
    assert sides.type == "INT" and sides.hard_min == 3


def test_changes_from_python_tag_their_owner(file, add, lamp):
    """Without a callback on the property, Blender's viewport would not hear of a change made by a script."""
    data = lamp()
    add("Lamp", data)
    heard = []

    def listen(scene, depsgraph):
        heard.extend(update.id.original.name for update in depsgraph.updates)

    bpy.app.handlers.depsgraph_update_post.append(listen)
    try:
        for owner, name, value in (
            (data.sdf_lamp.sphere, "radius", 0.75),
            (data.sdf_lamp, "shape", "TORUS"),
            (file.scene.sdf_lights, "samples", 9),
        ):
            bpy.context.view_layer.update()
            heard.clear()
            setattr(owner, name, value)
            bpy.context.view_layer.update()
            assert (file.scene.name if owner == file.scene.sdf_lights else data.name) in heard, name
    finally:
        bpy.app.handlers.depsgraph_update_post.remove(listen)


def test_lamp_operator(file):
    file.scene.cursor.location = (1.0, 2.0, 3.0)
    bpy.ops.ed.undo_push(message="Before")
    assert bpy.ops.sdf_lights.lamp_add(shape="BOX_FRAME", power=25.0) == {"FINISHED"}
    obj = bpy.context.object
    assert obj.type == "LIGHT" and tuple(obj.location) == (1.0, 2.0, 3.0)
    assert obj.data.type == "POINT" and obj.data.energy == 25.0
    assert obj.data.sdf_lamp.use and obj.data.sdf_lamp.shape == "BOX_FRAME"
    assert bpy.ops.sdf_lights.lamp_add(source="EXPRESSION") == {"FINISHED"}
    assert bpy.context.object.data.sdf_lamp.source == "EXPRESSION"


def test_saved_files_keep_lamps(file, add, lamp, tmp_path):
    data = lamp("Kept", "TORUS", major_radius=2.5)
    add("Lamp", data)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "file.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "file.blend"))
    kept = bpy.data.lights["Kept"].sdf_lamp
    assert kept.use and kept.shape == "TORUS" and kept.torus.major_radius == 2.5
    from sdf_lights.blender.lamp import shape_of

    assert shape_of(kept) != Sphere() and shape_of(kept).major_radius == 2.5


def test_pass_switches(file):
    switches = [item for item in PASSES if item.switch]
    assert not any(passes.is_enabled(item, file.layer) for item in switches)
    for item in switches:
        setattr(passes.owner_of(item, file.layer), item.switch, True)
        assert passes.is_enabled(item, file.layer)
    shown = [item.switch for light in (False, True) for item, _ in passes.switches(light)]
    assert sorted(shown) == sorted({item.switch for item in switches})
