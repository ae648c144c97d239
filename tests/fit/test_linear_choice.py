"""Which linear model records ask for: against SciPy's own solutions of every form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.errors import UserError
from ident.fit import fit
from ident.fit.linear.choice import begin_off_zero, choose_linear
from ident.fit.linear.start_model import linear_choice, start_model

STEP, SIGMA, ONE = 0.01, 1e-3, Channel("V", 1.0)
OMEGA = 2 * np.pi * 1.5


def record(system: tuple, level: float = 0.0, bias: float = 0.0, seed: int = 0, start: str = "unknown") -> Trace:
    """An answer to filtered noise, of rms 1, plus a level; `bias` of the drive is not in its column."""
    rng = np.random.default_rng(seed)
    t = STEP * np.arange(3000)
    drive = signal.lfilter([0.2], [1.0, -0.8], rng.normal(size=len(t)))
    _, answer, _ = signal.lsim(system, drive + bias, t)
    size = np.std(answer)
    response = answer / size + level + SIGMA * rng.normal(size=len(t))
    return Trace("a.csv", t, drive, response, ONE, ONE, NoiseFloor(SIGMA), start)  # type: ignore[arg-type]


SYSTEMS = {
    "oscillator": ([1.0], [1.0, OMEGA / 8, OMEGA**2]),
    "overdamped": ([1.0], [1.0, OMEGA / 0.2, OMEGA**2]),
    "no-spring": ([1.0], [1.0, 1 / 0.4, 0.0]),
}


@pytest.mark.parametrize("form", SYSTEMS)
def test_the_form_is_found_with_its_numbers(form):
    choice = choose_linear([record(SYSTEMS[form])])
    assert choice.chosen.form == form
    assert choice.chosen.left < 5e-3
    if form == "no-spring":
        assert choice.chosen.second == pytest.approx(0.4, rel=0.01)
    else:
        wanted = {"oscillator": 8.0, "overdamped": 0.2}[form]
        np.testing.assert_allclose([choice.chosen.first, choice.chosen.second], [1.5, wanted], rtol=0.02)


@pytest.mark.parametrize(("level", "wanted"), [(0.0, False), (0.002, False), (0.01, True), (5.0, True)])
def test_at_rest_a_constant_is_added_where_the_first_sample_shows_one(level, wanted):
    """A sensor's zero far off: no oscillator came near, and an axis without inertia was taken for the start. Or nearer:
    an offset of ten noise floors hid that all responses came late."""
    choice = choose_linear([record(SYSTEMS["oscillator"], level, start="rest")])
    assert (choice.chosen.form, choice.chosen.level) == ("oscillator", wanted)
    assert choice.chosen.first == pytest.approx(1.5, rel=0.05)


@pytest.mark.parametrize(("level", "wanted"), [(0.0, False), (0.7, True)])
def test_a_constant_is_added_only_where_the_records_need_it(level, wanted):
    choice = choose_linear([record(SYSTEMS["oscillator"], level)])
    assert (choice.chosen.form, choice.chosen.level) == ("oscillator", wanted)
    if wanted:
        assert choice.chosen.constant == pytest.approx(level, rel=0.01)


def test_a_start_from_rest_says_where_the_zero_is():
    choice = choose_linear([record(SYSTEMS["oscillator"], start="rest")])
    assert not any(c.level for c in choice.candidates if c.form == "oscillator")


def test_one_record_of_another_gain_does_not_hide_the_zero_of_the_others():
    records = [record(SYSTEMS["oscillator"], 0.5, seed=seed, start="rest") for seed in range(3)]
    records[1] = replace(records[1], response=1.25 * records[1].response)
    assert choose_linear(records).chosen.level
    assert not choose_linear(
        [replace(r, response=r.response - 0.5 * (i != 1)) for i, r in enumerate(records)]
    ).chosen.level


def test_two_records_that_begin_apart_tell_no_zero():
    records = [record(SYSTEMS["oscillator"], level, seed=i, start="rest") for i, level in enumerate((0.0, 0.05))]
    assert not any(c.level for c in choose_linear(records).candidates if c.form == "oscillator")


def test_a_noisy_record_does_not_say_where_the_zero_of_quiet_ones_is():
    """Three quiet records begin at zero; the one in the middle of all begins a noise floor of its own away from it."""
    quiet = record(SYSTEMS["oscillator"], start="rest")
    at = lambda zero, sigma: replace(quiet, response=np.full(3000, zero), noise=NoiseFloor(sigma))
    noisy = [at(-0.011, 0.006), at(-0.02, 0.02), at(-0.04, 0.04), at(-0.01, 0.015)]
    assert not begin_off_zero([at(-0.0023, 0.0028), at(0.0008, 0.0023), *noisy])
    assert begin_off_zero([at(-0.0123, 0.0015), at(-0.0118, 0.0013), *noisy])


def test_what_a_campaign_asks_for_is_done():
    choice = choose_linear([record(SYSTEMS["oscillator"])], "no-spring")
    assert choice.chosen.form == "no-spring"
    assert any(c.form == "quasi-static" for c in choice.candidates)  # still there to compare with


def test_what_only_follows_its_drive_is_gain_and_offset():
    slow = record(SYSTEMS["oscillator"])
    drive = signal.lfilter(*signal.butter(3, 1 / 40), slow.drive)
    noise = SIGMA * np.random.default_rng(3).normal(size=len(drive))
    stage = replace(slow, drive=drive, response=drive / np.std(drive) + 0.4 + noise)
    campaign = Campaign("stage", (stage,), Oscillator())
    for told in (campaign, replace(campaign, linear="quasi-static")):
        model = start_model(told)
        assert (model.form, model.names) == ("quasi-static", ("sensor-offset",))
        found = fit(model, told)
        assert found.fitted.error_over_signal < 2e-3  # with what inertia still does
        assert found.value("sensor-offset.offset") == pytest.approx(0.4, abs=1e-3)
        static = found.value("oscillator.gain") / (2 * np.pi * found.values[0]) ** 2
        assert static * np.std(drive) == pytest.approx(1.0, rel=2e-3)


def test_a_decay_has_no_gain():
    still = replace(record(SYSTEMS["oscillator"]), drive=np.zeros(3000))
    with pytest.raises(UserError, match="quasi-static"):
        choose_linear([still], "quasi-static")


def test_a_mass_without_a_spring_is_fitted_with_the_force_that_its_drive_lacks():
    records = (record(SYSTEMS["no-spring"], bias=0.3),)
    campaign = Campaign("axis", records, Oscillator())
    model = start_model(campaign)
    assert (model.form, model.names) == ("no-spring", ("static-force",))
    found = fit(model, campaign)
    assert found.fitted.error_over_noise == pytest.approx(1.0, abs=0.1)
    assert found.value("oscillator.decay-time") == pytest.approx(0.4, rel=0.01)
    force, gain = found.value("static-force.force0"), found.value("oscillator.gain")
    assert force / gain == pytest.approx(0.3, rel=0.02)
    assert linear_choice(campaign) is linear_choice(campaign)  # compared once


def test_a_tilted_axis_that_sticks_is_given_no_spring():
    """Friction of a quarter of the force and a slope, from rest: of the forms without a constant a soft overdamped
    spring left least, and what was missing was then looked for beside it. A constant force is no sensor's level."""
    decay, gain, friction, slope, fine = 0.29, 1.2, 0.7, 0.22, 8
    records = []
    for k, hertz in enumerate((0.23, 0.41, 0.67)):
        t = STEP * np.arange(1200)
        drive = 2.2 * np.sin(2 * np.pi * hertz * t) + 0.8 * np.sin(2 * np.pi * 2.3 * hertz * t + k)
        z, v, answer = 0.0, 0.0, np.zeros(len(t))
        for i in range(len(t) - 1):
            for _ in range(fine):  # friction takes at most all of the velocity that the other forces leave
                free = v + STEP / fine * (gain * drive[i] - slope - v / decay)
                v = np.sign(free) * max(abs(free) - STEP / fine * friction, 0.0)
                z += STEP / fine * v
            answer[i + 1] = z
        noisy = answer + SIGMA * np.random.default_rng(k).normal(size=len(t))
        records.append(Trace(f"{k}", t, drive, noisy, ONE, ONE, NoiseFloor(SIGMA), "rest"))
    chosen = choose_linear(records).chosen
    assert (chosen.form, chosen.level) == ("no-spring", True)
