"""A function of one coordinate times another coordinate: a damping, stiffness or drive that varies.

Such a law has as many numbers as a function of one coordinate, so it can be resolved far finer than a function of two,
and says more: the damper itself, over the place or the voltage, and not only that force depends on both.

Source: T. Hastie, R. Tibshirani, 1993, J. R. Stat. Soc. B 55, 757 (varying-coefficient models).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...effects.dependence import Side
from .coordinates import absorbed
from .splines import Places, Size, sharp, splines
from .terms import TURNS, Term, bumps, monomial, number, single, step_width

# Splines over the coordinate with which it varies: for a brake over a tenth of the motion 12 leave 1.18 times the χ² of
# noise and 24 leave 1.00; a refit with 48 had no bound where the motion seldom was.
_FIRST, PIECES = 12, 24


class Factor(NamedTuple):
    """What the function is multiplied by.

    **Arguments:** `text` and `code` with {n}, the coordinate, and {w}, the width of its step; `power` of its unit;
    `value` of x/largest; `linear`: whether it is the coordinate itself; `width` of its step over the largest, if that
    is to be fitted.
    """

    text: str
    code: str
    power: int
    value: Callable[[np.ndarray], np.ndarray]
    linear: bool = False
    width: float = 0.0


def _turning(width: float) -> Factor:
    return Factor("tanh({n}/{w})", _TURNS_OVER, 0, lambda x: np.tanh(x / width), width=width)


_TURNS_OVER = "jnp.tanh({n} / {w})"
_LINEAR = Factor("{n}", "{n}", 1, lambda x: x, linear=True)
_SIGN = Factor("sign({n})", _TURNS_OVER, 0, sharp)
_SQUARE = Factor("{n}²", "{n}**2", 2, lambda x: x * x)
_FACTORS = {"z": (_LINEAR,), "v": (_LINEAR, _SIGN), "V": (_LINEAR, _SQUARE), "dV": (_LINEAR,)}
_SOFTER = {"v": tuple(_turning(width) for width in TURNS)}


class Product(NamedTuple):
    """A function of the coordinate `of`, in so many `pieces`, times a `factor` of the coordinate `by`."""

    of: str
    by: str
    factor: Factor
    pieces: int = _FIRST

    def functions(self, place: Places, ranges: Mapping[str, Size]) -> np.ndarray:
        """Splines of one coordinate times the factor of the other, without dimension, (k, lanes, points)."""
        return self.curves(place, ranges) * self.factor.value(place[self.by] / ranges[self.by].largest)

    def curves(self, place: Places, ranges: Mapping[str, Size]) -> np.ndarray:
        """The splines alone, (k, …), constant where the coordinate seldom was.

        They would follow the noise there, and a simulation that comes there had no bound.
        """
        return splines(place[self.of], self._inner(ranges), self.pieces)

    def scale(self, ranges: Mapping[str, Size]) -> float:
        """What the factor is divided by in `functions`."""
        return ranges[self.by].largest ** self.factor.power

    def _inner(self, ranges: Mapping[str, Size]) -> Size:
        low, high = ranges[self.of].mostly
        return ranges[self.of]._replace(low=low, high=high)

    @property
    def powers(self) -> tuple[tuple[str, int], ...]:
        """Of the coordinates by whose units those of the function are divided."""
        return ((self.by, self.factor.power),) if self.factor.power else ()

    @property
    def softer(self) -> tuple[Product, ...]:
        """The same with a step that is as wide as to be seen."""
        return tuple(self._replace(factor=factor) for factor in _SOFTER.get(self.by, ()))

    @property
    def name(self) -> str:
        """ "v", "sign(v)" or "tanh(v/w)"."""
        return self.factor.text.format(n=self.by, w="w")

    def text(self, ranges: Mapping[str, Size]) -> str:
        """The same with its width."""
        return self.factor.text.format(n=self.by, w=number(self.factor.width * ranges[self.by].largest))

    def words(self, ranges: Mapping[str, Size]) -> list[Term]:
        """The factor, and simple functions of the one coordinate times it."""
        return [self._times(term, ranges) for term in (monomial([]), *single(self.of, ranges[self.of]))]

    def known(self, side: Side) -> bool:
        """Whether the model has the factor times a constant already."""
        return self.factor.linear and absorbed(side, self.by)

    def table(self, side: Side, ranges: Mapping[str, Size], seen: Sequence[Places]) -> list[Term]:
        """A table of the one coordinate times the factor.

        Where the model has the factor's constant already, each spline is written less its mean along the motion `seen`,
        weighed by the work that it does there: so the model's own stays as it was fitted.
        """
        found = bumps(self.of, self._inner(ranges), gauge=self.known(side), knots=self.pieces)
        if self.known(side):
            work = self.work(seen)
            found = [_less(term, float(np.average(_along(term, seen), weights=work))) for term in found]
        return [self._times(term, ranges) for term in found]

    def work(self, seen: Sequence[Places]) -> np.ndarray:
        """What a constant in the place of the function would do along the motion `seen`, (points,)."""
        return np.concatenate([self.factor.value(place[self.by]).ravel() ** 2 for place in seen])

    @property
    def height(self) -> float:
        """The factor at the largest value, over `scale`."""
        return float(self.factor.value(np.ones(3))[0])

    def _times(self, term: Term, ranges: Mapping[str, Size]) -> Term:
        largest = ranges[self.by].largest
        size, again, text = self.scale(ranges), term.again, self.text(ranges)
        code = self.factor.code.format(n=self.by, w="{w}")
        return term._replace(
            text=text if term.text == "1" else f"{term.text} {text}",
            code=code if term.code == "1.0" else f"{term.code} * {code}",
            names=tuple(dict.fromkeys((*term.names, self.by))),
            powers=(*term.powers, *self.powers),
            value=lambda x: term.value(x) * size * self.factor.value(x[self.by] / largest),
            law=f"g({self.of}) {text}",
            kind=term.kind and f"{term.kind} {text}",
            again=again and (lambda x: self._times(again(x), ranges)),
            width=step_width(self.by, ranges[self.by], self.factor.width) if self.factor.code == _TURNS_OVER else None,
        )


def _along(term: Term, seen: Sequence[Places]) -> np.ndarray:
    return np.concatenate([term.value(place).ravel() for place in seen])


def _less(term: Term, mean: float) -> Term:
    knot = term.knot and term.knot._replace(level=mean)
    return term._replace(knot=knot, value=lambda x: term.value(x) - mean)


def products(first: str, second: str, ranges: Mapping[str, Size]) -> Iterator[Product]:
    """The products of two coordinates: either may vary with the other, if they move at all."""
    for of, by in ((first, second), (second, first)):
        if any(ranges[name].low == ranges[name].high for name in (of, by)):
            continue
        for factor in _FACTORS.get(by, ()):
            yield Product(of, by, factor)
