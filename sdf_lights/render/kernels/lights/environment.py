# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: a colour, or an equirectangular image with bilinear filtering.

The image is sampled with a piecewise-constant density over cells of longitude and of the sine of latitude. A cell's
probability is the mean of the filtered image over it, so it is zero only where the image is zero. Within a cell
directions are uniform in solid angle, so the density is exact for the samples. The density of a plain colour is part
cosine about the normal, part uniform, so light through a surface is sampled too.
"""

import math

import numpy as np

from ....jit import kernel
from ....vec import ZERO, dot, frame, mul, sub, to_world, transform_normal, transform_vector, vec
from ...images import colors
from ...scene import Ray
from .cone import FULL_SPHERE, cone_pdf, sample_cone, sample_sphere
from .portals import SHARE, portal_pdf, sample_portal, total_size
from .records import header_table, image_columns_table, image_rows_table, image_table

SCATTERED = Ray.DIFFUSE | Ray.GLOSSY | Ray.TRANSMISSION
MAX_COLUMNS = 4096
UNIFORM = 0.2  # share of uniform directions for a plain colour
DEFENSIVE = 0.1  # fraction of the mean that is added to the map of a world's nodes
# Weight of a uniform world in the selection of lights: the ray that continues a path finds it, too. Of 0.15, 0.35 and
# 1, this has the least noise for spheres and walls under a sky and an area light.
EVEN = 0.15


def image_distribution(pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Cumulative probabilities of the cells of an image (height, width, 3 or 1), and its mean over the sphere.

    Returns rows (R + 1,), columns (R, C + 1) and the mean of the average of its channels. In images wider than
    ``MAX_COLUMNS`` several pixels share a cell. Everything is zero if the image is black.
    """
    weight = np.abs(pixels[..., :3]).mean(axis=2, dtype=np.float64)
    # Mean of the bilinear filter over a pixel: 1/8, 6/8, 1/8 along each axis; longitude wraps, latitude does not.
    weight = 0.75 * weight + 0.125 * (np.roll(weight, 1, 1) + np.roll(weight, -1, 1))
    padded = np.pad(weight, ((1, 1), (0, 0)), mode="edge")
    weight = 0.75 * weight + 0.125 * (padded[:-2] + padded[2:])
    factor = -(-weight.shape[1] // MAX_COLUMNS)
    if factor > 1:
        weight = _pool(_pool(weight, factor).T, factor).T
    rows, columns = weight.shape
    band = np.diff(np.sin(np.pi * (np.arange(rows + 1) / rows - 0.5)))
    weight = weight * band[:, None]
    total_columns = np.zeros((rows, columns + 1))
    np.cumsum(weight, axis=1, out=total_columns[:, 1:])
    row_mass = total_columns[:, -1].copy()
    total_columns /= np.where(row_mass > 0.0, row_mass, 1.0)[:, None]
    total_rows = np.concatenate(([0.0], np.cumsum(row_mass)))
    mean = total_rows[-1] / (2.0 * columns)
    return total_rows / (total_rows[-1] or 1.0), total_columns, mean


def _pool(weight: np.ndarray, factor: int) -> np.ndarray:
    """Means of ``factor`` rows at a time; the last group may be smaller, and its mean is slightly too low."""
    starts = np.arange(0, len(weight), factor)
    return np.add.reduceat(weight, starts, axis=0) / factor


def _unevenness(rows: np.ndarray, columns: np.ndarray) -> float:
    """Fraction of the probability of ``image_distribution`` above a uniform distribution: 0 for uniform light, almost 1
    for a sun in the dark."""
    mass = np.diff(rows)[:, None] * np.diff(columns, axis=1)
    band = np.diff(np.sin(np.pi * (np.arange(len(rows)) / (len(rows) - 1) - 0.5)))
    return float(np.maximum(mass - band[:, None] / (2.0 * mass.shape[1]), 0.0).sum())


def pack(tables, scene, emitter, world_map) -> tuple[float, float]:
    """Fill the tables of the world, whose index among emitters is given. Returns its irradiance, and its weight in the
    selection of lights.

    ``world_map`` is as in ``pack.pack_lights``.
    """
    world, header = scene.world, tables["light_header"]
    tables["light_emitters"][emitter]["visibility"] = int(world.visibility)
    color = world.strength * np.asarray(world.color, float)
    if not np.isfinite(color).all():
        scene.warnings.append(
            "The world is black, because its colour or strength is not a finite number: set it again."
        )
        return 0.0, 0.0
    mean, uneven = np.abs(color).mean(), 0.0
    header["world_color"], header["rotation"] = color, world.rotation
    if world.image is not None and mean > 0.0:
        pixels = colors(scene.images[world.image])
        if not np.isfinite(pixels).all():
            name = scene.images[world.image].name
            scene.warnings.append(
                f"Image “{name}” has pixels that are not finite numbers: they are black in the world."
            )
            pixels = np.where(np.isfinite(pixels).all(axis=2, keepdims=True), pixels, np.float32(0.0))
        rows, columns, image_mean = image_distribution(pixels * np.abs(color).astype(np.float32))
        header["height"], header["width"] = pixels.shape[:2]
        header["rows"], header["columns"] = columns.shape[0], columns.shape[1] - 1
        tables["light_image"] = np.ascontiguousarray(pixels).ravel()
        tables["light_image_rows"], tables["light_image_columns"] = rows, columns.ravel()
        mean, uneven = image_mean, _unevenness(rows, columns)
    if world_map is not None and mean > 0.0:
        # Parts that the map misses between its points still have some probability.
        values = world_map.values
        weight = values + DEFENSIVE * values.mean(dtype=np.float64) + 1e-30
        rows, columns, _ = image_distribution(weight[..., None])
        header["graph"], (header["height"], header["width"]) = 1, weight.shape
        header["rows"], header["columns"] = columns.shape[0], columns.shape[1] - 1
        tables["light_image_rows"], tables["light_image_columns"] = rows, columns.ravel()
        uneven = _unevenness(rows, columns)
        if world_map.sun is not None:
            header["sun"], header["sun_share"] = world_map.sun, world_map.sun_share
            header["sun_width"] = 1.0 - math.cos(world_map.half_angle)
            uneven += world_map.sun_share * (1.0 - uneven)
        mean *= world_map.mean
    if world.visibility & SCATTERED != SCATTERED or header["portal_count"][0] > 0:
        uneven = 1.0  # only light rays find it, or find it far better
    return math.pi * mean, math.pi * mean * (EVEN + (1.0 - EVEN) * uneven)


@kernel
def _coordinates(header, d):
    """(u, v) in [0, 1] of a world direction: longitude and latitude as in Cycles."""
    d = transform_vector(header.rotation, d)
    u = 0.5 - math.atan2(d[1], d[0]) / (2.0 * math.pi)
    return u, 0.5 + math.atan2(d[2], math.hypot(d[0], d[1])) / math.pi


@kernel
def world_radiance(block, d):
    """Background radiance along the unit vector d, for any visibility of the world, without the factor of its nodes."""
    header = header_table(block)[0]
    color = vec(header.world_color)
    if header.height == 0 or header.graph != 0:
        return color
    u, v = _coordinates(header, d)
    image = image_table(block)
    x, y = u * header.width - 0.5, v * header.height - 0.5
    left, below = math.floor(x), math.floor(y)
    fx, fy = x - left, y - below
    x0, x1 = int(left) % header.width, int(left + 1.0) % header.width
    y0, y1 = max(int(below), 0), min(int(below) + 1, header.height - 1)
    a, b = 3 * (y0 * header.width + x0), 3 * (y0 * header.width + x1)
    c, e = 3 * (y1 * header.width + x0), 3 * (y1 * header.width + x1)
    wa, wb, wc, we = (1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy
    return mul(
        color,
        (
            wa * image[a] + wb * image[b] + wc * image[c] + we * image[e],
            wa * image[a + 1] + wb * image[b + 1] + wc * image[c + 1] + we * image[e + 1],
            wa * image[a + 2] + wb * image[b + 2] + wc * image[c + 2] + we * image[e + 2],
        ),
    )


@kernel
def _search(table, first, count, u):
    """Cell i of ``count`` with table[first + i] ≤ u < table[first + i + 1]; one of positive probability."""
    low, high = 0, count
    while high - low > 1:
        middle = (low + high) // 2
        if table[first + middle] <= u:
            low = middle
        else:
            high = middle
    return low


@kernel
def _cell_pdf(block, header, row, column):
    rows, columns = image_rows_table(block), image_columns_table(block)
    at = row * (header.columns + 1) + column
    probability = (rows[row + 1] - rows[row]) * (columns[at + 1] - columns[at])
    low = math.sin(math.pi * (row / header.rows - 0.5))
    high = math.sin(math.pi * ((row + 1) / header.rows - 0.5))
    return probability * header.columns / (2.0 * math.pi * (high - low))


@kernel
def _color_pdf(n, d):
    if n[0] == 0.0 and n[1] == 0.0 and n[2] == 0.0:
        return FULL_SPHERE
    return UNIFORM * FULL_SPHERE + (1.0 - UNIFORM) * max(dot(n, d), 0.0) / math.pi


@kernel
def world_pdf(block, x, n, d):
    """Density of ``sample_world`` in direction d at the point x with normal n (the zero vector: none)."""
    pdf = _sky_pdf(block, n, d)
    if header_table(block)[0].portal_count > 0:
        total = total_size(block, x)
        if total > 0.0:
            return (1.0 - SHARE) * pdf + SHARE * portal_pdf(block, x, total, d)
    return pdf


@kernel
def pdf_in_cycles(block, x, d):
    """Density with which Cycles samples the world in direction d at the point x. It draws no light rays to a world of
    one colour."""
    header = header_table(block)[0]
    return world_pdf(block, x, ZERO, d) if header.height > 0 or header.portal_count > 0 else 0.0


@kernel
def _sky_pdf(block, n, d):
    """``world_pdf`` without portals."""
    header = header_table(block)[0]
    if header.height == 0:
        return _color_pdf(n, d)
    pdf = _map_pdf(block, header, d)
    if header.sun_share > 0.0:
        # From the square of a distance: the cosine of so small an angle has few digits in single precision.
        away = sub(d, vec(header.sun))
        pdf *= 1.0 - header.sun_share
        if dot(away, away) <= 2.0 * header.sun_width:
            pdf += header.sun_share * cone_pdf(header.sun_width)
    return pdf


@kernel
def _map_pdf(block, header, d):
    u, v = _coordinates(header, d)
    # Rows are bands of latitude, so the row of a direction is that of v.
    row = min(max(int(v * header.rows), 0), header.rows - 1)
    column = min(max(int(u * header.columns), 0), header.columns - 1)
    return _cell_pdf(block, header, row, column)


@kernel
def sample_world(block, x, n, u1, u2):
    """Direction from x and its density."""
    if header_table(block)[0].portal_count > 0:
        total = total_size(block, x)
        if total > 0.0:
            if u2 < SHARE:
                wi, found = sample_portal(block, x, total, u1, u2 / SHARE)
            else:
                wi, pdf = _sample_sky(block, n, u1, (u2 - SHARE) / (1.0 - SHARE))
                found = pdf > 0.0
            return wi, world_pdf(block, x, n, wi) if found else 0.0
    return _sample_sky(block, n, u1, u2)


@kernel
def _sample_sky(block, n, u1, u2):
    """``sample_world`` without portals."""
    header = header_table(block)[0]
    if header.height == 0:
        if n[0] == 0.0 and n[1] == 0.0 and n[2] == 0.0:
            return sample_sphere(u1, u2), FULL_SPHERE
        if u2 < UNIFORM:
            wi = sample_sphere(u1, u2 / UNIFORM)
        else:
            square = (u2 - UNIFORM) / (1.0 - UNIFORM)
            r = math.sqrt(square)
            t, b = frame(n)
            phi = 2.0 * math.pi * u1
            wi = to_world((r * math.cos(phi), r * math.sin(phi), math.sqrt(1.0 - square)), t, b, n)
        return wi, _color_pdf(n, wi)
    if header.sun_share > 0.0:
        if u2 < header.sun_share:
            wi = sample_cone(vec(header.sun), header.sun_width, u1, u2 / header.sun_share)
            return wi, _sky_pdf(block, n, wi)
        wi = _sample_map(block, header, u1, (u2 - header.sun_share) / (1.0 - header.sun_share))[0]
        return wi, _sky_pdf(block, n, wi)
    return _sample_map(block, header, u1, u2)


@kernel
def _sample_map(block, header, u1, u2):
    """Direction and its density, by the image or the map."""
    rows, columns = image_rows_table(block), image_columns_table(block)
    row = _search(rows, 0, header.rows, u2)
    height = rows[row + 1] - rows[row]
    first = row * (header.columns + 1)
    column = _search(columns, first, header.columns, u1)
    width = columns[first + column + 1] - columns[first + column]
    if not (height > 0.0 and width > 0.0):
        return (0.0, 0.0, 1.0), 0.0
    low = math.sin(math.pi * (row / header.rows - 0.5))
    high = math.sin(math.pi * ((row + 1) / header.rows - 0.5))
    z = low + (high - low) * min((u2 - rows[row]) / height, 1.0)
    longitude = 2.0 * math.pi * (0.5 - (column + min((u1 - columns[first + column]) / width, 1.0)) / header.columns)
    r = math.sqrt(max(1.0 - z * z, 0.0))
    wi = transform_normal(header.rotation, (r * math.cos(longitude), r * math.sin(longitude), z))
    return wi, _cell_pdf(block, header, row, column)
