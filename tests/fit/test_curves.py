"""Sweeps are fitted: parameters come back with honest errors, alone and beside traces; jumps are predicted."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Sweep
from ident.campaign.sweeps.jump import jump_of
from ident.campaign.sweeps.settled import settled
from ident.effects.registry import built_in
from ident.fit import fit
from ident.fit.linear.curve_guess import guess_curves
from ident.model import Model

FREQUENCY, QUALITY, GAIN, CUBIC = 40.0, 50.0, 100.0, 3e6
VOLT, METRE = Channel("V", 1.0), Channel("m", 1.0)


def closed_form(level: float, frequency: np.ndarray, up: bool, cubic: float) -> np.ndarray:
    """Complex response of a Duffing oscillator to first order, the branch as the sweep meets it."""
    omega, own = 2 * np.pi * frequency, 2 * np.pi * FREQUENCY
    found, before = [], 0.0
    for w in omega if up else omega[::-1]:
        shift, loss = own**2 - w**2, (w * own / QUALITY) ** 2
        roots = np.roots([(0.75 * cubic) ** 2, 1.5 * cubic * shift, shift**2 + loss, -((GAIN * level) ** 2)])
        if cubic == 0:
            roots = np.array([(GAIN * level) ** 2 / (shift**2 + loss)])
        real = np.sqrt(np.real(roots[(np.abs(roots.imag) < 1e-9 * np.abs(roots)) & (roots.real > 0)]))
        nearest = np.argmin(np.abs(real - before)) if found else np.argmin(real)
        before = float(real[nearest])
        found.append(before * np.exp(-1j * np.angle(shift + 0.75 * cubic * before**2 + 1j * w * own / QUALITY)))
    return np.array(found if up else found[::-1])


def sweep(level: float, cubic: float, phase: bool, seed: int = 0, sigma: float = 2e-5) -> Sweep:
    frequency = np.linspace(38.0, 43.5, 56)
    both = [closed_form(level, frequency, up, cubic) for up in (True, False)]
    rng = np.random.default_rng(seed)
    answer = np.concatenate(both)
    answer = answer + sigma * (rng.normal(size=len(answer)) + 1j * rng.normal(size=len(answer)))
    up = np.repeat([True, False], len(frequency))
    twice = np.tile(frequency, 2)
    turn, levels = np.angle(answer) if phase else None, np.full(len(twice), level)
    return Sweep(f"{level} V", twice, levels, np.abs(answer), turn, up,
                 "fundamental", VOLT, METRE, NoiseFloor(sigma))  # fmt: skip


@pytest.mark.parametrize("phase", [False, True])
def test_the_linear_guess_is_read_off_the_curves(phase: bool) -> None:
    found = guess_curves([sweep(0.3, 0.0, phase)])
    assert found.frequency == pytest.approx(FREQUENCY, rel=1e-3)
    assert found.quality == pytest.approx(QUALITY, rel=0.02)
    assert found.gain == pytest.approx(GAIN, rel=0.02)


@pytest.mark.parametrize("phase", [False, True])
def test_a_bistable_sweep_gives_its_parameters_back(phase: bool) -> None:
    device = Oscillator()
    model = Model(device) + built_in()["cubic-stiffness"](device)
    # First-order theory is off the true curve by (k A²/ω0²)², a few 1e-3 here: the noise is larger than that.
    campaign = Campaign("", (sweep(0.5, CUBIC, phase, 1, 3e-4),), device)
    found = fit(model, campaign)
    assert found.converged
    assert found.fitted.error_over_noise < 1.15
    for estimate, truth in zip(found.estimates[:4], (FREQUENCY, QUALITY, GAIN, CUBIC), strict=True):
        assert estimate.standard_error is not None
        assert abs(estimate.value - truth) < 4 * estimate.standard_error + 0.01 * truth
    up, down = found.curves[0].runs
    assert up.jump is not None and down.jump is not None
    for run in (up, down):
        assert run.jump is not None and run.jump.measured is not None and run.jump.model is not None
        assert run.jump.model == pytest.approx(run.jump.measured, abs=0.15)
    assert np.count_nonzero(found.curves[0].apart) <= 3
    assert not found.curves[0].backwards


@pytest.mark.parametrize("up", [True, False])
def test_the_only_sweep_of_a_level_called_by_the_wrong_direction_is_told_by_its_jump(up: bool) -> None:
    device = Oscillator()
    model = Model(device) + built_in()["cubic-stiffness"](device)
    both = sweep(0.8, CUBIC, False, 3, 3e-4)
    rows = np.flatnonzero(both.up == up)
    once = {name: getattr(both, name)[rows] for name in ("frequency", "level", "amplitude")}
    words = []
    for called in (up, not up):
        one = replace(both, **once, up=np.full(len(rows), called))
        found = fit(model, Campaign("", (one,), device))
        assert found.fitted.error_over_noise < 1.3  # whatever the sweep is called
        words.append([f"{run.level:g} {'up' if run.up else 'down'}" for run in found.curves[0].backwards])
    assert words == [[], [f"0.8 {'down' if up else 'up'}"]]


def stepped(level: float, cubic: float, periods: int, seed: int, sigma: float) -> Sweep:
    """A sweep whose motion is integrated through (Runge-Kutta of order 4), each frequency held for so many periods:
    beside the jumps it has not settled."""
    frequency, own, steps = np.linspace(38.0, 43.5, 56), 2 * math.pi * FREQUENCY, 48
    push = [GAIN * level * math.cos(math.pi / steps * k) for k in range(2 * steps + 1)]
    lock_in = 2 / steps * np.exp(-2j * np.pi / steps * np.arange(steps))
    both, found, z, v = np.concatenate([frequency, frequency[::-1]]), [], 0.0, 0.0

    def rate(z: float, v: float, u: float) -> float:
        return u - own / QUALITY * v - (own**2 + cubic * z * z) * z

    for f in both.tolist():
        h = 1 / (steps * f)
        for _ in range(periods):
            passed = []
            for k in range(0, 2 * steps, 2):
                passed.append(z)
                a = rate(z, v, push[k])
                b = rate(z + h / 2 * v, v + h / 2 * a, push[k + 1])
                c = rate(z + h / 2 * v + h * h / 4 * a, v + h / 2 * b, push[k + 1])
                d = rate(z + h * v + h * h / 2 * b, v + h * c, push[k + 2])
                z, v = z + h * v + h * h / 6 * (a + b + c), v + h / 6 * (a + 2 * b + 2 * c + d)
        found.append(lock_in @ np.array(passed))
    rng = np.random.default_rng(seed)
    answer = np.array(found) + sigma * (rng.normal(size=len(both)) + 1j * rng.normal(size=len(both)))
    up, levels = np.repeat([True, False], len(frequency)), np.full(len(both), level)
    return Sweep(f"{level} V", both, levels, np.abs(answer), np.angle(answer), up,
                 "fundamental", VOLT, METRE, NoiseFloor(sigma))  # fmt: skip


def test_points_that_had_not_settled_beside_a_jump_do_not_bend_the_fit() -> None:
    device = Oscillator()
    model = Model(device) + built_in()["cubic-stiffness"](device)
    fast = stepped(0.8, CUBIC, 100, 1, 3e-4)  # twice the quality factor: six times the ring-up
    still = settled(fast)
    assert 4 <= np.count_nonzero(~still) <= 8  # two jumps
    found = fit(model, Campaign("", (fast,), device))
    assert found.fitted.error_over_noise < 1.1
    for name, true in (
        ("oscillator.frequency", FREQUENCY),
        ("oscillator.quality", QUALITY),
        ("cubic-stiffness.k3", CUBIC),
    ):
        one = found[name]
        assert one.error is not None and abs(one.value - true) < 4 * one.error, name
    reading = found.curves[0]
    off = np.abs(fast.amplitude - reading.reading) / fast.deviation
    assert np.max(off[~still]) > 20  # they would have
    assert np.all(np.isnan(reading.residual[~still])) and np.all(np.isfinite(reading.residual[still]))


def test_points_that_creep_where_a_curve_is_about_to_fold_do_not_bend_the_fit() -> None:
    device = Oscillator()
    model = Model(device) + built_in()["cubic-stiffness"](device)
    fast = stepped(0.36, CUBIC, 100, 1, 3e-4)
    assert all(jump_of(fast, run.rows) is None for run in fast.runs)
    still = settled(fast)
    assert 2 <= np.count_nonzero(~still) <= 4
    up, down = (part_of(fast, fast.up == way) for way in (True, False))
    for one, other in ((up, down), (down, up)):
        np.testing.assert_array_equal(settled(one, [up, down]), still[fast.up == one.up[0]])  # each in its own file
        assert settled(one).all() and settled(one, [replace(other, load=1.0)]).all()
    found = fit(model, Campaign("", (fast,), device))
    assert found.fitted.error_over_noise < 1.15
    off = np.abs(fast.amplitude - found.curves[0].reading) / fast.deviation
    assert np.max(off[~still]) > 8  # they would have


def part_of(sweep: Sweep, rows: np.ndarray) -> Sweep:
    assert sweep.phase is not None
    return replace(sweep, frequency=sweep.frequency[rows], level=sweep.level[rows], up=sweep.up[rows],
                   amplitude=sweep.amplitude[rows], phase=sweep.phase[rows])  # fmt: skip


def test_a_fit_from_a_motion_without_bound_ends() -> None:
    """LAPACK does not come back from a step that is no number."""
    device = Oscillator()
    model = Model(device) + built_in()["cubic-stiffness"](device)
    campaign = Campaign("", (sweep(0.5, CUBIC, False, 2, 3e-4),), device)
    near, far = (np.array([FREQUENCY, QUALITY, GAIN, cubic, 0.0]) for cubic in (0.3 * CUBIC, -30 * CUBIC))
    assert np.all(np.isfinite(fit(model, campaign, initial=far).values))
    assert fit(model, campaign, initial=[far, near]).fitted.error_over_noise < 1.2


def test_a_fit_that_starts_with_its_jump_elsewhere_finds_back() -> None:
    device = Oscillator()
    model = Model(device) + built_in()["cubic-stiffness"](device)
    campaign = Campaign("", (sweep(0.5, CUBIC, False, 2, 3e-4),), device)
    for cubic in (0.3 * CUBIC, 3 * CUBIC):
        found = fit(model, campaign, initial=np.array([FREQUENCY * 1.01, QUALITY * 0.7, GAIN * 1.2, cubic, 0.0]))
        bent = found["cubic-stiffness.k3"]
        assert bent.error is not None and bent.error < 0.05 * CUBIC and abs(bent.value - CUBIC) < 3 * bent.error
