"""Further linear modes: found where records show them, exact steady answers from their frequency responses, and not
where a device is nonlinear."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import lsim

from experiments.hidden_effects.generator import draw, write
from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.noise.recursive import recursive_filter
from ident.campaign.read import read_campaign
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.errors import UserError
from ident.fit import fit
from ident.fit.linear.choice import choose_linear
from ident.fit.linear.start_model import linear_choice, start_model
from ident.fit.linear.stretches import oscillator_filter
from ident.report.words.tables import record_sheet

N, STEP, NOISE = 2000, 0.005, 0.005
FOUR = ((4.9, 0.02, 0.5), (7.3, 0.02, 2.0), (9.1, 0.015, -1.2), (12.5, 0.015, 0.8))  # Hz, damping ratio, gain


def record(seed: int, modes: tuple[tuple[float, float, float], ...] = FOUR, level: float = 1.0) -> Trace:
    """The steady acceleration under a multisine of 2-15 Hz: Σ g (iω)²/(ω_k² − ω² + 2iζω_kω) of its lines."""
    rng = np.random.default_rng(seed)
    f = np.fft.rfftfreq(N, STEP)
    omega = 2 * np.pi * f
    answer = sum(
        g * -(omega**2) / ((2 * np.pi * fk) ** 2 - omega**2 + 4j * np.pi * fk * z * omega) for fk, z, g in modes
    )
    lines = np.where((f > 2) & (f < 15), np.exp(1j * rng.uniform(0, 2 * np.pi, f.size)), 0)
    drive, response = (level * np.fft.irfft(x) / np.std(np.fft.irfft(lines)) for x in (lines, lines * answer))
    sigma, one = NOISE * float(np.std(response)), Channel("m", 1.0)
    response = response + sigma * rng.normal(size=N)
    return Trace(
        "a.csv", STEP * np.arange(N), drive, response, one, one, NoiseFloor(sigma), "unknown", measures="acceleration"
    )


def test_four_modes_are_found_and_fitted_to_the_noise():
    campaign = Campaign("wing", (record(1), record(2, level=3.0)), Oscillator())
    choice = linear_choice(campaign)
    assert choice is not None and choice.chosen.words == "oscillator, 4 modes"
    model = start_model(campaign)
    assert model.names == ("second-mode", "third-mode", "fourth-mode")
    found = fit(model, campaign)
    assert found.fitted.error_over_noise < 1.05
    periods = [found.value(f"{name}.period") for name in model.names]
    own = sorted([found.values[0], *(1 / period for period in periods)])
    np.testing.assert_allclose(own, [f for f, _, _ in FOUR], rtol=1e-4)


def test_the_campaign_may_say_how_many_there_are():
    records = (record(1), record(2))
    for told, names in ((1, ()), (2, ("second-mode",))):
        assert start_model(Campaign("wing", records, Oscillator(), modes=told)).names == names
    # one that the campaign names itself is not doubled
    assert start_model(Campaign("wing", records, Oscillator(), effects=("second-mode",))).names == ("second-mode",)


def test_modes_of_a_form_that_has_none_are_refused():
    with pytest.raises(UserError, match="modes = 2 needs"):
        choose_linear([record(1)], "no-spring", modes=2)


def test_one_mode_in_noise_stays_one():
    assert start_model(Campaign("one", (record(1, FOUR[1:2]), record(2, FOUR[1:2])), Oscillator())).names == ()


@pytest.mark.parametrize(
    ("starts", "drift"),
    [(("rest", "rest"), 0.0), (("rest", "unknown"), 0.0), (("rest", "unknown"), 0.3), (("unknown", "unknown"), 0.3)],
)
def test_a_zero_that_is_off_is_no_mode(starts: tuple[str, str], drift: float):
    """A slow mode could begin in motion and so be a level, in each record that does not start from rest."""
    w, records = 2 * np.pi * 7.3, []
    for seed, start in enumerate(starts):
        one = record(seed, FOUR[1:2])
        t, rng = one.time, np.random.default_rng(seed)
        answer = recursive_filter(*oscillator_filter(7.3, 25.0, STEP, 0), one.drive) * w**2
        answer += np.std(answer) * (0.3 + drift * np.expm1(-t / 6) + 0.005 * rng.normal(size=N))
        noise = NoiseFloor(0.005 * float(np.std(answer)))
        records.append(replace(one, response=answer, start=start, noise=noise, measures="displacement"))
    assert not {"second-mode"} & {*start_model(Campaign("offset", tuple(records), Oscillator())).names}


@pytest.mark.parametrize("effect", ["cubic-stiffness", "end-stop", "coulomb-friction", "viscoelastic-support"])
def test_a_nonlinear_device_is_no_device_of_many_modes(effect: str, tmp_path: Path):
    case = draw(8200, (effect,), size=0.1, noise=0.003, device="oscillator", records=6, length=1200)
    write(case, tmp_path / "c", tmp_path / "truth.json")
    choice = linear_choice(read_campaign(tmp_path / "c"))
    assert choice is not None and not choice.chosen.further


@pytest.mark.parametrize(
    ("line", "device", "said"),
    [("modes = 0", True, "from 1 to"), ('modes = "two"', True, "from 1 to"), ("modes = 2", False, "only an oscillator"),
     ('modes = 2\nlinear = "no-spring"', True, "only an oscillator")],
)  # fmt: skip
def test_what_cannot_be_is_said(line: str, device: bool, said: str, tmp_path: Path):
    kind = 'device = { kind = "oscillator", output = "V" }\n' if device else ""
    (tmp_path / "campaign.toml").write_text(f'{kind}[model]\n{line}\n[[record]]\nfile = "a.csv"\n')
    t = np.arange(50) * 1e-3
    np.savetxt(tmp_path / "a.csv", np.c_[t, np.sin(300 * t), np.cos(300 * t)], delimiter=",", header="t_s,u_V,y_V")
    with pytest.raises(UserError) as error:
        read_campaign(tmp_path)
    assert said in str(error.value) and "campaign.toml, line" in str(error.value)


def test_errors_stand_in_the_unit_of_what_was_read():
    campaign = Campaign("wing", (record(1, FOUR[1:2]),), Oscillator(output="m"))
    told = record_sheet(fit(start_model(campaign), campaign))
    assert [column.name for column in told.columns][3] == "rms error (mm/s²)"


def test_two_modes_are_found_where_none_alone_resembles_the_device():
    """Below its second mode, which answers the other way, a device does not even look like an oscillator: gain and
    offset won. The mode that moves is the first, however many records lie far from it."""
    campaign = Campaign("two", tuple(_sine_of_two(ratio) for ratio in (0.4, 0.5, 0.6, 1.0, 1.1)), Oscillator())
    choice = linear_choice(campaign)
    assert choice is not None and choice.chosen.form == "oscillator" and choice.chosen.further
    assert choice.chosen.first == pytest.approx(7.0, rel=0.01)
    assert choice.chosen.left < 0.02


def _sine_of_two(ratio: float) -> Trace:
    """From rest, under a sine at a ratio of the first of two modes, of 7 and 34 Hz."""
    t, one = STEP * np.arange(N) / 2, Channel("m", 1.0)
    drive, answer = np.sin(2 * np.pi * 7.0 * ratio * t), np.zeros(N)
    for f, q, slope in ((7.0, 22.0, 1.0), (34.0, 30.0, -5.0)):
        w = 2 * np.pi * f
        answer = answer + slope * lsim(([w**2], [1.0, w / q, w**2]), drive, t)[1]
    sigma = NOISE * float(np.std(answer))
    noise = np.random.default_rng(int(100 * ratio)).normal(size=N)
    return Trace(f"{ratio}.csv", t, drive, answer + sigma * noise, one, one, NoiseFloor(sigma), "rest")


def test_a_motion_that_repeats_itself_does_not_turn_friction_into_modes() -> None:
    """An axis without a spring goes to and fro under a controller, four times the same: modes with as many numbers as
    the motion has lines meet it, and predict one half from the other."""
    period, mass, viscous, dry, count = 6.0, 95.0, 200.0, 20.0, 1200
    wanted = lambda t: 0.1 * (1 - np.cos(2 * np.pi * t / period)) ** 2
    force = lambda t, y: 9000.0 * (wanted(t) - y[0]) - 900.0 * y[1]

    def motion(t: float, y: np.ndarray) -> list[float]:
        return [y[1], (force(t, y) - viscous * y[1] - dry * np.tanh(y[1] / 1e-3) - 3.0) / mass]

    t = np.linspace(0.0, 4 * period, count)
    y = solve_ivp(motion, (0.0, t[-1]), [0.0, 0.0], "LSODA", t, rtol=1e-8, atol=1e-10).y
    drive, one, sigma = force(t, y) / 35.0, Channel("m", 1.0), 1e-5
    reading = y[0] + sigma * np.random.default_rng(3).normal(size=count)
    record = Trace("axis.csv", t, drive, reading, one, one, NoiseFloor(sigma), "unknown")
    assert not choose_linear([record]).chosen.further
