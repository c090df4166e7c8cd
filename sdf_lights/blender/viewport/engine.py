# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The methods of the render engine that viewports call."""

from __future__ import annotations

import traceback

import bpy

from ..guard import sentence
from ..naming import LABEL


class ViewportEngine:
    """Methods of a ``RenderEngine``. No exception leaves them; the viewport shows the error."""

    _rendered = None

    def view_update(self, context, depsgraph):
        try:
            self._view().data_changed(depsgraph)
        except Exception as error:
            self._tell(error)

    def view_draw(self, context, depsgraph):
        try:
            self._view().draw(self, context, depsgraph)
        except Exception as error:
            self._tell(error)

    def _view(self):
        if self._rendered is None:
            from .rendered import RenderedView

            self._rendered = RenderedView()
        return self._rendered

    def _tell(self, error: Exception) -> None:
        if bpy.app.debug or bpy.app.debug_python:
            traceback.print_exc()
        self.update_stats(LABEL, sentence(error))

    def __del__(self):
        try:
            rendered = self._rendered
        except ReferenceError:  # Blender has freed its part
            return
        if rendered is not None:
            rendered.close()
