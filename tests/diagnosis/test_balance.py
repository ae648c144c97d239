"""The search of amplitudes on curves ends where there is nothing to go by."""

from __future__ import annotations

import numpy as np

from ident.diagnosis.linearised.balance import _searched


def test_a_step_to_where_slopes_have_no_bound_is_the_last():
    """A law may be finite where its derivatives overflow."""

    def at(x):
        slope = 1e200 if x[0] > 0.5 else 1.0
        return np.array([1.0 - x[0], 0.1]), np.array([[slope, 0.0]])

    found = _searched(at, np.zeros(1), np.zeros(1, bool))
    assert 0.5 < found[0] <= 1.01
