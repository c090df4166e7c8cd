# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A value node as its definition in ``render.nodes`` sees it: inputs, settings and data of Blender's node."""

from __future__ import annotations

import math
import pathlib

import bpy
import mathutils
import numpy as np

from ...graph.formula import Formula, Vector, constant
from ...render.material import Attribute, Table
from ...render.nodes.definition import NodeInputs
from ...render.nodes.geometry import generated, to_object, transformed_normal, uv
from ...render.nodes.variables import INCOMING, NORMAL, POSITION
from .common import matrix_of
from .links import NOWHERE
from .node_values import BLACK, constant_of, converted, numbers_of, replaces_default, working_space
from .zones import Stack, by_identifier


def _incoming(node) -> Vector:
    """The direction to the viewer, in the space of the object or the light."""
    turn = node.setting("light_normals")
    return to_object(INCOMING, "NORMAL") if turn is None else transformed_normal(node, turn, INCOMING)


# The value of an unlinked Vector socket of these textures; for all others, Generated coordinates.
_IMPLICIT = {"ShaderNodeTexImage": uv, "ShaderNodeTexEnvironment": lambda node: POSITION, "ShaderNodeTexIES": _incoming}
# In worlds too, which have no UV map: an image shows one place, as in Cycles. All others have the direction there.
_LIKE_ON_SURFACES = {"ShaderNodeTexImage"}
# For these nodes it is zero, although they hide its value like textures.
_NO_COORDINATES = {"ShaderNodeMapRange", "ShaderNodeVectorRotate", "ShaderNodeTexWhiteNoise"}

MOST_IES_BYTES = 16 << 20  # of an IES text; reading a device would never end


def is_field(node, socket) -> bool:
    """Whether Blender computes no result of a node without a link to this input: it stands for the position."""
    return (
        has_coordinates(node, socket) or node.bl_idname == "ShaderNodeTexWhiteNoise" and socket.identifier == "Vector"
    )


def has_coordinates(node, socket) -> bool:
    """Whether an input has coordinates instead of its own value if nothing is linked."""
    return socket.identifier == "Vector" and socket.hide_value and node.bl_idname not in _NO_COORDINATES


class BlenderInputs(NodeInputs):
    """A value node as its definition sees it: ``render.nodes.NodeInputs``."""

    def __init__(self, reader, node, stack: Stack, output):
        self._reader, self._node, self._stack = reader, node, stack
        self.wanted = {socket.identifier for socket in node.outputs if socket.is_linked} | {output.identifier}

    def _socket(self, identifier: str):
        return by_identifier(self._node.inputs, identifier)

    def _read(self, identifier: str) -> tuple[Formula | Vector, str]:
        socket = self._socket(identifier)
        value, kind = (None, "VALUE") if socket is None else self._reader.value(socket, self._stack)
        return (constant(0.0), "VALUE") if value is None else (value, kind)

    def number(self, socket: str) -> Formula:
        return converted(*self._read(socket), 0.0)

    def vector(self, socket: str) -> Vector:
        found = self._socket(socket)
        if found is not None and has_coordinates(self._node, found) and not self.is_given(socket):
            found = self.coordinates()
        else:
            found = converted(*self._read(socket), BLACK)
        return self._mapped(found) if socket == "Vector" else found

    color = vector

    def normal(self, socket: str) -> Vector:
        return self.vector(socket) if self.is_given(socket) else NORMAL

    def coordinates(self) -> Vector:
        """The value of an unlinked Vector input of a texture."""
        kind = self._node.bl_idname
        if self._reader.domain == "WORLD" and kind not in _LIKE_ON_SURFACES:
            return POSITION
        return _IMPLICIT.get(kind, generated)(self)

    def _mapped(self, vector: Vector) -> Vector:
        """A vector after the texture mapping that some nodes contain."""
        mapping = getattr(self._node, "texture_mapping", None)
        if mapping is None:
            return vector
        matrix = texture_matrix(mapping)
        if matrix is None:
            return vector
        rows = [[self.parameter(float(entry)) for entry in row] for row in matrix]
        mapped = Vector(*(row[0] * vector.x + row[1] * vector.y + row[2] * vector.z + row[3] for row in rows))
        return mapped.normalized() if mapping.vector_type == "NORMAL" else mapped

    def has(self, socket: str) -> bool:
        return self._socket(socket) is not None

    def is_linked(self, socket: str) -> bool:
        found = self._socket(socket)
        return found is not None and self._reader.has_source(found, self._stack)

    def varies(self, socket: str) -> bool:
        return self.is_linked(socket) and numbers_of(self._reader.parameters, self._read(socket)[0]) is None

    def is_given(self, socket: str) -> bool:
        found = self._socket(socket)
        if found is None:
            return False
        if self._reader.has_source(found, self._stack):
            return True
        node, end, _ = self._reader.resolve(found, self._stack)
        if node is not None:
            return False
        if replaces_default(end, found):
            return True
        # Such a texture of constants has even the hidden value of a group's input.
        return end not in (found, NOWHERE) and self._reader.folds(self._node, self._stack, found.identifier)

    def is_folded(self) -> bool:
        return self._reader.folds(self._node, self._stack)

    def own(self, output: str) -> Formula | Vector:
        return self._reader.parametric(constant_of(by_identifier(self._node.outputs, output)))

    def setting(self, name: str):
        if name == "working_space":
            return working_space()
        if name == "scene_time":
            scene = self._reader.scene
            frame = scene.frame_current_final
            return frame * scene.render.fps_base / scene.render.fps, frame
        if name == "object_matrix":
            other = self._node.object
            return None if other is None else matrix_of(other.matrix_world.inverted_safe())[:3]
        if name == "occlusion_distance":
            world = self._reader.scene.world
            return 10.0 if world is None else world.light_settings.distance
        if name == "material_index":
            return self._reader.material_index
        if name in ("domain", "grids", "volume_interpolation"):
            return getattr(self._reader, name)
        if name in ("light_matrix", "light_normals", "light_shape", "object_info"):
            return self._reader.light.get(name)
        if name == "attribute_value":
            return self._reader.attribute_value(self._node)
        if name == "blender_version":
            return bpy.app.version[:2]
        if name == "ies_text":
            return ies_text(self._node)
        return getattr(self._node, name, None)

    def parameter(self, value: float | Attribute) -> Formula:
        return self._reader.parametric(value)

    def table(self, values: np.ndarray) -> Formula:
        return self._reader.parametric(Table(np.asarray(values, np.float64)))

    def image(self, straight: bool = False, tiled: bool = True) -> Formula:
        node = self._node
        # Textures of the world repeat.
        extension = getattr(node, "extension", "REPEAT")
        return self._reader.parametric(
            self._reader.images.texture(
                node.image,
                node.image_user,
                interpolation=node.interpolation,
                extension=extension,
                alpha=straight,
                tiled=tiled,
            )
        )

    def report(self, sentence: str) -> None:
        self._reader.report(self._node, sentence)


def ies_text(node) -> str:
    """The IES file of a node, from a text or from disk; empty if there is none."""
    if node.mode == "INTERNAL":
        text = "" if node.ies is None else node.ies.as_string()
        return text if len(text) <= MOST_IES_BYTES else ""
    path = pathlib.Path(bpy.path.abspath(node.filepath, library=node.id_data.library))
    try:
        if not path.is_file() or path.stat().st_size > MOST_IES_BYTES:
            return ""
        return path.read_text(encoding="latin-1")
    except (OSError, ValueError):
        return ""


LEAST_SIZE = 1e-5  # of a texture node's own mapping, if it divides
_AXES = {"NONE": None, "X": 0, "Y": 1, "Z": 2}


def texture_matrix(mapping) -> np.ndarray | None:
    """(3, 4) matrix of a texture node's own mapping; None if it is the identity."""
    axes = [_AXES[getattr(mapping, f"mapping_{axis}")] for axis in "xyz"]
    location, rotation, size = (tuple(getattr(mapping, name)) for name in ("translation", "rotation", "scale"))
    if axes == [0, 1, 2] and not any(location) and not any(rotation) and size == (1.0, 1.0, 1.0):
        return None
    swizzle = np.zeros((3, 3))
    for row, column in enumerate(axes):
        if column is not None:
            swizzle[row, column] = 1.0
    turn = np.array(mathutils.Euler(rotation, "XYZ").to_matrix(), np.float64)
    kind = mapping.vector_type
    # As in Cycles: a size of zero stands for a small one where it divides.
    inverse = [1.0 / (entry if abs(entry) >= LEAST_SIZE else math.copysign(LEAST_SIZE, entry + 0.0)) for entry in size]
    if kind == "TEXTURE":
        linear = np.diag(inverse) @ turn.T
        return np.column_stack([linear @ swizzle, -linear @ np.array(location)])
    linear = turn @ np.diag(inverse if kind == "NORMAL" else size)
    return np.column_stack([linear @ swizzle, location if kind == "POINT" else np.zeros(3)])
