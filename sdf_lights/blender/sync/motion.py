# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion while the shutter is open: Blender evaluates the scene at other times, and this module records what has moved.

The times, and the objects that may move, are those of Cycles. Lamps and lights, which stand still in Cycles, move here
too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterator
from dataclasses import fields, replace
from typing import NamedTuple

import bpy
import numpy as np

from ...render.errors import RenderError
from ...render.motion import exposure, poses, resampled
from ...render.scene import Camera, Emitter, Lamp, Scene, Shutter
from .attributes import random_number
from .common import Warnings, is_finite, matrix_of
from .images import Images
from .lights import light_of
from .mesh import Form, Readable

_CURVE_POINTS = 257
_STILL = 1e-5  # metres
# these fields of a light keep the values of the frame
_KEPT = ("visibility", *(item.name for item in fields(Emitter)))
_FORM = ("shape", "emission")  # of a lamp that does not deform, and the nodes of a light
# as a fraction of the time that the shutter is open, from the frame on
_OPENS = {"START": 0.0, "CENTER": -0.5, "END": -1.0}


class Key(NamedTuple):
    """Identifies an instance at all times."""

    instancer: int
    obj: int
    number: tuple[int, ...]
    hair: bool = False  # its particle hair


class Placed(NamedTuple):
    """Index of an instance in a scene: in ``instances``, ``lamps`` or ``lights``, or −1."""

    instance: int = -1
    lamp: int = -1
    light: int = -1


class Wish(NamedTuple):
    """The motion of an object: the number of steps of the shutter, and whether it deforms. With 0 steps it stands
    still."""

    steps: int
    forms: bool


def key_of(item: bpy.types.DepsgraphObjectInstance, hair: bool = False) -> Key:
    """See ``Key``."""
    instancer = item.parent.original.as_pointer() if item.is_instance and item.parent is not None else 0
    number = tuple(item.persistent_id) if item.is_instance else ()
    return Key(instancer, item.object.original.as_pointer(), number, hair)


def wish_of(*owners: bpy.types.Object | None) -> Wish:
    """The motion settings of an object or an instance. Both its instancer and itself are asked, as in Cycles."""
    steps, forms = 0, True
    for owner in owners:
        if owner is None:
            continue
        settings = getattr(owner, "cycles", None)
        if not getattr(settings, "use_motion_blur", True):
            return Wish(0, False)
        steps = max(steps, 1 << min(max(getattr(settings, "motion_steps", 1), 1), 7))
        forms = forms and getattr(settings, "use_deform_motion", True)
    return Wish(steps, forms)


def is_wanted(depsgraph: bpy.types.Depsgraph) -> bool:
    """Whether the render has motion blur."""
    layer = depsgraph.view_layer_eval
    return depsgraph.scene_eval.render.use_motion_blur and getattr(layer, "use_motion_blur", True)


def shutter_of(scene: bpy.types.Scene) -> Shutter:
    """The shutter of a scene: its curve and its rolling shutter."""
    mapping = scene.render.motion_blur_shutter_curve
    mapping.initialize()
    curve = mapping.curves[0]
    density = [mapping.evaluate(curve, x) for x in np.linspace(0.0, 1.0, _CURVE_POINTS)]
    cycles = getattr(scene, "cycles", None)
    rolls = getattr(cycles, "rolling_shutter_type", "NONE") != "NONE"
    return Shutter(exposure(np.array(density)), cycles.rolling_shutter_duration if rolls else None)


class Motion:
    """Records the state of everything at even times of the shutter, and writes it into a scene.

    ``cameras`` makes the camera of each view. ``placed`` and ``forms`` are the records of the object reader.
    """

    def __init__(
        self,
        depsgraph: bpy.types.Depsgraph,
        engine: bpy.types.RenderEngine,
        scene: Scene,
        cameras: Callable[[], list[Camera]],
    ):
        self._depsgraph, self._engine, self._scene = depsgraph, engine, scene
        self._cameras = cameras

    def read(self, placed: dict[Key, Placed], forms: dict[int, Readable], views: list[Camera]) -> None:
        """Evaluate the scene at all times, and write the motion into the scene and the cameras ``views``. Restores the
        frame at the end."""
        blender_scene = self._depsgraph.scene_eval
        camera_object = self._engine.camera_override or blender_scene.camera
        wishes, deforms = self._wishes(placed, forms)
        camera = self._wish(camera_object).steps if camera_object is not None else 0
        steps = max([camera, *(wish.steps for wish in wishes.values())], default=0)
        if steps == 0 and not self._has_other_middle():
            return
        steps = steps or 2
        self._frame = blender_scene.frame_current, blender_scene.frame_subframe
        seen = [Seen(placed, forms, deforms) for _ in range(steps + 1)]
        eyes: list[list[Camera]] = [[] for _ in views]
        try:
            for step in self._times(steps):
                if step in self._steps_of(camera, steps):
                    for eye, at in zip(eyes, self._cameras()):
                        eye.append(at)
                self._look(seen[step], wishes, step, steps)
        finally:
            self._go_back()
        moves = self._give(placed, wishes, deforms, seen, steps)
        for view, eye in zip(views, eyes):
            moves |= self._give_camera(view, eye)
        if moves:
            self._finish()

    def _wish(self, *owners: bpy.types.Object | None) -> Wish:
        return wish_of(*owners)

    def _give_camera(self, view: Camera, seen: list[Camera]) -> bool:
        """Write the motion of a camera. Returns whether it moves."""
        if all(same_place(at, seen[0]) for at in seen[1:]):
            self._stand(view, seen)
            return False
        view.motion = resampled(tuple(seen))
        return True

    def _stand(self, thing, found: list) -> None:
        """Give something that stands still its state at the middle of the shutter."""
        if found and self._has_other_middle():
            for item in fields(thing):
                setattr(thing, item.name, getattr(found[0], item.name))

    def _finish(self) -> None:
        """Called if something moves."""
        self._scene.shutter = shutter_of(self._depsgraph.scene_eval)

    def _wishes(self, placed: dict[Key, Placed], forms: dict[int, Readable]) -> tuple[dict[Key, Wish], set[int]]:
        """The motion settings of each instance, and the meshes that may deform."""
        wishes, deforms = {}, set()
        known: dict[int, bool] = {}
        for item, key in self._items(placed):
            wishes[key] = self._wish(item.parent if item.is_instance else None, item.object)
            place = placed[key]
            if place.instance < 0 or not self._form_steps(wishes[key], wishes[key].steps or 2):
                continue
            if key.obj not in known:
                known[key.obj] = item.object.is_deform_modified(self._depsgraph.scene_eval, "RENDER")
            if known[key.obj]:
                deforms.add(self._scene.instances[place.instance].mesh)
        return wishes, deforms

    def _items(self, wanted: Container[Key]) -> Iterator[tuple[bpy.types.DepsgraphObjectInstance, Key]]:
        """All motion settings, with their keys: those of an object, and of its hair."""
        for item in self._depsgraph.object_instances:
            for hair in (False, True) if len(item.object.particle_systems) else (False,):
                key = key_of(item, hair)
                if key in wanted:
                    yield item, key

    def _times(self, steps: int) -> Iterator[int]:
        """Go to each of the even times in turn; yields its number."""
        opens, length = self._span()
        frame, subframe = self._frame
        for step in range(steps + 1):
            time = frame + subframe + opens + length * step / steps
            whole = math.floor(time)
            self._engine.frame_set(whole, time - whole)
            yield step

    def _span(self) -> tuple[float, float]:
        """The first of the times, relative to the frame, and the length of the interval, in frames."""
        render = self._depsgraph.scene_eval.render
        length = render.motion_blur_shutter
        return _OPENS.get(render.motion_blur_position, -0.5) * length, length

    def _has_other_middle(self) -> bool:
        """Whether the shutter is not half open at the frame itself. As in Cycles, what is not blurred then has its
        state of that middle."""
        opens, length = self._span()
        return opens + 0.5 * length != 0.0

    def _steps_of(self, wished: int, steps: int) -> range:
        """Which of the times 0 … ``steps`` count for something that wishes a number of steps."""
        if wished:
            return range(0, steps + 1, steps // wished)
        return range(steps // 2, steps // 2 + int(self._has_other_middle()))

    def _form_steps(self, wish: Wish, steps: int) -> range:
        """The same for its vertices."""
        return self._steps_of(wish.steps if wish.forms else 0, steps)

    def _go_back(self) -> None:
        self._engine.frame_set(*self._frame)

    def _look(self, seen: Seen, wishes: dict[Key, Wish], step: int, steps: int) -> None:
        """Record the present state of everything needed at this step."""
        for item, key in self._items(wishes):
            wish = wishes[key]
            if step in self._steps_of(wish.steps, steps):
                seen.note(key, item, self._depsgraph, self._scene)

    def _give(
        self, placed: dict[Key, Placed], wishes: dict[Key, Wish], deforms: set[int], seen: list[Seen], steps: int
    ) -> bool:
        """Write the motion into the scene. Returns whether anything moves."""
        moves = False
        for key, place in placed.items():
            wish = wishes.get(key)
            those = [seen[step] for step in self._steps_of(wish.steps, steps)] if wish is not None else []
            if not those or any(key not in each.places for each in those):
                continue  # it stands still, appears or disappears
            found = [each.places[key] for each in those]
            if place.instance >= 0:
                instance = self._scene.instances[place.instance]
                if any(not np.array_equal(matrix, found[0]) for matrix in found[1:]):
                    instance.motion, moves = poses(np.stack(found)), True
                elif self._has_other_middle():
                    instance.matrix = found[0]
                mesh = instance.mesh
                if mesh in deforms and self._reform(mesh, [seen[step] for step in self._form_steps(wish, steps)]):
                    moves = True
                deforms.discard(mesh)
            else:
                moves |= self._give_light(place, found, wish.forms or not wish.steps)
        return moves

    def _reform(self, index: int, seen: list[Seen]) -> bool:
        if any(index not in each.forms for each in seen):
            return False  # its vertices change at some time
        mesh = self._scene.meshes[index]
        forms = [each.forms[index] for each in seen]
        if self._has_other_middle():  # it may stand still, but not as at the frame
            first, forms = Form(mesh.positions, mesh.normals, mesh.radii), forms if len(forms) > 1 else 2 * forms
        else:
            first = forms[0]
        if all(_same_form(form, first) for form in forms):
            return False
        positions = [form.positions for form in forms]
        sizes = [form.radii for form in forms]
        mesh.motion = np.stack(positions)
        if mesh.normals is not None:
            mesh.motion_normals = np.stack([form.normals for form in forms])
        if mesh.radii is not None:
            mesh.motion_radii = np.stack(sizes)
        return True

    def _give_light(self, place: Placed, found: list, deforms: bool) -> bool:
        lights = self._scene.lamps if place.lamp >= 0 else self._scene.lights
        index = max(place.lamp, place.light)
        light = lights[index]
        if any(type(other) is not type(light) for other in found):
            return False
        kept = {name: getattr(light, name) for name in _KEPT}
        if not deforms or not isinstance(light, Lamp):
            kept |= {name: getattr(light, name) for name in _FORM if hasattr(light, name)}
        found = [replace(other, **kept) for other in found]
        if all(same_place(other, found[0]) for other in found[1:]):
            self._stand(light, found)
            return False
        light.motion = resampled(tuple(found))
        return True


class Seen:
    """The state at one time."""

    def __init__(self, placed: dict[Key, Placed], forms: dict[int, Readable], deforms: set[int]):
        self._placed, self._forms, self._deforms = placed, forms, deforms
        self.places: dict[Key, np.ndarray | object] = {}
        self.forms: dict[int, Form] = {}

    def note(
        self, key: Key, item: bpy.types.DepsgraphObjectInstance, depsgraph: bpy.types.Depsgraph, scene: Scene
    ) -> None:
        """Keep the state of an object at the current time."""
        matrix = matrix_of(item.matrix_world)
        if not is_finite(matrix):
            return
        place = self._placed[key]
        if place.instance >= 0:
            self.places[key] = matrix
            mesh = scene.instances[place.instance].mesh
            if mesh in self._deforms and mesh not in self.forms:
                form = self._forms[mesh].read(item.object, depsgraph)
                if form is not None:
                    self.forms[mesh] = form
            return
        aside = Scene(Camera(None), 0, 0)
        ignore = Warnings(aside.warnings)
        known = (scene.lamps[place.lamp] if place.lamp >= 0 else scene.lights[place.light]).visibility
        try:
            owner = matrix_of(item.object.original.evaluated_get(depsgraph).matrix_world)
            images = Images(aside, ignore)
            light = light_of(item.object, matrix, known, depsgraph, ignore, images, owner, random_number(item))
        except RenderError:
            return
        if light is not None:
            self.places[key] = light


def _same_form(a: Form, b: Form) -> bool:
    if a.radii is None or b.radii is None:
        return np.array_equal(a.positions, b.positions)
    # Particle hair is computed in world space, with different rounding at each time. Cycles uses this tolerance.
    return all(np.abs(x - y).max(initial=0.0) <= _STILL for x, y in ((a.positions, b.positions), (a.radii, b.radii)))


def same_place(a, b) -> bool:
    """Whether all numbers of two lights or cameras are equal, and the shapes of lamps."""
    for name, value in vars(a).items():
        other = getattr(b, name)
        if isinstance(a, Lamp) and name in _FORM and value != other:
            return False
        if isinstance(value, np.ndarray):
            if not np.array_equal(value, other):
                return False
        elif isinstance(value, float | tuple) and value != other:
            return False
    return True
