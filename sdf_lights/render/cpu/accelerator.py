# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own Embree 4, used through its C API; kernels call it by address (``kernels.rays``).

A mesh that is used once is added to the top-level scene in world space, which saves a second traversal. A mesh that is
used more often, or that moves as a whole, becomes a separate Embree scene that its instances share. In both cases the
Embree geometry id at the top level is the index of the instance in ``Scene.instances``.
"""

from __future__ import annotations

import ctypes

import numpy as np

from ..errors import RenderError
from ..identity import Same
from ..kernels.lights import shadow_bits
from ..kernels.ray_origins import SHAPE, filter_address
from ..kernels.rays import NONE, QUERY, masks_of, world_positions
from ..libraries import load_embree
from ..scene import Mesh, Primitive, Scene
from ..strands import EMBREE_TYPES, Buffers, baked_instances, buffers, strand_of, tessellation


class _Api:
    """The functions of Embree's C API that are used, with their types."""

    _SIGNATURES = {
        "rtcNewDevice": ("p", "c"),
        "rtcRetainDevice": (None, "p"),
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
        "rtcSetGeometryTessellationRate": (None, "pf"),
        "rtcSetGeometryUserData": (None, "pp"),
    }
    _TYPES = {
        "p": ctypes.c_void_p,
        "i": ctypes.c_int,
        "u": ctypes.c_uint,
        "z": ctypes.c_size_t,
        "c": ctypes.c_char_p,
        "f": ctypes.c_float,
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
_UINT, _UINT3, _FLOAT3, _FLOAT4, _FLOAT3X4_ROW_MAJOR = 0x5001, 0x5003, 0x9003, 0x9004, 0x9134
_ROBUST, _FILTER_IN_ARGUMENTS = 4, 8
_INVOKE_ARGUMENT_FILTER, _ALL_FEATURES = 2, 0xFFFFFFFF


class _Device:
    """A device of Embree."""

    def __init__(self, api: _Api):
        self._api, self.handle = api, api.rtcNewDevice(b"threads=0")
        if not self.handle:
            raise RenderError("Embree could not start a device: free memory and render again.")

    def __del__(self):
        if self.handle:
            self._api.rtcReleaseDevice(self.handle)


class _EmbreeScene:
    """An Embree scene, and the arrays that it reads.

    It retains the device: Python may release what belongs to a cycle of references in any order, and Embree needs the
    device until the last scene has gone.
    """

    def __init__(self, api: _Api, device: _Device):
        self._api, self._device = api, device.handle
        api.rtcRetainDevice(device.handle)
        self.handle = api.rtcNewScene(device.handle)
        self.arrays: list = []
        api.rtcSetSceneFlags(self.handle, _ROBUST | _FILTER_IN_ARGUMENTS)
        api.rtcSetSceneBuildQuality(self.handle, 1)

    def __del__(self):
        self._api.rtcReleaseScene(self.handle)
        self._api.rtcReleaseDevice(self._device)


def accelerator_of(scene: Scene, transparent: np.ndarray, deep: np.ndarray | None = None) -> Accelerator:
    """An ``Accelerator``; ``transparent`` and ``deep`` (materials,) as there. If nothing has moved, it is the one that
    the scene has kept, which gives the same hits."""
    before = scene.kept.get(_KEPT) if scene.kept is not None else None
    if before is not None and before.is_valid_for(scene, transparent, deep):
        return before
    made = Accelerator(scene, transparent, deep, before)
    if scene.kept is not None:
        scene.kept[_KEPT] = made
    return made


_KEPT = "accelerator"


class Accelerator:
    """Embree's structures over all instances of a scene. Keep it while kernels use its block scalars."""

    def __init__(
        self,
        scene: Scene,
        transparent: np.ndarray,
        deep: np.ndarray | None = None,
        before: Accelerator | None = None,
    ):
        """``transparent``, ``deep``: (materials,) bool, True if a material lets some light straight through, and if
        light may scatter below it. ``inner_scenes`` (instances,) has a separate Embree scene for each of the latter, in
        world space if the instance is baked; 0 for others. Unchanged shared meshes of ``before`` are not built
        again."""
        self._api = api = _Api() if before is None else before._api
        self._device = _Device(api) if before is None else before._device
        self._keep, self._scenes = [], []
        self._query = np.zeros(1, QUERY)
        self._query["flags"], self._query["features"] = _INVOKE_ARGUMENT_FILTER, _ALL_FEATURES
        self._query["filter"] = filter_address()
        self._signature = _signature(scene, transparent, deep)
        self._inner: dict[tuple, _EmbreeScene] = {}
        self.baked = baked_instances(scene)
        shared: dict[int, int] = {}
        old = {} if before is None else before._inner
        self.inner_scenes = np.zeros(len(scene.instances), np.int64)
        self.scene = self._new_scene()
        masks = masks_of(scene.instances, transparent, shadow_bits(scene))
        for index, instance in enumerate(scene.instances):
            mesh = scene.meshes[instance.mesh]
            if not len(mesh.triangles):
                continue
            if self.baked[index]:
                geometry = self._geometry(mesh, instance.matrix)
            else:
                if instance.mesh not in shared:
                    form = _form_of(mesh)
                    found = old.get(form)
                    if found is None:
                        found = _EmbreeScene(api, self._device)
                        first = len(self._keep)
                        self._attach([found.handle], self._geometry(mesh), 0, NONE)
                        api.rtcCommitScene(found.handle)
                        found.arrays = [*self._keep[first:], mesh]
                    self._inner[form] = found
                    shared[instance.mesh] = found.handle
                geometry = api.rtcNewGeometry(self._device.handle, _INSTANCE)
                poses = instance.matrix[None] if instance.motion is None else instance.motion
                api.rtcSetGeometryInstancedScene(geometry, shared[instance.mesh])
                api.rtcSetGeometryTimeStepCount(geometry, len(poses))
                for step, pose in enumerate(poses):
                    matrix = np.ascontiguousarray(pose[:3], np.float32)
                    api.rtcSetGeometryTransform(geometry, step, _FLOAT3X4_ROW_MAJOR, matrix.ctypes.data)
            alone = []
            if deep is not None and any(deep[material] for material in instance.materials):
                apart = self.baked[index] or mesh.primitive != Primitive.TRIANGLES
                alone = [self._new_scene()] if apart else []
                self.inner_scenes[index] = alone[0] if alone else shared[instance.mesh]
            # As in Cycles, light cannot leave again below curves and spheres.
            inside = alone if mesh.primitive == Primitive.TRIANGLES else []
            self._attach([self.scene, *inside], geometry, index, masks[index])
            for inner in alone:
                api.rtcCommitScene(inner)
        api.rtcCommitScene(self.scene)
        error = api.rtcGetDeviceError(self._device.handle)
        if error:
            raise RenderError(
                "Embree ran out of memory while sorting the scene's triangles: reduce subdivision or instance objects."
                if error == 4
                else f"Embree could not build the scene (its error code is {error})."
            )

    def fill(self, block: np.ndarray) -> None:
        """Store the scene of Embree and the addresses of its functions in a block (1,)."""
        block["embree_scene"] = self.scene
        block["rtc_intersect"] = self._api.address("rtcIntersect1")
        block["rtc_occluded"] = self._api.address("rtcOccluded1")
        block["rtc_occluded8"] = self._api.address("rtcOccluded8")
        block["filtered_query"] = self._query.ctypes.data

    def is_valid_for(self, scene: Scene, transparent: np.ndarray, deep: np.ndarray | None) -> bool:
        """Whether these structures are valid for this scene, too. ``transparent`` and ``deep`` (materials,) as in
        ``accelerator_of``."""
        return self._signature == _signature(scene, transparent, deep)

    def _new_scene(self) -> int:
        self._scenes.append(_EmbreeScene(self._api, self._device))
        return self._scenes[-1].handle

    def _geometry(self, mesh: Mesh, matrix: np.ndarray | None = None) -> int:
        """The geometry of a mesh, in world space by ``matrix``, or in local space."""
        if mesh.primitive != Primitive.TRIANGLES:
            return self._strands(mesh, buffers(mesh, matrix))
        forms = [form if matrix is None else world_positions(form, matrix) for form in _forms(mesh)]
        return self._triangles(forms, mesh.triangles)

    def _strands(self, mesh: Mesh, given: Buffers) -> int:
        """A geometry of curves or spheres."""
        api, share = self._api, self._api.rtcSetSharedGeometryBuffer
        geometry = api.rtcNewGeometry(self._device.handle, EMBREE_TYPES[mesh.primitive])
        api.rtcSetGeometryTimeStepCount(geometry, len(given.vertices))
        for step, vertices in enumerate(given.vertices):
            share(geometry, _VERTEX_BUFFER, step, _FLOAT4, vertices.ctypes.data, 0, 16, len(vertices))
        if given.indices is not None:
            share(geometry, _INDEX_BUFFER, 0, _UINT, given.indices.ctypes.data, 0, 4, len(given.indices))
        if mesh.primitive == Primitive.RIBBONS:
            api.rtcSetGeometryTessellationRate(geometry, tessellation(mesh))
        strands, record = strand_of(mesh), np.zeros(1, SHAPE)
        record["strand_of_address"], record["strand_of_count"] = strands.ctypes.data, len(strands)
        self._keep += [given, strands, record]
        api.rtcSetGeometryUserData(geometry, record.ctypes.data)
        return geometry

    def _triangles(self, forms: list[np.ndarray], triangles: np.ndarray) -> int:
        """A geometry with the vertices ``forms``, each (V, 3), at even times."""
        indices = np.ascontiguousarray(triangles, np.int32)
        self._keep.append(indices)
        geometry = self._api.rtcNewGeometry(self._device.handle, _TRIANGLES)
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


def _forms(mesh: Mesh) -> list[np.ndarray]:
    """Positions (V, 3) of a mesh at even times of the shutter."""
    return [mesh.positions] if mesh.motion is None else list(mesh.motion)


def _form_of(mesh: Mesh) -> tuple:
    """What decides an Embree scene of a mesh in its own space."""
    arrays = (mesh.positions, mesh.triangles, mesh.radii, mesh.motion, mesh.motion_radii)
    return (*map(Same, arrays), mesh.primitive, mesh.subdivisions)


def _signature(scene: Scene, transparent: np.ndarray, deep: np.ndarray | None) -> tuple | None:
    """Key of the structures of a scene; None if it is not needed."""
    if scene.kept is None:
        return None
    masks = masks_of(scene.instances, transparent, shadow_bits(scene))
    scattering = set() if deep is None else set(np.flatnonzero(deep).tolist())
    instances = [
        (
            instance.mesh,
            np.asarray(instance.matrix).tobytes(),
            Same(instance.motion),
            mask,
            scattering.isdisjoint(instance.materials),
        )
        for instance, mask in zip(scene.instances, masks)
    ]
    return [_form_of(mesh) for mesh in scene.meshes], instances
