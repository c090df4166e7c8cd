# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""No setting is silent: each number, switch and choice that Blender's data has is read, told of as not supported, or
named here as one that changes no picture of Cycles either.

In a scene in which much is used, one property after the other gets another value. Then the scene of the engine differs,
or its warnings do, or ``NO_PICTURE`` has the property. So a setting that a newer Blender brings is found.
"""

from __future__ import annotations

import dataclasses
import enum
import hashlib
import re

import bmesh
import bpy
import numpy as np
import pytest

from sdf_lights.blender import cycles, cycles_table
from sdf_lights.blender.sync import frame_settings
from sdf_lights.render.passes import PASSES

bpy.ops.preferences.addon_enable(module="cycles")

# Names of properties by owner, as patterns.
EVERYWHERE = r"use_fake_user|use_extra_user|is_runtime_data|tag|asset_data|show_.*|hide_select|use_nodes|active_.*_index|active_selection_set"
EEVEE_LIGHT = (
    r"(specular|diffuse|transmission|volume)_factor|use_custom_distance|cutoff_distance|shadow_(buffer|filter|maximum|jitter|cascade)_.*|"
    r"use_shadow_jitter|use_absolute_resolution|use_square"
)
NO_PICTURE = {
    # files, the compositor, stamps, Freestyle, other engines; with Freestyle, Blender itself renders once more
    "render": r"preview_pixel_size|ppm_.*|fps.*|dither_intensity|filter_size|threads.*|hair_.*|use_high_quality_normals|use_crop_to_border|"
    r"use_(placeholder|overwrite|compositing|sequencer|file_extension|lock_interface|render_cache|single_layer)|.*stamp_.*|use_stamp|"
    r"metadata_input|sequencer_.*|use_sequencer_.*|views_format|.*gpencil.*|line_thickness.*|compositor_.*|use_persistent_data|"
    r"(use_)?bake_.*|save_output|.*texture_cache|anisotropic_filter|"
    # without several views, modifiers, particles and volumes
    r"use_multiview|use_simplify.*|simplify_.*|border_min_y|use_freestyle|engine|frame_map_.*|motion_blur_shutter_curve",
    "scene.cycles": r"bake_type|debug_.*|sample_offset|sample_subset_length|use_layer_samples|use_camera_cull|camera_cull_margin|"
    # nothing is far away, and there are no images
    r"use_distance_cull|distance_cull_margin|texture_(limit|resolution).*",
    "layer": r"use|use_ao|use_freestyle|use_volumes|use_grease_pencil|use_pass_combined|use_pass_cryptomatte_accurate|use_pass_grease_pencil",
    "layer.cycles": r"denoising_pass_.*",  # what the denoiser sees, not the picture
    "object": r"parent_.*|use_parent_.*|use_camera_lock_parent|track_axis|up_axis|location|rotation_(quaternion|axis_angle|mode)|"
    r"delta_rotation_quaternion|lock_.*|empty_.*|use_empty_.*|add_rest_position_attribute|use_simulation_cache|hide_viewport|hide_probe_.*|"
    r"hide_surface_pick|instance_.*|use_instance_.*|display_.*|use_grease_pencil_lights|use_shape_key_edit_mode|use_mesh_mirror_.|"
    r"shadow_terminator_normal_offset|visible_raycast|matrix_.*|use_dynamic_topology_sculpting",
    # not far away; its mesh does not deform; settings of older versions; Fast GI; caustics need a light and a caster
    "object.cycles": r"use_(camera|distance)_cull|use_deform_motion|shadow_terminator_.*|ao_distance|is_caustics_.*|dicing_rate",
    "material": r"surface_render_method|blend_method|alpha_threshold|use_transparency_overlap|use_backface_culling.*|.*refraction.*|"
    r"use_sss_translucency|thickness_mode|use_thickness_from_shadow|volume_intersection_method|max_vertex_displacement|preview_.*|"
    r"use_preview_world|paint_.*|diffuse_color|specular_.*|roughness|metallic|line_.*",
    "material.cycles": r"volume_.*|homogeneous_volume",  # noise and steps
    "world": r"use_eevee_.*|color|probe_resolution|sun_.*|use_sun_.*",
    "world.cycles": r"is_caustics_light|sampling_method|sample_map_resolution|volume_.*|homogeneous_volume",
    "world.visibility": r"shadow",  # Cycles has no such setting of worlds
    "world.mist": r"use_mist|intensity|height",
    "world.light": r"ao_factor",  # Fast GI
    "POINT": EEVEE_LIGHT + r"|temperature",
    "SUN": EEVEE_LIGHT + r"|temperature|shadow_soft_size",
    "SPOT": EEVEE_LIGHT + r"|temperature",
    "AREA": EEVEE_LIGHT + r"|temperature|shadow_soft_size|size_y",
    "light.cycles": r"is_caustics_light|is_portal",
    "camera": r"passepartout_alpha|sensor_fit|sensor_height|ortho_scale|display_size|lens_unit|composition_.*|panorama_type|fisheye_.*|"
    r"(latitude|longitude)_.*|central_cylindrical_.*|custom_.*",  # of other kinds of cameras
}


def digest(value, into, seen: dict) -> None:
    """Add everything that a value holds to a hash."""
    if isinstance(value, np.ndarray) and value.dtype != object:
        into.update(repr((value.dtype, value.shape)).encode() + np.ascontiguousarray(value).tobytes())
    elif value is None or isinstance(value, (bool, int, float, str, bytes, enum.Enum, np.generic)):
        into.update(repr(value).encode())
    elif isinstance(value, dict):
        digest(list(value.items()), into, seen)
    elif isinstance(value, (list, tuple, np.ndarray)):
        into.update(b"%d" % len(value))
        for item in value:
            digest(item, into, seen)
    elif isinstance(value, (set, frozenset)):
        digest(sorted(map(repr, value)), into, seen)
    elif id(value) in seen:
        into.update(b"#%d" % seen[id(value)][0])
    else:
        seen[id(value)] = len(seen), value  # kept alive, so that no other value gets its address
        slots = [name for kind in type(value).__mro__ for name in getattr(kind, "__slots__", ())]
        into.update(type(value).__name__.encode())
        for name in sorted({*getattr(value, "__dict__", ()), *slots}):
            digest(getattr(value, name, None), into, seen)


def _other_number(prop, now):
    step = 1 if prop.type == "INT" else max(0.1 * abs(now), 0.05)
    return now + step if now + step <= min(prop.hard_max, prop.soft_max) else now - step


def other_values(prop, now) -> list:
    """Other values of a property that now has this one."""
    if prop.type == "BOOLEAN":
        return [[not each for each in now] if prop.is_array else not now]
    if prop.type == "ENUM" and not prop.is_enum_flag:
        return [item.identifier for item in prop.enum_items if item.identifier != now]
    if prop.type in {"INT", "FLOAT"}:
        return [[_other_number(prop, each) for each in now] if prop.is_array else _other_number(prop, now)]
    return []


def _material(name: str):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    return made, made.node_tree, {node.bl_idname: node for node in made.node_tree.nodes}


@pytest.fixture
def owners(file, add, quad) -> dict:
    """A scene in which much is used; its data by the names of ``NO_PICTURE``."""
    scene, layer = file.scene, file.layer
    bumpy, tree, nodes = _material("Bumpy")
    bsdf, output = nodes["ShaderNodeBsdfPrincipled"], nodes["ShaderNodeOutputMaterial"]
    noise, bump, info, lift = (
        tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexNoise", "Bump", "ObjectInfo", "Displacement")
    )
    bsdf.inputs["Emission Strength"].default_value, bsdf.inputs["Alpha"].default_value = 1.0, 0.5
    for source, socket in (
        (noise.outputs[0], bump.inputs["Height"]),
        (noise.outputs[0], lift.inputs["Height"]),
        (bump.outputs[0], bsdf.inputs["Normal"]),
        (info.outputs["Color"], bsdf.inputs["Emission Color"]),
        (lift.outputs[0], output.inputs["Displacement"]),
    ):
        tree.links.new(source, socket)
    mesh = quad()
    mesh.materials.append(bumpy)
    mesh.polygons.foreach_set("use_smooth", [True])
    floor = add("Floor", mesh)
    for frame in (1, 3):
        floor.location.x = float(frame)
        floor.keyframe_insert("location", frame=frame)
    fog, tree, nodes = _material("Fog")
    tree.nodes.remove(nodes["ShaderNodeBsdfPrincipled"])
    scatter = tree.nodes.new("ShaderNodeVolumeScatter")
    tree.links.new(scatter.outputs[0], nodes["ShaderNodeOutputMaterial"].inputs["Volume"])
    box, form = bpy.data.meshes.new("Box"), bmesh.new()
    bmesh.ops.create_cube(form, size=1.0)
    form.to_mesh(box)
    form.free()
    box.materials.append(fog)
    add("Box", box)
    hair = bpy.data.hair_curves.new("Hair")
    hair.add_curves([3, 3])
    hair.position_data.foreach_set("vector", np.random.default_rng(1).random(18).astype(np.float32))
    add("Hair", hair)
    lights = {
        kind: add(kind, bpy.data.lights.new(kind, kind), (0.0, 0.0, 3.0)).data
        for kind in ("POINT", "SUN", "SPOT", "AREA")
    }
    scene.world = world = bpy.data.worlds.new("World")
    world.use_nodes = True
    camera = file.camera.data
    camera.dof.use_dof = scene.render.use_motion_blur = scene.render.use_border = True
    scene.render.border_max_x, scene.cycles.rolling_shutter_type = 0.9, "TOP"
    layer.use_pass_normal = layer.use_pass_cryptomatte_object = True
    scene.frame_set(2)
    return {
        "render": scene.render,
        "scene.cycles": scene.cycles,
        "curves": scene.cycles_curves,
        "layer": layer,
        "layer.cycles": layer.cycles,
        "object": floor,
        "object.cycles": floor.cycles,
        "material": bumpy,
        "material.cycles": bumpy.cycles,
        "world": world,
        "world.cycles": world.cycles,
        "world.visibility": world.cycles_visibility,
        "world.mist": world.mist_settings,
        "world.light": world.light_settings,
        **lights,
        "light.cycles": lights["AREA"].cycles,
        "camera": camera,
        "camera.dof": camera.dof,
    }


def _differing(owner, prop, found, first: str) -> bool | None:
    """Whether what is ``found`` differs with another value of the property; None if it has no other value."""
    now = getattr(owner, prop.identifier)
    now = list(now) if prop.type != "ENUM" and getattr(prop, "is_array", False) else now
    tried = None
    for value in other_values(prop, now):
        try:
            setattr(owner, prop.identifier, value)
        except (AttributeError, TypeError, ValueError):
            continue  # Blender does not take it here
        tried = found() != first
        setattr(owner, prop.identifier, now)
        if tried:
            break
    return tried


def test_no_setting_is_silent(file, owners, synced):
    scene = file.scene
    rows = [row for row in cycles_table.ROWS if row.read is None and not row.note.startswith("Read directly")]
    untouched = {name for row in rows for name in row.cycles} - {"use_fast_gi"}
    passes = {item.switch for item in PASSES}

    def found() -> str:
        """Of all that the engine knows of the scene, and says of it."""
        cycles.copy(scene)
        made, into = synced(), hashlib.sha256()
        digest((dataclasses.replace(made, kept=None), frame_settings(scene, True)), into, {})
        return into.hexdigest()

    first = found()
    assert found() == first
    silent, checked = [], 0
    for name, owner in owners.items():
        unread = re.compile(f"(?:{EVERYWHERE})|(?:{NO_PICTURE.get(name, EVERYWHERE)})")
        for prop in owner.bl_rna.properties:
            word = prop.identifier
            if (
                prop.is_readonly
                or unread.fullmatch(word)
                or word in passes
                or name == "scene.cycles"
                and word in untouched
            ):
                continue
            if getattr(prop, "is_array", False) and len(prop.array_dimensions) > 0 and prop.array_dimensions[1] > 0:
                continue  # matrices follow from what is checked
            result = _differing(owner, prop, found, first)
            checked += result is not None
            if result is False:
                silent.append(f"{name}.{word}")
            if result:
                first = found()  # not all values can be set back: a camera's angle changes its lens
    assert silent == [], "\n".join(silent)
    assert checked > 100
