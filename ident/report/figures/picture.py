"""A figure as the page shows it, and as files in the formats that a paper asks for."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

from .style import png, vector

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = ("png", "svg", "pdf")
_asked: ContextVar[tuple[str, ...]] = ContextVar("formats of figures", default=("png",))


class Picture(NamedTuple):
    """A PNG with the words that stand for it, and the same figure in further formats."""

    caption: str
    image: bytes
    others: Mapping[str, bytes] = MappingProxyType({})

    @property
    def files(self) -> dict[str, bytes]:
        """The figure in every format that it has."""
        return {"png": self.image, **self.others}

    @property
    def source(self) -> str:
        return "data:image/png;base64," + base64.b64encode(self.image).decode("ascii")

    @property
    def lacks(self) -> tuple[str, ...]:
        """The formats that were asked for and that it does not have."""
        return tuple(f for f in _asked.get() if f not in self.files)

    def write(self, folder: Path, name: str) -> list[Path]:
        """Write it as `name.png` and so on, in the formats that were asked for and that it has; the files."""
        paths = {folder / f"{name}.{f}": content for f, content in self.files.items() if f in _asked.get()}
        for path, content in paths.items():
            path.write_bytes(content)
        return list(paths)

    def as_dict(self) -> dict[str, str]:
        """Caption and base64 of every format, for JSON."""
        return {"caption": self.caption} | {f: base64.b64encode(c).decode("ascii") for f, c in self.files.items()}


def draw(caption: str, figure: Figure) -> Picture:
    """A figure as a picture, in the formats that were asked for."""
    return Picture(caption, png(figure), {format: vector(figure, format) for format in _asked.get() if format != "png"})


def draw_kept(caption: str, figure: Figure) -> Picture:
    """A figure as a picture in every format: what it shows is not kept, so whoever writes it later draws nothing."""
    with drawn_as(FORMATS):
        return draw(caption, figure)


def from_dict(told: Mapping[str, Any]) -> Picture:
    """The picture that `as_dict` told."""
    files = {format: base64.b64decode(told[format]) for format in FORMATS if format in told}
    return Picture(told["caption"], files.pop("png"), files)


@contextmanager
def drawn_as(formats: tuple[str, ...]) -> Iterator[None]:
    """Figures are written in these formats while this lasts."""
    before = _asked.set(formats)
    try:
        yield
    finally:
        _asked.reset(before)


@contextmanager
def drawn_as_before(figures: Path) -> Iterator[None]:
    """Figures are also written in the formats that are in this folder, so that a page made anew loses none."""
    there = tuple(f for f in FORMATS if f not in _asked.get() and any(figures.glob(f"*.{f}")))
    with drawn_as((*_asked.get(), *there)):
        yield
