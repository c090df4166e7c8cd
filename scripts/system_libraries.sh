#!/bin/sh
# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
#
# Prints the Debian packages of the system libraries that Blender's Python module links to, and, for OpenGL without a
# window, Mesa's. With --tests, those that tests alone need: OpenVDB for Debian's Python, which is Blender's version, and
# the reference compiler for GLSL.
if [ "${1:-}" = --tests ]; then
    echo python3-openvdb glslang-tools
    exit
fi
echo libgl1 libegl1 libgl1-mesa-dri libsm6 libxi6 libxrender1 libxfixes3 libxkbcommon0
