# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders one .blend by both engines, in a separate process: ``python -m benchmarks.file_session JOB``, as ``files``
does."""

from __future__ import annotations

import json
import math
import pathlib
import sys

import bpy
import contact_sheet
import host
import numpy as np
from mathutils import Matrix, Vector
from scenery.materials import Graph
from scenery.modelling import add

from . import node_scenes, pictures, simple_scenes
from .node_pictures import CYCLES, ENGINES, warnings_of
from .node_sources import Sources


def trees(material_trees) -> list[bpy.types.NodeTree]:
    """These node trees and the groups in them."""
    found, pending = [], list(material_trees)
    while pending:
        tree = pending.pop()
        if tree is not None and tree not in found:
            found.append(tree)
            pending += [node.node_tree for node in tree.nodes if getattr(node, "node_tree", None)]
    return found


def kinds(roots) -> list[str]:
    """bl_idname of all nodes."""
    return sorted({node.bl_idname for tree in trees(roots) for node in tree.nodes})


def settle(scene, engine: str, job: dict) -> None:
    """The file's settings, except those that trade error for bias, or cost time."""
    simple_scenes.enable_cycles()
    render = scene.render
    scale = job["size"] / max(render.resolution_x, render.resolution_y)
    if not 0.99 < scale < 1.01:
        render.resolution_x, render.resolution_y = (
            max(round(size * scale), 4) for size in (render.resolution_x, render.resolution_y)
        )
    render.resolution_percentage, render.use_border = 100, False
    render.use_compositing = render.use_sequencer = render.use_motion_blur = False
    bounces = scene.cycles.max_bounces
    kept = {name: getattr(scene.cycles, name) for name in ("diffuse_bounces", "glossy_bounces", "transmission_bounces")}
    simple_scenes.plain_cycles(scene, job["samples"], bounces)
    simple_scenes.plain_sdf_lights(scene, job["samples"], bounces, job["device"])
    for name, value in kept.items():
        setattr(scene.cycles, name, value)
        setattr(scene.sdf_lights, name, value)
    for name, theirs in (("transparent_bounces", "transparent_max_bounces"), ("volume_bounces", "volume_bounces")):
        if hasattr(scene.sdf_lights, name):
            setattr(scene.sdf_lights, name, getattr(scene.cycles, theirs))
    render.engine = engine


def compared(scene, part: str, roots, job: dict) -> dict:
    """A row: the scene by both engines."""
    row = dict(
        file=pathlib.Path(job["path"]).name,
        part=part,
        nodes=" ".join(kinds(roots)),
        mean_cycles=None,
        mean_ours=None,
        mean_ratio=None,
        error="",
        warnings="",
    )
    made = {}
    for engine in ENGINES:
        try:
            settle(scene, engine, job)
            made[engine] = pictures.render().pixels
        except RuntimeError as error:
            row["error"] = (
                f"{'Cycles' if engine == CYCLES else 'SDF Lights'}: {str(error).removeprefix('Error: ').strip()}"
            )
            return row
    theirs, ours = (float(made[engine].mean()) for engine in ENGINES)
    row |= dict(
        mean_cycles=theirs,
        mean_ours=ours,
        mean_ratio=ours / theirs if theirs else None,
        warnings=" ".join(warnings_of(scene.name)),
    )
    if job["keep"]:
        folder = pathlib.Path(job["keep"])
        folder.mkdir(parents=True, exist_ok=True)
        both = np.concatenate([made[engine][::-1] for engine in ENGINES], axis=1)
        contact_sheet.write(
            folder / f"{pathlib.Path(job['path']).stem} {part}.png".replace("/", "_"),
            contact_sheet.srgb(np.clip(both, 0.0, 1.0)),
        )
    return row


def of_scene(job: dict) -> list[dict]:
    """The file's own scenes."""
    bpy.ops.wm.open_mainfile(filepath=job["path"], load_ui=False)
    host.register_extension()
    scene = bpy.context.scene
    if scene.camera is None and not _add_camera(scene):
        return []
    roots = [
        owner.node_tree
        for group in (bpy.data.materials, bpy.data.worlds, bpy.data.lights)
        for owner in group
        if owner.users
    ]
    return [compared(scene, scene.name, roots, job)]


def _add_camera(scene) -> bool:
    """A camera that sees all meshes, for a file with only models, and a sun if there is no light. Returns False if
    nothing is visible."""
    bpy.context.view_layer.update()
    shown = [thing for thing in scene.objects if thing.type == "MESH" and not thing.hide_render and thing.data.vertices]
    if not shown:
        return False
    corners = [thing.matrix_world @ Vector(corner) for thing in shown for corner in thing.bound_box]
    low, high = (Vector(bound(corner[axis] for corner in corners) for axis in range(3)) for bound in (min, max))
    radius = max(0.5 * (high - low).length, 1e-3)
    camera = bpy.data.cameras.new("Camera")
    camera.clip_start, camera.clip_end = 1e-3 * radius, 100.0 * radius
    looks = Vector((-1.0, 2.0, -1.0)).normalized()
    placed = Matrix.Translation(0.5 * (low + high) - looks * radius / math.sin(0.5 * camera.angle))
    scene.camera = add("Camera", camera)
    scene.camera.matrix_world = placed @ looks.to_track_quat("-Z", "Y").to_matrix().to_4x4()
    if not any(thing.type == "LIGHT" for thing in scene.objects):
        add("Sun", bpy.data.lights.new("Sun", "SUN")).rotation_euler = (0.6, 0.3, 0.0)
    return True


def of_assets(job: dict) -> list[dict]:
    """Each material and each group of shader nodes, on a ball under a lamp."""
    rows = []
    with bpy.data.libraries.load(job["path"]) as (there, _):
        names = dict(materials=list(there.materials), node_groups=list(there.node_groups))
    for kind, found in names.items():
        for name in found:
            scene, thing = node_scenes.ball(job["size"])
            with bpy.data.libraries.load(job["path"]) as (_, wanted):
                setattr(wanted, kind, [name])
            asset = getattr(bpy.data, kind).get(name)
            if kind == "materials":
                thing.material_slots[0].material = asset
                rows.append(compared(scene, name, [asset.node_tree], job))
            elif asset is not None and asset.bl_idname == "ShaderNodeTree":
                for socket in asset.interface.items_tree:
                    if socket.item_type == "SOCKET" and socket.in_out == "OUTPUT":
                        thing.material_slots[0].material = wearing(asset, socket)
                        rows.append(compared(scene, f"{name} {socket.name}", [asset], job))
    return rows


def wearing(group: bpy.types.NodeTree, socket) -> bpy.types.Material:
    """A material that shows one output of a group, whose inputs vary."""
    graph = Graph(f"{group.name} {socket.name}")
    node = graph.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    sources = Sources(graph)
    for item in node.inputs:
        sources.feed_by_type(item)
    output = next(item for item in node.outputs if item.identifier == socket.identifier)
    if output.type != "SHADER":
        output = graph.node("ShaderNodeEmission", Color=output, Strength=1.0)
    place = "Volume" if "olume" in socket.name else "Displacement" if output.name == "Displacement" else "Surface"
    return graph.finish(output, place)


if __name__ == "__main__":
    job = json.loads(sys.argv[1])
    bpy.ops.wm.read_factory_settings(use_empty=True)
    host.register_extension()
    rows = of_assets(job) if job["assets"] else of_scene(job)
    pathlib.Path(job["out"]).write_text(json.dumps(rows), encoding="utf-8")
    host.finish(0)
