# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own Embree 4 through ctypes, 16 rays a call, for scenes that are too large for NumPy.

Every instance refers to an Embree scene of its mesh. Names and numbers are those of Embree's C API (rtcore.h).
"""

from __future__ import annotations

import ctypes

import numpy as np

from ..libraries import load_embree
from ..scene import Primitive, Scene
from ..strands import EMBREE_TYPES, buffers, tessellation
from .hits import Hits

LANES = 16
# Fields of RTCRayHit16, each 16 values of 4 bytes; some more for versions with longer hits.
(ORIGIN, NEAR, DIRECTION, TIME, FAR, MASK, ID, FLAGS, NORMAL, U, V, PRIMITIVE, GEOMETRY, INSTANCE, FIELDS) = (
    0,
    3,
    4,
    7,
    8,
    9,
    10,
    11,
    12,
    15,
    16,
    17,
    18,
    19,
    24,
)
NOTHING = 0xFFFFFFFF

TRIANGLES, INSTANCES = 0, 121
INDICES, VERTICES = 0, 1
UINT, UINT3, FLOAT3, FLOAT4, FLOAT3X4_ROW_MAJOR = 0x5001, 0x5003, 0x9003, 0x9004, 0x9134
ROBUST = 4

_POINTER, _INT, _UINT, _SIZE = ctypes.c_void_p, ctypes.c_int, ctypes.c_uint, ctypes.c_size_t
_SIGNATURES = {
    "rtcNewDevice": (_POINTER, ctypes.c_char_p),
    "rtcReleaseDevice": (None, _POINTER),
    "rtcGetDeviceError": (_INT, _POINTER),
    "rtcNewScene": (_POINTER, _POINTER),
    "rtcReleaseScene": (None, _POINTER),
    "rtcCommitScene": (None, _POINTER),
    "rtcSetSceneFlags": (None, _POINTER, _INT),
    "rtcNewGeometry": (_POINTER, _POINTER, _INT),
    "rtcReleaseGeometry": (None, _POINTER),
    "rtcCommitGeometry": (None, _POINTER),
    "rtcAttachGeometryByID": (None, _POINTER, _POINTER, _UINT),
    "rtcSetGeometryMask": (None, _POINTER, _UINT),
    "rtcSetSharedGeometryBuffer": (None, _POINTER, _INT, _UINT, _INT, _POINTER, _SIZE, _SIZE, _SIZE),
    "rtcSetGeometryInstancedScene": (None, _POINTER, _POINTER),
    "rtcSetGeometryTessellationRate": (None, _POINTER, ctypes.c_float),
    "rtcSetGeometryTransform": (None, _POINTER, _UINT, _INT, _POINTER),
    "rtcIntersect16": (None, _POINTER, _POINTER, _POINTER, _POINTER),
}


class EmbreeRays:
    """Nearest hits with all instances of ``scene``. Raises RenderError if there is no Embree."""

    def __init__(self, scene: Scene):
        library = load_embree()
        for name, (result, *arguments) in _SIGNATURES.items():
            # A separate prototype: other users of the library keep theirs.
            prototype = ctypes.CFUNCTYPE(result, *arguments)
            setattr(self, name, prototype((name, library)))
        self._device = self.rtcNewDevice(None)
        self._scenes, self._buffers = [], []
        meshes = [self._mesh(mesh) for mesh in scene.meshes]
        self._scene = self._new_scene()
        for index, instance in enumerate(scene.instances):
            geometry = self.rtcNewGeometry(self._device, INSTANCES)
            self.rtcSetGeometryInstancedScene(geometry, meshes[instance.mesh])
            matrix = np.ascontiguousarray(instance.matrix[:3], np.float32)
            self.rtcSetGeometryTransform(geometry, 0, FLOAT3X4_ROW_MAJOR, matrix.ctypes.data)
            self.rtcSetGeometryMask(geometry, int(instance.visibility))
            self._attach(self._scene, geometry, index)
        self.rtcCommitScene(self._scene)
        error = self.rtcGetDeviceError(self._device)
        if error:
            raise RuntimeError(f"Embree's error code is {error}")

    def _new_scene(self) -> int:
        scene = self.rtcNewScene(self._device)
        self.rtcSetSceneFlags(scene, ROBUST)
        self._scenes.append(scene)
        return scene

    def _attach(self, scene: int, geometry: int, index: int) -> None:
        self.rtcCommitGeometry(geometry)
        self.rtcAttachGeometryByID(scene, geometry, index)
        self.rtcReleaseGeometry(geometry)

    def _mesh(self, mesh) -> int:
        scene = self._new_scene()
        if len(mesh.triangles) and mesh.primitive != Primitive.TRIANGLES:
            self._attach_strands(scene, mesh)
        elif len(mesh.triangles):
            # Embree reads 16 bytes at the last vertex.
            positions = np.zeros((len(mesh.positions) + 1, 3), np.float32)
            positions[:-1] = mesh.positions
            triangles = np.ascontiguousarray(mesh.triangles, np.uint32)
            self._buffers += [positions, triangles]
            geometry = self.rtcNewGeometry(self._device, TRIANGLES)
            share = self.rtcSetSharedGeometryBuffer
            share(geometry, VERTICES, 0, FLOAT3, positions.ctypes.data, 0, 12, len(mesh.positions))
            share(geometry, INDICES, 0, UINT3, triangles.ctypes.data, 0, 12, len(triangles))
            self.rtcSetGeometryMask(geometry, NOTHING)
            self._attach(scene, geometry, 0)
        self.rtcCommitScene(scene)
        return scene

    def _attach_strands(self, scene: int, mesh) -> None:
        given = buffers(mesh)
        self._buffers.append(given)
        geometry = self.rtcNewGeometry(self._device, EMBREE_TYPES[mesh.primitive])
        share, vertices = self.rtcSetSharedGeometryBuffer, given.vertices[0]
        share(geometry, VERTICES, 0, FLOAT4, vertices.ctypes.data, 0, 16, len(vertices))
        if given.indices is not None:
            share(geometry, INDICES, 0, UINT, given.indices.ctypes.data, 0, 4, len(given.indices))
        if mesh.primitive == Primitive.RIBBONS:
            self.rtcSetGeometryTessellationRate(geometry, tessellation(mesh))
        self.rtcSetGeometryMask(geometry, NOTHING)
        self._attach(scene, geometry, 0)

    def __del__(self):
        for scene in reversed(getattr(self, "_scenes", [])):
            self.rtcReleaseScene(scene)
        if getattr(self, "_device", None):
            self.rtcReleaseDevice(self._device)

    def intersect(self, origins: np.ndarray, directions: np.ndarray, far: np.ndarray, masks: np.ndarray) -> Hits:
        """See ``Geometry.intersect``, which adds the points."""
        count = len(origins)
        packets = -(-count // LANES)
        words = packets * FIELDS * LANES
        memory = np.zeros(4 * (words + 2 * LANES) + 64, np.uint8)
        start = -memory.ctypes.data % 64
        words32 = memory[start : start + 4 * (words + 2 * LANES)].view(np.uint32)
        valid = words32[:LANES]
        valid[:] = NOTHING
        rays = words32[2 * LANES :].reshape(packets, FIELDS, LANES)
        floats = rays.view(np.float32)

        def lanes(values, fill=0.0):
            return np.pad(values, (0, packets * LANES - count), constant_values=fill).reshape(packets, LANES)

        for axis in range(3):
            floats[:, ORIGIN + axis] = lanes(origins[:, axis])
            floats[:, DIRECTION + axis] = lanes(directions[:, axis], 1.0)
        floats[:, FAR] = lanes(np.minimum(far, 3e38), -1.0)
        rays[:, MASK] = lanes(masks, 0)
        rays[:, GEOMETRY], rays[:, INSTANCE] = NOTHING, NOTHING
        intersect, on, first, size = self.rtcIntersect16, valid.ctypes.data, rays.ctypes.data, 4 * FIELDS * LANES
        for address in range(first, first + packets * size, size):
            intersect(on, self._scene, address, None)

        def values(array, field):
            return array[:, field].ravel()[:count]

        found = values(rays, GEOMETRY) != NOTHING
        return Hits(
            np.where(found, values(floats, FAR), np.inf),
            np.where(found, values(rays, INSTANCE).astype(int), -1),
            np.where(found, values(rays, PRIMITIVE).astype(int), -1),
            values(floats, U).astype(float),
            values(floats, V).astype(float),
            np.zeros((count, 3)),
        )
