# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Limit of the difference between a node's picture and Cycles'."""

LIMIT = 0.01  # of relative differences, in the mean and the 99th percentile


def over(row: dict) -> bool:
    """Whether a case differs by more than the limit, beyond the uncertainty of its noise."""
    if row["mean_difference"] is None:
        return True
    return (row["mean_difference"] - row["mean_doubt"] > LIMIT) or (row["p99"] - row["p99_doubt"] > LIMIT)
