# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own Embree 4, built through its C API; kernels call it by address (``kernels.rays``).

A mesh used once is put into the top-level scene in world space, which spares its rays the second traversal; a mesh used
more often, or that moves as a whole, becomes an Embree scene of its own that its instances share. Either way the
Embree geometry id at the top level is the index of the instance in ``Scene.instances``.
"""

from __future__ import annotations

import ctypes

import numpy as np

from ..errors import RenderError
from ..kernels.lights import shadow_bits
from ..kernels.rays import NONE, mask_of, world_positions
from ..libraries import load_embree
from ..scene import Mesh, Scene


class _Api:
    """The functions of Embree's C API that are used, with their types."""

    _SIGNATURES = {
        "rtcNewDevice": ("p", "c"),
        "rtcReleaseDevice": (None, "p"),
        "rtcGetDeviceError": ("i", "p"),
        "rtcNewScene": ("p", "p"),
        "rtcSetSceneFlags": (None, "pi"),
        "rtcSetSceneBuildQuality": (None, "pi"),
        "rtcCommitScene": (None, "p"),
        "rtcReleaseScene": (None, "p"),
        "rtcNewGeometry": ("p", "pi"),
        "rtcReleaseGeometry": (None, "p"),
        "rtcCommitGeometry": (None, "p"),
        "rtcAttachGeometryByID": (None, "ppu"),
        "rtcSetGeometryMask": (None, "pu"),
        "rtcSetSharedGeometryBuffer": (None, "piuipzzz"),
        "rtcSetGeometryInstancedScene": (None, "pp"),
        "rtcSetGeometryTransform": (None, "puip"),
        "rtcSetGeometryTimeStepCount": (None, "pu"),
    }
    _TYPES = {
        "p": ctypes.c_void_p,
        "i": ctypes.c_int,
        "u": ctypes.c_uint,
        "z": ctypes.c_size_t,
        "c": ctypes.c_char_p,
        None: None,
    }

    def __init__(self):
        self.library = load_embree()
        for name, (result, arguments) in self._SIGNATURES.items():
            function = getattr(self.library, name)
            function.restype = self._TYPES[result]
            function.argtypes = [self._TYPES[letter] for letter in arguments]
            setattr(self, name, function)

    def address(self, name: str) -> int:
        return ctypes.cast(getattr(self.library, name), ctypes.c_void_p).value


_TRIANGLES, _INSTANCE = 0, 121
_INDEX_BUFFER, _VERTEX_BUFFER = 0, 1
_UINT3, _FLOAT3, _FLOAT3X4_ROW_MAJOR = 0x5003, 0x9003, 0x9134
_ROBUST = 4


class Accelerator:
    """Embree's structures over all instances of a scene. Hold on to it while kernels use its block scalars."""

    def __init__(self, scene: Scene, transparent: np.ndarray, deep: np.ndarray | None = None):
        """``transparent``, ``deep``: (materials,) bool, True where a material lets some light straight through, and where
        light may scatter below it. ``inner_scenes`` (instances,) has an Embree scene of nothing else for these, in the
        world if the instance is baked; 0 for others."""
        self._api = api = _Api()
        self._device = api.rtcNewDevice(b"threads=0")
        if not self._device:
            raise RenderError("Embree could not start a device: free memory and render again.")
        self._keep, self._scenes = [], []
        uses = np.bincount([instance.mesh for instance in scene.instances], minlength=len(scene.meshes))
        self.baked = np.array(
            [uses[instance.mesh] == 1 and instance.motion is None for instance in scene.instances], dtype=bool
        )
        shared: dict[int, int] = {}
        self.inner_scenes = np.zeros(len(scene.instances), np.int64)
        self.scene = self._new_scene()
        bits = shadow_bits(scene)
        for index, instance in enumerate(scene.instances):
            mesh = scene.meshes[instance.mesh]
            if not len(mesh.triangles):
                continue
            if self.baked[index]:
                forms = [world_positions(form, instance.matrix) for form in _forms(mesh)]
                geometry = self._triangles(forms, mesh.triangles)
            else:
                if instance.mesh not in shared:
                    inner = self._new_scene()
                    self._attach([inner], self._triangles(_forms(mesh), mesh.triangles), 0, NONE)
                    api.rtcCommitScene(inner)
                    shared[instance.mesh] = inner
                geometry = api.rtcNewGeometry(self._device, _INSTANCE)
                poses = instance.matrix[None] if instance.motion is None else instance.motion
                api.rtcSetGeometryInstancedScene(geometry, shared[instance.mesh])
                api.rtcSetGeometryTimeStepCount(geometry, len(poses))
                for step, pose in enumerate(poses):
                    matrix = np.ascontiguousarray(pose[:3], np.float32)
                    api.rtcSetGeometryTransform(geometry, step, _FLOAT3X4_ROW_MAJOR, matrix.ctypes.data)
            alone = []
            if deep is not None and any(deep[material] for material in instance.materials):
                alone = [self._new_scene()] if self.baked[index] else []
                self.inner_scenes[index] = alone[0] if alone else shared[instance.mesh]
            self._attach([self.scene, *alone], geometry, index, mask_of(instance, transparent, bits))
            for inner in alone:
                api.rtcCommitScene(inner)
        api.rtcCommitScene(self.scene)
        error = api.rtcGetDeviceError(self._device)
        if error:
            raise RenderError(
                "Embree ran out of memory while sorting the scene's triangles: reduce subdivision or instance objects."
                if error == 4
                else f"Embree could not build the scene (its error code is {error})."
            )

    def fill(self, block: np.ndarray) -> None:
        """Store the scene of Embree and the addresses of its functions in a block."""
        block["embree_scene"] = self.scene
        block["rtc_intersect"] = self._api.address("rtcIntersect1")
        block["rtc_occluded"] = self._api.address("rtcOccluded1")

    def _new_scene(self) -> int:
        scene = self._api.rtcNewScene(self._device)
        self._api.rtcSetSceneFlags(scene, _ROBUST)
        self._api.rtcSetSceneBuildQuality(scene, 1)
        self._scenes.append(scene)
        return scene

    def _triangles(self, forms: list[np.ndarray], triangles: np.ndarray) -> int:
        """A geometry whose vertices are at ``forms``, each (V, 3), at even times."""
        indices = np.ascontiguousarray(triangles, np.uint32)
        self._keep.append(indices)
        geometry = self._api.rtcNewGeometry(self._device, _TRIANGLES)
        share = self._api.rtcSetSharedGeometryBuffer
        self._api.rtcSetGeometryTimeStepCount(geometry, len(forms))
        for step, positions in enumerate(forms):
            # Embree reads 16 bytes at the last vertex.
            padded = np.zeros((len(positions) + 1, 3), np.float32)
            padded[:-1] = positions
            self._keep.append(padded)
            share(geometry, _VERTEX_BUFFER, step, _FLOAT3, padded.ctypes.data, 0, 12, len(positions))
        share(geometry, _INDEX_BUFFER, 0, _UINT3, indices.ctypes.data, 0, 12, len(indices))
        return geometry

    def _attach(self, scenes: list[int], geometry: int, index: int, mask: int) -> None:
        self._api.rtcSetGeometryMask(geometry, mask)
        self._api.rtcCommitGeometry(geometry)
        for scene in scenes:
            self._api.rtcAttachGeometryByID(scene, geometry, index)
        self._api.rtcReleaseGeometry(geometry)

    def __del__(self):
        api = getattr(self, "_api", None)
        if api is None:
            return
        for scene in reversed(getattr(self, "_scenes", [])):
            api.rtcReleaseScene(scene)
        if getattr(self, "_device", None):
            api.rtcReleaseDevice(self._device)


def _forms(mesh: Mesh) -> list[np.ndarray]:
    """Positions (V, 3) of a mesh at even times of the shutter."""
    return [mesh.positions] if mesh.motion is None else list(mesh.motion)
