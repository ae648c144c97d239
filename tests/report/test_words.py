"""What is said of a fit: tables, combinations, starts, correlations, warnings."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from ident.campaign import NoiseFloor, Platform
from ident.campaign.quality.clipping import clipped_mask
from ident.fit.identifiability import Combination
from ident.fit.result import Start
from ident.report.words import tables
from ident.report.words.drives import drive_words, only_frequency
from ident.report.words.sentences import _noise, sentences, verdict
from ident.report.words.tables import (
    combination_sentences,
    correlation_sentences,
    parameter_sheet,
    record_sheet,
    start_sentence,
)  # fmt: skip
from ident.report.words.terminal import fit_text


def _said(fit) -> str:
    return " ".join(s.text for s in sentences(fit))


def _warned(fit) -> str:
    return " ".join(s.text for s in sentences(fit) if s.warning)


def test_the_parameter_table_says_what_each_number_is_worth(make_fit):
    rows = {row[0]: row[1:] for row in parameter_sheet(make_fit()).rows}
    assert rows["platform.d31"] == ("63.9900", "± 0.0046", "pm/V", "")
    assert rows["residual-stress.sigma12"] == ("(106.7)", "", "MPa", "undetermined")
    assert rows["pzt-hysteresis.zeta"][3].startswith("not significant")
    assert rows["residual-stress.sigma2"][3] == "held"
    assert rows["residual-stress.width"][3] == "not used with these settings"


def test_the_noise_floor_of_volts_is_given_in_volts(oscillator_fit):
    vague = tuple(replace(r, noise=NoiseFloor(2e-4, relative_error=0.8)) for r in oscillator_fit.campaign.traces)
    doubtful = replace(oscillator_fit, campaign=replace(oscillator_fit.campaign, records=vague))
    assert 'noise = "200 µV"' in _noise(doubtful)[0].text


def test_an_oscillator_has_no_newtons(oscillator_fit):
    rows = {row[0]: row[1:] for row in parameter_sheet(oscillator_fit).rows}
    assert rows["cubic-stiffness.k3"] == ("60.0010", "± 0.0021", "1e3 1/(V²·s²)", "")
    assert " N" not in fit_text(oscillator_fit).replace(" No ", "")
    assert "K_f" not in _said(oscillator_fit)


def test_records_are_judged_one_by_one_and_together(make_fit):
    sheet = record_sheet(make_fit(heldout_misfit=0.05))
    assert [row[:3] for row in sheet.rows] == [
        ("first_8V.csv", "fitted", "1600"),
        ("second_3V.csv", "fitted", "1600"),
        ("held_out_5V.csv", "held out", "1600"),
        ("all fitted", "", "3200"),
        ("all held out", "", "1600"),
    ]
    assert [column.name for column in sheet.columns][3:5] == ["rms error (nm)", "noise floor (nm)"]
    ratios = [float(row[5]) for row in sheet.rows]
    assert ratios[0] == pytest.approx(1.0, abs=0.05)
    assert ratios[2] == pytest.approx(0.05 * 5e-6 / math.sqrt(2) / 2e-8, rel=0.03)
    assert sheet.marks == ("", "", "warning", "total", "total")


@pytest.mark.parametrize("width", [80, 100])
def test_the_terminal_text_fits_its_window(make_fit, width):
    text = fit_text(make_fit(misfit=0.4), width)
    assert max(len(line) for line in text.splitlines()) <= width
    assert "\x1b" not in text
    assert "…" not in text  # nothing is cut off
    marked = [line for line in text.splitlines() if line.startswith("! ")]
    assert len(marked) == sum(sentence.warning for sentence in sentences(make_fit(misfit=0.4))) > 0


def test_what_is_determined_of_the_undetermined(make_fit):
    linear = "only 0.81·sigma12 + 0.59·sigma23 of residual-stress is determined; its value is 74.391 ± 0.098 MPa"
    assert combination_sentences(make_fit()) == (linear + "; the rest is not",)
    product = Combination(("platform.d31", "drive-lag.time"), (0.8, -0.4), 0.8 * math.log(2.0), 0.008, "", True)
    (text,) = combination_sentences(make_fit(combinations=(product,)))[:1]
    assert (
        "only the product platform.d31 · drive-lag.time^-0.50 is determined; its value is 2.000 in SI, to 1.0 %" in text
    )


def test_parameters_of_which_nothing_is_known_are_named(make_fit):
    assert combination_sentences(make_fit(combinations=())) == (
        "the records say nothing about residual-stress.sigma12 and residual-stress.sigma23",
    )


def test_starts(make_fit):
    fit = make_fit()
    assert start_sentence(fit) == "2 of 2 starts reach the same minimum"
    other = (*fit.starts, Start(200.0, 7.3, 30, True), Start(math.nan, math.nan, 0, False))
    text = start_sentence(replace(fit, starts=other))
    assert text.startswith("2 of 4 starts reach the same minimum; the next best ends at 7.30")
    assert text.endswith("1 could not be solved")
    alone = start_sentence(replace(fit, starts=fit.starts[:1]))
    assert alone == "there was one start, and it reaches the noise floor"
    bad = make_fit(misfit=0.4)
    assert "nothing shows that its minimum is the deepest" in start_sentence(replace(bad, starts=bad.starts[:1]))


def test_strong_correlations_in_words(make_fit):
    fit = make_fit()
    matrix = fit.covariance.copy()
    matrix[0, 1] = matrix[1, 0] = -0.95 * np.sqrt(matrix[0, 0] * matrix[1, 1])
    assert correlation_sentences(replace(fit, covariance=matrix)) == (
        "platform.frequency and platform.quality are poorly told apart: one can grow as the other shrinks"
        " (correlation -0.95)",
    )
    assert correlation_sentences(fit) == ()


def test_of_many_strong_correlations_the_closest(make_fit, monkeypatch):
    fit = make_fit()
    deviation = np.sqrt(fit.covariance.diagonal())
    monkeypatch.setattr(tables, "_MOST_PAIRS", 1000)
    every = correlation_sentences(whole := replace(fit, covariance=0.95 * np.outer(deviation, deviation)))
    assert len(every) > 3
    monkeypatch.setattr(tables, "_MOST_PAIRS", 2)
    rest = f"so are {len(every) - 2} more pairs, with correlations beyond ±0.9"
    assert correlation_sentences(whole) == (*every[:2], rest)


def test_a_good_fit_is_called_good_and_a_bad_one_is_not_trusted(make_fit):
    good, bad = make_fit(), make_fit(misfit=0.05)
    assert "to the noise floor" in verdict(good)
    assert "Do not trust the error bars" not in _said(good)
    assert "does not describe" in verdict(bad)
    assert "worst in first_8V.csv" in verdict(bad)
    ratio = f"{bad.fitted.error_over_noise:.1f}"  # about 11
    assert f"misses the records by {ratio} times the noise floor" in _warned(bad)


def test_a_model_that_does_not_carry_over_is_told_so(make_fit):
    assert "does not carry over" in verdict(make_fit(heldout_misfit=0.05))
    assert "seen, are predicted to the noise floor too" in verdict(make_fit())


def test_sigma_is_explained(make_fit):
    assert 'sigma = "known"' in _said(make_fit())
    assert 'sigma = "scaled"' in _said(make_fit(sigma="scaled"))
    assert "cannot judge the model" in _warned(make_fit(sigma="fitted"))


def test_step_error_and_convergence(make_fit):
    assert "negligible" in _said(make_fit())
    assert "more than a tenth" in _warned(make_fit(step_error=0.3))
    assert "did not converge" in _warned(make_fit(converged=False))
    assert "did not converge" in verdict(make_fit(converged=False))


def test_a_doubtful_noise_floor_is_named(make_fit):
    fit = make_fit()
    vague = replace(fit.campaign.traces[0], noise=NoiseFloor(2e-8, relative_error=0.8))
    traces = (vague, *fit.campaign.traces[1:])
    assert "first_8V.csv (±80 %)" in _warned(make_fit(campaign=replace(fit.campaign, records=traces)))
    low = tuple(s._replace(error_over_noise=0.4) for s in fit.scores)
    assert 'noise = "20 nm"' in _warned(make_fit(campaign=replace(fit.campaign, records=traces)))
    assert "well below the noise floor" in _warned(make_fit(scores=low))


@pytest.mark.parametrize(
    ("closure", "in_plane", "warning", "words"),
    [
        ("axial-force", "yaw", True, "11–16 % off finite elements"),
        ("axial-force", "yaw", True, "so this applies here"),
        ("axial-force", "clamped", True, "wrong sign"),
        ("sign-change", "yaw", True, "phenomenological"),
        ("frame", "yaw", False, "within 1–2 %"),
    ],
)
def test_whoever_reads_a_stress_gradient_is_told_what_the_closure_decides(make_fit, closure, in_plane, warning, words):
    fit = make_fit(device=Platform(in_plane=in_plane), settings={"closure": closure})
    assert words in (_warned(fit) if warning else _said(fit))
    if not warning:
        assert words not in _warned(fit)
    if in_plane == "clamped":
        assert "applies here" not in _said(fit)


def test_the_limits_of_the_hysteresis_and_of_d31_are_said(make_fit):
    said = _said(make_fit())
    assert "carries over badly to other frequencies" in said
    assert "from 317 to 500 Hz" in said
    assert "K_f and d31 enter as a product" in said and "eta and zeta, like d31" in said
    assert "hysteresis" not in _said(make_fit(effects=()))


def test_a_record_is_named_by_its_drive(make_fit):
    trace = make_fit().campaign.traces[0]
    assert drive_words(trace, Platform()) == "8 V sine at 317 Hz"
    one = replace(trace, drive=trace.drive * 0.999999 / 8)
    assert drive_words(one, Platform()) == "1 V sine at 317 Hz"
    assert drive_words(replace(trace, load=40e-6), Platform()) == "8 V sine at 317 Hz, 40 mg load"
    assert drive_words(replace(trace, period=None), Platform()).startswith("changing drive, up to 7.98 V, around 3")
    assert drive_words(replace(trace, drive=np.full_like(trace.drive, 2.0), period=None), Platform()) == "constant 2 V"


def test_one_drive_frequency_is_seen_whatever_the_waveform(make_fit):
    record = make_fit().campaign.fitted[0]
    t = record.step * np.arange(len(record.time))
    hertz = 20 / t[-1]
    triangle = (1 + t / t[-1]) * np.arcsin(np.sin(2 * np.pi * hertz * t)) + 5 * t / t[-1]
    assert only_frequency(replace(record, drive=triangle)) == pytest.approx(hertz, rel=0.05)
    tones = sum(np.sin(2 * np.pi * f * t) for f in hertz * np.arange(1, 6))
    assert only_frequency(replace(record, drive=tones)) is None
    octave = np.sin(2 * np.pi * hertz * (t + t**2 / (2 * t[-1])))  # a sweep from one frequency to twice as much
    assert only_frequency(replace(record, drive=octave)) is None
    assert only_frequency(replace(record, drive=np.full(len(t), 3.0))) is None


def test_a_record_that_is_clipped_is_named_beside_the_fit(make_fit):
    found = make_fit()
    first, *others = found.campaign.traces
    limit = 0.7 * float(np.max(np.abs(first.response)))
    response = np.clip(first.response, -limit, limit)
    masked = clipped_mask(response)
    assert masked is not None
    clipped = replace(first, response=response, masked=masked, stuck=float(np.mean(masked)))  # as reading it finds
    spoilt = make_fit(campaign=replace(found.campaign, records=(clipped, *others)))
    assert "sticks to a limit" in _warned(spoilt) and first.name in _warned(spoilt)
    assert "Suspect" not in _said(found)


def test_a_device_that_is_not_the_one_described_is_asked_about(make_fit):
    assert "is this that device" not in _said(make_fit())
    estimates = make_fit().estimates
    elsewhere = tuple(e._replace(value=121.0) if e.name == "platform.frequency" else e for e in estimates)
    said = _warned(make_fit(estimates=elsewhere))
    assert "platform.frequency = 121.0 Hz is far from the 505.4 Hz that are expected (nominal geometry" in said
    assert 'device = { kind = "oscillator", output = "m", input = "V" }' in said
