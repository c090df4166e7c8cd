# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair of particle systems as curves, as in Cycles: parents, or the children instead of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import bpy
import numpy as np

from ...render.images import decoded
from ...render.material import Attribute
from ...render.scene import AttributeValues, Domain, Mesh, Scene
from ...render.strands import strand_of
from .common import matrix_of
from .mesh import Form, Readable
from .strands import Strands, strands


def hair_systems(obj: bpy.types.Object, viewport: bool = False) -> Iterator[bpy.types.ParticleSystemModifier]:
    """The modifiers of an evaluated object whose particles are hair rendered as paths."""
    for modifier in obj.modifiers:
        if modifier.type != "PARTICLE_SYSTEM" or not (modifier.show_viewport if viewport else modifier.show_render):
            continue
        settings = modifier.particle_system.settings
        if settings.type == "HAIR" and settings.render_type == "PATH":
            yield modifier


class ParticleHairs:
    """Adds the hair of each object to the scene once. ``curves`` knows their shape. ``forms`` gets the readers of the
    hair."""

    def __init__(self, scene: Scene, depsgraph: bpy.types.Depsgraph, curves: Strands, forms: dict[int, Readable]):
        self._scene, self._curves, self._forms = scene, curves, forms
        self._viewport = depsgraph.mode == "VIEWPORT"

    def index(self, obj: bpy.types.Object, slots: int, attributes: Iterable[Attribute]) -> int | None:
        """Index of the hair of an evaluated object in the scene, with these attributes; None if there is none."""
        hair = ParticleHair(obj, self._viewport)
        mesh = hair.mesh(slots)
        if mesh is None:
            return None
        mesh.primitive, mesh.subdivisions = self._curves.shape, self._curves.subdivisions
        for attribute in attributes:
            found = hair.attribute(mesh, attribute)
            if found is not None:
                mesh.attributes[attribute] = found
        self._scene.meshes.append(mesh)
        self._forms[len(self._scene.meshes) - 1] = HairForms(len(mesh.positions))
        return len(self._scene.meshes) - 1


class HairForms(NamedTuple):
    """Reads hair of so many points again."""

    count: int

    def read(self, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Form | None:
        """See ``mesh.Readable``."""
        mesh = ParticleHair(obj.original.evaluated_get(depsgraph), depsgraph.mode == "VIEWPORT").mesh(1)
        return None if mesh is None or len(mesh.positions) != self.count else Form(mesh.positions, None, mesh.radii)


class ParticleHair:
    """The hair of an evaluated object, from all of its systems; curves are in object space."""

    def __init__(self, obj: bpy.types.Object, viewport: bool = False):
        self._obj, self._systems = obj, list(hair_systems(obj, viewport))
        self._numbers = [_numbers(modifier.particle_system, viewport) for modifier in self._systems]
        self._steps = [_steps(modifier.particle_system.settings, viewport) for modifier in self._systems]

    def points(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions (V, 3), and the start of each curve and the end of the last one (curves + 1,)."""
        places = []
        for modifier, numbers, steps in zip(self._systems, self._numbers, self._steps):
            co, obj = modifier.particle_system.co_hair, self._obj
            found = np.array([co(obj, particle_no=i, step=k) for i in numbers for k in range(steps)], np.float64)
            found = found.reshape(len(numbers), steps, 3)
            for step in range(1, steps):  # truncated paths have no more
                missing = (found[:, step] == 0.0).all(-1)
                found[missing, step] = found[missing, step - 1]
            places.append(found.reshape(-1, 3))
        world = np.concatenate([np.zeros((0, 3)), *places])
        back = np.linalg.inv(matrix_of(self._obj.matrix_world))
        counts = [steps for numbers, steps in zip(self._numbers, self._steps) for _ in numbers]
        first = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        return (world @ back[:3, :3].T + back[:3, 3]).astype(np.float32), first

    def mesh(self, slots: int) -> Mesh | None:
        """All curves; the faces of the object have so many ``slots``. None if there is no hair."""
        positions, first = self.points()
        if not len(positions):
            return None
        mesh = strands(
            self._obj.name, positions, np.zeros(len(positions), np.float32), first, np.arange(len(first) - 1)
        )
        mesh.radii = self.radii(mesh)
        system = np.repeat(np.arange(len(self._systems)), [len(numbers) for numbers in self._numbers])
        chosen = [modifier.particle_system.settings.material - 1 for modifier in self._systems]
        mesh.slots = np.clip(np.array(chosen, np.int32), 0, slots - 1)[system][strand_of(mesh)].astype(np.int32)
        return mesh

    def radii(self, mesh: Mesh) -> np.ndarray:
        """(V,) radius of each point, interpolated from the root to the tip."""
        along = mesh.attributes[Attribute("strand", "intercept")].values[:, 0]
        parts, start = [], 0
        for modifier, numbers, steps in zip(self._systems, self._numbers, self._steps):
            settings, count = modifier.particle_system.settings, len(numbers) * steps
            size, shape = 0.5 * settings.radius_scale, settings.shape
            exponent = 1.0 + shape if shape < 0.0 else 1.0 / (1.0 - min(shape, 1.0 - 1e-6))
            left = np.maximum(1.0 - along[start : start + count], 0.0) ** exponent
            radius = size * (settings.tip_radius + left * (settings.root_radius - settings.tip_radius))
            if settings.use_close_tip:
                radius.reshape(-1, steps)[:, -1] = 0.0
            parts.append(radius)
            start += count
        return np.concatenate(parts).astype(np.float32)

    def attribute(self, mesh: Mesh, attribute: Attribute) -> AttributeValues | None:
        """The emitter's values at the root of each curve: UV maps, colours of corners, generated coordinates."""
        data = self._obj.data
        if attribute.kind == "uv":
            names = [layer.name for layer in data.uv_layers]
            active = next((layer.name for layer in data.uv_layers if layer.active_render), None)
            name = attribute.name or active
            found = self._of_roots("uv_on_emitter", "uv_no", names.index(name)) if name in names else None
        elif attribute.kind == "geometry" and attribute.name:
            names = [
                item.name for item in data.attributes if item.data_type == "BYTE_COLOR" and item.domain == "CORNER"
            ]
            found = None
            if attribute.name in names:
                srgb = self._of_roots("mcol_on_emitter", "vcol_no", names.index(attribute.name))
                found = decoded(srgb)
        elif attribute.kind == "generated":
            roots = mesh.positions[mesh.triangles[np.flatnonzero(np.diff(strand_of(mesh), prepend=-1)), 0]]
            location, size = np.array(data.texspace_location), np.array(data.texspace_size)
            found = (roots - location) * np.divide(0.5, size, out=np.zeros(3), where=size != 0.0) + 0.5
        else:
            return None
        if found is None:
            return None
        return AttributeValues(Domain.TRIANGLE, np.ascontiguousarray(found[strand_of(mesh)], np.float32))

    def _of_roots(self, name: str, place: str, number: int) -> np.ndarray:
        rows: list = []
        for modifier, numbers in zip(self._systems, self._numbers):
            system = modifier.particle_system
            particles, read = system.particles, getattr(system, name)
            last = len(particles) - 1
            rows += [
                read(modifier, particle=particles[min(i, last)], particle_no=i, **{place: number}) for i in numbers
            ]
        return np.array(rows, np.float64)


def _numbers(system: bpy.types.ParticleSystem, viewport: bool) -> Iterable[int]:
    """Numbers of the paths: parents come first; with children they are left out."""
    parents, children = len(system.particles), len(system.child_particles)
    if viewport:
        children = int(children * system.settings.display_percentage / 100.0)
    first = parents if system.settings.child_type != "NONE" and children else 0
    return range(first, parents + children)


def _steps(settings: bpy.types.ParticleSettings, viewport: bool) -> int:
    steps = (1 << (settings.display_step if viewport else settings.render_step)) + 1
    return steps + settings.kink_extra_steps if settings.kink == "SPIRAL" else steps
