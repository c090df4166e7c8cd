#!/bin/sh
# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
#
# Prints the Debian packages of the system libraries that Blender's Python module links to, and, for OpenGL without a
# window, Mesa's.
echo libgl1 libegl1 libgl1-mesa-dri libsm6 libxi6 libxrender1 libxfixes3 libxkbcommon0
