"""A mode of a decay that a bent line hid, asked for beside the effect that bends it."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.search.discover import walk_on
from ident.diagnosis.search.fewer_modes import without_its_mode
from ident.diagnosis.search.further_mode import with_its_mode
from ident.diagnosis.search.steps import Walked
from ident.effects.library.cubic_stiffness import CubicStiffness
from ident.effects.library.power_law_stiffness import PowerLawStiffness
from ident.effects.library.quadratic_damping import QuadraticDamping
from ident.effects.library.quadratic_stiffness import QuadraticStiffness
from ident.effects.library.second_mode import SecondMode
from ident.fit import fit
from ident.model import Model

ONE, F, STEP, NOISE = Channel("V", 1.0), 23.0, 1 / 1400.0, 0.005


def decays(second: float) -> Campaign:
    """Two decays with drag, and with a second mode of some size relative to the first."""
    w, t, rng, records = 2 * np.pi * F, STEP * np.arange(2500), np.random.default_rng(8), []
    for size in (1.0, 0.5):
        rates = lambda _, y: (y[1], -w * w * y[0] - w / 120 * y[1] - 0.02 * abs(y[1]) * y[1])
        z = solve_ivp(rates, (0, t[-1]), (size, 0.0), "DOP853", t, rtol=1e-9, atol=1e-12).y[0]
        z = z + second * size * np.exp(-np.pi * 144 / 90 * t) * np.cos(2 * np.pi * 144 * t + size)
        noisy = z + NOISE * rng.standard_normal(len(t))
        records.append(Trace(f"{size}", t, 0 * t, noisy, ONE, ONE, NoiseFloor(NOISE), "unknown"))
    return Campaign("beam", tuple(records), Oscillator("V", "V"))


def test_it_is_found_beside_the_effect_that_hid_it():
    campaign = decays(0.05)
    found = fit(Model(campaign.device) + QuadraticDamping(), campaign)
    more, _ = with_its_mode(found, prepare(found), lambda _: None)
    assert more.model.names == ("quadratic-damping", "second-mode")
    assert abs(more.fitted.error_over_noise - 1) < 0.05 < found.fitted.error_over_noise - 1
    assert abs(more["second-mode.period"].value * 144 - 1) < 0.01


def test_noise_is_no_mode():
    campaign = decays(0.0)
    found = fit(Model(campaign.device) + QuadraticDamping(), campaign)
    assert with_its_mode(found, prepare(found), lambda _: None)[0] is found


def test_a_line_that_moves_is_no_mode_wherever_a_search_for_one_begins():
    """A pendulum in air, whose softening is in the model and whose drag is not."""
    w, t, rng, records = 2 * np.pi * 0.9, np.arange(2400) / 60.0, np.random.default_rng(9), []
    for size in (50.0, 25.0):
        rates = lambda _, y: (y[1], -w * w * np.sin(y[0]) - 0.02 * y[1] - 0.03 * abs(y[1]) * y[1])
        z = solve_ivp(rates, (0, t[-1]), (np.radians(size), 0.0), "DOP853", t, rtol=1e-9, atol=1e-12).y[0]
        noisy = z + 1.4e-3 * rng.standard_normal(len(t))
        records.append(Trace(f"{size}", t, 0 * t, noisy, ONE, ONE, NoiseFloor(1.4e-3), "unknown"))
    campaign = Campaign("pendulum", tuple(records), Oscillator("rad", "V"))
    found = fit(Model(campaign.device) + PowerLawStiffness(), campaign)
    assert found.fitted.error_over_noise > 3
    assert with_its_mode(found, prepare(found), lambda _: None)[0] is found


def magnet() -> Campaign:
    """Decays of a blade whose spring bends to both sides and to one, read as accelerations of SI size."""
    w, t, records = 2 * np.pi * F, STEP * np.arange(2500), []
    bent = lambda z: w * w * (z - 35.0 * z**2 + 1e4 * z**3)
    rates = lambda _, y: (y[1], -bent(y[0]) - w / 130 * y[1])
    for k, size in enumerate((2.6e-3, 1.3e-3, 2.0e-3)):
        z, v = solve_ivp(rates, (0, t[-1]), (size, 0.0), "DOP853", t, rtol=1e-10, atol=1e-13).y
        read = -bent(z) - w / 130 * v
        noise = 3e-3 * np.std(read)
        noisy = read + noise * np.random.default_rng(k).standard_normal(len(t))
        records.append(Trace(f"{k}", t, 0 * t, noisy, ONE, ONE, NoiseFloor(noise), "unknown", measures="acceleration"))
    return Campaign("blade", tuple(records), Oscillator("m", "V"))


def test_the_overtone_of_a_law_is_no_mode():
    """At twice the frequency the even part of a spring rang longest of all that its odd part left, and became a mode
    that nothing questioned; the law then found only refined its shape."""
    campaign = magnet()
    start = fit(Model(campaign.device), campaign)
    library = {one.name: one for one in (CubicStiffness, QuadraticStiffness, SecondMode, QuadraticDamping)}
    steps = walk_on(Walked(start), library).walked.steps
    assert [(step.added, step.role) for step in steps] == [
        ("cubic-stiffness", "effect"), ("quadratic-stiffness", "effect")
    ]  # fmt: skip
    assert steps[-1].fit.model.names == ("cubic-stiffness", "quadratic-stiffness")
    assert abs(steps[-1].fit.fitted.error_over_noise - 1) < 0.05


def test_a_mode_that_joined_a_walk_is_questioned_beside_what_comes_later():
    campaign = magnet()
    start = fit(Model(campaign.device), campaign)
    whole = fit(Model(campaign.device) + CubicStiffness() + SecondMode() + QuadraticStiffness(), campaign)
    found = without_its_mode(whole, start, ["cubic-stiffness", "quadratic-stiffness"], prepare(start), lambda _: None)
    assert found is not None and found[0].model.names == ("cubic-stiffness", "quadratic-stiffness")
    two = decays(0.05)
    start = fit(Model(two.device), two)
    whole = fit(Model(two.device) + QuadraticDamping() + SecondMode(), two)
    assert without_its_mode(whole, start, ["quadratic-damping"], prepare(start), lambda _: None) is None
