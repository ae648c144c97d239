"""Which points of a grid are worth a start of a refit beside the best one."""

from __future__ import annotations

from ident.diagnosis.ranking.weigh import _apart, _Point


def test_other_maxima_come_before_neighbours_of_the_best_point() -> None:
    """A further mode far above the band does nearly as well wherever it is: the best five of its grid lay there, and
    the one at 2.3 times the resonance was called crosstalk."""
    drops = [9.0, 9.5, 9.4, 9.3, 9.2, 8.0, 8.8, 7.0]
    points = [_Point(drop, {}, slice(2 * k, 2 * k + 2)) for k, drop in enumerate(drops)]
    others = sorted((p for p in points if p.drop != 9.5), key=lambda p: -p.drop)
    assert [p.drop for p in _apart(others, points, [8], 2)] == [8.8, 9.4, 9.3, 9.2, 9.0, 8.0, 7.0]
    # In two dimensions a neighbour is one along either axis or across.
    assert [p.drop for p in _apart(others, points, [2, 1, 4], 2)][:2] == [9.4, 9.3]


def test_an_effect_of_many_amplitudes_has_no_more_axes_than_shapes() -> None:
    """A table of twenty terms, written from a misfit, took 166 TiB."""
    points = [_Point(drop, {}, slice(20 * k, 20 * k + 20)) for k, drop in enumerate([3.0, 5.0, 4.0])]
    assert [p.drop for p in _apart([points[2], points[0]], points, [*[1] * 20, 3, *[1] * 10], 20)] == [4.0, 3.0]
    assert _apart([], points[:1], [1] * 31, 20) == []
