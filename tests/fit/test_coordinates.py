"""Bounds are kept by bijections, and uncertainty maps back by their slope."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ident.campaign.device import Oscillator
from ident.effects.library.end_stop import EndStop
from ident.fit.assemble import bounds_of
from ident.fit.coordinates import slopes, to_coordinates, to_values
from ident.model import Model

INF = np.inf
share = st.floats(0.001, 0.999)


@given(st.floats(-1e12, 1e12), st.floats(1e-12, 1e12), st.floats(1e-9, 1e3), st.floats(1.1, 1e4), share)
def test_values_survive_the_round_trip(free, positive, low, ratio, inside):
    values = np.array([free, positive, low * ratio**inside])
    lower, upper = np.array([-INF, 0.0, low]), np.array([INF, INF, low * ratio])
    back = np.asarray(to_values(to_coordinates(values, lower, upper), lower, upper))
    np.testing.assert_allclose(back, values, rtol=1e-9)


@given(st.floats(-50, 50), st.floats(1e-9, 1e3), st.floats(1.1, 1e4))
def test_no_coordinate_leaves_the_range(coordinate, low, ratio):
    value = float(to_values(np.array([coordinate]), np.array([low]), np.array([low * ratio]))[0])
    assert low * (1 - 1e-12) <= value <= low * ratio * (1 + 1e-12)


@given(st.floats(-1, 1), st.floats(1e-3, 1e3), st.floats(10.0, 1e3))
def test_slopes_are_the_derivatives(coordinate, low, ratio):
    lower, upper = np.array([-INF, 0.0, low]), np.array([INF, INF, low * ratio])
    at = np.full(3, coordinate)
    ends = [np.asarray(to_values(at + h, lower, upper)) for h in (-1e-5, 1e-5)]
    expected = (ends[1] - ends[0]) / 2e-5
    np.testing.assert_allclose(slopes(np.asarray(to_values(at, lower, upper)), lower, upper), expected, rtol=1e-5)


def test_a_start_on_a_bound_is_moved_inside():
    lower, upper = np.array([2.0]), np.array([8.0])
    for edge in (2.0, 8.0, 1.0, 100.0):
        assert np.isfinite(to_coordinates(np.array([edge]), lower, upper)).all()


def test_a_value_that_a_fit_left_on_a_limit_does_not_move_it_and_a_users_does():
    parameter = next(p for p in (Model(Oscillator()) + EndStop()).parameters if p.name == "end-stop.gap")
    scales = SimpleNamespace(displacement=1e-5)
    low, high = (limit * scales.displacement for limit in (0.05, 1.0))  # shares of the travel, as its file has them
    assert bounds_of(parameter, low * (1 - 1e-9), scales) == pytest.approx((low, high))
    assert bounds_of(parameter, high * (1 + 1e-9), scales) == pytest.approx((low, high))
    beyond = low / 2
    assert bounds_of(parameter, beyond, scales) == pytest.approx((beyond / 3, high))
