# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One bpy process for all tests here: the add-on is registered once, and every test starts from an empty file."""

import contextlib
import pathlib
import sys
import types

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))

import build_extension  # noqa: E402  (found on the path set above)
import host  # noqa: E402
from scenery.compositing import empty_compositor  # noqa: E402

from sdf_lights import blender  # noqa: E402
from sdf_lights.blender import sync as sync_package  # noqa: E402
from sdf_lights.blender.naming import ENGINE  # noqa: E402


@pytest.fixture(scope="session")
def blender_zip(blender_command, tmp_path_factory) -> pathlib.Path:
    """The extension's zip for the Blender with a window."""
    folder = tmp_path_factory.mktemp("blender_zip")
    return build_extension.build(build_extension.this_platform(), host.python_of(blender_command), folder)


@pytest.fixture(scope="session")
def registered():
    """The registered add-on, alone: tests of scripts in the same process may have registered another copy."""
    if host.PACKAGE in sys.modules:
        sys.modules.pop(host.PACKAGE).unregister()
    blender.register()
    yield blender
    blender.unregister()


@pytest.fixture
def file(registered):
    """An empty file whose scene has this engine, a small frame, and a camera at (0, −5, 1) that looks along +y."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = ENGINE
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 24, 16, 100
    # The reference renders these few pixels at once; machine code of the other back end may have to be compiled first.
    scene.sdf_lights.device = "REFERENCE"
    scene.sdf_lights.samples = 2
    scene.sdf_lights.noise_threshold = 0.0
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.0, -5.0, 1.0), (np.pi / 2, 0.0, 0.0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    return types.SimpleNamespace(scene=scene, camera=camera, layer=scene.view_layers[0])


class _Probe(bpy.types.RenderEngine):
    """Syncs what Blender gives to a render engine at F12, and keeps the scene instead of rendering it."""

    bl_idname = "SDF_LIGHTS_TEST_PROBE"
    bl_label = "Probe"
    scenes: dict = {}

    def render(self, depsgraph):
        try:
            self.scenes[depsgraph.view_layer.name] = sync_package.sync(depsgraph, self)
        except Exception as error:  # Blender would swallow it
            self.scenes[depsgraph.view_layer.name] = error


@pytest.fixture(scope="session")
def _probe():
    bpy.utils.register_class(_Probe)
    yield _Probe
    bpy.utils.unregister_class(_Probe)


@pytest.fixture
def synced(file, _probe):
    """Function: the ``render.scene.Scene`` of a view layer at F12, of the open scene or of another one."""

    def run(layer: str | None = None, rendered: bpy.types.Scene | None = None):
        rendered = rendered or file.scene
        _probe.scenes.clear()
        rendered.render.engine = _probe.bl_idname
        bpy.ops.render.render(scene=rendered.name)
        rendered.render.engine = ENGINE
        scene = _probe.scenes[layer or rendered.view_layers[0].name]
        if isinstance(scene, Exception):
            raise scene
        return scene

    return run


@pytest.fixture
def add(file):
    """Function: link a new object with this data to the scene."""

    def run(name: str, data, location=(0.0, 0.0, 0.0), rotation=(0.0, 0.0, 0.0), scale=(1.0, 1.0, 1.0)):
        obj = bpy.data.objects.new(name, data)
        obj.location, obj.rotation_euler, obj.scale = location, rotation, scale
        file.scene.collection.objects.link(obj)
        return obj

    return run


@pytest.fixture
def quad():
    """Function: a mesh of one square, from −1 to 1, facing +z, with a UV map from 0 to 1."""

    def run(name: str = "Quad"):
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
        mesh.uv_layers.new(name="UVMap").uv.foreach_set("vector", [0, 0, 1, 0, 1, 1, 0, 1])
        mesh.update()
        return mesh

    return run


@pytest.fixture
def lamp():
    """Function: the data of an SDF lamp."""

    def run(name: str = "Lamp", shape: str = "SPHERE", power: float = 100.0, **parameters):
        light = bpy.data.lights.new(name, "POINT")
        light.energy = power
        light.sdf_lamp.use = True
        light.sdf_lamp.shape = shape
        for key, value in parameters.items():
            setattr(getattr(light.sdf_lamp, shape.lower()), key, value)
        return light

    return run


@pytest.fixture
def stage(add, quad, lamp, file):
    """A lit floor; the lamp's object."""
    add("Floor", quad(), scale=(5.0, 5.0, 1.0))
    return add("Lamp", lamp(radius=0.4), location=(0.0, 0.0, 1.0))


@pytest.fixture
def material():
    """Function: a material with an empty node tree; returns it, the tree, and its output's Surface socket."""

    def run(name: str = "Material"):
        made = bpy.data.materials.new(name)
        made.use_nodes = True
        tree = made.node_tree
        tree.nodes.clear()
        return made, tree, tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"]

    return run


@pytest.fixture
def compositor(file):
    """(tree, node): an empty tree of the scene's compositor, and the node whose first input is the result."""
    return empty_compositor(file.scene)


@pytest.fixture
def pictures(file, tmp_path):
    """Function: render, and read back {layer: {pass: (height, width, channels)}} with row 0 at the bottom."""
    openexr = pytest.importorskip("support.openexr")

    def run():
        settings, path = file.scene.render.image_settings, tmp_path / "picture.exr"
        with contextlib.suppress(AttributeError):  # new in 5.0
            settings.media_type = "MULTI_LAYER_IMAGE"
        settings.file_format, settings.color_depth = "OPEN_EXR_MULTILAYER", "32"
        file.scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True)
        return openexr.read_passes(path)

    return run


@pytest.fixture
def render(file, pictures):
    """Function: both engines' pictures (height, width, RGBA) of ``samples`` samples a pixel."""
    bpy.ops.preferences.addon_enable(module="cycles")
    scene = file.scene
    cycles = scene.cycles
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.blur_glossy, cycles.light_sampling_threshold, cycles.sample_clamp_indirect = 0.0, 0.0, 0.0
    cycles.pixel_filter_type, scene.render.film_transparent = "BOX", True
    scene.render.image_settings.color_mode = "RGBA"

    def run(samples: int) -> tuple[np.ndarray, np.ndarray]:
        cycles.samples, result = samples, {}
        for scene.render.engine in ("CYCLES", "SDF_LIGHTS"):
            bpy.ops.sdf_lights.cycles_settings_copy()
            scene.sdf_lights.device, scene.sdf_lights.guided_samples = "CPU", False
            result[scene.render.engine] = pictures()["ViewLayer"]["Combined"].astype(float)
        return result["SDF_LIGHTS"], result["CYCLES"]

    return run


@pytest.fixture
def volume_frame(file, render):
    """A frame of 12 × 8 pixels before a black world, and few bounces; Cycles marches in short steps."""
    scene = file.scene
    scene.render.resolution_x, scene.render.resolution_y = 12, 8
    scene.render.film_transparent = False
    scene.cycles.max_bounces = scene.cycles.volume_bounces = 1
    scene.cycles.volume_step_rate = 0.2
    if bpy.app.version >= (5, 0, 0):
        scene.cycles.volume_biased = True  # else Cycles prepares 3.5 seconds for its tracking
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.0, 0.0, 0.0, 1.0)
    return scene
