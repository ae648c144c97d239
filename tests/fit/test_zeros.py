"""Zeros of records' own beside a law that moves the mean: fitted with the model, not read out before it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ident.campaign import Campaign, Trace
from ident.campaign.apart import floating, read_apart
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor
from ident.fit import fit
from ident.fit.problem import Unknowns, evaluate
from ident.fit.rebuild import fit_at
from ident.model import build_model
from ident.posterior.density import make_density

OMEGA, QUALITY, SQUARE = 2 * np.pi * 10.0, 20.0, 2e5  # rad/s, 1, 1/(m s²)
NOISE = 2e-6
ZEROS = (40e-6, -25e-6, 5e-6)


def _record(level: float, zero: float, seed: int, start: str = "rest") -> Trace:
    rng = np.random.default_rng(seed)
    rates, phases = 2 * np.pi * np.linspace(6.0, 14.0, 9), rng.uniform(0, 2 * np.pi, 9)
    push = lambda t: level * float(np.sin(rates * t + phases).sum())
    law = lambda t, y: (y[1], push(t) - OMEGA / QUALITY * y[1] - OMEGA**2 * y[0] - SQUARE * y[0] ** 2)
    time = np.arange(1200) / 400.0
    z = solve_ivp(law, (0, 3), (0.0, 0.0), t_eval=time, rtol=1e-9, atol=1e-12).y[0]
    reading, drive = z + zero + NOISE * rng.standard_normal(len(time)), np.array([push(t) for t in time])
    unit = Channel("m", 1.0)
    return Trace(
        f"{seed}.csv",
        time,
        drive,
        reading,
        Channel("m/s^2", 1.0),
        unit,
        NoiseFloor(NOISE),
        start=start,
        holdout=seed == 3,
    )


@pytest.fixture(scope="module", params=["rest", "unknown"])
def floated(request) -> Campaign:
    records = tuple(_record(0.4, zero, k + 1, request.param) for k, zero in enumerate(ZEROS))
    read = tuple(read_apart(record, "level", (0.0,)) for record in records)
    device = Oscillator("m", "m/s^2")
    return floating(Campaign("test", read, device, ("quadratic-stiffness",), linear="oscillator"))


def test_the_law_keeps_what_it_does_to_the_mean(floated):
    found = fit(build_model(floated), floated)
    assert found.fitted.error_over_noise == pytest.approx(1.0, abs=0.05)
    assert found.holdout is not None and found.holdout.error_over_noise == pytest.approx(1.0, abs=0.07)
    square = found["quadratic-stiffness.k2"]
    assert abs(square.value - SQUARE) < 4 * square.error
    held = replace(floated, records=tuple(replace(record, floats=False) for record in floated.records))
    assert fit(build_model(held), held).fitted.error_over_noise > 3  # what the zeros were there for
    assert found.freedom == fit(build_model(held), held).freedom + 2


def test_derivatives_are_those_of_what_is_left(floated):
    found = fit(build_model(floated), floated)
    static, data, unknowns, there = found.solved
    step = 1e-4
    for k in range(len(unknowns.x)):
        x = unknowns.x.copy()
        x[k] += step
        above = evaluate(static, data, Unknowns(x, unknowns.starts)).residuals
        x[k] -= 2 * step
        below = evaluate(static, data, Unknowns(x, unknowns.starts)).residuals
        np.testing.assert_allclose(
            (above - below) / (2 * step), there.by_x[k], atol=2e-4 * np.max(np.abs(there.by_x[k]))
        )
    for own in data.tape.slices:  # nothing of a constant is left to anybody
        assert abs(np.sum(there.residuals[own])) < 1e-6 * len(there.residuals[own])


def test_a_posterior_knows_of_them(floated):
    """Its density is as wide as the error bars say, and stands where the fit does."""
    found = fit(build_model(floated), floated)
    density = make_density(found)
    linear = density.linearise()
    widths = np.sqrt(np.diag(np.linalg.inv(linear.matrix))) * np.asarray(density.data.scale)
    assert widths[3] == pytest.approx(found["quadratic-stiffness.k2"].error, rel=0.05)
    assert np.max(np.abs(np.linalg.solve(linear.matrix, linear.gradient) * density.data.scale / widths)) < 0.1
    for white in density.innovations(np.zeros((1, density.size))):
        assert np.std(white) == pytest.approx(1.0, abs=0.1)
        assert abs(np.mean(white)) < 0.01


def test_no_record_is_read_by_a_zero_beside_a_motion_without_bound(floated):
    there = fit_at(build_model(floated), floated, np.array([10.0, QUALITY, 1.0, -1e9, 0.0]))
    assert not np.all(np.isfinite(there.readings[0]))
    assert all(np.all(np.isfinite(record.response)) for record in there.campaign.traces)
