"""How a search ends: where no parameter is worth a step, and near a bound too."""

from __future__ import annotations

import numpy as np

from ident.fit.normal import Normal
from ident.fit.solve import _decrement


def test_towards_a_bound_a_step_promises_no_more_than_it_reaches() -> None:
    """The cost falls by e^c along a logarithm c: an unlimited Newton step promises the same however little is left."""
    promised = []
    for left in (1.0, 1e-2, 1e-4):
        # cost ½ (1 + left)²: its gradient and curvature (Gauss–Newton) by c = ln left; a second parameter is settled
        normal = Normal(np.array(0.5), np.array([left, 0.0]), np.diag([left**2, 1.0]))
        promised.append(_decrement(normal, np.array([1.0, 1.0]), np.array([0.5, np.inf])))
    assert np.all(np.array(promised) <= 0.5 * np.array([1.0, 1e-2, 1e-4]))
    free = Normal(np.array(0.5), np.array([1e-2, 0.0]), np.diag([1e-4, 1.0]))
    assert _decrement(free, np.ones(2), np.full(2, np.inf)) == 0.5  # as the books have it
