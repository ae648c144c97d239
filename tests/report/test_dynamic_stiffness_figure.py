"""The picture of curves before any fit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from ident.campaign import read_campaign
from ident.report.figures.dynamic_stiffness import dynamic_stiffness_figure

DATA = Path(__file__).resolve().parents[2] / "data"


def test_the_picture_shows_both_laws_and_says_what_they_show():
    campaign = read_campaign(DATA / "platform_sweeps")
    figure = dynamic_stiffness_figure(campaign)
    assert figure is not None
    assert [axes.get_ylabel() for axes in figure.axes] == ["natural frequency (Hz)", "damping rate (1/s)"]
    low, high = figure.axes[0].get_ylim()
    assert low < 499 and high > 511.5
    words = " ".join(text.get_text() for text in figure.texts)
    assert "rises with the amplitude" in words and "3.00 V" in words and "9.00 V" in words


def test_without_phase_there_is_no_picture():
    campaign = read_campaign(DATA / "platform_sweeps")
    alone = replace(campaign, records=tuple(replace(sweep, phase=None) for sweep in campaign.sweeps))
    assert dynamic_stiffness_figure(alone) is None
