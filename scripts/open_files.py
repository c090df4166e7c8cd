# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Opens .blend files and renders their content: each scene, and, on balls, all materials, groups of shader nodes and
worlds that no scene shows. Prints for each file the failures and everything that is not rendered as it says.

Files are opened in a separate process; if one ends it, the next file has a new process. Scripts in files are not run.
"""

from __future__ import annotations

import argparse
import json
import math
import pathlib
import sys
import time
import traceback

import bpy
import host
from mathutils import Matrix, Vector

from sdf_lights.blender.shader_trees import use_nodes

STAGE = "SDF Lights: what no scene shows"
MOST_SCENES = 8  # of one file
FAR = 1e6  # metres: larger objects are backdrops


def parse(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="open_files",
        description="Open .blend files, render what is in them, and tell what failed and what is not modelled.",
    )
    parser.add_argument("paths", nargs="+", type=pathlib.Path, help="files, or folders with files")
    parser.add_argument("--size", type=int, default=64, help="pixels of the longer side (default: 64)")
    parser.add_argument("--samples", type=int, default=1, help="samples per pixel (default: 1)")
    parser.add_argument("--out", type=pathlib.Path, metavar="FILE.json", help="write the rows there")
    return parser.parse_args(arguments)


def files_in(paths: list[pathlib.Path]) -> list[pathlib.Path]:
    """Files as they are given, and those of folders, sorted."""
    found = []
    for path in paths:
        found += sorted(path.rglob("*.blend")) if path.is_dir() else [path]
    return [path.resolve() for path in found]


def opened(path: str, size: int, samples: int) -> dict:
    """A row about one file: failures, messages of our engine, the amount rendered."""
    started = time.perf_counter()
    row = dict(file=path, scenes=0, shown_apart=0, errors=[], not_modelled=[])
    try:
        bpy.ops.wm.open_mainfile(filepath=path, load_ui=False, use_scripts=False)
    except RuntimeError as error:  # of another type, or newer than this Blender can read
        return row | dict(errors=[_sentence(error)], seconds=time.perf_counter() - started)
    host.register_extension()
    try:
        scenes = [scene for scene in bpy.data.scenes if any(_solid(thing) for thing in scene.objects)][:MOST_SCENES]
        shown = {slot.material for scene in scenes for thing in scene.objects for slot in thing.material_slots}
        row["scenes"] = len(scenes)
        for scene in scenes:
            _complete(scene)
            _render(scene, size, samples, row)
        stage, row["shown_apart"] = _stage(shown)
        if row["shown_apart"]:
            _render(stage, size, samples, row)
            for world in [world for world in bpy.data.worlds if world not in {scene.world for scene in scenes}]:
                stage.world = world
                _render(stage, 16, 1, row)
    except Exception:  # a file that cannot be shown is reported; the others continue
        row["errors"].append(traceback.format_exc())
    row["not_modelled"] = list(dict.fromkeys(row["not_modelled"]))
    return row | dict(seconds=time.perf_counter() - started)


def _sentence(error: Exception) -> str:
    return str(error).removeprefix("Error: ").strip()


def _solid(thing: bpy.types.Object) -> bool:
    return (
        thing.type in {"MESH", "CURVE", "SURFACE", "META", "FONT", "CURVES", "POINTCLOUD", "VOLUME"}
        and not thing.hide_render
    )


def _complete(scene: bpy.types.Scene) -> None:
    """Give a scene the camera that it lacks, with a view of all its objects."""
    if scene.camera is not None:
        return
    corners = [
        thing.matrix_world @ Vector(corner) for thing in scene.objects if _solid(thing) for corner in thing.bound_box
    ]
    corners = [corner for corner in corners if all(abs(axis) < FAR for axis in corner)] or [Vector()]
    middle = sum(corners, Vector()) / len(corners)
    radius = max((corner - middle).length for corner in corners) or 1.0
    _look(scene, middle, radius)


def _look(scene: bpy.types.Scene, middle: Vector, radius: float) -> None:
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    way = Vector((0.6, -0.7, 0.5)).normalized()
    camera.data.clip_end = max(10.0 * radius, 100.0)
    camera.matrix_world = (
        Matrix.Translation(middle + 3.0 * radius * way) @ way.to_track_quat("Z", "Y").to_matrix().to_4x4()
    )
    scene.collection.objects.link(camera)
    scene.camera = camera


def _render(scene: bpy.types.Scene, size: int, samples: int, row: dict) -> None:
    render = scene.render
    scale = size / max(render.resolution_x, render.resolution_y)
    render.resolution_x, render.resolution_y = (
        max(round(scale * side), 4) for side in (render.resolution_x, render.resolution_y)
    )
    render.resolution_percentage = 100
    render.use_border = render.use_compositing = render.use_sequencer = False
    render.engine = host.ENGINE
    scene.sdf_lights.samples, scene.sdf_lights.denoise, scene.sdf_lights.device = samples, False, "CPU"
    try:
        bpy.ops.render.render(scene=scene.name)
    except RuntimeError as error:
        row["errors"].append(f"Scene '{scene.name}': {_sentence(error)}")
    row["not_modelled"] += host.program("blender.feedback").of_last_render(scene.name)


# -- what no scene shows -----------------------------------------------------------------------------------------------


def _stage(shown: set) -> tuple[bpy.types.Scene, int]:
    """A scene with a ball for each material that is not ``shown`` and for each group of shader nodes, and their
    number."""
    materials = [material for material in bpy.data.materials if material not in shown and not material.is_grease_pencil]
    materials += [
        _material_of(tree) for tree in bpy.data.node_groups if tree.bl_idname == "ShaderNodeTree" and _output(tree)
    ]
    scene = bpy.data.scenes.new(STAGE)
    mesh = _ball()
    columns = max(math.ceil(math.sqrt(len(materials))), 1)
    for index, material in enumerate(materials):
        thing = bpy.data.objects.new(material.name, mesh)
        thing.location = index % columns, index // columns, 0.0
        scene.collection.objects.link(thing)
        thing.material_slots[0].link, thing.material_slots[0].material = "OBJECT", material
    light = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    scene.collection.objects.link(light)
    _look(scene, Vector((0.5 * columns, 0.5 * columns, 0.0)), float(columns))
    return scene, len(materials)


def _output(tree: bpy.types.NodeTree):
    """The first output of a group that a material can show."""
    outputs = [item for item in tree.interface.items_tree if item.item_type == "SOCKET" and item.in_out == "OUTPUT"]
    known = [
        item
        for item in outputs
        if item.socket_type.startswith(("NodeSocketShader", "NodeSocketColor", "NodeSocketFloat", "NodeSocketVector"))
    ]
    return min(known, key=lambda item: item.socket_type != "NodeSocketShader", default=None)


def _material_of(tree: bpy.types.NodeTree) -> bpy.types.Material:
    material = bpy.data.materials.new(f"Group {tree.name}")
    made = use_nodes(material)
    nodes, link = made.nodes, made.links.new
    nodes.clear()
    group, output = nodes.new("ShaderNodeGroup"), nodes.new("ShaderNodeOutputMaterial")
    group.node_tree = tree
    socket = next(socket for socket in group.outputs if socket.identifier == _output(tree).identifier)
    link(socket, output.inputs["Volume" if "olume" in socket.name else "Surface"])
    return material


def _ball() -> bpy.types.Mesh:
    import bmesh  # not at the top: it is part of Blender's own module

    work = bmesh.new()
    work.loops.layers.uv.new("UVMap")
    bmesh.ops.create_uvsphere(work, u_segments=24, v_segments=12, radius=0.45, calc_uvs=True)
    mesh = bpy.data.meshes.new("Ball")
    work.to_mesh(mesh)
    work.free()
    mesh.materials.append(None)
    return mesh


# -- the command -------------------------------------------------------------------------------------------------------


def rows_of(paths: list[pathlib.Path], size: int, samples: int, told=lambda row: None) -> list[dict]:
    """A row for each file; if a file ends the process, that is one of its errors."""
    import open_files  # by its name, under which the other process finds its functions
    from benchmarks.isolation import Isolated

    rows, other = [], Isolated()
    for path in paths:
        try:
            row = other.call(open_files.opened, str(path), size, samples)
        except RuntimeError as error:
            row = dict(file=str(path), scenes=0, shown_apart=0, errors=[_sentence(error)], not_modelled=[], seconds=0.0)
        rows.append(row)
        told(row)
    other.close()
    return rows


def told(row: dict) -> None:
    name = pathlib.Path(row["file"]).name
    print(f"{name}: {row['scenes']} scenes, {row['shown_apart']} things apart, {row['seconds']:.1f} s", flush=True)
    for kind, sentences in (("failed", row["errors"]), ("not as it says", row["not_modelled"])):
        for sentence in sentences:
            print(f"  {kind}: {sentence}", flush=True)


def main() -> int:
    options = parse(sys.argv[1:])
    paths = files_in(options.paths)
    if not paths:
        print("open_files: there are no .blend files.", file=sys.stderr)
        return 2
    rows = rows_of(paths, options.size, options.samples, told)
    failed = sum(bool(row["errors"]) for row in rows)
    print(f"{len(rows)} files, {failed} failed")
    if options.out:
        options.out.write_text(json.dumps(dict(blender=bpy.app.version_string, rows=rows), indent=1), encoding="utf-8")
    return 1 if failed else 0


if __name__ == "__main__":
    host.finish(main())
