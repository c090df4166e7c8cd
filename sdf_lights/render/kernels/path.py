# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""State of one path and of its sample, as records of the workspace."""

import numpy as np

from ...jit import kernel, table
from ...vec import ZERO, average, mul, put, put_sum, scale, sub, vec
from ..scene import Ray
from ..settings import MOST_BRANCHES
from . import lights
from .light_paths.records import source_table as light_path_sources
from .outputs import dispatch as outputs
from .outputs.records import LIGHT

WHITE = (1.0, 1.0, 1.0)
CAMERA = int(Ray.CAMERA)  # the kind of a path until it scatters

# Sets of random numbers: two for the camera, then so many for each vertex of a path.
CAMERA_SETS, VERTEX_SETS = 2, 4
LIGHT_SET, SCATTER_SET, ROULETTE_SET, EMISSION_SET = range(4)
# The same number again for events in media on the way to a vertex.
MEDIA_SETS = 1 << 24
TRAVEL_SET, PHASE_SET, PLACE_SET = range(1, 4)

# And for the subsurface walk, which has 256 steps. Like all sets that the GPU draws, they are numbers of 31 bits.
SUBSURFACE_SETS = 1 << 28
# And for the pass Ambient Occlusion, and for the points whose lobes a shared surface has.
OCCLUSION_SETS, MIXTURE_SETS = 1 << 50, 1 << 51

# Where a ray of a path ends; AT_EXIT: subsurface scattering has ended, and the hit is in the workspace's ray.
AT_SURFACE, IN_MEDIUM, AT_EXIT = range(3)

# The contribution of one sample to the film. ``lamps`` is the part of ``combined`` from SDF lamps. If the path has
# ``divided``, ``before`` and ``lamps_before`` are both sums before the split. It was to split into so many
# ``branches``, which ``met`` so many surfaces; a ray that leaves the scene counts as a fraction of one. ``spread`` is
# the sum of the squared deviations of these branches' contributions. ``cuts`` counts the lamps that were examined box
# by box before the path split: that takes longer than everything else there.
SAMPLE = np.dtype(
    [
        ("combined", "f8", 3),
        ("lamps", "f8", 3),
        ("emission", "f8", 3),
        ("environment", "f8", 3),
        ("alpha", "f8"),
        ("depth", "f8"),
        ("position", "f8", 3),
        ("normal", "f8", 3),
        ("albedo", "f8", 3),
        ("diffuse_albedo", "f8", 3),
        ("found", "i8"),
        ("before", "f8", 3),
        ("lamps_before", "f8", 3),
        ("divided", "i8"),
        ("branches", "i8"),
        ("met", "f8"),
        ("spread", "f8"),
        ("cuts", "f8"),
    ],
    align=True,
)

# ``origin`` is the point of the last scattering (the camera at first), with shading normal ``normal``. Light sampling
# there competes with the ray, so MIS needs its pdf there. ``start`` is ``origin`` moved off the surface. ``glossy_pdf``
# is the microfacet part of ``pdf``, and ``least_pdf`` the least pdf of all directions so far that are not singular.
# ``two_sided`` is 1 if light on either side of that surface counted, ``has_glossy`` if it has microfacets, and
# ``scattered`` is the number of scatterings after it. ``found`` lamps along the ray are in ``lamps_found``; −1: not
# searched yet. ``light_tree`` is that of the last scattering object, 0 for the camera: the ray can hit its emitters.
# ``branch_weight`` is the fraction of the sample that the path represents, 1 until it splits, and ``index`` its index
# in the sampling pattern. ``expected``: for a branch, an estimate of its light, from the irradiance at its hit;
# ``brought``: its contribution to the sample, as a sum of RGB. ``event`` says where the ray ends, ``in_medium`` is 1 if
# a medium was the last to scatter the path, and it has ``crossed`` so many surfaces that only bound media. ``connects``
# is BEFORE along a ray from the surface where the path split, if connections to light paths estimate the light of its
# next hit, too; of that, they can estimate the part ``connection_weight`` (RGB). It is BEYOND from the next surface on:
# then they do estimate the part ``connection_weight`` of what lamps add in the present direction, and
# ``followed_weight`` (RGB) of what the surface scatters by those closures that light paths ``follow`` there.
# ``path_weight`` is the part that they are expected to leave to the ray, if Russian roulette has counted on that;
# else 1. ``connections``: how many were made where the ray left, by row ``choice`` of what that surface expects of the
# tree. ``connects_again`` is 1 where a later surface is connected, too, and ``unconnected`` is the part of the light of
# sources that connections of surfaces before have left. ``stopped`` is not 0 if the ray has passed a surface that stops
# light rays. ``catches`` is 1 once the camera's path has hit a shadow catcher. ``spans`` still holds the ``kept_count``
# intervals of the lamp ``kept`` along the ray; −1: of none. ``reused`` says whether the light of a branch is shared
# among the paths of a group: UNSHARED, ARRIVES on the way to the surface that may be, REUSED there if it is, or MIXED
# if it scatters as the mixture of what all see, and ONWARD behind it. ``row`` is that of the sample of a branch's own
# path, and ``scale`` the largest throughput as the branch began. ``caustic`` is 0 unless the path has been scattered at
# the first surface that the camera sees by a lobe that is not singular, and by mirrors and sharp glass alone after
# that: then 1, and 1 more for each of these. It is BY_LOBE behind a narrow lobe instead of these. ``rival`` is what
# light paths that find the same light compete with: see ``caustic_paths.weights``. At the surface after the first,
# ``lines`` and ``lamp_pdf`` are those of ``caustic_paths.lobes``.
PATH = np.dtype(
    [
        ("origin", "f8", 3),
        ("normal", "f8", 3),
        ("start", "f8", 3),
        ("direction", "f8", 3),
        ("t_min", "f8"),
        ("near", "f8"),
        ("t_max", "f8"),
        ("throughput", "f8", 3),
        ("pdf", "f8"),
        ("glossy_pdf", "f8"),
        ("least_pdf", "f8"),
        ("two_sided", "i8"),
        ("has_glossy", "i8"),
        ("scattered", "i8"),
        ("light_tree", "i8"),
        ("kind", "i8"),
        ("length", "f8"),
        ("spread", "f8"),
        ("bounce", "i8"),
        ("diffuse", "i8"),
        ("glossy", "i8"),
        ("transmission", "i8"),
        ("volume", "i8"),
        ("transparent", "i8"),
        ("stopped", "i8"),
        ("last", "i8"),
        ("found", "i8"),
        ("kept", "i8"),
        ("kept_count", "i8"),
        ("index", "i8"),
        ("seed", "u4"),
        ("dimension", "i8"),
        ("branch_weight", "f8"),
        ("expected", "f8"),
        ("brought", "f8"),
        ("alive", "i8"),
        ("event", "i8"),
        ("in_medium", "i8"),
        ("crossed", "i8"),
        ("catches", "i8"),
        ("connects", "i8"),
        ("connection_weight", "f8", 3),
        ("followed_weight", "f8", 3),
        ("follow", "i8"),
        ("path_weight", "f8"),
        ("choice", "i8"),
        ("connections", "i8"),
        ("connects_again", "i8"),
        ("unconnected", "f8"),
        ("reused", "i8"),
        ("row", "i8"),
        ("scale", "f8"),
        ("caustic", "i8"),
        ("rival", "f8"),
        ("lines", "f8"),
        ("lamp_pdf", "f8"),
    ],
    align=True,
)

TABLES = {"path": PATH, "sample": SAMPLE}
# The path itself, its state at a split, and the branches.
WAITING, FIRST_BRANCH = 1, 2
# The ray itself, those of the branches, and the path's ray while light rays leave it.
FIRST_BRANCH_RAY = 1
KEPT_RAY = FIRST_BRANCH_RAY + MOST_BRANCHES
# The path that has hit a shadow catcher, with its ray, and the sample while the path continues among catchers alone.
CAUGHT, CAUGHT_RAY, KEPT_SAMPLE = FIRST_BRANCH + MOST_BRANCHES, KEPT_RAY + 1, 1
COUNTS = {"path": CAUGHT + 1, "sample": KEPT_SAMPLE + 1, "ray": CAUGHT_RAY + 1}

path_table = table("path", PATH)
sample_table = table("sample", SAMPLE)


NO_EMITTER = -1

NOWHERE, BEFORE, BEYOND = range(3)  # values of ``connects``
UNSHARED, ARRIVES, REUSED, MIXED, ONWARD = range(5)  # values of ``reused``


@kernel
def of_instance(instance):
    """The argument of ``contribute`` for emission of an instance's surfaces; and the instance, from that."""
    return -2 - instance


@kernel
def leave_connected(block, path, value, emitter):
    """What connections to light paths leave of the light of an emitter that a path finds."""
    if block.light_paths and light_path_sources(block)[emitter]:
        value = scale(value, path.unconnected)
        if path.connects == BEYOND:
            return mul(value, sub(WHITE, vec(path.connection_weight)))
    return value


@kernel
def contribute(block, workspace, radiance, factor, source, scatters):
    """Add ``throughput × radiance × factor`` to the sample.

    ``source`` is the emitter, ``of_instance(…)`` for an emissive surface, or ``NO_EMITTER``. ``scatters`` is the number
    of scatterings of the light on its way to the camera.
    """
    path = path_table(workspace)[0]
    sample = sample_table(workspace)[0]
    value = scale(mul(vec(path.throughput), radiance), factor)
    if source >= 0:
        value = leave_connected(block, path, value, source)
    limit = block.clamp_indirect if scatters > 1 else block.clamp_direct
    if limit > 0.0 and not (block.reuses_paths and path.reused >= REUSED):
        brightness = value[0] + value[1] + value[2]
        if brightness > limit:
            value = scale(value, limit / brightness)
    value = scale(value, path.branch_weight)
    put_sum(sample.combined, value)
    if 0 <= source < block.lamp_count and not path.catches:
        put_sum(sample.lamps, value)
    if scatters == 0 and not path.catches:
        if source == lights.world_emitter(block):
            put_sum(sample.environment, value)
        else:
            put_sum(sample.emission, value)
    if block.outputs & LIGHT:
        outputs.add_light(block, workspace, value, source, scatters)


@kernel
def show_environment(workspace, radiance):
    """Add light of the world only to its own pass, which shows the background hidden by a transparent film."""
    path = path_table(workspace)[0]
    sample = sample_table(workspace)[0]
    if not path.catches:
        put_sum(sample.environment, scale(mul(vec(path.throughput), radiance), path.branch_weight))


@kernel
def put_depths(path, surface):
    """Tell a surface, or a light, how often the path has scattered so far."""
    surface.depth[0] = path.bounce
    surface.depth[1] = path.diffuse
    surface.depth[2] = path.glossy
    surface.depth[3] = path.transmission
    surface.depth[4] = path.transparent


@kernel
def subtract_alpha(workspace, part):
    """Subtract from the sample's alpha where the camera sees nothing behind."""
    sample = sample_table(workspace)[0]
    alpha = sample.alpha - part * average(vec(path_table(workspace)[0].throughput))
    sample.alpha = alpha if alpha > 1e-12 else 0.0  # three thirds may round to less than one


@kernel
def clear_sample(workspace):
    """Set all sums of the workspace's sample to 0."""
    sample = sample_table(workspace)[0]
    put(sample.combined, ZERO)
    put(sample.lamps, ZERO)
    put(sample.emission, ZERO)
    put(sample.environment, ZERO)
    put(sample.position, ZERO)
    put(sample.normal, ZERO)
    put(sample.albedo, ZERO)
    put(sample.diffuse_albedo, ZERO)
    sample.alpha = 1.0
    sample.depth = 0.0
    sample.found = 0
    sample.divided = 0
    sample.branches = 1
    sample.met = sample.spread = sample.cuts = 0.0
