# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Simplify: what Blender does of it, and what is left to the engine, as Cycles does it."""

import bpy
import numpy as np
import pytest

from sdf_lights.render.images import reduced

pytest.importorskip("_cycles")


@pytest.fixture
def simple(file):
    """A scene that is simplified."""
    bpy.ops.preferences.addon_enable(module="cycles")
    file.scene.render.use_simplify = True
    return file.scene


def drawn(scene, pictures) -> dict[str, float]:
    """Means of both engines' pictures."""
    scene.cycles.samples, scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = 128, False, False
    scene.sdf_lights.device, scene.sdf_lights.samples, found = "REFERENCE", 128, {}
    for scene.render.engine in ("CYCLES", "SDF_LIGHTS"):
        found[scene.render.engine] = float(pictures()["ViewLayer"]["Combined"][..., :3].mean())
    return found


PLACES = [(0.0, 2.0, 1.0), (2.2, 2.0, 1.0), (4.0, 2.0, 1.0), (0.0, -7.0, 1.0), (0.0, 40.0, 1.0), (-3.0, 30.0, 9.0)]


@pytest.mark.parametrize("ways", [("camera",), ("distance",), ("camera", "distance")], ids="+".join)
@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_what_is_culled_is_what_cycles_culls(simple, file, add, quad, material, pictures, synced, ways, kind):
    """Objects glow, and a floor shows how many of them there are."""
    glow, tree, output = material("Glow")
    emission = tree.nodes.new("ShaderNodeEmission")
    emission.inputs["Strength"].default_value = 20.0
    tree.links.new(emission.outputs[0], output)
    white, tree, output = material("White")
    tree.links.new(tree.nodes.new("ShaderNodeBsdfDiffuse").outputs[0], output)
    floor = quad("Floor")
    floor.materials.append(white)
    add("Floor", floor, scale=(10.0, 20.0, 1.0))
    file.camera.data.type = kind
    simple.cycles.camera_cull_margin, simple.cycles.distance_cull_margin = 0.1, 20.0
    for way in ways:
        setattr(simple.cycles, f"use_{way}_cull", True)
    shape = quad()
    shape.materials.append(glow)
    for number, place in enumerate(PLACES):
        size = 0.3 if number < 4 else 3.0
        obj = add(f"Quad {number}", shape, place, rotation=(np.pi / 2, 0.0, 0.0), scale=(size,) * 3)
        for way in ways:
            setattr(obj.cycles, f"use_{way}_cull", True)
    kept = {instance.name[-1] for instance in synced().instances} - {"r"}
    # Depths of an orthographic camera are parts of its range, so what is just behind it is within the margin.
    outside, far = {"2", "3"} if kind == "PERSP" else {"2", "5"}, {"4", "5"}
    expected = {"camera": outside, "distance": far, "camera+distance": outside & far}["+".join(ways)]
    assert kept == set("012345") - expected
    found = drawn(simple, pictures)
    assert found["SDF_LIGHTS"] == pytest.approx(found["CYCLES"], rel=0.02)


def test_objects_that_do_not_ask_stay(simple, add, quad, synced):
    simple.cycles.use_camera_cull = True
    add("Quad", quad(), (50.0, 2.0, 1.0))
    assert len(synced().instances) == 1
    bpy.data.objects["Quad"].cycles.use_camera_cull = True
    assert synced().instances == []
    simple.render.use_simplify = False
    assert len(synced().instances) == 1


def test_textures_are_as_small_as_the_limit(simple, add, quad, material, synced):
    image = bpy.data.images.new("Stripes", 512, 256)
    pixels = np.ones((256, 512, 4), np.float32)
    pixels[:, ::2, :3] = 0.0
    image.pixels.foreach_set(pixels.ravel())
    made, tree, output = material("Striped")
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    tree.links.new(node.outputs["Color"], output)
    mesh = quad()
    mesh.materials.append(made)
    add("Quad", mesh)
    assert synced().images[0].pixels.shape[:2] == (256, 512)
    simple.cycles.texture_limit_render = "128"
    small = synced().images[0].pixels
    assert small.shape[:2] == (64, 128)
    assert np.abs(small[..., 0].astype(float) - 127.5).max() <= 0.5


def test_reduced_pixels_are_means():
    pixels = np.arange(6 * 8, dtype=np.float32).reshape(6, 8, 1)
    half = reduced(pixels, 4)
    assert half.shape == (3, 4, 1) and half[0, 0, 0] == np.mean([0, 1, 8, 9])
    assert reduced(pixels, 0) is pixels and reduced(pixels, 8) is pixels
    assert reduced(pixels, 6).shape == (3, 4, 1)  # by halves alone
    assert reduced(pixels, 6, 1.0).shape == (4, 6, 1)
    assert reduced(pixels, 0, 0.5).shape == (3, 4, 1)


def test_blender_divides_and_grows_less_by_itself(simple, add, quad, synced):
    """Subdivision and children of hair are simplified in the dependency graph."""
    floor = add("Floor", quad())
    floor.modifiers.new("Divide", "SUBSURF").render_levels = 3
    system = floor.modifiers.new("Fur", "PARTICLE_SYSTEM").particle_system
    system.settings.type, system.settings.count, system.settings.child_type = "HAIR", 10, "SIMPLE"
    system.settings.rendered_child_count = 8
    simple.render.use_simplify = False
    whole = [len(mesh.triangles) for mesh in synced().meshes]
    simple.render.use_simplify = True
    simple.render.simplify_subdivision_render, simple.render.simplify_child_particles_render = 1, 0.5
    less = [len(mesh.triangles) for mesh in synced().meshes]
    assert less[0] * 16 == whole[0] and less[1] * 2 == pytest.approx(whole[1], rel=0.1)
