"""An effect that acts on curves by the square of its size alone is found, though at zero it has no slope."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator, Platform
from ident.campaign.record import NoiseFloor, Sweep
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.ranking.confirm import accept, confirm
from ident.diagnosis.ranking.score import score
from ident.diagnosis.search.parts import take_apart
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


def bent(level: float, seed: int) -> Sweep:
    """A spring with a force −k z²/(1 + z²/10) beside its linear one, z in units of the resonance at 1 V, by plain
    Runge-Kutta steps."""
    ratio = 1 + np.concatenate([np.linspace(-10, -2.5, 6), np.linspace(-2.2, 3.5, 26), np.linspace(4, 12, 5)]) / 35
    step, periods, count, unit = 2 * np.pi / STEPS, 150, len(ratio), 1e-5

    def rate(phase: float, y: np.ndarray) -> np.ndarray:
        force = level / 35 * np.cos(phase) - y[0] - y[1] / 35 - 0.14 * y[0] ** 2 / (1 + 0.1 * y[0] ** 2)
        return np.stack([y[1], force]) / ratio

    y, total = np.zeros((2, count)), np.zeros(count, complex)
    for k in range(STEPS * periods):
        phase = step * k
        if k >= STEPS * (periods - 1):
            total += y[0] * np.exp(-1j * phase) * 2 / STEPS
        a = rate(phase, y)
        b = rate(phase + step / 2, y + step / 2 * a)
        c = rate(phase + step / 2, y + step / 2 * b)
        y = y + step / 6 * (a + 2 * b + 2 * c + rate(phase + step, y + step * c))
    noise = 2e-3 * np.random.default_rng(seed).standard_normal((2, count))
    return Sweep(f"{level:.3f} V", 500 * ratio, np.full(count, level), unit * np.abs(total) * (1 + noise[0]),
                 np.angle(total) + noise[1], np.ones(count, bool), "fundamental", VOLT, METRE, NoiseFloor(1e-4 * unit),
                 relative_noise=2e-3, phase_noise=2e-3)  # fmt: skip


def swept_bent(device: Oscillator | Platform) -> Campaign:
    levels = (1 / 3, 5 / 9, 7 / 9, 1.0)
    return Campaign("", tuple(bent(level, seed) for seed, level in enumerate(levels)), device)


def test_beside_an_even_force_a_spring_is_refitted_from_either_sign() -> None:
    """A quadratic spring that has taken part of a cubic one's place: the slope there says soften, and from there the
    quadratic one is lost, where it has no slope; twice as large beside a hardening one it fits."""
    campaign = swept_bent(Oscillator(output="m"))
    regression = prepare(fit(Model(campaign.device), campaign))
    quadratic, cubic = (built_in()[name] for name in ("quadratic-stiffness", "cubic-stiffness"))
    (found,) = score(regression, {quadratic.name: quadratic})
    alone = accept(confirm(regression, quadratic, found), regression.fit)
    assert alone.fitted.error_over_noise > 1.3
    beside = prepare(alone)
    (found,) = score(beside, {cubic.name: cubic})
    assert found.values["k3"] < 0
    both = confirm(beside, cubic, found)
    assert both.values[-2] > 0 and both.chi2 < 1.1 * regression.n


def test_a_stress_that_a_bent_spring_may_owe_its_lead_to_is_given_beside_the_spring() -> None:
    campaign = swept_bent(Platform())
    linear = fit(Model(campaign.device), campaign)
    regression = prepare(linear)
    names = ("residual-stress", "quadratic-stiffness", "cubic-stiffness", "power-law-stiffness")
    library = {name: built_in()[name] for name in names}
    (found,) = score(regression, {names[0]: library[names[0]]})
    stress = accept(confirm(regression, library[names[0]], found), linear)
    (parts,) = take_apart(stress, names[:1], library, linear, lambda _: None)
    assert parts.names == ("quadratic-stiffness", "cubic-stiffness") and not parts.better
