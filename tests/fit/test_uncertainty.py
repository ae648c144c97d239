"""Covariance against Monte Carlo, and what the data do not determine."""

import numpy as np
from scipy import signal

from ident.campaign.record import NoiseFloor
from ident.fit.uncertainty import Linearisation, _spread, covariance


def test_coloured_noise_widens_the_error_bars_as_monte_carlo_says():
    rng = np.random.default_rng(3)
    n, phi = 600, 0.8
    design = np.stack([np.ones(n), np.sin(np.arange(n) / 9.0)], axis=1)
    noise = NoiseFloor(1.0, (phi,))
    linear = Linearisation(design, np.zeros(n), _spread(design, noise))
    predicted = np.sqrt(np.diag(covariance(linear, np.zeros(2)).matrix))
    white = rng.normal(size=(3000, n + 200)) * np.sqrt(1 - phi**2)
    drawn = signal.lfilter([1.0], [1.0, -phi], white, axis=1)[:, 200:]
    estimates = drawn @ np.linalg.pinv(design).T
    np.testing.assert_allclose(predicted, estimates.std(axis=0), rtol=0.06)


def test_a_direction_without_information_is_left_out():
    rng = np.random.default_rng(1)
    column = rng.normal(size=(200, 1))
    design = np.concatenate([column, 2 * column, rng.normal(size=(200, 1))], axis=1)
    found = covariance(Linearisation(design, np.zeros(200), design.T @ design), np.zeros(3))
    assert found.null.shape == (3, 1)
    assert abs(found.null[2, 0]) < 1e-9
    assert np.isfinite(found.matrix).all()


def test_a_prior_determines_what_the_data_leave_open():
    column = np.ones((50, 1))
    design = np.concatenate([column, column], axis=1)
    linear = Linearisation(design, np.zeros(50), design.T @ design)
    found = covariance(linear, np.array([0.0, 10.0]))
    assert found.null.shape == (2, 0)
    np.testing.assert_allclose(found.matrix[1, 1], 0.01, rtol=1e-6)
