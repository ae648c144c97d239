"""The picture of a free decay."""

from __future__ import annotations

import numpy as np

from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.fit.judge import score_record
from ident.report.figures.records import record_figure

ONE = Channel("V", 1.0)


def test_a_decay_shows_frequency_and_damping_against_amplitude_and_a_driven_record_does_not():
    t = 1e-3 * np.arange(3000)
    response = np.exp(-2 * t) * np.cos(2 * np.pi * 30 * t)
    for drive, beside in ((np.zeros(len(t)), 2), (np.random.default_rng(0).normal(size=len(t)), 1)):
        record = Trace("a.csv", t, drive, response, ONE, ONE, NoiseFloor(1e-4), "unknown")
        figure = record_figure(record, 0.9 * response, score_record(record, 0.9 * response), Oscillator())
        assert len(figure.axes) == 2 + beside
        shown = [axes.get_ylabel() for axes in figure.axes[2:]]
        assert (shown == ["frequency (Hz)", "decay rate (1/s)"]) == (beside == 2)
