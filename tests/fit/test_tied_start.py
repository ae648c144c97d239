"""Samples that are skipped still say where a motion starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.fit import fit
from ident.fit.assemble import assemble
from ident.model import Model
from ident.response import lay_out

ONE, STEP, SIGMA = Channel("V", 1.0), 1e-3, 1e-3
OMEGA = 2 * np.pi * 40


def record(skip: int, cubic: float = 0.0) -> Trace:
    """A multisine answered by a sharp oscillator with a cubic spring, cut from a longer one; rms about 1."""
    rng = np.random.default_rng(2)
    phases = rng.uniform(0, 2 * np.pi, 30)
    drive = lambda t: sum(np.sin(2 * np.pi * (5 + 3 * k) * t + p) for k, p in enumerate(phases))
    pull = lambda t, y: [y[1], OMEGA**2 * (0.05 * drive(t) - y[0] - cubic * y[0] ** 3) - OMEGA / 200 * y[1]]
    t = STEP * np.arange(1500)
    found = solve_ivp(pull, (-0.6, t[-1]), [0.0, 0.0], t_eval=t, rtol=1e-8, atol=1e-10).y[0]
    noisy = found + SIGMA * rng.normal(size=len(t))
    return Trace("a.csv", t, drive(t), noisy, ONE, ONE, NoiseFloor(SIGMA), "unknown", skip=skip)


def weights(trace: Trace) -> np.ndarray:
    """What each sample weighs in a fit, in units of 1/σ."""
    model = Model(Oscillator())
    tape = lay_out([trace], 40.0, 20.0, model)
    values = np.array([40.0, 20.0, 1.0])
    return assemble(model, Campaign("a", (trace,), Oscillator()), [trace], tape, values)[1].weight * SIGMA


def test_the_first_of_the_skipped_samples_hold_the_start_and_the_others_weigh_nothing():
    weight = weights(record(200))
    assert np.all(weight[200:] == 1.0)
    assert np.count_nonzero(weight[:200]) == 6  # a quarter of a period
    assert np.all(weight[:6] == 1.0)


def test_records_from_rest_need_no_such_thing():
    assert not np.any(weights(replace(record(200), start="rest"))[:200])


@pytest.mark.parametrize("skip", [0, 300])
def test_a_start_does_not_run_away_where_the_model_lacks_something(skip):
    trace = record(skip, cubic=0.5)
    found = fit(Model(Oscillator()), Campaign("a", (trace,), Oscillator()))
    largest = np.max(np.abs(trace.response))
    assert found.converged and found.fitted.error_over_noise > 5
    assert np.max(np.abs(found.readings[0])) < 2 * largest
