# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A street in fog, a forest of instances, a landscape with water."""

from __future__ import annotations

import math

import bpy
import numpy as np
from scenery.materials import Graph, principled
from scenery.modelling import add, box, leaf, plane, rod
from scenery.staging import camera, glowing, light, sky, world

from .stage import scene

TREES = 4000


@scene("a street by night: sixty lamps, wet asphalt, lit windows, fog")
def street(opened) -> None:
    graph = world((0.006, 0.009, 0.02))
    graph.finish(
        graph.node("ShaderNodeVolumeScatter", Color=(0.8, 0.85, 0.95), Density=0.025, Anisotropy=0.3), "Volume"
    )
    asphalt = Graph("Asphalt")
    place = asphalt.node("ShaderNodeTexCoord", "Object")
    wet = asphalt.node("ShaderNodeTexNoise", Vector=place, Scale=0.6, Detail=4.0)
    gloss = asphalt.node("ShaderNodeMapRange", Value=wet, _1=0.4, _2=0.6, _3=0.06, _4=0.6)
    grain = asphalt.node("ShaderNodeTexNoise", Vector=place, Scale=60.0, Detail=3.0)
    asphalt.finish(
        asphalt.node(
            "ShaderNodeBsdfPrincipled",
            Base_Color=(0.035, 0.036, 0.04),
            Roughness=gloss,
            Normal=asphalt.bump(grain, 0.01),
        )
    )
    add("Road", plane("Road", (12.0, 130.0)), asphalt.material, location=(0.0, 55.0, 0.0))
    random = np.random.default_rng(5)
    wall = principled("Render", (0.3, 0.26, 0.22, 1.0), 0.85)
    lit, dark = glowing("Lit window", (1.0, 0.7, 0.35), 1.5), principled("Pane", (0.03, 0.03, 0.04, 1.0), 0.05)
    for side in (-1.0, 1.0):
        for block in range(7):
            height = float(random.uniform(8.0, 16.0))
            y = 5.0 + 17.0 * block
            add("House", box("House", (8.0, 15.0, height)), wall, location=(side * 10.0, y, 0.5 * height))
            for floor in range(int(height / 3.2)):
                for column in range(4):
                    shown = lit if random.random() < 0.3 else dark
                    at = (side * 5.98, y - 5.4 + 3.6 * column, 1.8 + 3.2 * floor)
                    add("Window", plane("Window", (1.3, 1.7)), shown, location=at, rotation=(90, 0, -90 * side))
    post = principled("Post", (0.1, 0.1, 0.1, 1.0), 0.4, Metallic=1.0)
    for index in range(30):
        for side in (-1.0, 1.0):
            x, y = side * 4.6, 2.0 + 4.0 * index
            if index % 3 == 0:
                rod("Post", (x, y, 0.0), (x, y, 4.5), 0.06, post, steps=8)
            warm = (1.0, 0.62, 0.3) if index % 2 else (0.75, 0.85, 1.0)
            kind, more = ("SPOT", dict(spot_size=2.0, spot_blend=0.6)) if index % 3 == 0 else ("POINT", {})
            height = 4.4 if index % 3 == 0 else 2.6
            light(
                f"Lamp {index} {side}",
                kind,
                70.0,
                (x, y, height),
                (0.6 * x, y, 0.0),
                warm,
                shadow_soft_size=0.12,
                **more,
            )
    camera((1.2, -6.0, 1.7), (-0.2, 30.0, 3.0), 55.0)


def _tree(name: str, seed: int, triangles: int, materials) -> bpy.types.Mesh:
    """A trunk and a crown of leaves, with about so many triangles; ``materials``: of the trunk and of the leaves."""
    random = np.random.default_rng(seed)
    around = np.linspace(0.0, 2.0 * math.pi, 12, endpoint=False)
    ring = np.stack([np.cos(around), np.sin(around), np.zeros(12)], axis=1)
    trunk = np.concatenate([0.09 * ring, 0.03 * ring + (0.0, 0.0, 1.4)])
    faces = [(side, (side + 1) % 12, 12 + (side + 1) % 12, 12 + side) for side in range(12)]
    shape = leaf("Leaf", 0.12, 0.06, 5)
    blade = np.array([vertex.co for vertex in shape.vertices])
    pattern = np.array([polygon.vertices for polygon in shape.polygons])
    bpy.data.meshes.remove(shape)
    count = triangles // (2 * len(pattern))
    way = random.standard_normal((count, 3))
    way *= (0.55 * random.random((count, 1)) ** 0.35) / np.linalg.norm(way, axis=1, keepdims=True)
    place = way * (1.0, 1.0, 1.3) + (0.0, 0.0, 1.6)
    # Each leaf is rotated about z, and hangs at its own angle.
    turn, fall = random.uniform(0.0, 2.0 * math.pi, count), random.uniform(-1.0, 1.0, count)
    x, y, z = blade.T[:, None, :]
    y, z = y * np.cos(fall)[:, None] - z * np.sin(fall)[:, None], y * np.sin(fall)[:, None] + z * np.cos(fall)[:, None]
    cosine, sine = np.cos(turn)[:, None], np.sin(turn)[:, None]
    leaves = np.stack([x * cosine - y * sine, x * sine + y * cosine, z], axis=2) + place[:, None]
    first = len(trunk) + len(blade) * np.arange(count)[:, None, None]
    mesh = bpy.data.meshes.new(name)
    vertices = np.concatenate([trunk, leaves.reshape(-1, 3)])
    mesh.from_pydata(vertices.tolist(), [], faces + (first + pattern).reshape(-1, 4).tolist())
    for material in materials:
        mesh.materials.append(material)
    indices = np.ones(len(mesh.polygons), np.int32)
    indices[: len(faces)] = 0
    mesh.polygons.foreach_set("material_index", indices)
    return mesh


@scene("a forest: 4,000 instances of trees that have 400,000 triangles together")
def forest(opened) -> None:
    bark = principled("Bark", (0.12, 0.075, 0.045, 1.0), 0.9)
    graph = Graph("Leaves")
    random_tone = graph.node("ShaderNodeObjectInfo", "Random")
    tone = graph.node("ShaderNodeMix", data_type="RGBA", _0=random_tone, _1=(0.06, 0.16, 0.02), _2=(0.2, 0.22, 0.03))
    front = graph.node("ShaderNodeBsdfPrincipled", Base_Color=tone, Roughness=0.5)
    back = graph.node("ShaderNodeBsdfTranslucent", Color=tone)
    graph.finish(graph.node("ShaderNodeMixShader", _0=0.35, _1=front, _2=back))
    ground = Graph("Ground")
    moss = ground.node("ShaderNodeTexNoise", Vector=ground.node("ShaderNodeTexCoord", "Object"), Scale=1.5, Detail=8.0)
    mixed = ground.node("ShaderNodeMix", data_type="RGBA", _0=moss, _1=(0.05, 0.035, 0.02), _2=(0.06, 0.1, 0.02))
    ground.finish(ground.node("ShaderNodeBsdfPrincipled", Base_Color=mixed, Roughness=0.95))
    add("Ground", plane("Ground", (140.0, 140.0)), ground.material, location=(0.0, 60.0, 0.0))
    random = np.random.default_rng(11)
    kinds = 4
    for kind in range(kinds):
        places = np.stack(
            [
                random.uniform(-30.0, 30.0, TREES // kinds),
                4.0 + 75.0 * random.random(TREES // kinds) ** 0.8,
                np.zeros(TREES // kinds),
            ],
            axis=1,
        )
        # Faces of different sizes that parent instances: their size is that of the tree.
        size = random.uniform(0.7, 1.5, TREES // kinds)[:, None, None]
        turn = random.uniform(0.0, 2.0 * math.pi, TREES // kinds)[:, None]
        angles = turn + np.arange(4) * (0.5 * math.pi)
        corners = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=2) * (math.sqrt(0.5) * size)
        mesh = bpy.data.meshes.new(f"Places {kind}")
        vertices = (places[:, None] + corners).reshape(-1, 3)
        mesh.from_pydata(vertices.tolist(), [], np.arange(len(vertices)).reshape(-1, 4).tolist())
        parent = add(f"Places {kind}", mesh)
        parent.instance_type, parent.use_instance_faces_scale, parent.show_instancer_for_render = "FACES", True, False
        tree = add(f"Tree {kind}", _tree(f"Tree {kind}", kind, 100_000, (bark, graph.material)))
        tree.parent = parent
    sky(25.0, 140.0, 0.15)
    camera((0.0, -1.0, 1.8), (0.0, 20.0, 2.2), 60.0)


@scene("a landscape: slopes of rock and snow by their nodes, a lake, a low sun")
def landscape(opened) -> None:
    steps = 160
    y, x = np.mgrid[0:steps, 0:steps] / (steps - 1.0)
    random = np.random.default_rng(2)
    height = np.zeros_like(x)
    for octave in range(7):
        frequency = 1.6 * 1.9**octave
        for _ in range(3):
            turn, phase = random.uniform(0.0, 2.0 * math.pi, 2)
            wave = np.sin(2.0 * math.pi * frequency * (x * math.cos(turn) + y * math.sin(turn)) + phase)
            height += (1.0 - np.abs(wave)) * 0.55**octave / 3.0
    height = 14.0 * (height - np.quantile(height, 0.35)) * (0.25 + y)
    vertices = np.stack([80.0 * (x - 0.5), 90.0 * y, height], axis=2).reshape(-1, 3)
    cell = (np.arange(steps - 1)[:, None] * steps + np.arange(steps - 1)[None]).ravel()
    mesh = bpy.data.meshes.new("Terrain")
    mesh.from_pydata(vertices.tolist(), [], np.stack([cell, cell + 1, cell + steps + 1, cell + steps], axis=1).tolist())
    mesh.shade_smooth()
    rock = Graph("Terrain")
    place = rock.node("ShaderNodeTexCoord", "Object")
    slope = rock.node("ShaderNodeSeparateXYZ", "Z", Vector=rock.node("ShaderNodeNewGeometry", "Normal"))
    level = rock.node("ShaderNodeSeparateXYZ", "Z", Vector=place)
    rough = rock.node("ShaderNodeTexNoise", Vector=place, Scale=0.8, Detail=9.0, Roughness=0.6)
    flat = rock.node("ShaderNodeMapRange", Value=slope, _1=0.6, _2=0.85, interpolation_type="SMOOTHSTEP")
    high = rock.node("ShaderNodeMapRange", Value=level, _1=4.0, _2=9.0)
    snow = rock.node("ShaderNodeMath", operation="MULTIPLY", _0=flat, _1=high)
    stone = rock.node("ShaderNodeMix", data_type="RGBA", _0=rough, _1=(0.1, 0.08, 0.07), _2=(0.25, 0.22, 0.19))
    grass = rock.node("ShaderNodeMix", data_type="RGBA", _0=flat, _1=stone, _2=(0.06, 0.09, 0.03))
    tone = rock.node("ShaderNodeMix", data_type="RGBA", _0=snow, _1=grass, _2=(0.85, 0.87, 0.9))
    rock.finish(
        rock.node("ShaderNodeBsdfPrincipled", Base_Color=tone, Roughness=0.9, Normal=rock.bump(rough, 0.6, 0.7))
    )
    add("Terrain", mesh, rock.material)
    water = Graph("Water")
    waves = water.node("ShaderNodeTexNoise", Vector=water.node("ShaderNodeTexCoord", "Object"), Scale=1.2, Detail=3.0)
    water.finish(
        water.node(
            "ShaderNodeBsdfPrincipled",
            Base_Color=(0.01, 0.04, 0.05),
            Roughness=0.03,
            Normal=water.bump(waves, 0.05, 0.4),
        )
    )
    add("Lake", plane("Lake", (80.0, 90.0)), water.material, location=(0.0, 45.0, 0.3))
    sky(12.0, 110.0, 0.2)
    camera((0.0, -8.0, 5.0), (2.0, 40.0, 3.0), 52.0)
