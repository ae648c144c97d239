"""Held-out error that the errors of the parameters explain is no failure of the model."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy import signal

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.fit import Fit, carry_over, fit
from ident.fit.carry_over import expected_error, uncertain_steps
from ident.model import Model
from ident.report.words.sentences import verdict

OMEGA0, QUALITY, GAIN, STEP, SIGMA = 2 * np.pi * 500.0, 60.0, 3e5, 5e-5, 0.1


def trace(hertz: float, samples: int, rng: np.random.Generator, **fields: bool) -> Trace:
    """A sine of one volt from rest, answered by a linear oscillator (SciPy's exact filter of the sampled drive)."""
    fine = np.arange(16 * samples) * STEP / 16
    drive = np.sin(2 * np.pi * hertz * fine)
    _, response, _ = signal.lsim(([GAIN], [1.0, OMEGA0 / QUALITY, OMEGA0**2]), drive, fine)
    noisy = response[::16] + SIGMA * rng.normal(size=samples)
    one, noise = Channel("V", 1.0), NoiseFloor(SIGMA, (), "given", 0.0)
    return Trace(f"{hertz:g}.csv", fine[::16], drive[::16], noisy, one, one, noise, **fields)  # type: ignore[arg-type]


def fitted(seed: int) -> Fit:
    rng = np.random.default_rng(seed)
    records = (trace(450.0, 200, rng), trace(500.0, 800, rng, holdout=True))
    return fit(Model(Oscillator()), Campaign("short", records, Oscillator()))


def test_it_is_what_repeated_experiments_show():
    runs = [fitted(seed) for seed in range(24)]
    expected = np.mean([expected_error(run) ** 2 for run in runs])
    seen = np.mean([run.holdout.error_over_noise**2 for run in runs if run.holdout])
    assert expected > 1.3  # a fifth of a record off resonance predicts the resonance badly
    assert seen - 1 == pytest.approx(expected - 1, rel=0.5)


def test_the_verdict_tells_unsure_parameters_from_a_wrong_model():
    runs = [fitted(seed) for seed in range(6)]
    unsure = max(runs, key=lambda run: run.holdout.error_over_noise if run.holdout else 0.0)
    assert "errors of the parameters" in verdict(unsure)
    held = unsure.campaign.heldout[0]
    other = replace(held, response=2 * held.response)  # of a device that moves twice as much
    wrong = fit(unsure.model, replace(unsure.campaign, records=(*unsure.campaign.fitted, other)))
    assert "does not carry over" in verdict(wrong)


def test_a_motion_without_bound_says_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    record = SimpleNamespace(counted=np.ones(3, bool), noise=SimpleNamespace(sigma=1.0))
    campaign = SimpleNamespace(heldout_sweeps=(), heldout=[record])
    model = SimpleNamespace(parameters=[SimpleNamespace(positive=False)])
    fit: Any = SimpleNamespace(campaign=campaign, covariance=np.eye(1), values=np.ones(1), free=(0,), model=model)
    for size in (1e200, np.inf):
        far = lambda *_, size=size: (np.full(3, size), np.full((3, 1), size), np.zeros((3, 0)))
        monkeypatch.setattr(carry_over, "read_with_slopes", far)
        assert expected_error.__wrapped__(fit) == np.inf


def test_the_squares_of_uncertain_steps_are_the_covariance_whatever_the_units() -> None:
    rng = np.random.default_rng(3)
    units = np.array([1e-3, 2.0, 1e-9, 1e13])
    mixed = rng.normal(size=(4, 4))
    covariance = (mixed @ mixed.T + np.eye(4)) * np.outer(units, units)
    told: Any = SimpleNamespace(covariance=covariance, values=np.zeros(6), free=(0, 1, 3, 5))
    steps = uncertain_steps(told)
    np.testing.assert_allclose(steps[:, [0, 1, 3, 5]].T @ steps[:, [0, 1, 3, 5]], covariance, rtol=1e-10)
    assert not steps[:, [2, 4]].any()
