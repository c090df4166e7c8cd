# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects and instances: their positions in the world, and their materials."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import bpy
import numpy as np

from ...render.errors import RenderError
from ...render.material import OBJECT_DENSITY, Attribute
from ...render.scene import AttributeValues, Domain, Instance, Lamp, Portal, Ray, Scene
from ..naming import BESIDE_GROUP
from .attributes import InstanceAttributes, property_of, random_number, texture_space
from .common import FLAT, Warnings, is_finite, matrix_of, visibility_of
from .grids import Fixed, Found, Grids, boxed
from .images import Images
from .kept import Kept, owners_of
from .lights import control, light_of
from .linking import Linking
from .materials import Materials
from .mesh import Meshes, Readable
from .motion import Key, Placed, key_of
from .particle_hair import ParticleHairs
from .simplify import Culling
from .strands import Strands

# A flattened instance gets this fraction of its largest scale as thickness, so its matrix has an inverse.
_THICKNESS = 1e-6


# Not here: curves, text, surfaces and metaballs, whose evaluated meshes Blender lists as separate instances; Grease
# Pencil, which Blender itself draws over the picture of any engine.
ALL = frozenset({"MESH", "CURVES", "POINTCLOUD", "VOLUME", "LIGHT"})
LIGHTS = frozenset({"LIGHT"})


def sync_objects(
    depsgraph: bpy.types.Depsgraph,
    scene: Scene,
    materials: Materials | None,
    images: Images,
    warn: Warnings,
    kinds: frozenset[str] = ALL,
    shows: Callable[[bpy.types.DepsgraphObjectInstance], bool] = lambda item: True,
    notes: bool = False,
    culling: Culling | None = None,
    kept: Kept | None = None,
) -> Noted:
    """Append every mesh, instance, lamp and light of the dependency graph to ``scene``: those of the ``kinds`` that it
    ``shows`` and ``culling`` does not leave out. Lights need no ``materials``.

    An unusable object is left out with a warning that names it; the rest is rendered. With ``notes``, returns the data
    to find all of them again at another time.
    """
    reader = _Reader(depsgraph, scene, materials, images, warn, notes, culling, kept)
    for item in depsgraph.object_instances:
        # Nothing may refer to `item` after this iteration: Blender reuses it for the next instance.
        if item.object.type in kinds and item.show_self and shows(item):
            reader.read(item)
        if item.object.type == "MESH" and "CURVES" in kinds and item.show_particles and has_hair(item) and shows(item):
            reader.read(item, hair=True)
    return Noted(reader.placed, reader.forms)


def has_hair(item: bpy.types.DepsgraphObjectInstance) -> bool:
    """Whether an instance shows particle hair. Objects in an edit mode show none, as in Cycles."""
    obj = item.object
    return len(obj.particle_systems) > 0 and obj.mode not in ("PARTICLE_EDIT", "EDIT")


class Noted(NamedTuple):
    """The index of each instance in the scene, and readers of the meshes."""

    placed: dict[Key, Placed]
    forms: dict[int, Readable]


class _Flags(NamedTuple):
    """The data that an object passes on to all its instances."""

    visibility: Ray
    holdout: bool
    catcher: bool


class _Shown(NamedTuple):
    """The data that all instances of an object share: index of the mesh, those of its materials, the attributes that
    they read, and the values of some."""

    mesh: int | None
    slots: tuple[int, ...]
    wanted: set[Attribute]
    values: dict[Attribute, AttributeValues] = {}


class _Reader:
    """Reads instances. Data shared by many instances is read from Blender once."""

    def __init__(
        self,
        depsgraph: bpy.types.Depsgraph,
        scene: Scene,
        materials: Materials | None,
        images: Images,
        warn: Warnings,
        notes: bool,
        culling: Culling | None,
        kept: Kept | None,
    ):
        self._depsgraph = depsgraph
        self._view_layer = depsgraph.view_layer  # the original, which knows original objects
        self._scene, self._materials, self._images, self._warn = scene, materials, images, warn
        self.meshes = Meshes(scene, warn, kept)
        self.forms = self.meshes.forms
        self._strands = Strands(scene, depsgraph, self.forms)
        self._hairs = ParticleHairs(scene, depsgraph, self._strands, self.forms)
        self.placed: dict[Key, Placed] = {}
        self._notes, self._culling = notes, culling
        self._linking = Linking(depsgraph)
        self._instances = InstanceAttributes()
        self._flags: dict[tuple[int, int], _Flags] = {}  # by object and instancer
        self._grids = Grids(depsgraph, warn)
        self._shown: dict[tuple[int, int, bool], _Shown] = {}  # by object and mesh, and whether it is hair

    def read(self, item: bpy.types.DepsgraphObjectInstance, hair: bool = False) -> None:
        """Add the mesh of an instance to the scene; with ``hair`` its particle hair instead."""
        obj = item.object
        kind = obj.type
        matrix = matrix_of(item.matrix_world)
        if not is_finite(matrix):
            self._warn(
                f"Object '{obj.original.name}' has a transform that is not finite: it is left out; clear its "
                "location, rotation and scale."
            )
            return
        if kind != "LIGHT" and self._culling is not None and self._culling.leaves_out(obj, matrix):
            return
        flags = self._flags_of(obj, item.parent if item.is_instance else None)
        before = len(self._scene.instances), len(self._scene.lamps), len(self._scene.lights)
        if kind in ("MESH", "CURVES", "POINTCLOUD", "VOLUME"):
            self._surface(item, obj, matrix, flags, hair)
        else:
            self._light(obj, matrix, flags, random_number(item))
        after = len(self._scene.instances), len(self._scene.lamps), len(self._scene.lights)
        if self._notes and after != before:
            self.placed[key_of(item, hair)] = Placed(*(old if new > old else -1 for old, new in zip(before, after)))

    def _surface(
        self,
        item: bpy.types.DepsgraphObjectInstance,
        obj: bpy.types.Object,
        matrix: np.ndarray,
        flags: _Flags,
        hair: bool,
    ) -> None:
        matrix = invertible(matrix)
        if matrix is None:
            return
        original = obj.original
        data = self.meshes.evaluated(obj, self._depsgraph) if obj.type == "MESH" else obj.data
        key = original.as_pointer(), data.as_pointer(), hair
        if key not in self._shown:
            grids = None if hair else self._grids.of(obj)
            self._shown[key] = self._meet(item, obj, data, hair) if grids is None else self._meet_volume(obj, grids)
        index, slots, wanted, values = self._shown[key]
        if index is None:
            return
        self._scene.instances.append(
            Instance(
                index,
                matrix,
                slots,
                original.name,
                flags.visibility,
                flags.holdout,
                {**self._attributes(item, wanted, matrix), **values},
                tuple(obj.color),
                original.pass_index,
                random_number(item),
                **self._linking.of_instance(original, item.parent.original if item.is_instance else original),
                asset=_topmost(original).name,
                catcher=flags.catcher,
                terminator=original.shadow_terminator_geometry_offset,
                light_group=original.lightgroup,
            )
        )

    def _meet(self, item: bpy.types.DepsgraphObjectInstance, obj: bpy.types.Object, data, hair: bool) -> _Shown:
        """Read the mesh, the hair or the points of an object."""
        slots = tuple(self._materials.index(material) for material in slot_materials(obj))
        wanted = self._materials.needs(slots)
        if hair:
            found = self._hairs.index(obj.original.evaluated_get(self._depsgraph), len(slots), wanted)
        elif obj.type == "MESH":
            found = self.meshes.index(data, len(slots), wanted, owners_of(item))
        else:
            found = self._strands.index(data, wanted)
        return _Shown(found, slots, wanted)

    def _meet_volume(self, obj: bpy.types.Object, grids: Found) -> _Shown:
        """Read the grids of an object, whose box bounds its volume."""
        used = self._materials.of_volume(slot_materials(obj), grids)
        if used is None:
            return _Shown(None, (), set())
        material, interpolation = used
        wanted = self._materials.needs((material,))
        box = boxed(grids, wanted, obj.original.name, interpolation)
        if box is None:
            return _Shown(None, (), set())
        self._scene.meshes.append(box.mesh)
        index = len(self._scene.meshes) - 1
        self.forms[index] = Fixed()
        return _Shown(index, (material,), wanted, box.values)

    def _attributes(self, item: bpy.types.DepsgraphObjectInstance, wanted: set[Attribute], matrix: np.ndarray) -> dict:
        """Values that materials read and that are the same all over an instance."""
        found = {}
        for attribute in wanted:
            if attribute == OBJECT_DENSITY:
                # As in Cycles: along the diagonal.
                size = float(np.linalg.norm(matrix[:3, :3].sum(axis=1))) / math.sqrt(3.0)
                found[attribute] = AttributeValues(Domain.WHOLE, np.full((1, 1), 1.0 / size, np.float32))
                continue
            if attribute.kind in ("instancer_generated", "instancer_uv"):
                if item.is_instance:
                    place = np.array(item.orco if attribute.kind == "instancer_generated" else item.uv, np.float32)
                    place = 0.5 * place - 0.5 if attribute.kind == "instancer_generated" else place
                    found[attribute] = AttributeValues(Domain.WHOLE, place[None])
                continue
            if attribute.kind == "texture_space":
                values = texture_space(item.object.data, attribute.name)
                if values is not None:
                    found[attribute] = AttributeValues(Domain.WHOLE, values)
                continue
            owners = {
                "object": (item.object, item.object.data),
                "instancer": (item.parent, item.object) if item.is_instance else (item.object, item.object.data),
                "view_layer": (self._depsgraph.view_layer, self._depsgraph.scene, self._depsgraph.scene.world),
            }.get(attribute.kind, ())
            values = self._instances.of(item, attribute.name) if attribute.kind == "instancer" else None
            if values is None:
                properties = (property_of(owner, attribute.name) for owner in owners)
                values = next((value for value in properties if value is not None), None)
            if values is not None:
                found[attribute] = AttributeValues(Domain.WHOLE, values)
        return found

    def _light(self, obj: bpy.types.Object, matrix: np.ndarray, flags: _Flags, random: float) -> None:
        try:
            owner = matrix_of(obj.original.evaluated_get(self._depsgraph).matrix_world)
            light = light_of(obj, matrix, flags.visibility, self._depsgraph, self._warn, self._images, owner, random)
        except RenderError as error:
            self._warn(str(error))
            return
        if isinstance(light, Portal):
            self._scene.portals.append(light)
            return
        if isinstance(light, Lamp) and (flags.holdout or obj.original.indirect_only_get(view_layer=self._view_layer)):
            light.visibility &= ~Ray.CAMERA  # also if the lamp itself is visible to the camera
        control(light, obj, self._linking.of_emitter(obj.original))
        if isinstance(light, Lamp):
            if self._depsgraph.scene.sdf_lights.is_beside:
                light.light_group = BESIDE_GROUP
            self._scene.lamps.append(light)
        else:
            self._scene.lights.append(light)

    def _flags_of(self, obj: bpy.types.Object, instancer: bpy.types.Object | None = None) -> _Flags:
        original = obj.original
        key = original.as_pointer(), 0 if instancer is None else instancer.original.as_pointer()
        if key not in self._flags and instancer is not None:
            own, others = self._flags_of(obj), self._flags_of(instancer)
            self._flags[key] = _Flags(
                own.visibility & others.visibility, own.holdout or others.holdout, own.catcher or others.catcher
            )
        elif key not in self._flags:
            rays = visibility_of(obj)
            if original.indirect_only_get(view_layer=self._view_layer):
                rays &= ~Ray.CAMERA
            held = obj.is_holdout or original.holdout_get(view_layer=self._view_layer)
            self._flags[key] = _Flags(rays, held, original.is_shadow_catcher)
        return self._flags[key]


def _topmost(obj: bpy.types.Object) -> bpy.types.Object:
    while obj.parent is not None:
        obj = obj.parent
    return obj


def slot_materials(obj: bpy.types.Object) -> list[bpy.types.Material | None]:
    """Material of each slot: that of the object if its slot says so, else that of its evaluated mesh.

    Modifiers may add slots to the mesh that the object does not have. A mesh without slots has one default material.
    """
    data, slots = obj.data.materials, obj.material_slots
    found = []
    for i in range(max(len(data), len(slots), 1)):
        if i < len(slots) and slots[i].link == "OBJECT":
            found.append(slots[i].material)
        else:
            found.append(data[i] if i < len(data) else None)
    return found


def invertible(matrix: np.ndarray) -> np.ndarray | None:
    """``matrix`` (4 × 4), with a small thickness if it flattens (a plane scaled to zero along its normal stays
    visible); None if no area is left."""
    linear = matrix[:3, :3]
    # In plain Python: there may be many thousands of objects, and NumPy takes ten times as long for nine numbers.
    a, b, c, d, e, f, g, h, i = entries = linear.ravel().tolist()
    determinant = a * (e * i - f * h) + b * (f * g - d * i) + c * (d * h - e * g)
    greatest = max(max(entries), -min(entries))
    if abs(determinant) > 1e-6 * greatest**3:  # then the least scale is above this fraction too
        return matrix
    rotation, scales, axes = np.linalg.svd(linear)
    if scales[1] <= FLAT * scales[0] or scales[0] == 0.0:
        return None
    if scales[2] > FLAT * scales[0]:
        return matrix
    scales[2] = _THICKNESS * scales[0]
    result = matrix.copy()
    result[:3, :3] = (rotation * scales) @ axes
    return result
