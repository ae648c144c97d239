"""What figures are drawn on: matplotlib's own canvas, but a word that stood in one figure is drawn from its image in
the next.

Axes of a dozen figures say much the same, and of the time that a figure takes half went into setting its letters, one
by one. Words are placed to the pixel, as matplotlib did until 3.10.
"""

from __future__ import annotations

import struct
import zlib
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg, RendererAgg, get_hinting_flag
from matplotlib.font_manager import FontProperties, findfont, get_font

_PACKING = 2  # of zlib: more takes twice as long for a tenth


class Canvas(FigureCanvasAgg):
    """A canvas that sets words from their images, and takes every text as it is: "$" begins no formula."""

    def get_renderer(self) -> RendererAgg:
        return _renderer(*self.get_width_height(physical=True), self.figure.dpi)

    def as_png(self) -> bytes:
        """The figure, drawn, as a PNG file.   ISO/IEC 15948, rows without a filter: a drawing is mostly empty."""
        self.draw()
        pixels = np.asarray(self.buffer_rgba())
        height, width = pixels.shape[:2]
        rows = np.concatenate([np.zeros((height, 1), np.uint8), pixels.reshape(height, -1)], axis=1)
        head = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
        parts = (b"IHDR", head), (b"IDAT", zlib.compress(rows.tobytes(), _PACKING)), (b"IEND", b"")
        return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(*part) for part in parts)


def _chunk(name: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))


@lru_cache(maxsize=2)  # the figures of a page have few sizes; each holds an image of some megabytes
def _renderer(width: float, height: float, dpi: float) -> _Renderer:
    return _Renderer(width, height, dpi)


class _Renderer(RendererAgg):
    def draw_text(
        self, gc: Any, x: float, y: float, s: str, prop: FontProperties, angle: float, ismath: Any = False,
        mtext: Any = None,
    ) -> None:  # fmt: skip
        word = _word(s, findfont(prop), prop.get_size_in_points(), self.dpi)
        if word is None or angle not in (0.0, 90.0):
            return super().draw_text(gc, x, y, s, prop, angle, False, mtext)
        letters, below = word.letters, word.below
        if angle == 0.0:
            left, bottom = round(x + word.right), round(y + below)
        else:
            letters, left, bottom = np.rot90(letters), round(x + below) - len(letters), round(y - word.right)
        image = np.empty((*letters.shape, 4), np.uint8)
        image[..., :3] = np.round(255 * np.asarray(gc.get_rgb()[:3]))
        image[..., 3] = letters
        self.draw_image(gc, left, int(self.height) - bottom, image[::-1])  # from below, as are its rows

    def get_text_width_height_descent(self, s: str, prop: FontProperties, ismath: Any) -> tuple[float, float, float]:
        word = _word(s, findfont(prop), prop.get_size_in_points(), self.dpi)
        return super().get_text_width_height_descent(s, prop, False) if word is None else word.size


class _Word(NamedTuple):
    """Width, height and descent (pixels), the image (its opacity), and where that ends below and begins to the right of
    the point at which the word stands."""

    size: tuple[float, float, float]
    letters: np.ndarray
    below: float
    right: float


@lru_cache(maxsize=2000)
def _word(text: str, file: str, size: float, dpi: float) -> _Word | None:
    """A word set in a font, or None if the font lacks a letter of it."""
    font = get_font(file)
    if not all(font.get_char_index(ord(letter)) for letter in text):
        return None
    font.clear()
    font.set_size(size, dpi)
    font.set_text(text, 0.0, flags=get_hinting_flag())
    font.draw_glyphs_to_bitmap(antialiased=True)
    width, height = font.get_width_height()
    descent = font.get_descent() / 64
    letters = np.asarray(font.get_image()).copy()
    return _Word((width / 64, height / 64, descent), letters, descent + 1, font.get_bitmap_offset()[0] / 64)
