# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kinds of cameras, and lenses."""

from __future__ import annotations

import math

from .stage import feature


@feature("Cameras")
def depth_of_field(scene):
    """A wide aperture of five blades."""
    lens = scene.camera.data.dof
    lens.use_dof, lens.aperture_fstop, lens.focus_distance = True, 0.3, 4.0
    lens.aperture_blades, lens.aperture_rotation, lens.aperture_ratio = 5, 0.3, 1.4


@feature("Cameras")
def orthographic(scene):
    """An orthographic camera, shifted."""
    scene.camera.data.type, scene.camera.data.ortho_scale, scene.camera.data.shift_x = "ORTHO", 3.2, 0.05


def _panorama(scene, kind: str, **settings) -> None:
    data = scene.camera.data
    data.type = "PANO"
    owner = data if hasattr(data, "panorama_type") else data.cycles
    owner.panorama_type = kind
    for name, value in settings.items():
        setattr(owner, name, value)
    scene.camera.location = (0.0, -1.4, 1.0)
    scene.camera.rotation_euler = (math.pi / 2, 0.0, 0.3)


@feature("Cameras")
def equirectangular(scene):
    """All directions, as an equirectangular panorama."""
    _panorama(scene, "EQUIRECTANGULAR")


@feature("Cameras")
def fisheye(scene):
    """An equidistant fisheye lens."""
    _panorama(scene, "FISHEYE_EQUIDISTANT", fisheye_fov=3.0)


@feature("Cameras")
def fisheye_equisolid(scene):
    """An equisolid fisheye lens."""
    _panorama(scene, "FISHEYE_EQUISOLID", fisheye_fov=2.6, fisheye_lens=9.0)


@feature("Cameras")
def mirror_ball(scene):
    """A mirror ball."""
    _panorama(scene, "MIRRORBALL")


@feature("Cameras")
def right_eye(scene):
    """The right of two eyes."""
    scene.render.use_multiview = True
    scene.render.views["left"].use = False
    stereo = scene.camera.data.stereo
    stereo.interocular_distance, stereo.convergence_distance = 0.6, 4.0


@feature("Cameras")
def clipping(scene):
    """Clip distances that cut off the balls in front and the wall behind."""
    scene.camera.data.clip_start, scene.camera.data.clip_end = 4.2, 6.0


@feature("Cameras")
def render_region(scene):
    """A part of the picture, as a render region."""
    render = scene.render
    render.use_border = render.use_crop_to_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.25, 0.75
