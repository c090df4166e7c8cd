# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From the film to rays: projections, the lens, clipping, and the pixel filter.

Conventions and filters follow Cycles, so a scene keeps its framing, its bokeh and its sharpness when the engine
changes.
"""

import math

import numpy as np

from ...emitter.primitives.disk import disk_point
from ...jit import kernel, table
from ...vec import cross, madd, normalize, scale, sub, transform_point, transform_vector
from ..scene import Camera, Projection, Scene
from ..settings import Filter, Settings

CAMERA = np.dtype(
    [
        ("matrix", "f8", (3, 4)),
        ("projection", "i8"),
        # Origin and size of a pixel on the window, and how many there are.
        ("corner", "f8", 2),
        ("step", "f8", 2),
        ("columns", "f8"),
        ("rows", "f8"),
        ("clip", "f8", 2),
        ("aperture", "f8"),
        ("focus", "f8"),
        ("blades", "i8"),
        ("blade_rotation", "f8"),
        ("blade_ratio", "f8"),
        ("edge", "f8"),
        ("lens", "f8", 5),  # greatest angle from the axis of a fisheye
        ("eye", "f8"),
        ("convergence", "f8"),
        ("merge", "f8", 2),
    ],
    align=True,
)

TABLES = {"camera": CAMERA, "filter_offsets": np.dtype(np.float64)}
SCALARS = [("camera_aperture", np.float64), ("camera_pixel_angle", np.float64), ("camera_pixel_width", np.float64)]

camera_table = table("camera", CAMERA)
filter_table = table("filter_offsets", np.float64)

(
    PERSPECTIVE,
    ORTHOGRAPHIC,
    EQUIRECTANGULAR,
    FISHEYE_EQUIDISTANT,
    FISHEYE_EQUISOLID,
    FISHEYE_POLYNOMIAL,
    MIRROR_BALL,
    CUBEMAP_FACE,
    CYLINDER,
) = (int(kind) for kind in Projection)
FIRST_PANORAMA = EQUIRECTANGULAR

# Larger than any angle and any distance: means "none", because infinity would not survive GLSL.
NONE = 1e30

FILTER_CELLS = 1024
TWO_PI = 2.0 * math.pi


def filter_radius(settings: Settings) -> float:
    """Radius of the pixel filter in pixels. The box is always one pixel wide, as in Cycles."""
    return {
        Filter.BOX: 0.5,
        Filter.GAUSSIAN: 1.5 * settings.filter_width,
        Filter.BLACKMAN_HARRIS: settings.filter_width,
    }[settings.filter]


def filter_weight(settings: Settings, x: np.ndarray) -> np.ndarray:
    """Pixel filter (n,) at the distances ``x`` (n,), in pixels, along one axis. It is not normalised.

    The gaussian has a standard deviation of a quarter of the width. The other filter is the four-term window of Harris
    1978, "On the use of windows for harmonic analysis with the discrete Fourier transform", over twice the width.
    """
    radius = filter_radius(settings)
    if settings.filter is Filter.BOX:
        weight = np.ones_like(x)
    elif settings.filter is Filter.GAUSSIAN:
        weight = np.exp(-0.5 * (4.0 * x / settings.filter_width) ** 2)
    else:
        phase = np.pi * (x / radius + 1.0)
        weight = sum(a * np.cos(k * phase) for k, a in enumerate((0.35875, -0.48829, 0.14128, -0.01168)))
    return np.where(np.abs(x) <= radius, weight, 0.0)


def filter_inverse_cdf(settings: Settings) -> np.ndarray:
    """(FILTER_CELLS + 1,) offsets in pixels at equal steps of the filter's distribution function."""
    radius = filter_radius(settings)
    edges = np.linspace(-radius, radius, 16 * FILTER_CELLS + 1)
    weight = filter_weight(settings, edges)
    cdf = np.concatenate([[0.0], np.cumsum(weight[1:] + weight[:-1])])
    offsets = np.interp(np.linspace(0.0, 1.0, FILTER_CELLS + 1), cdf / cdf[-1], edges)
    return 0.5 * (offsets - offsets[::-1])  # symmetric to the last bit


def pack_camera(scene: Scene) -> dict[str, np.ndarray]:
    """Tables of the camera and of the pixel filter."""
    return {"camera": camera_record(scene.camera, scene), "filter_offsets": filter_inverse_cdf(scene.settings)}


def camera_record(camera: Camera, scene: Scene) -> np.ndarray:
    """(1,) ``CAMERA`` of a camera that sees the frame of ``scene``."""
    record = np.zeros(1, CAMERA)
    left, right, bottom, top = camera.window
    record["matrix"] = np.asarray(camera.matrix, np.float64)[:3, :4]
    record["projection"] = camera.projection
    record["corner"] = left, bottom
    record["step"] = (right - left) / scene.width, (top - bottom) / scene.height
    record["columns"], record["rows"] = scene.width, scene.height
    record["clip"] = camera.clip
    for name in ("aperture", "focus", "blades", "blade_rotation", "blade_ratio", "lens"):
        record[name] = getattr(camera, name)
    record["edge"] = min(0.5 * camera.field, NONE)
    record["convergence"], record["merge"] = NONE, NONE
    if camera.eye is not None:
        record["eye"], record["convergence"] = camera.eye.offset, min(camera.eye.convergence, NONE)
        if camera.eye.merge is not None:
            record["merge"] = camera.eye.merge
    return record


def camera_scalars(scene: Scene) -> dict[str, float]:
    """Scalars of the block. ``camera_pixel_angle`` is the angle in radians that a pixel spans in the middle of the
    frame. It is 0 if rays are parallel; their pixels are ``camera_pixel_width`` metres wide."""
    camera = scene.camera
    left, right, _, _ = camera.window
    # Angle of one unit of the window there.
    angle = {
        Projection.ORTHOGRAPHIC: 0.0,
        Projection.FISHEYE_EQUISOLID: 2.0,
        Projection.MIRROR_BALL: 2.0,
        Projection.FISHEYE_POLYNOMIAL: abs(camera.lens[1]),
    }.get(camera.projection, 1.0)
    size = abs(right - left) / scene.width
    return {
        "camera_aperture": camera.aperture,
        "camera_pixel_angle": angle * size,
        "camera_pixel_width": size if camera.projection is Projection.ORTHOGRAPHIC else 0.0,
    }


@kernel
def filter_offset_1d(offsets, u):
    """Offset along an axis, in pixels, by the inverse of the filter's distribution function."""
    position = u * (len(offsets) - 1)
    cell = min(int(position), len(offsets) - 2)
    return offsets[cell] + (position - cell) * (offsets[cell + 1] - offsets[cell])


@kernel
def filter_offset(block, u1, u2):
    """Offset (pixels) from a pixel's centre, distributed as the pixel filter. So every sample has the same weight and
    none belongs to two pixels (Ernst, Stamminger and Greiner 2006, "Filter importance sampling")."""
    offsets = filter_table(block)
    return filter_offset_1d(offsets, u1), filter_offset_1d(offsets, u2)


@kernel
def sample_blades(blades, rotation, u1, u2):
    """Uniform point of the regular polygon in the unit circle; ``rotation`` is the angle of the middle of a side."""
    position = u1 * blades
    blade = min(int(position), blades - 1)
    across = 2.0 * (position - blade) - 1.0
    half = math.pi / blades
    outward = math.sqrt(u2)
    x, y = outward * math.cos(half), outward * across * math.sin(half)
    angle = rotation + 2.0 * half * blade
    c, s = math.cos(angle), math.sin(angle)
    return c * x - s * y, s * x + c * y


@kernel
def sample_lens(camera, u1, u2):
    """Point of the lens in metres. A ratio above 1 narrows it along x."""
    if camera.blades < 3:
        x, y = disk_point(u1, u2)
    else:
        x, y = sample_blades(camera.blades, camera.blade_rotation, u1, u2)
    return camera.aperture * x / camera.blade_ratio, camera.aperture * y


@kernel
def _lens_axes(direction):
    """Local axes of the lens: those of the camera; but the lens of a panorama faces each ray."""
    x = normalize((-direction[2], 0.0, direction[0]))
    if x[0] == 0.0 and x[2] == 0.0:
        x = (1.0, 0.0, 0.0)
    y = (
        x[1] * direction[2] - x[2] * direction[1],
        x[2] * direction[0] - x[0] * direction[2],
        x[0] * direction[1] - x[1] * direction[0],
    )
    return x, y


@kernel
def _off_axis(x, y, angle):
    """Unit direction at an angle from the viewing axis, towards (x, y)."""
    radius = math.sqrt(x * x + y * y)
    if radius <= 0.0:
        return (0.0, 0.0, -math.cos(angle))
    across = math.sin(angle) / radius
    return (across * x, across * y, -math.cos(angle))


@kernel
def panorama_direction(camera, x, y):
    """Unit direction of a panorama at the point (x, y) of its window; (0, 0, 0) outside the picture."""
    kind = camera.projection
    if kind == EQUIRECTANGULAR:
        return (math.cos(y) * math.sin(x), math.sin(y), -math.cos(y) * math.cos(x))
    if kind == CYLINDER:
        return normalize((math.sin(x), y, -math.cos(x)))
    if kind == CUBEMAP_FACE:
        return normalize((math.tan(x), math.tan(y), -1.0))
    radius = math.sqrt(x * x + y * y)
    if kind == FISHEYE_POLYNOMIAL:
        k = camera.lens
        angle = -(k[0] + radius * (k[1] + radius * (k[2] + radius * (k[3] + radius * k[4]))))
        return _off_axis(x, y, angle) if abs(angle) <= camera.edge else (0.0, 0.0, 0.0)
    if kind == FISHEYE_EQUIDISTANT:
        angle = radius
    else:
        angle = 2.0 * math.asin(min(radius, 1.0))
        if radius > 1.0:
            return (0.0, 0.0, 0.0)
        if kind == MIRROR_BALL:
            return _off_axis(x, y, angle)
    return _off_axis(x, y, angle) if angle <= camera.edge else (0.0, 0.0, 0.0)


@kernel
def panorama_place(camera, x, y, z):
    """Point of the window at which a panorama shows a point of camera space, whose z points into the picture."""
    kind = camera.projection
    across = math.sqrt(x * x + z * z)
    if kind == EQUIRECTANGULAR:
        return math.atan2(x, z), math.atan2(y, across)
    if kind == CYLINDER:
        return math.atan2(x, z), y / across if across > 0.0 else 0.0
    if kind == CUBEMAP_FACE:
        return math.atan2(x, z), math.atan2(y, z)
    off = math.sqrt(x * x + y * y)
    if off <= 0.0:
        return 0.0, 0.0
    angle = math.atan2(off, z)
    if kind == FISHEYE_EQUIDISTANT:
        radius = angle
    elif kind == FISHEYE_POLYNOMIAL:
        radius = _radius_of(camera.lens, -angle)
    else:
        radius = math.sin(0.5 * angle)
    return radius * x / off, radius * y / off


@kernel
def _radius_of(k, value):
    """Argument at which the polynomial of a lens has a value, by Newton's method."""
    radius = (value - k[0]) / k[1] if k[1] != 0.0 else 0.0
    for _ in range(20):
        slope = k[1] + radius * (2.0 * k[2] + radius * (3.0 * k[3] + radius * 4.0 * k[4]))
        if slope == 0.0:
            break
        step = (value - (k[0] + radius * (k[1] + radius * (k[2] + radius * (k[3] + radius * k[4]))))) / slope
        radius += step
        if abs(step) < 1e-9:
            break
    return radius


@kernel
def _from_an_eye(camera, origin, direction):
    """The ray (origin, unit direction) of a panorama for an eye beside the camera, for any viewing direction."""
    offset = camera.eye
    above = abs(math.asin(min(max(direction[1], -1.0), 1.0)))
    if above > camera.merge[1]:
        offset = 0.0
    elif above > camera.merge[0]:
        offset *= math.cos(0.5 * math.pi * (above - camera.merge[0]) / (camera.merge[1] - camera.merge[0]))
    side = scale(normalize(cross(direction, (0.0, 1.0, 0.0))), offset)
    if camera.convergence < NONE:
        direction = normalize(sub(scale(direction, camera.convergence), side))
    return madd(origin, 1.0, side), direction


@kernel(forceinline=True)  # results returned through memory are slow to read
def camera_ray(block, px, py, u1, u2):
    """Ray through the point (px, py) of the frame, in pixels from the lower left corner of the whole frame.

    (u1, u2) choose the point of the lens. Returns (origin, unit direction, t_min, t_max) in world space. Clipping is
    along the viewing axis; for panoramas by radius. A plane at ``focus`` along the axis is in focus; for panoramas a
    sphere. t_max is negative if a panorama shows nothing.
    """
    camera = camera_table(block)[0]
    sx = camera.corner[0] + camera.step[0] * px
    sy = camera.corner[1] + camera.step[1] * py
    origin, lens_x, lens_y = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    if camera.projection == PERSPECTIVE:
        direction = (sx, sy, -1.0)
    elif camera.projection == ORTHOGRAPHIC:
        origin, direction = (sx, sy, 0.0), (0.0, 0.0, -1.0)
    else:
        direction = panorama_direction(camera, sx, sy)
        if direction[0] == 0.0 and direction[1] == 0.0 and direction[2] == 0.0:
            return transform_point(camera.matrix, origin), transform_vector(camera.matrix, (0.0, 0.0, -1.0)), 0.0, -1.0
        lens_x, lens_y = _lens_axes(direction)
    if camera.aperture > 0.0:
        focused = madd(origin, camera.focus, direction)
        x, y = sample_lens(camera, u1, u2)
        origin = madd(madd(origin, x, lens_x), y, lens_y)
        direction = scale(sub(focused, origin), 1.0 / camera.focus)
    along = 1.0
    if camera.projection >= FIRST_PANORAMA:
        if camera.eye != 0.0:
            origin, direction = _from_an_eye(camera, origin, normalize(direction))
    else:
        # Here direction has z = −1, so its length is the distance along the ray per metre along the axis.
        along = math.sqrt(direction[0] ** 2 + direction[1] ** 2 + direction[2] ** 2)
    return (
        transform_point(camera.matrix, origin),
        transform_vector(camera.matrix, normalize(direction)),
        camera.clip[0] * along,
        camera.clip[1] * along,
    )


@kernel
def view_depth(block, position):
    """Depth (metres) of a world position as in Blender's Depth pass: along the viewing axis; for panoramas the distance
    from the camera. ``Camera.matrix`` is rigid, so its transpose inverts its rotation."""
    camera = camera_table(block)[0]
    m = camera.matrix
    offset = (position[0] - m[0, 3], position[1] - m[1, 3], position[2] - m[2, 3])
    if camera.projection >= FIRST_PANORAMA:
        return math.sqrt(offset[0] ** 2 + offset[1] ** 2 + offset[2] ** 2)
    return -(m[0, 2] * offset[0] + m[1, 2] * offset[1] + m[2, 2] * offset[2])


@kernel
def pixel_through_lens(camera, position, u1, u2):
    """Pixel (x, y), as in ``pixel_of``, at which a perspective or orthographic camera shows a position by the point
    (u1, u2) of its lens."""
    x, y = pixel_of(camera, position, False)
    if camera.aperture <= 0.0:
        return x, y
    m = camera.matrix
    offset = (position[0] - m[0, 3], position[1] - m[1, 3], position[2] - m[2, 3])
    depth = -(m[0, 2] * offset[0] + m[1, 2] * offset[1] + m[2, 2] * offset[2])
    # The line from the lens to the position crosses the plane in focus beside the line from the middle of the lens.
    shift = 1.0 / camera.focus - 1.0 / depth if camera.projection == PERSPECTIVE else depth / camera.focus - 1.0
    lens_x, lens_y = sample_lens(camera, u1, u2)
    return x + shift * lens_x / camera.step[0], y + shift * lens_y / camera.step[1]


@kernel
def pixel_of(camera, position, distant):
    """Pixel (x, y) from the lower left corner of the whole frame at which a camera shows a position; for an infinitely
    ``distant`` object, the position is its direction."""
    m, away = camera.matrix, 0.0 if distant else 1.0
    offset = (position[0] - away * m[0, 3], position[1] - away * m[1, 3], position[2] - away * m[2, 3])
    x = m[0, 0] * offset[0] + m[1, 0] * offset[1] + m[2, 0] * offset[2]
    y = m[0, 1] * offset[0] + m[1, 1] * offset[1] + m[2, 1] * offset[2]
    z = -(m[0, 2] * offset[0] + m[1, 2] * offset[1] + m[2, 2] * offset[2])
    if camera.projection == PERSPECTIVE:
        x, y = (x / z, y / z) if z != 0.0 else (0.0, 0.0)
    elif camera.projection >= FIRST_PANORAMA:
        x, y = panorama_place(camera, x, y, z)
    return (x - camera.corner[0]) / camera.step[0], (y - camera.corner[1]) / camera.step[1]
