"""A law as a table where no short formula says it: of a product, or of a function of one coordinate.

What the model's linear part has already is taken out of each spline along the motion, so that this part stays as it was
fitted. Beyond the motion a table goes on level: tangents at its ends, where the records seldom were, led away from a
pendulum beside a magnet twice as far as that.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...effects.dependence import Side
from ..linearised.regression import Regression
from .coordinates import Stage, absorbed
from .formula import Formula, fitted, goal, measured
from .products import Product
from .splines import Places, Size
from .terms import Term, bumps, number

_PIECES = (12, 24, 48)  # splines of a curve: as few as say it


def tabled(regression: Regression, stage: Stage, side: Side, product: Product, spline_drop: float) -> Formula | None:
    """A product with its function as a table; None if the model absorbs all of it."""
    ranges, seen = stage.ranges(side), stage.modelled if side == "sensor" else stage.moved
    words = measured(regression, stage, side, product.table(side, ranges, seen))
    if not words.terms:
        return None
    found = fitted(regression, stage, side, words, range(len(words.terms)), goal(regression, spline_drop))
    grid = np.linspace(*ranges[product.of].mostly, 99)
    place = {product.of: grid, product.by: np.full_like(grid, ranges[product.by].largest)}
    factor = product.scale(ranges) * product.height
    law = found.coefficients @ np.stack([term.value(place) for term in found.terms]) / factor
    return _told(found, found.terms[0].law, law, product.known(side))


def curve(regression: Regression, stage: Stage, side: Side, name: str, spline_drop: float) -> Formula | None:
    """A function of one coordinate as a table that says what splines explain; None if none does."""
    own, seen = stage.ranges(side)[name], stage.modelled if side == "sensor" else stage.moved
    low, high = own.mostly
    own = own._replace(low=low, high=high)
    known = absorbed(side, name)
    for pieces in _PIECES:
        terms = bumps(name, own, gauge=known, knots=pieces)
        terms = [_level(term, name, own, seen) for term in terms] if known else terms
        words = measured(regression, stage, side, terms)
        if not words.terms:
            continue
        found = fitted(regression, stage, side, words, range(len(words.terms)), goal(regression, spline_drop))
        if found.complete:
            place = {name: np.linspace(low, high, 99)}
            law = found.coefficients @ np.stack([term.value(place) for term in found.terms])
            return _told(found, f"g({name})", law, known)
    return None


def _level(term: Term, name: str, size: Size, seen: Sequence[Places]) -> Term:
    """A term less its best straight line through zero along the motion, as far as the table goes."""
    low, high = size.low / size.largest, size.high / size.largest
    along = lambda place: np.clip(place[name] / size.largest, low, high)
    x = np.concatenate([along(place).ravel() for place in seen])
    slope = float(x @ np.concatenate([term.value(place).ravel() for place in seen]) / (x @ x))
    knot = term.knot and term.knot._replace(slope=slope)
    return term._replace(knot=knot, value=lambda place: term.value(place) - slope * along(place))


def _told(found: Formula, g: str, law: np.ndarray, known: bool) -> Formula:
    least, most = (number(float(x)).replace("-", "−") for x in (law.min(), law.max()))
    text = f"{'reading = z +' if found.side == 'sensor' else 'F ='} {g}, g from {least} to {most}"
    return found._replace(text=text + (" beside the model's own" if known else ""), tabled=True)
