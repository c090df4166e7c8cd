# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Interfaces between the parts of the renderer: a back end, a light, a light sampler, a BSDF, a sampler, a film.

They correspond to ``base/`` in pbrt. Kernels have no objects, so everything except a back end is a module with these
functions. ``block`` is the record of a scene (``kernels.packing``), ``workspace`` that of a thread
(``kernels.workspace``). Points and unit vectors are tuples in world space, pdfs are per solid angle, radiance is RGB,
u1 … are uniform numbers in [0, 1). ``tests/render/test_interfaces.py`` checks everything registered against them, by
names and parameters.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, runtime_checkable

import numpy as np

from .film import Film as FilmOfScene
from .scene import Scene


@runtime_checkable
class BackEnd(Protocol):
    """Renders a scene into a film. Made with (scene, film, cancelled, say), which may compile for a while.

    ``say(text)`` reports its present step. ``ready`` is False if ``cancelled()`` returned True during the set-up.
    Raises ``RenderError``, and ``DeviceError`` if another back end must take over.
    """

    @property
    def name(self) -> str:
        """For the user: "CPU", "GPU (and its model)"."""
        ...

    ready: bool

    def sample(self, first: int, count: int, stop: Callable[[], bool], report: Callable[[float], None]) -> bool:
        """Add samples ``first`` to ``first + count − 1`` to every active pixel. Returns False if ``stop()`` ended it
        before."""
        ...

    def finish(self) -> None:
        """Warn about unresolved rays, and free the memory of the render; the film stays."""
        ...


@runtime_checkable
class LightPathTracer(Protocol):
    """Traces light paths for a back end that only connects its paths with them, of a scene that has some.

    ``tables`` and ``scalars`` of ``kernels.light_paths.records`` are the same for all samples: which materials and
    emitters have light paths, and how much paths count on them.
    """

    tables: dict[str, np.ndarray]
    scalars: dict[str, float]

    def use(self, sample: int) -> tuple[int, dict[str, np.ndarray]]:
        """For the samples from ``sample`` on: which is the first one after these, and the tables of the tree and of the
        vertices that all of them are connected with."""
        ...

    def finish(self) -> None:
        """Free the memory."""
        ...


@runtime_checkable
class InteractiveBackEnd(BackEnd, Protocol):
    """A back end for the viewport: it accepts changes of a scene, and stops at once."""

    def update_lights(self, scene: Scene) -> None:
        """Take the lamps and lights of a scene that is otherwise unchanged."""
        ...

    def update_camera(self, scene: Scene, film: FilmOfScene) -> None:
        """Take the camera and the settings of an otherwise unchanged scene, and another film."""
        ...

    def interrupt(self) -> None:
        """Stop sampling within milliseconds, if ``stop`` also returns True then. Other threads may call this."""
        ...


@runtime_checkable
class Light(Protocol):
    """A kind of light: a module of ``kernels.lights.kinds``, whose ``RECORD`` has a row for each light of the kind.

    ``normal(light, back)`` is optional: the unit normal of its surface, if that is not ``back``, the direction to the
    viewer.

    So are ``leave(light, u1, u2, u3, u4)`` and ``flux(rows)``, without which no light paths start there. ``leave`` is a
    ray that leaves the light, as ``SampleLe`` in pbrt: (origin, direction, flux, reach). The flux (RGB, W) is what the
    ray stands for, if it is the only one. It counts where the ray first meets a surface, up to the distance ``reach``.
    ``flux`` is the mean of RGB that each of the ``rows`` emits, about (n,).
    """

    def has_size(self, light):
        """Whether rays can hit the light of a scene."""
        ...

    def pack(self, row, light, rgb):
        """Fill the row of ``light``, whose strength times colour is ``rgb``. Returns what the light tree needs to know
        of it."""
        ...

    def sample(self, light, x, u1, u2):
        """From x: (wi, distance, radiance, pdf, singular). A pdf of 0 means that the light does not reach x."""
        ...

    def hit(self, light, o, d):
        """The hit of a ray: (distance, radiance, pdf of ``sample`` at o); the distance is −1 if it misses."""
        ...


@runtime_checkable
class LightSampler(Protocol):
    """Chooses one emitter among all for a point: ``kernels.lights``."""

    def select(self, block, number, x, n, u, cut):
        """(emitter, probability, u remapped to [0, 1)); emitter −1 if nothing gives light. n is zero if both sides
        count.

        ``number``: that of the light tree with the emitters that light the point.
        """
        ...

    def selection_probability(self, block, number, x, n, emitter, cut):
        """The probability with which ``select`` gives that emitter at the same x and n."""
        ...


@runtime_checkable
class Bsdf(Protocol):
    """A closure that few scenes have: a module of ``kernels.shading.special``. ``index`` is that of its ``CLOSURE``."""

    def evaluate(self, block, workspace, index, x, y, z):
        """For the direction (x, y, z): (red, green, blue, pdf) of f · |cos|, without the closure's weight."""
        ...

    def sample(self, block, workspace, index, u1, u2, u3):
        """(x, y, z, red, green, blue, pdf, kind): a direction, f · |cos| there, and bits of ``shading.records``."""
        ...


@runtime_checkable
class Sampler(Protocol):
    """The sampling pattern: ``kernels.samplers``. Each set of one to four numbers has its own ``dimension``."""

    def pixel_seed(self, x, y, seed):
        """A number that makes the patterns of pixels, and of renders with different ``seed``, independent."""
        ...

    def get_1d(self, index, seed, dimension):
        """A number for sample ``index``; ``seed`` is from ``pixel_seed``."""
        ...

    def get_2d(self, index, seed, dimension):
        """A point of the unit square; arguments as in ``get_1d``."""
        ...

    def get_3d(self, index, seed, dimension):
        """A point of the unit cube."""
        ...

    def get_4d(self, index, seed, dimension):
        """A point of the four-dimensional unit cube."""
        ...


@runtime_checkable
class Film(Protocol):
    """Stores samples: ``kernels.film``, by the index of a pixel."""

    def pixel_index(self, block, x, y):
        """The index of the pixel in column x and row y of the full frame."""
        ...

    def is_active(self, block, pixel):
        """Whether the pixel takes samples."""
        ...

    def samples_due(self, block, pixel, samples):
        """Indices (first, end) of the next samples of a pixel, so that pixels of rate 1 have ``samples`` then."""
        ...

    def add_sample(self, block, workspace, pixel, index):
        """Add the workspace's sample, number ``index`` of its pixel."""
        ...
