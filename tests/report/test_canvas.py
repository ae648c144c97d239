"""The canvas of figures: the same picture as matplotlib's own, sooner."""

from __future__ import annotations

import io

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from ident.report.figures.canvas import Canvas
from ident.report.figures.style import label, new_axes, new_figure, png


def _drawn(words: str, rotation: float = 0.0):
    figure = new_figure(4.0, 3.0)
    axes = new_axes(figure, 0.2, 0.2, 0.7, 0.6)
    axes.plot([0, 1, 2], [3, -2, 5])
    label(axes, "time (ms)", "÷ noise floor", "a heading")
    figure.text(0.5, 0.5, words, rotation=rotation, color="#cc3300", weight="bold")
    return figure


def _pixels(image: bytes) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(image)).convert("L"), float)


@pytest.mark.filterwarnings("ignore:Glyph .* missing from font")  # of letters that matplotlib's fonts lack
@pytest.mark.parametrize(("words", "rotation"), [("Ágj 12.5", 0), ("Ágj 12.5", 90), ("slanted", 30), ("漢字", 0)])
def test_words_stand_where_matplotlib_puts_them(words, rotation):
    figure = _drawn(words, rotation)
    assert isinstance(figure.canvas, Canvas)
    ours = _pixels(png(figure))
    again = _pixels(png(figure))
    FigureCanvasAgg(figure)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=100)
    theirs = _pixels(buffer.getvalue())
    assert ours.shape == theirs.shape == (300, 400)
    np.testing.assert_array_equal(ours, again)
    near = [np.roll(theirs, shift, axis) for axis in (0, 1) for shift in (-1, 0, 1)]
    assert np.mean(ours < 128) == pytest.approx(np.mean(theirs < 128), rel=0.15)
    assert np.mean(np.min([np.abs(ours - one) for one in near], axis=0) > 100) < 5e-4  # at most a pixel apart


def test_a_sign_of_money_begins_no_formula():
    ink = [np.sum(255 - _pixels(png(_drawn(words)))) for words in ("", "a $x_1$ b", "a x_1 b")]
    assert ink[1] > ink[2] > ink[0]


def test_the_picture_is_a_png_of_a_page():
    image = png(_drawn("x"))
    assert image.startswith(b"\x89PNG\r\n\x1a\n") and len(image) < 60_000
    Image.open(io.BytesIO(image)).verify()
