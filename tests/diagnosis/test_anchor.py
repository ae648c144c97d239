"""Records that no linear model describes: what is missing is seen from one that it describes alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.integrate import solve_ivp

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.diagnosis.diagnose import diagnose
from ident.diagnosis.linearised.anchor import _alone, prepare_at_best
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.ranking.confirm import confirm
from ident.diagnosis.ranking.score import score
from ident.effects.registry import built_in
from ident.fit import fit
from ident.fit.rebuild import fit_at
from ident.model import Model
from ident.report.diagnosis_view import advice

FREQUENCY, QUALITY, GAP, HARDNESS, SIGMA = 1000.0, 25.0, 0.9, 1.5, 0.005
OMEGA0 = 2 * np.pi * FREQUENCY
GAIN = OMEGA0**2 / QUALITY  # a volt at resonance moves the stage by one
LIBRARY = {name: built_in()[name] for name in ("end-stop", "damping-drift", "cubic-stiffness", "creep", "bouc-wen")}


def record(volts: float, hertz: float, seed: int) -> Trace:
    """A sine from rest, answered by an oscillator with a linear stop on one side (SciPy, tight tolerances)."""
    time = np.arange(1500) / 40e3
    omega = 2 * np.pi * hertz

    def rate(t, y):
        z, v = y
        stop = HARDNESS * OMEGA0**2 * max(z - GAP, 0.0)
        return [v, GAIN * volts * np.sin(omega * t) - OMEGA0 / QUALITY * v - OMEGA0**2 * z - stop]

    found = solve_ivp(rate, (0.0, time[-1]), [0.0, 0.0], "DOP853", time, rtol=1e-9, atol=1e-12, max_step=1e-5)
    response = found.y[0] + SIGMA * np.random.default_rng(seed).normal(size=len(time))
    one = Channel("V", 1.0)
    noise = NoiseFloor(SIGMA, (), "given", 0.0)
    return Trace(f"{volts:g}.csv", time, volts * np.sin(omega * time), response, one, one, noise)


def campaign() -> Campaign:
    sines = ((0.6, 1000.0), (3.0, 1000.0), (6.0, 1060.0))
    return Campaign("stop", tuple(record(*sine, seed) for seed, sine in enumerate(sines)), Oscillator())


def test_a_hard_stop_is_seen_from_the_record_that_does_not_touch_it():
    records = campaign()
    start = fit(Model(records.device), records)
    assert start.fitted.error_over_noise > 10
    assert not prepare(start).credible
    regression = prepare_at_best(start)
    assert regression.credible and regression.instead_of is not None
    assert regression.fit.scores[0].error_over_noise < 1.1  # its own record; the others are far off
    assert regression.fit.fitted.error_over_noise > start.fitted.error_over_noise
    assert (
        regression.best_chi2 == regression.instead_of.fit_chi2 < regression.fit_chi2
    )  # what an effect must leave less than
    best = score(regression, LIBRARY)[0]
    assert best.name == "end-stop"
    assert confirm(regression, LIBRARY["end-stop"], best).gain > 0.999


def bent_sine(volts: float, ratio: float, seed: int) -> Trace:
    """A steady sine beside the resonance of a hardening spring, which climbs by more than its width."""
    hertz, omega = ratio * FREQUENCY, 2 * np.pi * ratio * FREQUENCY
    time = 0.2 + np.arange(800) / 50e3

    def rate(t, y):
        z, v = y
        return [v, 0.2 * OMEGA0**2 * volts * np.sin(omega * t) - OMEGA0 / 18 * v - OMEGA0**2 * (z + 0.03 * z**3)]

    found = solve_ivp(rate, (0.0, time[-1]), [0.0, 0.0], "DOP853", time, rtol=1e-9, atol=1e-12, max_step=1e-5)
    response = found.y[0] + SIGMA * np.random.default_rng(seed).normal(size=len(time))
    one, noise = Channel("V", 1.0), NoiseFloor(SIGMA, (), "given", 0.0)
    drive = volts * np.sin(omega * time)
    return Trace(f"{seed}.csv", time - 0.2, drive, response, one, one, noise, "steady", period=50e3 / hertz)


def test_sines_beside_a_resonance_that_bends_are_seen_from_where_the_equation_of_motion_leads():
    sines = ((1.0, 0.95), (2.0, 0.98), (3.0, 1.0), (2.5, 1.02), (3.0, 0.97))
    records = Campaign("bent", tuple(bent_sine(*s, seed) for seed, s in enumerate(sines)), Oscillator())
    far = 6.4 * FREQUENCY  # where searches ended on other such devices: to a line the sines are a gain
    start = fit_at(Model(records.device), records, np.array([far, 0.5, 1.1 * (2 * np.pi * far) ** 2]))
    regression = prepare_at_best(start)
    assert regression.instead_of is not None and not regression.alone and not regression.instead_of.credible
    best = score(regression, LIBRARY)[0]
    assert best.name == "cubic-stiffness"
    refit = confirm(regression, LIBRARY["cubic-stiffness"], best)
    kept = regression.best_chi2 - refit.chi2  # of a promise that is counted from the best fit, as a refit is
    assert refit.chi2 < 1.1 * regression.n and abs(best.promised(regression) / kept - 1) < 0.01


def test_a_record_that_no_values_describe_either_is_no_place_to_look_from():
    records = replace(campaign(), records=(record(1.6, 1000.0, 0), record(6.0, 1060.0, 1)))
    start = fit(Model(records.device), records)
    alone = _alone(start, start.campaign.fitted[0])
    assert 5 < alone.fitted.error_over_noise < 0.5 * start.fitted.error_over_noise  # bent less, but bent
    assert not prepare_at_best(start).alone


def test_a_record_alone_is_fitted_from_what_it_says_itself():
    records = campaign()
    bent = {"oscillator.frequency": 3.1 * FREQUENCY, "oscillator.quality": 0.5, "oscillator.gain": 0.2 * GAIN}
    joint = fit(Model(records.device, start=tuple(bent.items())), records)
    found = _alone(joint, records.fitted[0])
    assert found.fitted.error_over_noise < 1.1
    assert abs(found.value("oscillator.quality") - QUALITY) < 0.2


def test_the_stop_is_named_and_its_gap_found():
    records = campaign()
    diagnosis = diagnose(fit(Model(records.device), records), LIBRARY)
    assert any("those that describe 0.6.csv alone" in sentence for sentence in advice(diagnosis))
    found = diagnosis.discovery
    assert found.verdict == "identified"
    assert [step.added for step in found.steps] == ["end-stop"]
    assert found.final.fitted.error_over_noise < 1.05
    assert abs(found.final.value("end-stop.gap") - GAP) < 0.01
