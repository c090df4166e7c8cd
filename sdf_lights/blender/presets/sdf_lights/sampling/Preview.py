# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

settings = bpy.context.scene.sdf_lights

settings.samples = 32
settings.noise_threshold = 0.1
settings.min_samples = 16
settings.time_limit = 0.0
settings.guided_samples = True
settings.denoise = True
