# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Subsurface scattering: as sync reads it, and beside Cycles."""

import math

import bpy
import mathutils
import numpy as np
import pytest

HAS_LEGACY = bpy.app.version >= (5, 2)
STONE = dict(Base_Color=(0.8, 0.7, 0.5, 1.0), Subsurface_Weight=1.0, Subsurface_Radius=(1.0, 0.7, 0.4), Roughness=0.3)
FLESH = dict(Base_Color=(0.8, 0.5, 0.4, 1.0), Subsurface_Weight=1.0, Subsurface_Radius=(1.0, 0.35, 0.17), Roughness=0.4)
WOOD = dict(Color=(0.7, 0.4, 0.2, 1.0), Radius=(1.0, 0.4, 0.2), IOR=1.6, Roughness=0.2, Anisotropy=0.3)
LEGACY = "RANDOM_WALK_LEGACY" if HAS_LEGACY else "RANDOM_WALK"

# Name: node, and values of its sockets and settings.
CASES = {
    "marble": ("BsdfPrincipled", dict(STONE, subsurface_method="RANDOM_WALK", Subsurface_Scale=0.2)),
    "skin": (
        "BsdfPrincipled",
        dict(FLESH, subsurface_method="RANDOM_WALK_SKIN", Subsurface_Scale=0.15, Subsurface_Anisotropy=0.8),
    ),
    "Burley": ("BsdfPrincipled", dict(STONE, subsurface_method="BURLEY", Subsurface_Scale=1.0)),
    "legacy": (
        "BsdfPrincipled",
        dict(STONE, subsurface_method=LEGACY, Subsurface_Scale=1.0, Subsurface_Anisotropy=0.5),
    ),
    "node": ("SubsurfaceScattering", dict(WOOD, falloff="RANDOM_WALK", Scale=0.3)),
    "weight of a texture": ("BsdfPrincipled", dict(STONE, subsurface_method="RANDOM_WALK", Subsurface_Scale=0.2)),
    "bumps": ("BsdfPrincipled", dict(STONE, subsurface_method="RANDOM_WALK", Subsurface_Scale=0.2)),
    "white": (
        "BsdfPrincipled",
        dict(STONE, Base_Color=(1.0, 1.0, 1.0, 1.0), subsurface_method="RANDOM_WALK", Subsurface_Scale=0.1),
    ),
}


def new(tree, kind: str, **values):
    node = tree.nodes.new(f"ShaderNode{kind}")
    for name, value in values.items():
        if name[0].islower():
            setattr(node, name, value)
        else:
            node.inputs[name.replace("_", " ")].default_value = value
    return node


def feed(tree, node, name: str) -> None:
    """What the case links to the node."""
    if name == "weight of a texture":
        checker = new(tree, "TexChecker", Scale=3.0, Color1=(1.0, 1.0, 1.0, 1.0), Color2=(0.2, 0.2, 0.2, 1.0))
        tree.links.new(checker.outputs["Color"], node.inputs["Subsurface Weight"])
    elif name == "bumps":
        noise, bump = new(tree, "TexNoise", Scale=4.0), new(tree, "Bump", Strength=1.0, Distance=0.3)
        tree.links.new(noise.outputs[0], bump.inputs["Height"])
        tree.links.new(bump.outputs[0], node.inputs["Normal"])


@pytest.fixture
def stage(file, add, material):
    """Function: a ball, a slab with light behind it, and two blocks in one another, one mirrored, of a case's
    material."""
    bpy.ops.preferences.addon_enable(module="cycles")

    def run(name: str):
        kind, values = CASES[name]
        made, tree, output = material("Deep")
        node = new(tree, kind, **values)
        feed(tree, node, name)
        tree.links.new(node.outputs[0], output)
        bpy.ops.mesh.primitive_plane_add(size=8.0)
        for operator, changes in (
            (
                bpy.ops.mesh.primitive_uv_sphere_add,
                dict(segments=48, ring_count=24, radius=0.5, location=(-1.1, 0, 0.5)),
            ),
            (bpy.ops.mesh.primitive_cube_add, dict(size=1.0, location=(0.1, 0.2, 0.51), scale=(0.8, 0.1, 1.0))),
            (bpy.ops.mesh.primitive_cube_add, dict(size=0.6, location=(1.1, 0.0, 0.31))),
        ):
            operator(**changes)
            bpy.context.object.data.materials.append(made)
            if operator is bpy.ops.mesh.primitive_uv_sphere_add:
                bpy.ops.object.shade_smooth()
        add("Again", bpy.context.object.data, (1.35, -0.35, 0.5), (0.3, 0.4, 0.5), (0.6, 0.7, -0.8))
        for place, energy, size in (((-1.5, -2.5, 2.5), 80.0, 0.8), ((0.6, 2.0, 1.2), 60.0, 0.5)):
            light = bpy.data.lights.new("Light", "AREA")
            light.energy, light.size = energy, size
            way = mathutils.Vector((0.0, 0.0, 0.5)) - mathutils.Vector(place)
            add("Light", light, place, way.to_track_quat("-Z", "Y").to_euler())
        file.camera.location, file.camera.rotation_euler = (0.0, -4.5, 1.6), (math.radians(76.0), 0.0, 0.0)
        file.camera.data.lens = 45.0
        render, cycles = file.scene.render, file.scene.cycles
        render.resolution_x, render.resolution_y = 48, 32
        cycles.use_adaptive_sampling = cycles.use_denoising = False
        cycles.samples, cycles.blur_glossy, cycles.light_sampling_threshold = 512, 0.0, 0.0
        cycles.sample_clamp_indirect, cycles.pixel_filter_type, cycles.max_bounces = 0.0, "BOX", 4
        return file.scene

    return run


def both(scene, pictures, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Pictures of this engine and of Cycles."""
    found = {}
    for scene.render.engine in ("CYCLES", "SDF_LIGHTS"):
        bpy.ops.sdf_lights.cycles_settings_copy()
        scene.sdf_lights.device, scene.sdf_lights.samples = "CPU", samples
        found[scene.render.engine] = pictures()["ViewLayer"]["Combined"][..., :3].astype(float)
    return found["SDF_LIGHTS"], found["CYCLES"]


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_scenes_look_as_in_cycles(stage, pictures, name):
    """The mean within 1 %; blocks of 8 × 8 pixels, whose noise is about 1 %, within 1.5 % of the picture's mean on
    average."""
    pytest.importorskip("_cycles")
    ours, theirs = both(stage(name), pictures, 128)
    near = [picture.reshape(4, 8, 6, 8, 3).mean((1, 3)) for picture in (ours, theirs)]
    difference = np.abs(near[0] - near[1]).mean() / theirs.mean()
    print(f"{name}: {ours.mean() / theirs.mean() - 1.0:+.4f}, blocks {difference:.4f}")
    assert ours.mean((0, 1)) == pytest.approx(theirs.mean((0, 1)), rel=0.01)
    assert difference < 0.015


def test_nodes_and_methods(synced, add, quad, material):
    made, tree, output = material("Deep")
    principled = new(
        tree, "BsdfPrincipled", subsurface_method="RANDOM_WALK_SKIN", Subsurface_Weight=0.5, Subsurface_IOR=1.3
    )
    node = new(tree, "SubsurfaceScattering", falloff="RANDOM_WALK", Scale=0.25)
    shaders = tree.nodes.new("ShaderNodeAddShader")
    for place, shader in enumerate((principled, node)):
        tree.links.new(shader.outputs[0], shaders.inputs[place])
    tree.links.new(shaders.outputs[0], output)
    mesh = quad()
    mesh.materials.append(made)
    add("Quad", mesh)
    scene = synced()
    assert scene.warnings == []
    found = next(material for material in scene.materials if material.name == "Deep").surface
    a, b = found["a"], found["b"]
    once = bpy.app.version < (5, 0)
    assert a.kind == "principled" and a.settings["subsurface_method"] == "RANDOM_WALK_SKIN"
    assert b.kind == "subsurface" and b.settings["subsurface_once"] == once
    assert b.settings["subsurface_method"] == ("RANDOM_WALK" if HAS_LEGACY else "RANDOM_WALK_LEGACY")


@pytest.mark.slow
def test_a_white_ball_keeps_the_energy_that_it_has_in_cycles(stage, pictures, file):
    """In a white world, without a boundary that reflects: with each method within 0.5 %."""
    pytest.importorskip("_cycles")
    scene = stage("white")
    for obj in list(bpy.data.objects):
        if obj.type == "LIGHT" or (obj.type == "MESH" and "Sphere" not in obj.name):
            bpy.data.objects.remove(obj)
    world = bpy.data.worlds.new("White")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    scene.world, scene.cycles.max_bounces, scene.cycles.samples = world, 0, 512
    file.camera.location, file.camera.rotation_euler = (-1.1, -4.5, 0.5), (math.pi / 2, 0.0, 0.0)
    file.camera.data.lens = 200.0
    node = bpy.data.materials["Deep"].node_tree.nodes["Principled BSDF"]
    node.inputs["Specular IOR Level"].default_value = 0.0
    for method, scale in (("RANDOM_WALK", 0.3 if not HAS_LEGACY else 0.02), ("RANDOM_WALK_SKIN", 0.2), ("BURLEY", 0.3)):
        node.subsurface_method, node.inputs["Subsurface Scale"].default_value = method, scale
        ours, theirs = (picture[8:-8, 12:-12].mean((0, 1)) for picture in both(scene, pictures, 256))
        print(method, ours, theirs)
        assert ours.mean() == pytest.approx(theirs.mean(), rel=0.005)
