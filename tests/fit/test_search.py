"""How a search ends: where no parameter is worth a step, and near a bound too; and which of several goes on."""

from __future__ import annotations

from collections import Counter

import numpy as np

from ident.fit.normal import Normal
from ident.fit.race import race
from ident.fit.solve import _decrement
from ident.fit.squares import squares_of


def _both(farthest: list[float]) -> tuple[np.ndarray, np.ndarray]:
    return -np.array(farthest), np.array(farthest)


def test_towards_a_bound_a_step_promises_no_more_than_it_reaches() -> None:
    """The cost falls by e^c along a logarithm c: an unlimited Newton step promises the same however little is left."""
    promised = []
    for left in (1.0, 1e-2, 1e-4):
        # cost ½ (1 + left)²: its gradient and curvature (Gauss–Newton) by c = ln left; a second parameter is settled
        normal = Normal(np.array(0.5), np.array([left, 0.0]), np.diag([left**2, 1.0]))
        promised.append(_decrement(normal, np.array([1.0, 1.0]), *_both([0.5, np.inf])))
    assert np.all(np.array(promised) <= 0.5 * np.array([1.0, 1e-2, 1e-4]))
    free = Normal(np.array(0.5), np.array([1e-2, 0.0]), np.diag([1e-4, 1.0]))
    assert _decrement(free, np.ones(2), *_both([np.inf, np.inf])) == 0.5  # as the books have it


def test_an_unknown_that_may_hardly_move_does_not_hold_back_one_that_may() -> None:
    """Both bend the residuals alike. Along the common directions a step is as short as the first may go, and it
    promised nothing: searches ended at 230 times the cost of their minimum."""
    normal = Normal(np.array(60.0), np.array([0.0, 10.0]), np.array([[1.0, 0.9], [0.9, 1.0]]))
    promised = _decrement(normal, np.ones(2), *_both([1e-9, np.inf]))
    assert np.isclose(promised, 50.0, rtol=1e-6)  # of the second alone, 10²/2


def test_a_step_within_limits_is_the_best_one_and_not_a_long_one_that_is_cut() -> None:
    """Cut to its limit in the first unknown, the free step asks of the second what suits a motion that is not made, and
    makes things worse: searches along a valley were refused every second trial, and crawled."""
    normal = Normal(np.array(0.0), np.array([-1.0, -1.0 + 1e-3]), np.array([[1.0, 0.999], [0.999, 1.0]]))
    squares, reach = squares_of(normal, np.ones(2)), _both([0.1, np.inf])
    whole = squares.best(*_both([np.inf, np.inf]))
    np.testing.assert_allclose(whole, np.linalg.solve(normal.matrix, -normal.gradient), atol=1e-9)
    best = squares.best(*reach)
    assert best[0] == 0.1 and np.isclose(best[1], 0.999 - 0.999 * 0.1)  # what is best for the second, the first given
    far = squares_of(normal._replace(gradient=np.array([-10.0, 9.0])), np.ones(2))
    cut = np.clip(far.best(*_both([np.inf, np.inf])), *reach)
    assert far.fall(cut) < 0 < far.fall(far.best(*reach))


class _Falling:
    """A search whose cost is known at every step."""

    def __init__(self, costs: list[float]):
        self.costs, self.steps = costs, 0

    @property
    def cost(self) -> float:
        return self.costs[min(self.steps, len(self.costs)) - 1]


def test_ever_fewer_starts_go_on() -> None:
    fast, late, lost, worse = (_Falling([9, 5, c, c / 2, c / 4]) for c in (2.0, 3.0, float("inf"), 4.0))
    taken: Counter[int] = Counter()

    def go_on(number: int, one: _Falling, most: int) -> None:
        taken[number] += most - one.steps
        one.steps = most

    race([worse, fast, lost, late], 20, go_on)  # type: ignore[arg-type, list-item]
    assert taken == {1: 3, 3: 3, 4: 6, 2: 20}
