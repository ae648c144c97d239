"""Where a model fails: misfits put in one place are found there, and noise is left alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.diagnosis.linearised.regression import Regression, prepare
from ident.diagnosis.where.locate import Where, locate
from ident.diagnosis.where.whiteness import drive_correlation, lagged, whiteness
from ident.diagnosis.where.words import Statement, hertz, statements, summary
from ident.fit import Fit, fit
from ident.fit.reading import read
from ident.model import Model
from ident.report.figures import where as figure
from ident.report.figures.where import where_figure
from tests.fit.test_curves import FREQUENCY, QUALITY, sweep

VALUES = np.array([100.0, 20.0, 4e5])  # Hz, 1, output/s² per volt
NOISE = 0.003


def sine_record(volts: float, hertz: float, seed: int, holdout: bool = False) -> Trace:
    t = np.arange(800) / 4000.0
    drive = volts * np.sin(2 * np.pi * hertz * t)
    channel = Channel("V", 1.0)
    empty = Trace(f"{volts:g}V_{hertz:g}Hz.csv", t, drive, np.ones(800), channel, channel, NoiseFloor(NOISE), "rest",
                  holdout, period=4000.0 / hertz)  # fmt: skip
    clean = read(Model(Oscillator()), VALUES, [empty])[0]
    return replace(empty, response=clean + NOISE * np.random.default_rng(seed).standard_normal(800))


def campaign(seed: int = 0) -> Campaign:
    plan = [(1.0, 50.0), (2.0, 80.0), (3.0, 125.0)]
    records = tuple(sine_record(v, f, 10 * seed + i) for i, (v, f) in enumerate(plan))
    return Campaign("three sines", records, Oscillator())


@pytest.fixture(scope="module")
def fitted() -> Fit:
    return fit(Model(Oscillator()), campaign(), initial=VALUES)


@pytest.fixture(scope="module")
def regression(fitted: Fit) -> Regression:
    return prepare(fitted)


def disturbed(regression: Regression, number: int, misfit: np.ndarray) -> Where:
    """The regression with a misfit, in noise floors, put into one record."""
    residual = regression.residual.copy()
    residual[regression.starts[number] :][: len(misfit)] += misfit
    return locate(replace(regression, residual=residual))


@pytest.mark.parametrize("period", [None, 600.0])
def test_a_level_is_no_noise_floor_stated_too_low(period: float | None, fitted: Fit) -> None:
    """Nor where no drive repeats, or not twice, and there is no harmonic to see it at."""
    records = tuple(replace(record, period=period) for record in fitted.campaign.records)
    where = disturbed(prepare(replace(fitted, campaign=replace(fitted.campaign, records=records))), 1, np.ones(800))
    assert "in the constant part" in summary(where)
    assert "white" not in summary(where)
    where_figure(where)


def test_masked_samples_leave_every_view_in_its_place() -> None:
    whole = campaign()
    clipped = np.zeros(800, bool)
    clipped[100:120] = True
    records = (replace(whole.records[0], masked=clipped), *whole.records[1:])
    regression = prepare(fit(Model(Oscillator()), replace(whole, records=records), initial=VALUES))
    assert regression.n == 3 * 800 - 20
    where = locate(regression)
    assert [own.stop for own in regression.places] == [800, 1600, 2400]
    assert len(where.time.ratio) and np.all(np.isfinite(where.time.ratio))
    assert not where.time.stands_out(1e-3).any()


def test_nothing_is_said_of_noise(regression: Regression) -> None:
    rng = np.random.default_rng(3)
    for _ in range(40):
        noise = regression.project(rng.standard_normal((1, regression.n)))[0]
        where = locate(replace(regression, residual=noise))
        assert statements(where) == []
        assert summary(where).startswith("No part of the records stands out")


def test_a_misfit_is_found_in_its_record_and_harmonic(regression: Regression) -> None:
    third = 3.0 * np.sin(2 * np.pi * 3 * 50.0 * np.arange(800) / 4000.0)
    where = disturbed(regression, 0, third)
    words = summary(where)
    assert "1V_50Hz.csv" in words
    assert "third harmonic" in words
    assert where.harmonics is not None and int(np.argmax(where.harmonics.excess)) == 3
    assert where.misfit == pytest.approx(800 * 4.5, rel=0.15)


@pytest.mark.parametrize(("told", "kept"), [("V", "V"), ("mN", "N"), ("counts", "counts")])
def test_the_level_of_a_drive_is_told_in_the_unit_of_the_drive(told: str, kept: str, fitted: Fit) -> None:
    pushed = replace(fitted, campaign=replace(fitted.campaign, device=Oscillator(input=told)))
    louder = np.repeat([0.0, 1.0, 1.0], 800) * 3.0 * (-1.0) ** np.arange(2400)
    where = locate(replace(prepared := prepare(pushed), residual=prepared.residual + louder))
    assert f"in records driven at 2 {kept} or more" in summary(where)


def test_a_misfit_is_found_in_its_time(regression: Regression) -> None:
    burst = np.where(np.arange(800) < 120, 4.0, 0.0) * (-1.0) ** np.arange(800)
    said = {s.axis: s.words for s in statements(disturbed(regression, 2, burst))}
    assert "first" in said["time"]


def test_the_error_is_that_of_the_fit_and_another_size_is_explained(regression: Regression) -> None:
    """Hum and the noise's colour are taken out before a place is looked for, and `ident fit` counts them in."""
    own = regression.fit.fitted.error_over_noise
    where = disturbed(regression, 1, np.full(800, 1.0))
    assert f"The error is {own:.2f} times the noise floor ({where.white_error:.2f} in what follows" in summary(where)
    assert [r.error for r in where.records] == [s.error_over_noise for s in regression.fit.scores]
    told = summary(where._replace(error=where.white_error))
    assert f"The error is {where.white_error:.2f} times the noise floor; what is left" in told
    assert "98.8 times" in summary(where._replace(error=98.84))


def test_a_phase_goes_round(regression: Regression) -> None:
    angle = 2 * np.pi * 50.0 * np.arange(800) / 4000.0
    said = {s.axis: s.words for s in statements(disturbed(regression, 0, np.where(np.cos(angle) > 0.88, 6.0, 0.0)))}
    assert said["phase"] == "at 330–30° of the drive's phase"


def test_an_offset_is_the_constant_part(regression: Regression) -> None:
    where = disturbed(regression, 1, np.full(800, 1.0))
    assert "in the constant part" in summary(where)


def test_a_floor_stated_too_low_is_no_place(regression: Regression) -> None:
    rng = np.random.default_rng(5)
    where = locate(replace(regression, residual=1.3 * regression.project(rng.standard_normal((1, regression.n)))[0]))
    assert statements(where) == []
    assert "a noise floor stated too low" in summary(where)


def test_whiteness_rejects_colour_only() -> None:
    rng = np.random.default_rng(1)
    white = rng.standard_normal(2000)
    coloured = white[1:] + 0.5 * white[:-1]
    assert whiteness([white], [0]).p_value > 0.001
    assert whiteness([coloured], [0]).p_value < 1e-12
    assert whiteness([coloured], [0]).values[0] == pytest.approx(0.4, abs=0.06)  # 0.5/(1 + 0.5²)


def test_drive_correlation_is_found_at_its_lag() -> None:
    rng = np.random.default_rng(2)
    drive = rng.standard_normal(3000)
    e = rng.standard_normal(3000) + 0.3 * lagged(drive, np.array([7]))[0]
    found = drive_correlation([e], [drive], [1.0], np.arange(-5.0, 15.0))
    assert found.p_value < 1e-12
    assert found.lags[int(np.argmax(np.abs(found.values)))] == 7
    alone = drive_correlation([rng.standard_normal(3000)], [drive], [1.0], np.arange(-5.0, 15.0))
    assert alone.p_value > 0.001


def test_the_figure_draws(regression: Regression) -> None:
    drawn = where_figure(locate(regression))
    assert len(drawn.axes) == 8
    assert "No part of the records stands out" in drawn.texts[0].get_text()


def test_the_figure_asks_and_answers(regression: Regression, monkeypatch: pytest.MonkeyPatch) -> None:
    third = 3.0 * np.sin(2 * np.pi * 3 * 50.0 * np.arange(800) / 4000.0)
    where = disturbed(regression, 0, third)
    told = lambda: [text.get_text() for text in where_figure(where).texts]
    assert {"Which record?", "At which harmonic?", "at the third harmonic of the drive"} <= set(told())
    assert "no: beyond the grey band" in told() and "At which frequency?" not in told()
    named = Statement("frequency", "between 140 and 160 Hz", 0.9, 0.0)
    monkeypatch.setattr(figure, "statements", lambda _: [named])  # what the words name has an axis
    assert {"At which frequency?", "between 140 and 160 Hz"} <= set(told())
    boxes = [axes.get_window_extent() for axes in where_figure(where).axes]
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])


def test_a_frequency_has_no_power_of_ten() -> None:
    assert [hertz(value) for value in (10090.3, 432.0, 0.33333, 1e6)] == ["10090", "432", "0.3333", "1000000"]


def test_curves_are_looked_at_along_their_own_axes() -> None:
    """A curve has no time, no turning points and no waveform."""
    device = Oscillator(output="m")
    sweeps = tuple(sweep(level, 0.0, True, k) for k, level in enumerate((0.2, 0.3)))
    # Of a larger quality factor only the peaks differ.
    r = sweeps[0].frequency / FREQUENCY
    size = lambda q: 1 / np.hypot(1 - r**2, r / q)
    sharper = replace(sweeps[1], amplitude=sweeps[1].amplitude * size(1.3 * QUALITY) / size(QUALITY))
    found = locate(prepare(fit(Model(device), Campaign("", (sweeps[0], sharper), device))))
    assert found.of_curves and found.displacement.edges[0] == 0.0
    assert found.time.edges[[0, -1]] == pytest.approx([38.0, 43.5])
    said = summary(found)
    assert "peak" in said and " Hz" in said and "stage" not in said and "%" not in said.split("Of the misfit")[0]
