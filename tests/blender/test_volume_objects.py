# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume objects and smoke have the brightness that they have in Cycles."""

import sys

import bpy
import numpy as np
import pytest

from sdf_lights.blender import vdb_files
from sdf_lights.blender.sync.grids import dense
from sdf_lights.render.material import Attribute
from tests.blender.node_trees import new
from tests.blender.volumes import agree, linked, set_world

pytest.importorskip("_cycles")

SIZE = 0.1  # metres, of voxels


@pytest.fixture(scope="session")
def openvdb():
    """OpenVDB's module, as the add-on finds it: that of bpy."""
    module = vdb_files.vdb()
    assert module is not None
    return module


def blobs(shape=(20, 17, 15), seed: int = 0) -> np.ndarray:
    """Smooth values (x, y, z) from 0 to 1, which end inside of the box."""
    generator = np.random.default_rng(seed)
    places = np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, count) for count in shape], indexing="ij"), axis=-1)
    total = np.zeros(shape)
    for _ in range(6):
        center, radius = generator.uniform(-0.5, 0.5, 3), generator.uniform(0.3, 0.5)
        total += np.clip(1.0 - ((places - center) ** 2).sum(-1) / radius**2, 0.0, None)
    return np.clip(total, 0.0, 1.0).astype(np.float32)


@pytest.fixture
def cloud(openvdb, tmp_path):
    """Function: a .vdb file of grids around the origin, (x, y, z) or (x, y, z, 3) values by name."""

    def write(name: str = "cloud.vdb", size: float = SIZE, background: float = 0.0, **values):
        made = []
        for key, array in values.items():
            array = np.asarray(array, np.float32)
            grid = openvdb.Vec3SGrid((background,) * 3) if array.ndim == 4 else openvdb.FloatGrid(background)
            grid.copyFromArray(array, ijk=tuple(-count // 2 for count in array.shape[:3]))
            grid.name, grid.transform = key, openvdb.createLinearTransform(size)
            made.append(grid)
        openvdb.write(str(tmp_path / name), grids=made)
        return str(tmp_path / name)

    return write


@pytest.fixture
def volume(add, material):
    """Function: a Volume object of a file at (0, 0, 1), with the volume that ``build(tree) -> socket`` makes, if
    given."""

    def run(path: str, build=None, **placed):
        data = bpy.data.volumes.new("Cloud")
        data.filepath = path
        if build is not None:
            made, tree, surface = material("Volume")
            tree.links.new(build(tree), surface.node.inputs["Volume"])
            data.materials.append(made)
        return add("Cloud", data, **{"location": (0.0, 0.0, 1.0), **placed})

    return run


def light(add, kind: str, energy: float):
    data = bpy.data.lights.new(kind, kind)
    data.energy = energy
    return add(kind, data, (1.5, -1.5, 2.5), (0.6, 0.4, 0.0))


def principled(**values):
    def build(tree):
        return new(tree, "ShaderNodeVolumePrincipled", **values).outputs[0]

    return build


def read(tree, name: str, output: str = "Fac"):
    return new(tree, "ShaderNodeAttribute", attribute_name=name).outputs[output]


@pytest.mark.parametrize("kind, energy", [("POINT", 200.0), ("SUN", 3.0)])
def test_a_cloud_under_a_light(volume_frame, render, cloud, volume, add, kind, energy):
    build = principled(Color=(0.8, 0.6, 0.4, 1.0), Density=6.0, Anisotropy=0.3)
    volume(cloud(density=blobs()), build)
    light(add, kind, energy)
    agree(render, 3000)


def test_a_turned_cloud_under_the_sky(volume_frame, render, cloud, volume):
    volume(
        cloud(density=4.0 * blobs()),
        principled(Color=(0.9, 0.7, 0.5, 1.0)),
        rotation=(0.3, 0.2, 0.5),
        scale=(1.2, -1.0, 0.8),
    )
    set_world(volume_frame, (0.2, 0.3, 0.5, 1.0))
    agree(render, 1000)


def test_density_in_the_space_of_the_world(volume_frame, render, cloud, volume):
    obj = volume(cloud(density=8.0 * blobs()), principled(Color=(0.9, 0.7, 0.5, 1.0)), scale=(0.5, 0.5, 0.4))
    obj.data.render.space = "WORLD"
    set_world(volume_frame, (0.2, 0.3, 0.5, 1.0))
    agree(render, 1000, 0.001)


def test_without_a_material(volume_frame, render, cloud, volume, add):
    volume(cloud(density=3.0 * blobs()))
    set_world(volume_frame, (0.5, 0.5, 0.5, 1.0))
    agree(render, 1000)


def glow(output):
    """A volume that emits what ``output(tree)`` gives."""

    def build(tree):
        return linked(tree, output(tree), "ShaderNodeEmission", "Color").outputs[0]

    return build


VECTOR = np.stack([blobs(seed=1), 0.5 * blobs(seed=2), blobs(seed=3)], axis=-1)


def from_info(output):
    return lambda tree: new(tree, "ShaderNodeVolumeInfo").outputs[output]


def from_grid(name, output="Fac"):
    return lambda tree: read(tree, name, output)


@pytest.mark.parametrize(
    "output",
    [
        *(from_info(output) for output in ("Color", "Density", "Flame", "Temperature")),
        from_grid("anything"),
        from_grid("color", "Color"),
        from_grid("color", "Vector"),
        from_grid("color"),
    ],
    ids=["color", "density", "flame", "temperature", "any grid", "vector", "vector as vector", "its mean"],
)
def test_nodes_read_grids(volume_frame, render, cloud, volume, output):
    grids = {name: 1.0 + seed * blobs(seed=seed) for seed, name in enumerate(("flame", "temperature", "anything"), 1)}
    volume_frame.cycles.volume_bounces = 0
    volume(cloud(density=blobs(), color=VECTOR, **grids), glow(output))
    agree(render, 400)


def test_fire_of_a_temperature(volume_frame, render, cloud, volume):
    volume_frame.cycles.volume_bounces = 0
    path = cloud(density=blobs(), heat=3.0 * blobs(seed=4))
    volume(path, principled(Temperature=600.0, Blackbody_Intensity=1.0, Temperature_Attribute="heat"))
    agree(render, 2000)


def test_colours_of_a_grid_absorb(volume_frame, render, cloud, volume):
    volume_frame.cycles.volume_bounces = 0
    build = principled(
        Color=(1.0, 0.8, 0.6, 1.0), Density=4.0, Color_Attribute="tint", Absorption_Color=(0.1, 0.2, 0.3, 1.0)
    )
    volume(cloud(density=blobs(), tint=VECTOR), build)
    set_world(volume_frame, (1.0, 1.0, 1.0, 1.0))
    agree(render, 1000)


def test_a_ramp_of_the_density(volume_frame, render, cloud, volume):
    """What is not linear in the grid: Cycles does not sample it by chance there."""

    def build(tree):
        dense = linked(
            tree, read(tree, "density"), "ShaderNodeMapRange", "Value", From_Min=0.3, From_Max=0.7, To_Max=8.0
        )
        return linked(
            tree, dense.outputs[0], "ShaderNodeVolumeAbsorption", "Density", Color=(0.2, 0.5, 0.8, 1.0)
        ).outputs[0]

    volume(cloud(density=blobs()), build)
    set_world(volume_frame, (1.0, 1.0, 1.0, 1.0))
    agree(render, 500)


def test_cubic_interpolation(volume_frame, render, cloud, volume):
    obj = volume(cloud(size=0.4, density=4.0 * blobs((6, 5, 5))), glow(from_grid("density")))
    obj.data.materials[0].cycles.volume_interpolation = "CUBIC"
    volume_frame.cycles.volume_bounces = 0
    agree(render, 500)


@pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="where Cycles marches, bounds are blocks of 8 voxels")
def test_without_a_density_a_principled_volume_fills_its_box(volume_frame, render, cloud, volume):
    """The box is that of the voxels above zero, also where others are active."""
    volume_frame.cycles.volume_biased = False
    path = cloud(color=VECTOR, background=0.25)
    volume(path, principled(Color_Attribute="color", Absorption_Color=(0.1, 0.2, 0.3, 1.0)))
    set_world(volume_frame, (1.0, 1.0, 1.0, 1.0))
    agree(render, 1000)


@pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="where Cycles marches, bounds are blocks of 8 voxels")
def test_outside_of_voxels_is_the_background(volume_frame, render, cloud, volume):
    volume_frame.cycles.volume_biased = False
    volume(cloud(density=2.0 + blobs((6, 5, 5)), size=0.3, background=0.5), glow(from_grid("density")))
    volume_frame.cycles.volume_bounces = 0
    agree(render, 2000)


def test_instances(volume_frame, render, cloud, volume, file):
    obj = volume(cloud(density=8.0 * blobs()), principled(Color=(0.9, 0.7, 0.5, 1.0)))
    group = bpy.data.collections.new("Clouds")
    file.scene.collection.objects.unlink(obj)
    group.objects.link(obj)
    for place in (-1.0, 1.0):
        instancer = bpy.data.objects.new("Instancer", None)
        instancer.instance_type, instancer.instance_collection = "COLLECTION", group
        instancer.location, instancer.scale, instancer.rotation_euler = (place, 1.0, 0.3), (0.7,) * 3, (0.0, 0.0, place)
        file.scene.collection.objects.link(instancer)
    set_world(volume_frame, (0.2, 0.3, 0.5, 1.0))
    agree(render, 1000, 0.001)


def test_geometry_nodes_make_volumes(volume_frame, render, add, material):
    made, tree, surface = material("Volume")
    tree.links.new(principled(Density=2.0)(tree), surface.node.inputs["Volume"])
    group = bpy.data.node_groups.new("Cube", "GeometryNodeTree")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    cube = group.nodes.new("GeometryNodeVolumeCube")
    cube.inputs["Resolution X"].default_value = 12
    # Cycles of 5.0 cuts off the edge of blocks of equal voxels.
    group.links.new(group.nodes.new("ShaderNodeTexNoise").outputs[0], cube.inputs["Density"])
    given = group.nodes.new("GeometryNodeSetMaterial")
    given.inputs["Material"].default_value = made
    group.links.new(cube.outputs[0], given.inputs[0])
    group.links.new(given.outputs[0], group.nodes.new("NodeGroupOutput").inputs[0])
    obj = add("Made", bpy.data.meshes.new("Empty"), (0.0, 0.0, 1.0), (0.0, 0.0, 0.4))
    obj.modifiers.new("Nodes", "NODES").node_group = group
    set_world(volume_frame, (0.2, 0.3, 0.5, 1.0))
    agree(render, 1000)


def test_a_surface_and_motion(volume_frame, render, cloud, volume):
    """A surface of the material is that of the box, and the box moves with its object."""
    obj = volume(cloud(density=4.0 * blobs()), principled(Color=(0.9, 0.7, 0.5, 1.0)))
    for time, place in ((0, -1.0), (2, 1.0)):
        obj.location.x = place
        obj.keyframe_insert("location", frame=time)
    volume_frame.render.use_motion_blur, volume_frame.render.motion_blur_shutter = True, 1.0
    volume_frame.frame_set(1)
    set_world(volume_frame, (0.2, 0.3, 0.5, 1.0))
    agree(render, 1000)


# -- what is read, and when --------------------------------------------------------------------------------------------


def grid_of(scene, name: str = "density") -> np.ndarray:
    """The packed numbers of the grid of the only instance."""
    (instance,) = scene.instances
    return instance.attributes[Attribute("grid", name)].values


def test_the_frame_of_a_sequence(synced, file, cloud, volume):
    for number in (1, 2, 3):
        path = cloud(f"smoke_{number:03d}.vdb", density=number * blobs())
    data = volume(path).data
    data.is_sequence, data.frame_duration = True, 3
    for number in (1, 3):
        file.scene.frame_set(number)
        assert grid_of(synced()).max() == pytest.approx(max(number * blobs().max(), 20), rel=0.5)
    assert not file.scene.frame_set(9) and not synced().instances


def test_edits_are_read_again(synced, cloud, volume):
    obj = volume(cloud(density=100.0 * blobs()))
    before = grid_of(synced())
    assert grid_of(synced()).tobytes() == before.tobytes()
    obj.data.filepath = cloud("other.vdb", density=200.0 * blobs())
    after = grid_of(synced())
    assert after.max() == pytest.approx(2.0 * before.max())
    cloud("other.vdb", density=400.0 * blobs())  # the same file, written again
    obj.data.grids.unload()
    assert grid_of(synced()).max() == pytest.approx(2.0 * after.max())


def test_instances_share_their_grid(synced, cloud, volume, add):
    obj = volume(cloud(density=blobs()))
    add("Copy", obj.data, (3.0, 0.0, 0.0))
    scene = synced()
    first, second = (each.attributes[Attribute("grid", "density")] for each in scene.instances)
    assert first is second and len(scene.instances) == 2


@pytest.mark.parametrize("content", [None, b"", b"no volume at all"])
def test_files_that_cannot_be_read(synced, volume, add, quad, tmp_path, content):
    path = tmp_path / "gone.vdb"
    if content is not None:
        path.write_bytes(content)
    volume(str(path))
    add("Quad", quad())
    scene = synced()
    assert len(scene.instances) == 1 and len(scene.warnings) == 1
    assert scene.warnings[0].startswith("Object 'Cloud': its volume cannot be read (") and "again" in scene.warnings[0]


def test_a_material_that_reads_no_grid_shows_nothing(volume_frame, render, cloud, volume):
    volume(cloud(density=blobs()), lambda tree: new(tree, "ShaderNodeVolumeScatter", Density=2.0).outputs[0])
    set_world(volume_frame, (1.0, 1.0, 1.0, 1.0))
    for picture in render(4):
        np.testing.assert_allclose(picture[..., :3], 1.0, atol=1e-6)


def test_without_openvdb_one_sentence_says_so(synced, cloud, volume, monkeypatch):
    volume(cloud(density=blobs()))
    for name in vdb_files.MODULES:
        monkeypatch.setitem(sys.modules, name, None)
    scene = synced()
    assert not scene.instances and len(scene.warnings) == 1
    assert "Object 'Cloud' is a volume" in scene.warnings[0] and "blender.org" in scene.warnings[0]


def test_smoke_fills_the_texture_space_of_its_domain():
    """Simulations do not run in the package bpy."""
    values = np.zeros((4, 6, 8, 1), np.float32)
    values[1:3, 2:5, 3:] = 0.5
    middle, size = np.array([1.0, 2.0, 3.0]), np.array([2.0, 3.0, 4.0])
    grid = dense(values, middle, size, 1e-6)
    assert grid.low.tolist() == [1, 2, 3] and grid.high.tolist() == [2, 4, 7]
    for place in ((0, 0, 0), (3, 5, 7)):  # the middle of a voxel of one metre
        where = grid.matrix[:3, :3] @ place + grid.matrix[:3, 3]
        np.testing.assert_allclose(where, middle - size + np.array(place) + 0.5)
    assert dense(0.0 * values, middle, size, 1e-6) is None


def test_velocities_that_would_blur_are_named(synced, file, cloud, volume):
    volume(cloud(density=blobs(), velocity=VECTOR))
    assert not synced().warnings
    file.scene.render.use_motion_blur = True
    (sentence,) = synced().warnings
    assert sentence.startswith("Object 'Cloud': motion blur by the velocity of its voxels")


def test_a_domain_without_smoke_shows_nothing(volume_frame, render, add, quad):
    obj = add("Domain", quad(), (0.0, 0.0, 1.0), (np.pi / 2, 0.0, 0.0))
    modifier = obj.modifiers.new("Fluid", "FLUID")
    modifier.fluid_type, modifier.domain_settings.domain_type = "DOMAIN", "GAS"
    set_world(volume_frame, (1.0, 1.0, 1.0, 1.0))
    for picture in render(4):
        np.testing.assert_allclose(picture[..., :3], 1.0, atol=1e-6)
