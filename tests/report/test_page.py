"""Figures and the HTML page."""

from __future__ import annotations

import re
import sys
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from ident.campaign import Platform
from ident.fit.judge import score_record
from ident.report.figures.picture import Picture, draw_kept, drawn_as, from_dict
from ident.report.figures.records import record_figure
from ident.report.figures.style import envelope, new_figure, png
from ident.report.html import Section, write_report
from ident.report.words.sheet import Column, Sheet

from .conftest import clean, sine_trace

PNG = b"\x89PNG"


class _Links(HTMLParser):
    def __init__(self):
        super().__init__()
        self.outside, self.images, self.open = [], 0, []

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.images += tag == "img"
        self.outside += [v for k, v in attrs if k in ("src", "href") and not (v or "").startswith("data:")]
        if tag == "img":
            assert given.get("alt")
        if tag not in ("meta", "img", "link", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_the_page_stands_alone_and_shows_every_record(make_fit, tmp_path):
    fit = make_fit()
    path = write_report(fit, tmp_path / "run", {"command": "ident fit <campaign> -o run"})
    page = path.read_text(encoding="utf-8")
    links = _Links()
    links.feed(page)
    assert links.outside == [] and links.open == []
    assert "url(" not in page and "@import" not in page
    assert links.images == 1 + len(fit.campaign.traces)
    assert sorted(p.name for p in (tmp_path / "run" / "figures").iterdir()) == [
        "01_first_8V.png", "02_second_3V.png", "03_held_out_5V.png", "overview.png",
    ]  # fmt: skip
    for words in ("two sines", "Parameters", "74.391 ± 0.098 MPa", "wrong sign", "ab" * 32, "Zero-point offset"):
        assert words in page
    assert "ident fit &lt;campaign&gt; -o run" in page


def test_names_and_titles_cannot_break_the_page(make_fit, tmp_path):
    evil = "<script>alert(1)</script>.csv"
    fit = make_fit(traces=(sine_trace(evil, 8.0, 317.0),))
    page = write_report(fit, tmp_path).read_text(encoding="utf-8")
    assert "<script" not in page


def test_other_parts_of_the_program_add_sections(make_fit, tmp_path):
    sheet = Sheet("Ranking", (Column("effect"), Column("gain", True)), (("end-stop", "0.4"),))
    section = Section("What is missing", ["A paragraph."], [sheet], [Picture("a picture", PNG)])
    fit = make_fit(traces=(sine_trace("a.csv", 8.0, 317.0),))
    page = write_report(fit, tmp_path, {"sections": [section], "parent": "runs/0"}).read_text(encoding="utf-8")
    for words in ("What is missing", "A paragraph.", "Ranking", "end-stop", 'alt="a picture"', "runs/0"):
        assert words in page


def test_a_kept_picture_has_every_format_and_one_of_earlier_versions_says_what_it_lacks(tmp_path):
    kept = from_dict(draw_kept("caption", new_figure(2, 1)).as_dict())
    early = Picture("caption", kept.image)
    with drawn_as(("svg", "pdf")):
        assert {path.name for path in kept.write(tmp_path, "a")} == {"a.svg", "a.pdf"}
        assert kept.lacks == () and early.lacks == ("svg", "pdf")
    assert {path.name for path in kept.write(tmp_path, "b")} == {"b.png"}


def test_of_many_records_the_worst_are_drawn(make_fit, tmp_path, monkeypatch):
    monkeypatch.setattr("ident.report.html._MOST_FIGURES", 1)
    fit = make_fit(heldout_misfit=0.1)
    page = write_report(fit, tmp_path).read_text(encoding="utf-8")
    assert len(re.findall("<img", page)) == 2
    assert "Left out: first_8V.csv, second_3V.csv" in page
    assert "03_held_out_5V.png" not in page and (tmp_path / "figures" / "01_held_out_5V.png").exists()


@pytest.mark.parametrize(
    "change",
    [
        {},
        {"period": None},
        {"skip": 400},
        {"holdout": True, "load": 4e-5},
        {"drive": np.zeros(1600), "period": None},
        {"drive": np.linspace(-1.0, 8.0, 1600), "period": None},
    ],
)
def test_every_kind_of_record_can_be_drawn(change):
    trace = sine_trace("a.csv", 8.0, 317.0)
    reading = clean(trace)
    trace = replace(trace, **change)
    assert png(record_figure(trace, reading, score_record(trace, reading), Platform())).startswith(PNG)


def test_a_long_record_is_shown_in_pieces_with_its_true_times():
    trace = sine_trace("a.csv", 8.0, 317.0, samples=20_000)
    reading = clean(trace)
    figure = record_figure(trace, reading, score_record(trace, reading), Platform())
    assert len(figure.axes[0].lines) == 6
    assert [text.get_text() for text in figure.axes[0].get_xticklabels()][-1] == "1262"  # ms


def test_a_figure_has_units_on_its_axes():
    trace = sine_trace("a.csv", 8.0, 317.0)
    figure = record_figure(trace, clean(trace), score_record(trace, clean(trace)), Platform())
    labels = [text for axes in figure.axes for text in (axes.get_xlabel(), axes.get_ylabel()) if text]
    assert labels == [
        "displacement (µm)", "time (ms)", "÷ noise floor", "drive phase (°)", "displacement (µm)", "drive (V)",
        "displacement (µm)",
    ]  # fmt: skip
    assert "8 V sine at 317 Hz" in figure.texts[0].get_text()


def test_a_record_is_drawn_to_its_end():
    values = np.zeros(4000)  # no multiple of the bins
    values[-2] = 7.0
    time, shown = envelope(np.arange(4000.0), values)
    assert shown[-1] == 7.0 and time[-1] >= 3995


def test_the_envelope_keeps_every_peak():
    values = np.zeros(50_000)
    values[12_345], values[40_001] = 7.0, -5.0
    _, shown = envelope(np.arange(50_000.0), values)
    assert len(shown) < 2_000
    assert (shown.max(), shown.min()) == (7.0, -5.0)


def test_pyplot_is_never_imported(make_fit, tmp_path):
    had = "matplotlib.pyplot" in sys.modules
    write_report(make_fit(traces=(sine_trace("a.csv", 8.0, 317.0),)), tmp_path)
    assert had or "matplotlib.pyplot" not in sys.modules
