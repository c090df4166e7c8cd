# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays against triangles: Blender's own Embree 4, built through its C API and called by address from kernels.

A mesh used once is put into the top-level scene in world space, which spares its rays the second traversal; a mesh used
more often becomes an Embree scene of its own that many instances share. Either way the Embree geometry id at
the top level is the index of the instance in ``Scene.instances``.
"""

from __future__ import annotations

import ctypes

import numpy as np

from ...jit import call_address3, kernel, table
from ...vec import vec
from ..errors import RenderError
from ..libraries import load_embree
from ..scene import Ray, Scene

NONE = 0xFFFFFFFF

# RTCRayHit of Embree 4 (rtcore_ray.h), and padding so that a version with longer hits has room.
RAY = np.dtype(
    [("origin", np.float32, (3,)), ("t_near", np.float32), ("direction", np.float32, (3,)), ("time", np.float32),
     ("t_far", np.float32), ("mask", np.uint32), ("id", np.uint32), ("flags", np.uint32),
     ("normal", np.float32, (3,)), ("u", np.float32), ("v", np.float32), ("primitive", np.uint32),
     ("geometry", np.uint32), ("instance", np.uint32), ("padding", np.uint32, (12,))])

# A geometry takes part in shadow rays through one of two bits, so that a scene's opaque part is asked first, with the
# cheaper any-hit query.
SHADOW_OPAQUE = int(Ray.SHADOW)
SHADOW_TRANSPARENT = 64

SCALARS = [("embree_scene", np.int64), ("rtc_intersect", np.int64), ("rtc_occluded", np.int64)]
ray_table = table("ray", RAY)


class _Api:
    """The functions of Embree's C API that are used, with their types."""

    _SIGNATURES = {
        "rtcNewDevice": ("p", "c"), "rtcReleaseDevice": (None, "p"), "rtcGetDeviceError": ("i", "p"),
        "rtcNewScene": ("p", "p"), "rtcSetSceneFlags": (None, "pi"), "rtcSetSceneBuildQuality": (None, "pi"),
        "rtcCommitScene": (None, "p"), "rtcReleaseScene": (None, "p"),
        "rtcNewGeometry": ("p", "pi"), "rtcReleaseGeometry": (None, "p"), "rtcCommitGeometry": (None, "p"),
        "rtcAttachGeometryByID": (None, "ppu"), "rtcSetGeometryMask": (None, "pu"),
        "rtcSetSharedGeometryBuffer": (None, "piuipzzz"), "rtcSetGeometryInstancedScene": (None, "pp"),
        "rtcSetGeometryTransform": (None, "puip"),
    }
    _TYPES = {"p": ctypes.c_void_p, "i": ctypes.c_int, "u": ctypes.c_uint, "z": ctypes.c_size_t, "c": ctypes.c_char_p,
              None: None}

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

    def __init__(self, scene: Scene, transparent: np.ndarray):
        """``transparent``: (materials,) bool, True where a material lets some light straight through."""
        self._api = api = _Api()
        self._device = api.rtcNewDevice(b"threads=0")
        if not self._device:
            raise RenderError("Embree could not start a device: free memory and render again.")
        self._keep, self._scenes = [], []
        uses = np.bincount([instance.mesh for instance in scene.instances], minlength=len(scene.meshes))
        self.baked = np.array([uses[instance.mesh] == 1 for instance in scene.instances], dtype=bool)
        shared: dict[int, int] = {}
        self.scene = self._new_scene()
        for index, instance in enumerate(scene.instances):
            mesh = scene.meshes[instance.mesh]
            if not len(mesh.triangles):
                continue
            if self.baked[index]:
                geometry = self._triangles(world_positions(mesh.positions, instance.matrix), mesh.triangles)
            else:
                if instance.mesh not in shared:
                    inner = self._new_scene()
                    self._attach(inner, self._triangles(mesh.positions, mesh.triangles), 0, NONE)
                    api.rtcCommitScene(inner)
                    shared[instance.mesh] = inner
                geometry = api.rtcNewGeometry(self._device, _INSTANCE)
                matrix = np.ascontiguousarray(instance.matrix[:3], np.float32)
                api.rtcSetGeometryInstancedScene(geometry, shared[instance.mesh])
                api.rtcSetGeometryTransform(geometry, 0, _FLOAT3X4_ROW_MAJOR, matrix.ctypes.data)
            self._attach(self.scene, geometry, index, mask_of(instance, transparent))
        api.rtcCommitScene(self.scene)
        error = api.rtcGetDeviceError(self._device)
        if error:
            raise RenderError(
                "Embree ran out of memory while sorting the scene's triangles: reduce subdivision or instance objects."
                if error == 4 else f"Embree could not build the scene (its error code is {error}).")

    def fill(self, block: np.ndarray) -> None:
        block["embree_scene"] = self.scene
        block["rtc_intersect"] = self._api.address("rtcIntersect1")
        block["rtc_occluded"] = self._api.address("rtcOccluded1")

    def _new_scene(self) -> int:
        scene = self._api.rtcNewScene(self._device)
        self._api.rtcSetSceneFlags(scene, _ROBUST)
        self._api.rtcSetSceneBuildQuality(scene, 1)
        self._scenes.append(scene)
        return scene

    def _triangles(self, positions: np.ndarray, triangles: np.ndarray) -> int:
        # Embree reads 16 bytes at the last vertex.
        padded = np.zeros((len(positions) + 1, 3), np.float32)
        padded[:-1] = positions
        indices = np.ascontiguousarray(triangles, np.uint32)
        self._keep += [padded, indices]
        geometry = self._api.rtcNewGeometry(self._device, _TRIANGLES)
        share = self._api.rtcSetSharedGeometryBuffer
        share(geometry, _VERTEX_BUFFER, 0, _FLOAT3, padded.ctypes.data, 0, 12, len(positions))
        share(geometry, _INDEX_BUFFER, 0, _UINT3, indices.ctypes.data, 0, 12, len(indices))
        return geometry

    def _attach(self, scene: int, geometry: int, index: int, mask: int) -> None:
        self._api.rtcSetGeometryMask(geometry, mask)
        self._api.rtcCommitGeometry(geometry)
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


def world_positions(positions: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """(V, 3) float32 world positions, rounded once, after the transform."""
    return (positions.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]).astype(np.float32)


def mask_of(instance, transparent: np.ndarray) -> int:
    """Kinds of rays that an instance takes part in; ``transparent`` as of ``Accelerator``."""
    mask = int(instance.visibility)
    if instance.visibility & Ray.SHADOW and any(transparent[material] for material in instance.materials):
        mask = mask & ~SHADOW_OPAQUE | SHADOW_TRANSPARENT
    return mask


def new_rays(count: int) -> np.ndarray:
    """Zeroed ray records at an address that Embree's aligned loads accept."""
    memory = np.zeros(count * RAY.itemsize + 64, np.uint8)
    offset = -memory.ctypes.data % 64
    return memory[offset:offset + count * RAY.itemsize].view(RAY)


@kernel
def _set_ray(ray, o, d, t_min, t_max, mask):
    ray.origin[0] = o[0]
    ray.origin[1] = o[1]
    ray.origin[2] = o[2]
    ray.t_near = t_min
    ray.direction[0] = d[0]
    ray.direction[1] = d[1]
    ray.direction[2] = d[2]
    ray.time = 0.0
    ray.t_far = t_max
    ray.mask = mask
    ray.flags = 0


@kernel
def intersect(block, workspace, o, d, t_min, t_max, mask):
    """Nearest triangle: True if there is one, with the hit left in ``ray_table(workspace)[0]``."""
    ray = ray_table(workspace)[0]
    _set_ray(ray, o, d, t_min, t_max, mask)
    ray.geometry = NONE
    ray.instance = NONE
    call_address3(block.rtc_intersect, block.embree_scene, workspace.ray_address, 0)
    return ray.geometry != NONE


@kernel
def occluded(block, workspace, o, d, t_min, t_max, mask):
    """True if any triangle lies between t_min and t_max."""
    ray = ray_table(workspace)[0]
    _set_ray(ray, o, d, t_min, t_max, mask)
    call_address3(block.rtc_occluded, block.embree_scene, workspace.ray_address, 0)
    return ray.t_far < 0.0


@kernel
def hit_instance(ray):
    """Index of the instance that was hit, whether it was put into the top level itself or by reference."""
    return np.int64(ray.geometry) if ray.instance == NONE else np.int64(ray.instance)


@kernel
def hit_normal(ray):
    return vec(ray.normal)
