# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene in the form that paths need."""

from __future__ import annotations

import numpy as np

from ..scene import ALL_SETS, OPEN_SET, Primitive, Scene
from ..scene import Emitter as Control
from .camera_rays import Camera
from .geometry import Geometry
from .lights import Emitter, Sky, Triangles, blender_light
from .materials import Materials
from .media import Media
from .sdf_lamps import SdfLamp

SPLIT = 8


class SceneData:
    """Geometry, materials, media and emitters of a scene. ``use_embree`` as in ``Geometry``.

    ``control``: of an emitter, by its ``id``, linking and limits of bounces. ``emitters``: those for light sampling.
    ``holdout`` and ``catchers`` (instances,): which of them are holdouts and shadow catchers.
    """

    def __init__(self, scene: Scene, use_embree: bool | None = None):
        self.scene, self.settings = scene, scene.settings
        self.geometry = Geometry(scene, use_embree)
        self.materials = Materials(scene, self.geometry)
        self.media = Media(scene, self.geometry)
        self.camera = Camera(scene)
        self.lamps: list[SdfLamp] = []
        for lamp in scene.lamps:
            try:
                self.lamps.append(SdfLamp(lamp))
            except ValueError as error:
                scene.warnings.append(f"The SDF lamp {lamp.name!r} is left out: {error}.")
        self.lights: list[Emitter] = [blender_light(light, scene) for light in scene.lights]
        self.sky = Sky(scene.world, scene)
        self.control: dict[int, Control] = {
            id(emitter): source
            for emitter, source in [*((lamp, lamp.lamp) for lamp in self.lamps), *zip(self.lights, scene.lights)]
        }
        self.control[id(self.sky)] = Control(max_bounces=scene.world.max_bounces)
        instances = scene.instances
        self.light_sets = np.array([*(instance.light_set for instance in instances), OPEN_SET], int)
        self.shadow_linking = any(instance.blockers != ALL_SETS for instance in instances)
        self.triangles = self._emissive_triangles()
        self.emitters = [*self.lamps, *self.lights]
        if not self.sky.black:
            self.emitters.append(self.sky)
        if self.triangles is not None:
            self.emitters.append(self.triangles)
        self.holdout = np.array([i.holdout for i in scene.instances] or [False])
        self.catchers = np.array([i.catcher for i in scene.instances] or [False])

    def _emissive_triangles(self) -> Triangles | None:
        """The emissive triangles for light sampling; others are found only by chance."""
        geometry, instances, triangles, corners = self.geometry, [], [], []
        for index, instance in enumerate(self.scene.instances):
            mesh = self.scene.meshes[instance.mesh]
            # Curves and spheres are only found by chance, as in Cycles.
            rows = np.arange(len(mesh.triangles) if mesh.primitive == Primitive.TRIANGLES else 0)
            material = geometry.material(np.full(len(rows), index), rows)
            rows = rows[self.materials.emissive[material]] if len(rows) else rows
            instances.append(np.full(len(rows), index))
            triangles.append(rows)
            local = geometry.corners[geometry.first[instance.mesh] + rows]
            matrix = geometry.matrices[index]
            corners.append(local @ matrix[:3, :3].T + matrix[:3, 3])
        if not sum(map(len, triangles)):
            return None
        return Triangles(*map(np.concatenate, (instances, triangles, corners)))

    @property
    def light_samples(self) -> float:
        """Mean number of light samples of an emitter at a vertex."""
        return min(len(self.emitters), SPLIT) / max(len(self.emitters), 1)
