# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Render passes have the names, the channels and the values that Cycles gives them."""

import json
import math

import bmesh
import bpy
import numpy as np
import pytest
from scenery.compositing import sum_of_light_groups

from sdf_lights.blender.naming import ENGINE
from sdf_lights.render.cryptomatte import number_of
from support.openexr import lit

pytest.importorskip("_cycles")

DATA = ("z", "ambient_occlusion", "mist", "uv", "object_index", "material_index")
LIGHT = ("emit", "environment")
LOBES = [f"{lobe}_{part}" for lobe in ("diffuse", "glossy", "transmission") for part in ("direct", "indirect", "color")]


@pytest.fixture
def scene(file, add, quad, material):
    """Objects of most lobes before a grey world, lit by an area light: diffuse, rough metal, rough glass, plastic, a
    half transparent sheet, and one that glows."""
    bpy.ops.preferences.addon_enable(module="cycles")
    half = math.pi / 2

    def surface(name: str, kind: str, index: int, alpha: float = 1.0, **inputs):
        made, tree, output = material(name)
        made.pass_index = index
        node = tree.nodes.new(f"ShaderNode{kind}")
        if kind in ("BsdfGlossy", "BsdfGlass"):
            node.distribution = "GGX"
        for key, value in inputs.items():
            node.inputs[key.replace("_", " ")].default_value = value
        if alpha < 1.0:
            clear, mix = tree.nodes.new("ShaderNodeBsdfTransparent"), tree.nodes.new("ShaderNodeMixShader")
            mix.inputs[0].default_value = alpha
            tree.links.new(clear.outputs[0], mix.inputs[1])
            tree.links.new(node.outputs[0], mix.inputs[2])
            node = mix
        tree.links.new(node.outputs[0], output)
        mesh = quad(name)
        mesh.materials.append(made)
        return mesh

    def shown(name: str, index: int, data, *place):
        obj = add(name, data, *place)
        obj.pass_index = index
        return obj

    shown("Floor", 1, surface("Floor", "BsdfDiffuse", 10, Color=(0.8, 0.5, 0.3, 1.0)), (0, 0, 0), (0, 0, 0), (3, 3, 1))
    metal = surface("Metal", "BsdfGlossy", 20, Color=(0.9, 0.8, 0.7, 1.0), Roughness=0.4)
    shown("Metal", 2, metal, (-1.2, 1.0, 0.8), (half, 0, 0.3), (0.6, 0.8, 1))
    glass = surface("Glass", "BsdfGlass", 30, Color=(0.9, 1.0, 0.9, 1.0), Roughness=0.3, IOR=1.4)
    shown("Glass", 3, glass, (1.2, 0.5, 0.8), (half, 0, -0.3), (0.6, 0.8, 1))
    plastic = surface("Plastic", "BsdfPrincipled", 40, Base_Color=(0.2, 0.4, 0.8, 1.0), Roughness=0.3)
    shown("Plastic", 4, plastic, (0, 1.5, 0.8), (half, 0, 0), (0.5, 0.8, 1))
    sheet = surface("Sheet", "BsdfDiffuse", 50, 0.7, Color=(0.7, 0.7, 0.2, 1.0))
    sheet.uv_layers.remove(sheet.uv_layers[0])
    shown("Sheet", 5, sheet, (0, -1, 0.6), (half, 0, 0), (0.6, 0.4, 1))
    thin = surface("Thin", "BsdfDiffuse", 60, 0.3, Color=(0.9, 0.2, 0.2, 1.0))
    shown("Thin", 6, thin, (-1, -1, 1.6), (half, 0, 0), (0.6, 0.4, 1))
    glow = surface("Glow", "Emission", 70, Color=(1.0, 0.6, 0.2, 1.0), Strength=2.0)
    shown("Glow", 7, glow, (1.2, -0.5, 1.8), (half, 0, 0), (0.3, 0.2, 1))
    light = bpy.data.lights.new("Area", "AREA")
    light.energy, light.size = 60.0, 1.0
    shown("Area", 8, light, (0.5, -0.5, 3.0))
    world = bpy.data.worlds.new("World")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.2, 0.3, 0.4, 1.0)
    world.light_settings.distance = 1.5
    world.mist_settings.start, world.mist_settings.depth, world.mist_settings.falloff = 2.0, 8.0, "QUADRATIC"
    file.scene.world = world
    file.camera.data.lens = 30.0
    file.scene.render.resolution_x, file.scene.render.resolution_y = 48, 32
    cycles = file.scene.cycles
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.samples, cycles.blur_glossy, cycles.light_sampling_threshold = 512, 0.0, 0.0
    cycles.sample_clamp_indirect, cycles.pixel_filter_type = 0.0, "BOX"
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = 4
    own = file.scene.sdf_lights
    own.device, own.samples, own.filter = "CPU", 256, "BOX"
    own.max_bounces = own.diffuse_bounces = own.glossy_bounces = own.transmission_bounces = 4
    own.clamp_indirect = 0.0
    return file.scene


@pytest.fixture
def both(scene, pictures):
    """Function: the passes of the first layer by this engine, and by Cycles."""

    def run(after=lambda: None):
        found = []
        for engine in (ENGINE, "CYCLES"):
            scene.render.engine = engine
            found.append(next(iter(pictures().values())))
            after()
        return found

    return run


def switch_on(layer, names):
    for name in names:
        setattr(layer, f"use_pass_{name}", True)


def assert_alike(ours, theirs):
    """All passes of Cycles are here, with the same channels, and means within 1 %, or 0.1 % of the picture's."""
    assert set(theirs) <= set(ours)
    least = 0.001 * theirs["Combined"][..., :3].mean(dtype=float)
    told = []
    for name, expected in theirs.items():
        found = ours[name]
        assert found.shape == expected.shape, name
        means, right = found.mean((0, 1), dtype=float), expected.mean((0, 1), dtype=float)
        if not np.abs(means - right).max() <= 0.01 * np.abs(right).max() + least:
            told.append((name, means.round(4), right.round(4)))
    assert told == []


def parts(passes):
    """What the passes of lobes, volumes, emission and environment sum up to."""
    found = lit(passes)
    data = ("Combined", "Depth", "Noisy Image")
    return sum(value for name, value in found.items() if not name.endswith(("Color", "Col")) and name not in data)


def test_data_and_directly_seen_light(scene, both, file):
    switch_on(file.layer, [*DATA[1:], *LIGHT])
    ours, theirs = both()
    edges = 0.1  # part of the pixels that several things share, of which the first sample of each renderer takes either
    for name in ("Object Index", "Material Index") if bpy.app.version >= (5, 0, 0) else ("IndexOB", "IndexMA"):
        found, expected = ours.pop(name), theirs.pop(name)
        assert found.shape == expected.shape and set(np.unique(found)) == set(np.unique(expected))
        assert (found != expected).mean() < edges
    assert_alike(ours, theirs)
    assert np.abs(ours["Mist"] - theirs["Mist"]).mean() < 0.01
    assert np.abs(ours["UV"] - theirs["UV"]).mean() < 0.01


@pytest.mark.parametrize("threshold", [0.0, 0.25, 0.7, 0.8])
def test_alpha_threshold(scene, both, file, threshold):
    """From which alpha on the two sheets have normals, UVs, numbers and depth."""
    switch_on(file.layer, ["z", "uv", "object_index", "normal"])
    file.layer.pass_alpha_threshold = threshold
    scene.cycles.samples = scene.sdf_lights.samples = 64
    ours, theirs = passes = both()
    index, depth = ("Object Index", "Depth") if bpy.app.version >= (5, 0, 0) else ("IndexOB", "Depth")
    edges = 0.1  # as above
    assert (ours[index] != theirs[index]).mean() < edges
    alike = ours[index] == theirs[index]  # Cycles has the depth of its first sample, which may pass a sheet by chance
    assert (np.abs(ours[depth] - theirs[depth]) > 0.05 * theirs[depth])[alike].mean() < edges
    for found, expected in ([one[name] for one in passes] for name in ("Normal", "UV")):
        assert np.abs(found - expected).mean() < 0.01
        right = expected.mean((0, 1), dtype=float)
        assert found.mean((0, 1), dtype=float) == pytest.approx(right, abs=0.01 * float(np.abs(expected).mean()))
    nearest = [np.median(ours[depth][ours[index] == number]) < 4.2 for number in (5, 6)]  # sheets at 4 m
    assert nearest == [threshold <= 0.7, threshold <= 0.3]


def test_lobes(scene, both, file):
    switch_on(file.layer, [*LOBES, *LIGHT])
    ours, theirs = both()
    assert_alike(lit(ours), lit(theirs))
    np.testing.assert_allclose(parts(ours), ours["Combined"][..., :3], rtol=1e-4, atol=1e-5)


SURFACES = {
    "glass": ("BsdfGlass", dict(Color=(0.8, 0.9, 0.9, 1.0), IOR=1.5)),
    "glossy": ("BsdfAnisotropic", dict(Color=(0.8, 0.6, 0.5, 1.0))),
    "conductor": ("BsdfMetallic", dict(fresnel_type="PHYSICAL_CONDUCTOR")),
    "plastic": ("BsdfPrincipled", {}),
    "metal": ("BsdfPrincipled", dict(Metallic=1.0, Anisotropic=0.7)),
    "transmission": ("BsdfPrincipled", {"Transmission Weight": 1.0}),
    "coat": ("BsdfPrincipled", {"Coat Weight": 1.0, "Coat Roughness": 0.7}),
    "film": ("BsdfPrincipled", {"Thin Film Thickness": 400.0}),
}


@pytest.mark.parametrize("distribution", ["GGX", "MULTI_GGX"])
@pytest.mark.parametrize("name", SURFACES)
def test_colors_of_lobes(scene, both, file, add, quad, material, name, distribution):
    """Four squares, smooth and rough, looked at steeply and flatly: each has the colours that Cycles gives it."""
    if name == "film" and bpy.app.version < (5, 0, 0):
        pytest.skip("the films of this Blender have other colors")
    kind, settings = SURFACES[name]
    for obj in list(scene.objects):
        if obj is not file.camera:
            bpy.data.objects.remove(obj)
    for column, (roughness, angle) in enumerate([(0.3, 0.2), (0.3, 1.2), (0.8, 0.2), (0.8, 1.2)]):
        made, tree, output = material(f"Surface {column}")
        node = tree.nodes.new(f"ShaderNode{kind}")
        node.distribution = distribution
        for key, value in settings.items():
            if hasattr(node, key):
                setattr(node, key, value)
            else:
                node.inputs[key].default_value = value
        node.inputs["Roughness"].default_value = roughness
        tree.links.new(node.outputs[0], output)
        mesh = quad(made.name)
        mesh.materials.append(made)
        add(made.name, mesh, (2.0 * column - 3.0, 0.0, 0.0), (angle, 0.0, 0.0), (1.0, 9.0, 1.0))
    camera = file.camera
    camera.location, camera.rotation_euler = (0.0, 0.0, 20.0), (0.0, 0.0, 0.0)
    camera.data.type, camera.data.ortho_scale = "ORTHO", 8.0
    scene.render.resolution_x, scene.render.resolution_y = 8, 2
    scene.cycles.samples = scene.sdf_lights.samples = 16
    colors = [f"{lobe}_color" for lobe in ("diffuse", "glossy", "transmission")]
    switch_on(file.layer, colors)
    ours, theirs = both()
    for key in theirs:
        if key.startswith("Trans") and bpy.app.version < (5, 1, 0):
            continue  # there, the color of refraction ignores roughness
        if key.endswith(("Color", "Col")):
            limit = 0.01 if bpy.app.version < (5, 0, 0) else 0.005  # conductors had slightly other colors
            np.testing.assert_allclose(ours[key], theirs[key], rtol=limit, atol=0.001, err_msg=key)


@pytest.mark.slow
def test_fog(scene, both, file):
    """What a volume scatters has passes of its own, and the light of surfaces in it those of their lobes."""
    tree = scene.world.node_tree
    fog = tree.nodes.new("ShaderNodeVolumeScatter")
    fog.inputs["Density"].default_value = 0.05
    tree.links.new(fog.outputs[0], tree.nodes["World Output"].inputs["Volume"])
    scene.cycles.volume_bounces = scene.sdf_lights.volume_bounces = 4
    # No light of a world gets through endless fog, but in Cycles of Blender 4.5 a few samples have it.
    tree.nodes["Background"].inputs["Color"].default_value = (0.0, 0.0, 0.0, 1.0)
    # Transmission Indirect has rare bright samples: of 2048 and 8192 of Cycles', six means are 0.00144 to 0.00156.
    scene.cycles.samples, scene.cycles.seed, scene.sdf_lights.samples = 2048, 1, 1024
    switch_on(file.layer, [*LOBES, *LIGHT])
    file.layer.cycles.use_pass_volume_direct = file.layer.cycles.use_pass_volume_indirect = True
    ours, theirs = both()
    assert_alike(lit(ours), lit(theirs))
    np.testing.assert_allclose(parts(ours), ours["Combined"][..., :3], rtol=1e-4, atol=1e-5)


def test_passes_do_not_change_the_picture(scene, pictures, file):
    scene.sdf_lights.samples = 8
    plain = pictures()["ViewLayer"]
    assert set(plain) == {"Combined", "Depth"} or set(plain) == {"Combined"}
    switch_on(file.layer, [*DATA, *LOBES, *LIGHT])
    np.testing.assert_array_equal(pictures()["ViewLayer"]["Combined"], plain["Combined"])


def test_light_groups(scene, both, file):
    """Each group has the light that it has in Cycles, and together they are the picture."""
    groups = {"Area": "Key", "Glow": "Fill"}
    for name in ("Key", "Fill", "Sky"):
        file.layer.lightgroups.add(name=name)
    for name, group in groups.items():
        bpy.data.objects[name].lightgroup = group
    scene.world.lightgroup = "Sky"
    ours, theirs = both()
    assert_alike(ours, theirs)
    whole = sum(ours[f"Combined_{group}"] for group in ("Key", "Fill", "Sky"))
    np.testing.assert_allclose(whole, ours["Combined"][..., :3], rtol=1e-4, atol=1e-5)


@pytest.mark.slow
def test_emission_of_volumes_in_light_groups(scene, both, file, add, material):
    """Where two volumes overlap, all emission belongs to the one that a ray enters last."""
    for name, color, place in (
        ("Key", (1.0, 0.5, 0.2, 1.0), (-0.3, -0.9, 1.0)),
        ("Fill", (0.2, 0.5, 1.0, 1.0), (0.3, -1.2, 1.1)),
    ):
        made, tree, output = material(name)
        glow = tree.nodes.new("ShaderNodeEmission")
        glow.inputs["Color"].default_value, glow.inputs["Strength"].default_value = color, 0.5
        tree.links.new(glow.outputs[0], output.node.inputs["Volume"])
        box, form = bpy.data.meshes.new(name), bmesh.new()
        bmesh.ops.create_cube(form, size=1.2)
        form.to_mesh(box)
        form.free()
        box.materials.append(made)
        file.layer.lightgroups.add(name=name)
        add(name, box, place, (0.2, 0.3, 0.4)).lightgroup = name
    scene.cycles.samples = scene.sdf_lights.samples = 128
    ours, theirs = both()
    assert_alike(ours, theirs)
    assert ours["Combined_Key"].mean() > 0.01 and ours["Combined_Fill"].mean() > 0.01


def test_a_light_may_have_a_pass_of_its_own(scene, pictures, file, lamp, add):
    lamps = [add(name, lamp(name, power=5.0), (x, 0.0, 1.0)) for name, x in (("Left.001", -1.0), ("Right", 1.0))]
    for obj in (*lamps, bpy.data.objects["Area"]):
        obj.data.sdf_lamp.use_pass = True
    file.layer.sdf_lights.use_pass_sdf_lamps = True
    scene.sdf_lights.samples = 8
    found = pictures()["ViewLayer"]
    both = found["Light Left_001"] + found["Light Right"]
    np.testing.assert_allclose(both, found["SDF Lamps"], rtol=1e-4, atol=1e-5)
    assert min(found[name].mean() for name in ("Light Left_001", "Light Right", "Light Area")) > 0.0
    lamps[0].data.energy = 0.0
    alone = pictures()["ViewLayer"]
    assert alone["Light Left_001"].max() == 0.0
    assert alone["Light Right"].mean() == pytest.approx(found["Light Right"].mean(), rel=0.02)


def test_blenders_node_picks_an_object(scene, pictures, file, compositor):
    """The Cryptomatte node of the compositor finds an object by its name."""
    switch_on(file.layer, ["cryptomatte_object"])
    scene.sdf_lights.samples = 16
    tree, end = compositor
    node = tree.nodes.new("CompositorNodeCryptomatteV2")
    node.source, node.scene, node.layer_name = "RENDER", scene, f"{file.layer.name}.CryptoObject"
    node.matte_id = "Plastic"
    tree.links.new(node.outputs["Matte"], end.inputs[0])
    found = pictures()
    passes, number = found[file.layer.name], number_of("Plastic")
    expected = sum(
        np.where(
            passes[f"CryptoObject{level:02}"][..., i] == np.float32(number),
            passes[f"CryptoObject{level:02}"][..., i + 1],
            0,
        )
        for level in range(3)
        for i in (0, 2)
    )
    assert expected.max() == 1.0
    np.testing.assert_allclose(found["Composite"]["Combined"][..., 0], expected, atol=1e-5)


def test_light_groups_are_mixed_anew(scene, pictures, file, compositor):
    """The compositor makes the key light half and the fill three times as bright, as a render with such lights is."""
    factors = {"Key": 0.5, "Fill": 3.0, "Sky": 1.0}
    for name in factors:
        file.layer.lightgroups.add(name=name)
    bpy.data.objects["Area"].lightgroup, bpy.data.objects["Glow"].lightgroup = "Key", "Fill"
    scene.world.lightgroup, scene.render.engine = "Sky", ENGINE
    file.layer.update_render_passes()
    tree, end = compositor
    result = sum_of_light_groups(scene, tree, factors)
    tree.links.new(result, end.inputs[0])
    mixed = pictures()["Composite"]["Combined"][..., :3]
    bpy.data.lights["Area"].energy *= factors["Key"]
    glow = bpy.data.objects["Glow"].data.materials[0].node_tree
    next(node for node in glow.nodes if node.type == "EMISSION").inputs["Strength"].default_value *= factors["Fill"]
    again = pictures()["ViewLayer"]["Combined"][..., :3]
    np.testing.assert_allclose(mixed.mean((0, 1)), again.mean((0, 1)), rtol=0.01)
    assert np.abs(mixed - again).mean() < 0.05 * again.mean()


KINDS = {"Object": "object", "Material": "material", "Asset": "asset"}


def covered(passes, kind: str) -> dict[float, float]:
    """How much each number of Cryptomatte covers, on average over the pixels."""
    found: dict[float, float] = {}
    for level in range(3):
        for first in (0, 2):
            numbers, coverage = (passes[f"Crypto{kind}{level:02}"][..., first + i].ravel() for i in (0, 1))
            for number in np.unique(numbers[coverage > 0.0]):
                found[float(number)] = found.get(float(number), 0.0) + float(coverage[numbers == number].sum())
    return {number: total / coverage.size for number, total in found.items()}


def test_cryptomatte(scene, both, file, tmp_path):
    """Numbers, coverage, and what the file says of them are those of Cycles."""
    openimageio = pytest.importorskip("OpenImageIO")
    switch_on(file.layer, [f"cryptomatte_{kind}" for kind in KINDS.values()])
    bpy.data.objects["Glass"].parent = bpy.data.objects["Metal"]
    said = []

    def read():
        spec = openimageio.ImageInput.open(str(tmp_path / "picture.exr")).spec()
        said.append({item.name: item.value for item in spec.extra_attribs if "cryptomatte" in item.name})

    ours, theirs = both(read)
    for kind in KINDS:
        found, expected = covered(ours, kind), covered(theirs, kind)
        assert set(found) == set(expected) and len(found) >= 6
        for number, part in expected.items():
            assert found[number] == pytest.approx(part, abs=0.002), (kind, number)
        first = ours[f"Crypto{kind}00"]
        assert (first[..., 1] >= first[..., 3] - 1e-6).all()
    assert len(said[0]) == 12 and said[0].keys() == said[1].keys()
    for name, value in said[1].items():
        if name.endswith("manifest"):
            assert json.loads(said[0][name]).items() <= json.loads(value).items()
        else:
            assert said[0][name] == value


def test_aovs(scene, both, file):
    for name, kind in (("Mask", "VALUE"), ("Paint", "COLOR")):
        aov = file.layer.aovs.add()
        aov.name, aov.type = name, kind
    for index, material in enumerate(("Floor", "Plastic", "Sheet")):
        tree = bpy.data.materials[material].node_tree
        node = tree.nodes.new("ShaderNodeOutputAOV")
        node.aov_name, node.inputs["Value"].default_value = "Mask", 0.2 * (index + 1)
        node = tree.nodes.new("ShaderNodeOutputAOV")
        node.aov_name = "Paint"
        place = tree.nodes.new("ShaderNodeTexCoord")
        tree.links.new(place.outputs["UV"], node.inputs["Color"])
    ours, theirs = both()
    assert_alike(ours, theirs)


@pytest.mark.parametrize("transparent", [False, True])
def test_aovs_of_worlds(scene, both, file, transparent):
    """They add to those of sheets that are too clear. A transparent film has none."""
    for name, kind in (("Mask", "VALUE"), ("Paint", "COLOR")):
        aov = file.layer.aovs.add()
        aov.name, aov.type = name, kind
    for tree in (bpy.data.materials["Thin"].node_tree, scene.world.node_tree):
        node, paint, place = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("OutputAOV", "OutputAOV", "TexCoord"))
        node.aov_name, node.inputs["Value"].default_value, paint.aov_name = "Mask", 0.3, "Paint"
        tree.links.new(place.outputs["Generated"], paint.inputs["Color"])
    scene.render.film_transparent = transparent
    scene.cycles.samples = scene.sdf_lights.samples = 128
    ours, theirs = both()
    theirs["Paint"][..., 3] = np.minimum(
        theirs["Paint"][..., 3], 1.0
    )  # Cycles counts each surface, here alpha ends at 1
    assert_alike(ours, theirs)
    assert (ours["Mask"].max() > 0.29) and (ours["Mask"][-1].mean() > 0.2) == (not transparent)


def test_aovs_in_groups(scene, both, file):
    """Each use of a group gives what it is given there; what is muted gives nothing."""
    aov = file.layer.aovs.add()
    aov.name, aov.type = "Mask", "VALUE"
    inner = bpy.data.node_groups.new("Inner", "ShaderNodeTree")
    inner.interface.new_socket("Amount", in_out="INPUT", socket_type="NodeSocketFloat")
    given, node = inner.nodes.new("NodeGroupInput"), inner.nodes.new("ShaderNodeOutputAOV")
    node.aov_name = "Mask"
    inner.links.new(given.outputs[0], node.inputs["Value"])
    outer = bpy.data.node_groups.new("Outer", "ShaderNodeTree")
    outer.interface.new_socket("Amount", in_out="INPUT", socket_type="NodeSocketFloat")
    given, group, half = (
        outer.nodes.new(f"{kind}") for kind in ("NodeGroupInput", "ShaderNodeGroup", "ShaderNodeMath")
    )
    group.node_tree, half.operation, half.inputs[1].default_value = inner, "MULTIPLY", 0.5
    outer.links.new(given.outputs[0], half.inputs[0])
    outer.links.new(half.outputs[0], group.inputs[0])
    for material, tree, amount in (("Floor", inner, 0.3), ("Plastic", outer, 0.8), ("Metal", inner, 0.9)):
        node = bpy.data.materials[material].node_tree.nodes.new("ShaderNodeGroup")
        node.node_tree, node.inputs[0].default_value = tree, amount
        node.mute = material == "Metal"
    ours, theirs = both()
    assert ours["Mask"].max() == pytest.approx(0.4, abs=0.01)
    assert_alike(ours, theirs)
