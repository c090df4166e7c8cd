# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the table of sheen (``sdf_lights/render/tables/sheen.npz``) from what Cycles renders.

    .venv-3.13/bin/python scripts/measure_sheen.py [--compare]

Each pixel of a picture is a face with its own tilt and roughness, seen from above by an orthographic camera. One sun
without an angle lights them, and throws no shadows. So one sample has no noise, and a pixel p is f · cos for the
directions wo and wi of its face. Along the tangent below wo, its bitangent and the normal, wi is (x, y, z). A linearly
transformed cosine of albedo R is

    p = R z / π (A / (A² (x² + y²) + 2 A B x z + (B² + 1) z²))²,

so √(z / (π p)) is linear in three numbers, which least squares over the pictures give. From them follow R, A and B.
The faces are at the entries of the table and halfway between. The entries follow by least squares, too, because what
lies between is bilinear. The residual of both fits proves that Cycles computes this, with entries at these places.

``--compare`` says how much the measured table and the stored one differ, and writes nothing.
"""

from __future__ import annotations

import argparse
import contextlib
import pathlib
import tempfile

import bpy
import host  # noqa: F401  (puts this checkout on the path)
import numpy as np
from mathutils import Vector

from sdf_lights.blender.shader_trees import use_nodes
from sdf_lights.render.tables.sheen import PATH, SCALE, SIZE, TERMS, load
from support import openexr

PICTURES = 40
LOWEST = 0.02  # cosine of wi: a flatter face loses digits
HIGHEST_RESIDUAL = 2e-6  # relative, of √(z / (π p)), and absolute, of the terms; pictures are float32
FEWEST = 6  # pictures in which a face is lit
# Without the ends: no camera sees a face from its edge, and from above the tangent is arbitrary.
COSINES = np.arange(1, 2 * SIZE - 2) / (2 * SIZE - 2)
ROUGHNESSES = np.arange(1, 2 * SIZE - 1) / (2 * SIZE - 2)


def _faces(cosines: np.ndarray, roughnesses: np.ndarray) -> bpy.types.Mesh:
    """A face for each pixel: rows of one tilt about x, columns of one roughness, which is an attribute."""
    vertices, faces = [], []
    for row, cosine in enumerate(cosines):
        rise = 0.5 * np.sqrt(1.0 - cosine * cosine) / cosine
        for column in range(len(roughnesses)):
            first = len(vertices)
            vertices += [(column, row, rise), (column + 1, row, rise)]
            vertices += [(column + 1, row + 1, -rise), (column, row + 1, -rise)]
            faces.append(range(first, first + 4))
    mesh = bpy.data.meshes.new("Faces")
    mesh.from_pydata(vertices, [], faces)
    values = np.tile(roughnesses, len(cosines)).astype(np.float32)
    mesh.attributes.new("roughness", "FLOAT", "FACE").data.foreach_set("value", values)
    mesh.update()
    return mesh


def _material() -> bpy.types.Material:
    made = bpy.data.materials.new("Sheen")
    tree = use_nodes(made)
    tree.nodes.clear()
    roughness, sheen = tree.nodes.new("ShaderNodeAttribute"), tree.nodes.new("ShaderNodeBsdfSheen")
    roughness.attribute_name, sheen.inputs["Color"].default_value = "roughness", (1.0, 1.0, 1.0, 1.0)
    tree.links.new(roughness.outputs["Fac"], sheen.inputs["Roughness"])
    tree.links.new(sheen.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return made


def _stage(cosines: np.ndarray, roughnesses: np.ndarray) -> bpy.types.Object:
    """The faces, their camera and their sun, as the open file; returns the sun."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="cycles")
    scene = bpy.context.scene
    mesh = _faces(cosines, roughnesses)
    mesh.materials.append(_material())
    camera, light = bpy.data.cameras.new("Camera"), bpy.data.lights.new("Sun", "SUN")
    camera.type, camera.ortho_scale, camera.clip_end = "ORTHO", max(len(cosines), len(roughnesses)), 1000.0
    light.energy, light.angle, light.use_shadow = 1.0, 0.0, False
    faces, eye, sun = (bpy.data.objects.new(data.name, data) for data in (mesh, camera, light))
    for obj in (faces, eye, sun):
        scene.collection.objects.link(obj)
    eye.location = 0.5 * len(roughnesses), 0.5 * len(cosines), 500.0
    sun.rotation_mode = "QUATERNION"
    scene.camera, render, cycles = eye, scene.render, scene.cycles
    render.engine, render.resolution_x, render.resolution_y = "CYCLES", len(roughnesses), len(cosines)
    render.resolution_percentage = 100
    cycles.samples, cycles.max_bounces, cycles.pixel_filter_type = 1, 0, "BOX"
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.light_sampling_threshold = cycles.sample_clamp_direct = 0.0
    settings = render.image_settings
    with contextlib.suppress(AttributeError):  # new in 5.0
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format, settings.color_depth, settings.exr_codec = "OPEN_EXR_MULTILAYER", "32", "ZIP"
    return sun


def _pictures(sun: bpy.types.Object):
    """Directions (3,) to the sun and pictures (cosines, roughnesses), in float64."""
    rng = np.random.default_rng(1)
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "picture.exr"
        bpy.context.scene.render.filepath = str(path)
        for number in range(PICTURES):
            direction = rng.normal(size=3)
            if number % 2:  # faces seen from above are lit from above only
                direction[2] = abs(direction[2])
            sun.rotation_quaternion = Vector(direction).to_track_quat("Z", "Y")
            bpy.ops.render.render(write_still=True)
            seen = openexr.read_passes(path)["ViewLayer"]["Combined"][..., 0].astype(float)
            yield np.array(sun.matrix_world.to_3x3() @ Vector((0.0, 0.0, 1.0))), seen


def measured_lobes(cosines: np.ndarray, roughnesses: np.ndarray) -> np.ndarray:
    """``TERMS`` (cosines, roughnesses, 3) of Cycles' sheen; not a number where it has too little to measure."""
    sine = np.sqrt(1.0 - cosines * cosines)
    zero = np.zeros(len(cosines))
    normal, tangent = np.stack([zero, sine, cosines], 1), np.stack([zero, -cosines, sine], 1)
    rows, wanted = [], []
    for wi, seen in _pictures(_stage(cosines, roughnesses)):
        z, x = (normal @ wi)[:, None], (tangent @ wi)[:, None]
        lit = (z > LOWEST) & (seen > 0.0)
        # A residual relative to what is seen: these rows are divided by it.
        weight = np.where(lit, np.sqrt(np.pi * seen / np.maximum(z, LOWEST)), 0.0)
        rows.append(weight[..., None] * np.stack([1.0 - z * z, 2.0 * x * z, z * z], -1))
        wanted.append(lit.astype(float))
    matrix, vector = np.stack(rows, 2), np.stack(wanted, 2)
    found = np.full((len(cosines), len(roughnesses), len(TERMS)), np.nan)
    for face in np.argwhere(vector.sum(-1) >= FEWEST):
        here = tuple(face)
        (first, second, third), *_ = np.linalg.lstsq(matrix[here], vector[here], rcond=None)
        residual = np.abs(matrix[here] @ (first, second, third) - vector[here]).max()
        assert residual < HIGHEST_RESIDUAL, f"Cycles' sheen is another lobe: {residual:.1e} at {here}"
        albedo = 1.0 / (first * third - second * second)
        found[here] = albedo, first * np.sqrt(albedo), second * np.sqrt(albedo)
    return found


def _hats(places: np.ndarray) -> np.ndarray:
    """Weights (places, SIZE) of the entries of an axis in linear interpolation."""
    return np.maximum(1.0 - np.abs(places[:, None] * (SIZE - 1) - np.arange(SIZE)), 0.0)


def measure() -> np.ndarray:
    """The table of the Blender that runs, (terms, SIZE, SIZE), as integers of ``SCALE``.

    Cycles leaves out sheen with an albedo below 1e-5. Entries that only such sheen reads are 0.
    """
    lobes = measured_lobes(COSINES, ROUGHNESSES).reshape(-1, len(TERMS))
    known = np.isfinite(lobes[:, 0])
    weights = np.einsum("ai,bj->abij", _hats(COSINES), _hats(ROUGHNESSES)).reshape(-1, SIZE * SIZE)[known]
    entries, *_ = np.linalg.lstsq(weights, lobes[known], rcond=1e-9)
    residual = np.abs(weights @ entries - lobes[known]).max()
    assert residual < HIGHEST_RESIDUAL, f"Cycles' sheen is another table: {residual:.1e}"
    return np.round(SCALE * entries.T).astype(np.int32).reshape(len(TERMS), SIZE, SIZE)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--compare", action="store_true", help="compare with the stored table and write nothing")
    arguments = parser.parse_args()
    table = measure()
    if arguments.compare:
        print(f"Blender {bpy.app.version_string}: {np.abs(table / SCALE - load()).max():.1e} at most")
    else:
        np.savez_compressed(PATH, **dict(zip(TERMS, table)))
