"""An effect that acts on curves by the square of its size alone is found, though at zero it has no slope."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import NoiseFloor, Sweep
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.ranking.confirm import confirm
from ident.diagnosis.ranking.score import score
from ident.effects.registry import built_in
from ident.fit import fit
from ident.model import Model
from tests.fit.test_curves import FREQUENCY, GAIN, METRE, QUALITY, VOLT, sweep

STEPS, PERIODS, PER_VOLT, SIGMA = 48, 400, 14000.0, 3e-6


def pumped(level: float, seed: int) -> Sweep:
    """An oscillator whose stiffness follows the voltage, all frequencies side by side, by plain Runge-Kutta steps."""
    frequency = np.linspace(38.0, 42.0, 40)
    omega, own, step = 2 * np.pi * frequency, 2 * np.pi * FREQUENCY, 2 * np.pi / STEPS

    def rate(phase: float, y: np.ndarray) -> np.ndarray:
        drive = level * np.cos(phase)
        return np.stack([y[1], GAIN * drive - (own**2 + PER_VOLT * drive) * y[0] - own / QUALITY * y[1]]) / omega

    y, total = np.zeros((2, len(frequency))), np.zeros(len(frequency), complex)
    for k in range(STEPS * PERIODS):
        phase = step * k
        if k >= STEPS * (PERIODS - 1):
            total += y[0] * np.exp(-1j * phase) * 2 / STEPS
        a = rate(phase, y)
        b = rate(phase + step / 2, y + step / 2 * a)
        c = rate(phase + step / 2, y + step / 2 * b)
        y = y + step / 6 * (a + 2 * b + 2 * c + rate(phase + step, y + step * c))
    amplitude = np.abs(total) + SIGMA * np.random.default_rng(seed).standard_normal(len(frequency))
    return Sweep(f"{level} V", frequency, np.full(len(frequency), level), amplitude, None,
                 np.ones(len(frequency), bool), "fundamental", VOLT, METRE, NoiseFloor(SIGMA))  # fmt: skip


def test_a_stiffness_that_follows_the_voltage_is_refitted_from_where_it_acts() -> None:
    """Its other term, with the squared voltage, explains a good part alone and would leave the first one at zero."""
    device = Oscillator(output="m")
    campaign = Campaign("", tuple(pumped(level, seed) for seed, level in enumerate((0.2, 0.35, 0.5))), device)
    linear = fit(Model(device), campaign)
    assert linear.fitted.error_over_noise > 5
    effect, regression = built_in()["voltage-stiffness"], prepare(linear)
    (found,) = score(regression, {effect.name: effect})
    starts = [found.values["per_volt"], *(one["per_volt"] for one in found.near)]
    assert min(map(abs, starts)) > 1e-6 * PER_VOLT, "at zero it has no slope"
    refitted = confirm(regression, effect, found)
    assert refitted.chi2 < 1.3 * regression.n
    values = dict(zip((p.name for p in refitted.model.parameters), refitted.values, strict=True))
    np.testing.assert_allclose(abs(values["voltage-stiffness.per_volt"]), PER_VOLT, rtol=0.1)


def test_a_turn_of_the_drive_that_amplitudes_hardly_show_is_not_refitted_from_zero() -> None:
    """A drive that saturates; that its loss is zero is no place to start from, as amplitudes know its square alone."""
    device = Oscillator(output="m")
    whole = [(level, sweep(level, 0.0, False, k)) for k, level in enumerate((0.2, 0.35, 0.5))]
    less = [replace(one, amplitude=(1 - 0.4 * level**2) * one.amplitude) for level, one in whole]
    regression = prepare(fit(Model(device), Campaign("", tuple(less), device)))
    effect = built_in()["pzt-hysteresis"]
    (found,) = score(regression, {effect.name: effect})
    assert abs(found.values["zeta"]) > 1e-3 * abs(found.values["eta"]) > 0
    assert confirm(regression, effect, found).chi2 < 1.3 * regression.n
