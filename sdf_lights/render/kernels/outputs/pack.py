# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables and scalars that a film's passes need of kernels, but for the code of kernels (``code_table.py``)."""

from __future__ import annotations

import numpy as np

from ...cryptomatte import number_of
from ...film import CAUGHT_LIGHT, Film
from ...material import UV
from ...passes import BY_NAME, DATA_SUMS, LIGHT_SUMS, Rule, aov_sources, light_group_pass
from ...passes import MATTES as MATTES_BY_KIND
from ...scene import Emitter, Scene
from . import vectors
from .records import CATCHERS, DATA, INSTANCE_MATTE, LIGHT, LOBES, MATTES, MOST_HITS, VECTORS
from .state import LIGHT_RAY


def bits_of(film: Film) -> int:
    """``outputs`` of a film."""
    bits = LIGHT * bool(film.light_places) | LOBES * bool(film.light_places.keys() & set(LIGHT_SUMS))
    bits |= CATCHERS * film.catches | VECTORS * ("vector" in film.data_places)
    return bits | (DATA | MATTES) * bool(film.matte_places) | DATA * bool(film.data_places)


def pack_outputs(
    scene: Scene, film: Film, emitters: list[Emitter], instances: np.ndarray
) -> tuple[dict[str, np.ndarray], dict[str, float]]:
    """Tables, except that of code, and scalars for the passes of ``film``. ``emitters`` are lamps, lights and the
    world, and ``instances`` (triangles,) those of the emissive triangles, in the order of the kernels' emitters."""
    bits = bits_of(film)
    numbers = np.zeros(film.data_sums.shape[1], np.int64)
    for item in map(BY_NAME.get, film.passes):
        if item is not None and item.rule is Rule.NUMBER:
            numbers[film.data_places[item.source]] = 1
    tables = {
        "film_light": film.light_sums.ravel(),
        "film_data": film.data_sums.ravel(),
        "light_places": np.array([film.light_places.get(name, -1) for name in LIGHT_SUMS], np.int64),
        "data_places": np.array([film.data_places.get(name, -1) for name in DATA_SUMS], np.int64),
        "data_numbers": numbers,
        "aov_places": np.array([film.data_places.get(name, -1) for name in aov_sources(scene.passes)], np.int64),
    }
    tables |= _groups(scene, film, emitters, instances) | _mattes(scene, film)
    tables |= vectors.pack_vectors(scene, bool(bits & VECTORS))
    attributes = scene.looked_up() if film.data_places else []
    scalars = {
        "outputs": bits,
        "background_moves": scene.background_moves,
        "light_columns": film.light_sums.shape[1] // 2,
        "data_columns": film.data_sums.shape[1],
        "matte_kinds": len(film.matte_places),
        "matte_slots": film.matte_slots,
        "caught_light": film.light_places.get(CAUGHT_LIGHT, -1),
        "uv_attribute": attributes.index(UV) if UV in attributes else 0,
        "occlusion_distance": scene.occlusion_distance,
        "mist_start": scene.mist.start,
        "mist_inverse_depth": 1.0 / scene.mist.depth if scene.mist.depth > 0.0 else 0.0,
        "mist_power": scene.mist.power,
    }
    return tables, scalars


def _groups(scene: Scene, film: Film, emitters: list[Emitter], instances: np.ndarray) -> dict[str, np.ndarray]:
    places = film.light_places
    groups = {item.name: places[item.source] for item in scene.passes if item.source in places}
    empty = np.zeros(0, np.int64)
    tables = {"emitter_groups": empty, "instance_groups": empty, "emitter_passes": empty}
    if not groups:
        return tables

    def of_group(emitter: Emitter) -> int:
        return groups.get(light_group_pass(emitter.light_group).name, -1) if emitter.light_group else -1

    if any(of_group(emitter) >= 0 for emitter in [*emitters, *scene.instances]):
        of_instances = np.array([of_group(instance) for instance in scene.instances], np.int64)
        own = np.array([of_group(emitter) for emitter in emitters], np.int64)
        triangles = of_instances[instances] if len(instances) else empty
        tables |= {"emitter_groups": np.concatenate([own, triangles]), "instance_groups": of_instances}
    if any(emitter.own_pass in groups for emitter in emitters):
        own = [groups.get(emitter.own_pass, -1) for emitter in emitters] + [-1] * len(instances)
        tables["emitter_passes"] = np.array(own, np.int64)
    return tables


def _mattes(scene: Scene, film: Film) -> dict[str, np.ndarray]:
    places, chosen = film.matte_places, bool(film.matte_places)
    known: dict[str, float] = {}

    def number(name: str) -> float:
        if name not in known:
            known[name] = number_of(name)
        return known[name]

    names = [(number(item.name), number(item.asset or item.name)) for item in scene.instances] if chosen else []
    return {
        "film_mattes": film.matte_sums.ravel(),
        "matte_places": np.array([places.get(kind, -1) for kind in MATTES_BY_KIND], np.int64),
        "instance_mattes": np.array(names, INSTANCE_MATTE),
        "material_mattes": np.array([number(material.name) for material in scene.materials] if chosen else []),
    }


def workspace_counts(film: Film) -> dict[str, int]:
    """Elements of a workspace's tables."""
    return {
        "first_scatterings": LIGHT_RAY + 1 if film.light_places else 0,
        "matte_hits": 1 + MOST_HITS if film.matte_places else 0,
        "output_sums": film.light_sums.shape[1] + film.data_sums.shape[1],
    }
