# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""SDF Lights: a Blender extension whose render engine samples signed distance functions as lights.

Nothing is imported at module level: the folder is also the root of the repository, and pytest imports a root
``__init__`` before any test; Blender's own modules may be missing there.
"""


def register():
    from .sdf_lights import blender

    blender.register()


def unregister():
    from .sdf_lights import blender

    blender.unregister()
