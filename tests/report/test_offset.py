"""Zero-point offset: known asymmetries are found, and their errors are honest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ident.campaign import NoiseFloor
from ident.posterior.offset import MEASURES, offsets
from ident.report.words.offsets import offset_sheet

from .conftest import SIGMA, clean, sine_trace

NAMES = [measure.name for measure in MEASURES]


def _curve(trace, mean=0.3e-6, second=0.2e-6, angle=0.7):
    turn = 2 * np.pi / trace.period * np.arange(len(trace.time))
    return mean + 8e-6 * np.sin(turn - 0.5) + second * np.sin(2 * turn + angle)


@pytest.mark.parametrize("per_period", [50.0, 37.3])
def test_known_asymmetries_are_found(per_period):
    trace = sine_trace("a.csv", 8.0, 317.0, per_period=per_period)
    exact = _curve(trace)
    noise = np.random.default_rng(1).normal(0.0, SIGMA, len(exact))
    rows = offsets(replace(trace, response=exact + noise), exact)
    assert rows is not None
    at_zero, at_half = (0.3e-6 + 8e-6 * np.sin(a - 0.5) + 0.2e-6 * np.sin(2 * a + 0.7) for a in (0.0, np.pi))
    dense = np.linspace(0, 2 * np.pi, 200_001)
    dwell = np.mean(8e-6 * np.sin(dense - 0.5) + 0.2e-6 * np.sin(2 * dense + 0.7) > 0) - 0.5
    truth = [0.3e-6, 0.2e-6, 0.7, dwell, (at_zero + at_half) / 2, at_zero - at_half]
    for row, value in zip(rows, truth, strict=True):
        slack = 1e-5 if row.measure.unit == "1" else 0.0  # the truth itself was counted on a grid
        assert row.model.value == pytest.approx(value, rel=2e-4, abs=slack), row.measure.name
        assert abs(row.data.value - value) < 5 * row.data.error, row.measure.name
        assert abs(row.difference.value) < 5 * row.difference.error, row.measure.name


def test_the_error_of_the_mean_is_that_of_the_noise():
    trace = sine_trace("a.csv", 8.0, 317.0)
    rows = offsets(trace, clean(trace))
    assert rows is not None
    expected = SIGMA / np.sqrt(len(trace.time) // 2)
    assert expected * 0.8 < rows[0].data.error < expected * 2.0


def test_slow_noise_makes_the_mean_less_certain():
    trace = sine_trace("a.csv", 8.0, 317.0)
    slow = replace(trace, noise=NoiseFloor(SIGMA, ar=(0.95,)))
    white_rows, slow_rows = offsets(trace, clean(trace)), offsets(slow, clean(trace))
    assert white_rows is not None and slow_rows is not None
    # √((1 + a)/(1 − a)) for the first-order process
    assert slow_rows[0].data.error == pytest.approx(SIGMA / np.sqrt(800) * np.sqrt(1.95 / 0.05), rel=0.2)


def test_a_symmetric_response_has_no_offset():
    trace = sine_trace("a.csv", 8.0, 317.0)
    rows = offsets(trace, clean(trace))
    assert rows is not None
    for name in ("mean over periods", "2nd harmonic", "dwell asymmetry", "at drive zeros, mean"):
        row = rows[NAMES.index(name)]
        assert abs(row.model.value) < 1e-12
        assert abs(row.data.value) < 5 * row.data.error


def test_the_crossings_are_those_of_the_drive_with_its_own_mean():
    trace = sine_trace("a.csv", 8.0, 317.0)
    shifted = replace(trace, drive=trace.drive + 2.0)
    rows = offsets(shifted, clean(trace))
    assert rows is not None
    early = np.arcsin(2.0 / 8.0)
    rising, falling = 8e-6 * np.sin(-early - 0.5), 8e-6 * np.sin(np.pi + early - 0.5)
    assert rows[4].model.value == pytest.approx((rising + falling) / 2, rel=1e-6)
    assert rows[5].model.value == pytest.approx(rising - falling, rel=1e-6)


def test_records_that_cannot_be_folded_have_no_offsets(make_fit):
    trace = sine_trace("a.csv", 8.0, 317.0)
    assert offsets(replace(trace, period=None), clean(trace)) is None
    assert offsets(replace(trace, drive=np.zeros_like(trace.drive)), clean(trace)) is None


def test_the_table_marks_what_the_model_misses(make_fit):
    trace = sine_trace("a.csv", 8.0, 317.0, offset=0.3e-6)
    fit = make_fit(traces=(trace,))
    sheet = offset_sheet(trace, fit.readings[0], fit.model.device)
    assert sheet is not None
    assert "8 V sine at 317 Hz" in sheet.title
    assert sheet.marks[0] == "warning"  # the model has no mean
    assert sheet.rows[0][1].startswith("300")
    assert sheet.rows[0][4] == "nm"
