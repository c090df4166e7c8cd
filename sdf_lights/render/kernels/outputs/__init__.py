# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes that few renders have, separate from the path tracer. A render without them neither runs nor compiles them."""
