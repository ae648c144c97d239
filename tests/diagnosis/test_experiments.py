"""What to measure next: proposals keep within the laboratory's means, and the one proposed tells the rivals apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator, Platform
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.diagnosis.next_record.experiments import SEPARATED, NextExperiment, grouped, rank_experiments
from ident.diagnosis.next_record.waveforms import Limits, limits_of, proposals
from ident.effects.library.cubic_damping import CubicDamping
from ident.effects.library.cubic_stiffness import CubicStiffness
from ident.effects.library.drive_lag import DriveLag
from ident.effects.library.quadratic_damping import QuadraticDamping
from ident.effects.library.sensor_lag import SensorLag
from ident.effects.library.sensor_nonlinearity import SensorNonlinearity
from ident.fit import Fit, fit
from ident.fit.reading import read
from ident.model import Model

STEP, F0, NOISE = 1 / 6000.0, 100.0, 0.003
LINEAR = [F0, 20.0, 4e5]


def measured(model: Model, values: list[float], name: str, drive: np.ndarray, seed: int) -> Trace:
    time, channel = STEP * np.arange(len(drive)), Channel("V", 1.0)
    blank = Trace(name, time, drive, np.ones(len(drive)), channel, channel, NoiseFloor(NOISE), "rest")
    clean = read(model, np.array(values), [blank])[0]
    noise = NOISE * np.random.default_rng(seed).standard_normal(len(drive))
    return Trace(name, time, drive, clean + noise, channel, channel, NoiseFloor(NOISE), "rest")


@pytest.fixture(scope="module")
def present() -> Campaign:
    """One weak sine of a device with a cubic spring."""
    drive = 1.0 * np.sin(2 * np.pi * 97.0 * STEP * np.arange(900))
    record = measured(Model(Oscillator()) + CubicStiffness(), [*LINEAR, 150.0, 0.0], "present.csv", drive, 1)
    return Campaign("one sine", (record,), Oscillator(max_voltage=3.0, max_frequency=300.0))


@pytest.fixture(scope="module")
def rivals(present: Campaign) -> dict[str, Fit]:
    base = Model(present.device)
    return {e.name: fit(base + e, present) for e in (CubicStiffness(), SensorNonlinearity())}


@pytest.fixture(scope="module")
def ranked(rivals: dict[str, Fit]) -> list[NextExperiment]:
    return rank_experiments(rivals)


def test_proposals_keep_the_limits() -> None:
    limits = Limits(5.0, 20.0, 180.0, 1e-4 * np.arange(1500))
    waves = proposals(limits, 100.0)
    assert {w.kind for w in waves} == {"sine", "biased", "burst", "multisine"}
    for wave in waves:
        assert np.max(np.abs(wave.voltage(limits.time))) <= 5.0 * (1 + 1e-9)
        assert 20.0 <= wave.hertz <= 180.0


def test_without_limits_the_records_own_range_holds(present: Campaign) -> None:
    limits = limits_of(replace(present, device=Oscillator()), F0)
    assert limits.volts == pytest.approx(1.0, rel=1e-3)
    assert len(limits.time) == 900
    assert limits_of(replace(present, device=Platform()), F0).volts == 10.0


def test_a_burst_is_switched_off_and_a_bias_stays() -> None:
    limits = Limits(5.0, 20.0, 180.0, 1e-4 * np.arange(1500))
    by_kind = {w.kind: w for w in proposals(limits, 100.0)}
    assert np.all(by_kind["burst"].voltage(limits.time)[-700:] == 0.0)
    assert np.mean(by_kind["biased"].voltage(limits.time)[-1000:]) == pytest.approx(2.5, abs=0.1)


def test_the_proposed_record_tells_the_rivals_apart(
    present: Campaign, rivals: dict[str, Fit], ranked: list[NextExperiment]
) -> None:
    best = ranked[0]
    assert set(best.separates) == set(rivals)
    assert best.expected_delta_chi2 > SEPARATED
    new = measured(Model(Oscillator()) + CubicStiffness(), [*LINEAR, 150.0, 0.0], "new.csv", best.voltage, 2)
    both = Campaign("two", (*present.records, new), present.device)
    chi2 = {}
    for name, before in rivals.items():
        after = fit(before.model, both, initial=before.values)
        chi2[name] = after.fitted.n * after.fitted.error_over_noise**2
    assert chi2["sensor-nonlinearity"] - chi2["cubic-stiffness"] > SEPARATED


def test_proposals_are_ranked_and_different(ranked: list[NextExperiment]) -> None:
    gains = [e.expected_delta_chi2 for e in ranked]
    assert gains == sorted(gains, reverse=True)
    assert len({e.record for e in ranked}) == len(ranked)
    assert all("from rest" in e.record for e in ranked)


def test_no_record_is_proposed_for_what_none_can_separate(rivals: dict[str, Fit]) -> None:
    first = next(iter(rivals.values()))
    lags = {e.name: replace(first, model=Model(first.model.device) + e) for e in (DriveLag(), SensorLag())}
    assert rank_experiments(lags) == []
    assert rank_experiments({"drive-lag": lags["drive-lag"]}) == []


def test_where_no_record_can_be_taken_none_is_proposed(rivals: dict[str, Fit]) -> None:
    """Records of 0.15 s hold three periods of 20 Hz, and a device that is driven up to 5 Hz none of those."""
    slow = lambda found: replace(found.campaign, device=Oscillator(max_voltage=3.0, max_frequency=5.0))
    assert rank_experiments({name: replace(found, campaign=slow(found)) for name, found in rivals.items()}) == []


def test_what_a_record_leaves_tied_is_named_together() -> None:
    names = ("drive-lag", "sensor-lag", "creep", "second-mode")
    assert grouped(names, [("drive-lag", "creep"), ("sensor-lag", "creep")]) == (
        ("drive-lag", "sensor-lag"),
        ("creep",),
    )
    assert grouped(names, [("drive-lag", "sensor-lag")]) == (("drive-lag",), ("sensor-lag",))


def test_a_record_to_take_is_told_in_the_unit_of_the_drive(present: Campaign) -> None:
    told = lambda device: proposals(limits_of(replace(present, device=device), F0), F0)[0].words
    assert " N, " in told(Oscillator("mm", "mN")) and " V, " in told(Oscillator()) and " V, " in told(Platform())


def test_of_free_decays_one_that_begins_farther_is_proposed() -> None:
    """For a liquid that nothing drives "sine 0 V, from rest" had been proposed."""
    time, mm = STEP * np.arange(900), Channel("mm", 1e-3)
    shrinking = np.exp(-2 * np.pi * F0 * time / 100.0) / (1 + 5 * time)  # as |v| v makes it
    clean = 2e-4 * shrinking * np.cos(2 * np.pi * F0 * time)
    noisy = clean + 2e-6 * np.random.default_rng(3).standard_normal(len(time))
    record = Trace("decay.csv", time, np.zeros(900), noisy, mm, mm, NoiseFloor(2e-6), "unknown")
    campaign = Campaign("a decay", (record,), Oscillator())
    laws = (QuadraticDamping(), CubicDamping())
    found = rank_experiments({law.name: fit(Model(Oscillator()) + law, campaign) for law in laws})
    assert all(one.record.startswith("free decay that begins with an amplitude of 0.") for one in found)
    farther = [one for one in found if one.waveform.begun > 2.5e-4]
    assert (
        farther
        and farther[0].record.endswith(" mm")
        and farther[0].groups == (("quadratic-damping",), ("cubic-damping",))
    )
    assert not np.any(farther[0].voltage)
    can_be_driven = replace(campaign, device=Oscillator(max_voltage=5.0))
    assert {wave.kind for wave in proposals(limits_of(can_be_driven, F0), F0)} >= {"sine", "burst"}


def test_how_far_a_decay_began_is_told_by_what_counts() -> None:
    """A masked spike, or a velocity beside a displacement, is no larger motion."""
    time, channel = STEP * np.arange(900), Channel("m", 1.0)
    swing = np.exp(-2 * np.pi * F0 * time / 100.0) * np.cos(2 * np.pi * F0 * time)
    spike = np.where(np.arange(900) == 5, 7.0, 1e-3 * swing)
    told = Trace("z.csv", time, 0 * time, spike, channel, channel, NoiseFloor(1e-6), masked=spike > 1.0)
    velocity = 0.5e-3 * 2 * np.pi * F0 * swing
    other = Trace("v.csv", time, 0 * time, velocity, channel, channel, NoiseFloor(1e-6), measures="velocity")
    limits = limits_of(Campaign("decays", (other, told), Oscillator()), F0)
    assert limits.measures == "displacement" and limits.begun == pytest.approx(1e-3, rel=0.1)
