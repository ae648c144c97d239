"""Covariance against Monte Carlo, and what the data do not determine."""

import numpy as np
from scipy import signal

from ident.campaign.record import NoiseFloor
from ident.fit.fit import fit
from ident.fit.uncertainty import Linearisation, _spread, covariance
from ident.model import build_model
from tests.posterior.records import campaign, record


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


def test_a_fit_that_holds_every_parameter_is_a_fit():
    names = ("frequency", "quality", "gain")
    held = {"frequency": 71.3, "quality": 14.0, "gain": 1.9e5, "fixed": names}
    data = campaign(record(1), oscillator=held)
    found = fit(build_model(data, ()), data)
    assert found.free == () and found.covariance.shape == (0, 0) and found.combinations == ()
    assert [found.value(name) for name in names] == [71.3, 14.0, 1.9e5] and found["quality"].error is None
    assert np.all(found.predict(data.traces[0]).error == 0.0)
