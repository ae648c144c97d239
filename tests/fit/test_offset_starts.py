"""A laser that reads its distance: records begin where the stage is, not where the reading is."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from ident.campaign import Campaign, Trace
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor
from ident.fit import fit
from ident.model import build_model
from ident.response import Equation, at_rest

_OMEGA, _QUALITY, _SOFTER, _DISTANCE = 2 * np.pi * 10.0, 20.0, 1e6, 0.05  # rad/s, 1, 1/(m s²), m
_NOISE = 2e-6


def _record(level: float, seed: int) -> Trace:
    """A beam whose spring has a hilltop at −ω²/k2 = −4 mm, in motion when the record begins."""
    rng = np.random.default_rng(seed)
    rates, phases = 2 * np.pi * np.linspace(6.0, 14.0, 17), rng.uniform(0, 2 * np.pi, 17)
    push = lambda t: level * float(np.sin(rates * t + phases).sum())
    law = lambda t, y: (y[1], push(t) - _OMEGA / _QUALITY * y[1] - _OMEGA**2 * y[0] - _SOFTER * y[0] ** 2)
    time = np.arange(800) / 400.0
    z = solve_ivp(law, (0, 2), (5e-4, 0.0), t_eval=time, rtol=1e-9, atol=1e-12).y[0]
    reading = _DISTANCE + z + _NOISE * rng.standard_normal(len(time))
    drive = np.array([push(t) for t in time])
    unit = Channel("m", 1.0)
    return Trace(f"{seed}.csv", time, drive, reading, Channel("m/s^2", 1.0), unit, NoiseFloor(_NOISE), start="unknown")


def test_a_stage_far_from_its_sensor_does_not_begin_beyond_the_hilltop():
    records = (_record(0.05, 1), _record(0.1, 2))
    effects = ("sensor-offset", "quadratic-stiffness")
    campaign = Campaign("test", records, Oscillator("m", "m/s^2"), effects, linear="oscillator")
    model = build_model(campaign)
    true = np.array([_OMEGA / 2 / np.pi, _QUALITY, 1.0, _DISTANCE, _SOFTER, 0.0])
    assert at_rest(Equation(model), true) == _DISTANCE
    found = fit(model, campaign, initial=true)
    assert found.fitted.error_over_noise < 1.1  # a start at 50 mm has no bound, and nothing leads back from there
    assert abs(found.value("quadratic-stiffness.k2") / _SOFTER - 1) < 0.01


def test_a_search_goes_on_from_the_starts_that_it_had_found():
    """A record that begins just before the hilltop, read with noise: what is read off its first samples lies beyond."""
    unit, time = Channel("m", 1.0), np.arange(800) / 400.0
    law = lambda t, y: (y[1], -_OMEGA / _QUALITY * y[1] - _OMEGA**2 * y[0] - _SOFTER * y[0] ** 2)
    z = solve_ivp(law, (0, 2), (-3.9e-3, 0.0), t_eval=time, rtol=1e-9, atol=1e-12).y[0]
    reading = z.copy()
    reading[:5] -= 3e-4
    record = Trace("a.csv", time, np.zeros(800), reading, unit, unit, NoiseFloor(1e-4), start="unknown")
    campaign = Campaign("test", (record,), Oscillator("m", "m/s^2"), ("quadratic-stiffness",), linear="oscillator")
    model = build_model(campaign)
    true = np.array([_OMEGA / 2 / np.pi, _QUALITY, 0.0, _SOFTER, 0.0])
    assert not fit(model, campaign, initial=true).fitted.error_over_noise < 100
    found = fit(model, campaign, initial=true, begun=np.array([[-3.9e-3, 0.0]]))
    assert found.fitted.error_over_noise < 1.0
