"""Which points of a grid are worth a start of a refit beside the best one."""

from __future__ import annotations

import numpy as np

from ident.diagnosis.ranking.score import _apart, _Point


def test_other_maxima_come_before_neighbours_of_the_best_point() -> None:
    """A further mode far above the band does nearly as well wherever it is: the best five of its grid lay there, and
    the one at 2.3 times the resonance was called crosstalk."""
    drops = [9.0, 9.5, 9.4, 9.3, 9.2, 8.0, 8.8, 7.0]
    nothing = np.zeros((0, 0))
    points = [_Point(drop, {}, nothing, nothing, slice(2 * k, 2 * k + 2)) for k, drop in enumerate(drops)]
    others = sorted((p for p in points if p.drop != 9.5), key=lambda p: -p.drop)
    assert [p.drop for p in _apart(others, points, [8], 2)] == [8.8, 9.4, 9.3, 9.2, 9.0, 8.0, 7.0]
    # In two dimensions a neighbour is one along either axis or across.
    assert [p.drop for p in _apart(others, points, [2, 1, 4], 2)][:2] == [9.4, 9.3]
