# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The GPU back end: the CPU's kernels, translated to GLSL, in OpenGL 4.3 compute shaders. See ``docs/gpu.md``."""
