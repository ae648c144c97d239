"""A short formula for what the splines have found, written in simple terms.

Terms are added one by one, several beginnings side by side, while each removes a fair part of what remains.

Source: D. A. Furnival, R. W. Wilson, 1974, Technometrics 16, 499 (best subsets of regressors); the weight of a term is
that of G. Schwarz, 1978, Ann. Stat. 6, 461, with 2 ln K for the choice among K terms.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ...effects.dependence import Side
from ..linearised.regression import Regression
from .coordinates import Stage, absorbed, rows_of
from .products import Product
from .subsets import regress
from .terms import Term, monomial, number, paired, remembered, single, table

_BEAM = 12  # beginnings followed side by side
_NEW = 1e-3  # squared share of a term that the others must leave for it to be added
_WORTH = 0.2  # part of the remaining excess that a further term must remove
_SAME, _LITTLE = 0.01, 0.1  # of what splines explain, and of what they leave: a formula that lacks no more says as much
_BARELY = 0.02  # of χ² per sample: formulas closer than that are equally good, and the plainest is taken
SHORT, _LONGEST = 3, 8  # terms
_FINER, _MORE = 2, 7  # rounds in which numbers are sought between those of a grid, and how many in each
_BEYOND = 1.3  # times the last number of a grid: as far as is looked beyond it

_Beginning = tuple[float, tuple[int, ...]]  # fall of χ², and the terms chosen


class Formula(NamedTuple):
    """A sum of terms.

    **Arguments:** `coefficients` and standard `errors`, one per term, SI; `drop` of χ²; `chi2_per_sample` after;
    `complete`: whether it explains nearly as much as the splines; `text`: "F = −3.1e9 z³"; `tabled`: whether it is a
    table.
    """

    side: Side
    terms: tuple[Term, ...]
    coefficients: np.ndarray
    errors: np.ndarray
    drop: float
    chi2_per_sample: float
    complete: bool
    text: str
    tabled: bool = False

    @property
    def one(self) -> bool:
        """Whether it is a single law: one term, a function of one coordinate times another, or terms that all need both
        of two coordinates, which sums of laws of one do not make."""
        both = {frozenset(term.names) for term in self.terms}
        return len(self.terms) == 1 or bool(self.terms[0].law) or (len(both) == 1 and len(min(both)) == 2)

    @property
    def numbers(self) -> int:
        """How many numbers it has, one that several terms share counted once."""
        widths = {term.width for term in self.terms if term.width and term.width.fitted}
        return len(self.terms) + len(widths) + len({(t.kind, t.number.value) for t in self.terms if t.number})


class Dictionary(NamedTuple):
    """Terms with their projected rows (k, n), each of raw length one, and those `lengths`."""

    terms: tuple[Term, ...]
    rows: np.ndarray
    lengths: np.ndarray


def dictionary(
    regression: Regression, stage: Stage, side: Side, coordinates: tuple[str, ...], product: Product | None = None
) -> Dictionary:
    """The simple terms of a set of coordinates that the model does not absorb; of a product, its own alone."""
    names = [name for name in coordinates if name not in ("1", "history")]
    ranges, terms = stage.ranges(side), [monomial([])]
    if product is not None:
        terms = product.words(ranges)
    else:
        for name in names:
            terms += single(name, ranges[name])
    if "history" in coordinates:
        terms += remembered(names[0], ranges[names[0]], regression.fit.scales.period)
    elif product is None and len(names) == 2:
        terms += paired(names[0], names[1])
    found = measured(regression, stage, side, terms)
    for inside in (*[_within] * _FINER, _at_top):
        found = _between(regression, stage, side, found, inside)
    return found


def _between(
    regression: Regression, stage: Stage, side: Side, coarse: Dictionary, inside: Callable[..., np.ndarray]
) -> Dictionary:
    """The dictionary with more terms around the best of each family: a grid of their numbers is a tenth off, and where
    a misfit stands far above the noise no term of it then says all that one can."""
    more: list[Term] = []
    # A brake that fades is a peak beside a damping, and another peak by itself, where the model does not absorb that.
    linear = coarse.rows[[i for i, term in enumerate(coarse.terms) if term.linear]]
    for by_value in _by_number(coarse).values():
        values = np.array(sorted(by_value))
        own = [np.concatenate([linear, coarse.rows[by_value[value]]]) for value in values]
        drops = np.array([regress(rows, regression.residual).drop for rows in own])
        best = by_value[values[np.argmax(drops)]]
        new = [x for x in inside(values, drops) if not np.any(np.isclose(x, values, atol=0.0))]
        more += [again(float(x)) for x in new for i in best if (again := coarse.terms[i].again) is not None]
    found = measured(regression, stage, side, more) if more else coarse._replace(terms=())
    rows, lengths = (np.concatenate(pair) for pair in ((coarse.rows, found.rows), (coarse.lengths, found.lengths)))
    return Dictionary((*coarse.terms, *found.terms), rows, lengths) if found.terms else coarse


def _by_number(words: Dictionary) -> dict[str, dict[float, list[int]]]:
    """Places of the terms of each kind, by their number: several that share one say most together, as a wave has a
    phase."""
    found: dict[str, dict[float, list[int]]] = {}
    for i, term in enumerate(words.terms):
        if term.kind and term.number is not None:
            found.setdefault(term.kind, {}).setdefault(term.number.value, []).append(i)
    return found


def _within(values: np.ndarray, drops: np.ndarray) -> np.ndarray:
    """Values between the neighbours of the best one, or beyond the ends."""
    best, around = int(np.argmax(drops)), np.concatenate([values[:1] / _BEYOND, values, values[-1:] * _BEYOND])
    return np.geomspace(around[best], around[best + 2], _MORE)


def _at_top(values: np.ndarray, drops: np.ndarray) -> np.ndarray:
    """Where a parabola through the best value and its neighbours is highest."""
    best = int(np.argmax(drops))
    if not 0 < best < len(values) - 1:
        return np.zeros(0)
    near = slice(best - 1, best + 2)
    x = np.log(values[near] / values[best])
    bend, slope, _ = np.polyfit(x, drops[near], 2)
    return values[best] * np.exp(np.clip(-slope / (2 * bend), x[0], x[2]))[None] if bend < 0 else np.zeros(0)


def measured(regression: Regression, stage: Stage, side: Side, terms: Sequence[Term]) -> Dictionary:
    """Terms with their rows, without those of which the model absorbs all."""
    raw = rows_of(regression, stage, side, lambda place: np.stack([term.value(place) for term in terms]))
    lengths = np.linalg.norm(raw, axis=1)
    rows = regression.project(raw / np.maximum(lengths, 1e-300)[:, None])
    new = (np.sum(rows**2, axis=1) > _NEW) & (lengths > 0)
    return Dictionary(tuple(t for t, keep in zip(terms, new, strict=True) if keep), rows[new], lengths[new])


def write_formula(
    regression: Regression, stage: Stage, side: Side, words: Dictionary, spline_drop: float, longest: int = SHORT
) -> Formula | None:
    """The shortest formula of at most `longest` terms that explains what the splines explain, or the best there is.

    None if no term says anything.
    """
    if not words.terms:
        return None
    gram, along = words.rows @ words.rows.T, words.rows @ regression.residual
    enough = goal(regression, spline_drop)
    together = [own for by_value in _by_number(words).values() for own in by_value.values() if len(own) == 2]
    known: list[dict[tuple[int, ...], float]] = [{} for _ in range(longest + 1)]  # by the number of terms
    beam = reached = [(0.0, ())]
    for count in range(longest):  # two terms may only say something together, so none is refused before the end
        for chosen, drop in _extend(gram, along, reached, together if count + 2 <= longest else []).items():
            known[len(chosen)][chosen] = drop
        reached = sorted(((drop, chosen) for chosen, drop in known[count + 1].items()), reverse=True)[:_BEAM]
        if not reached:
            break
        if _worth(regression, beam[0], reached[0], len(words.terms), longest):
            beam = reached
        if beam[0][0] >= enough:
            break
    same = beam[0][0] - _BARELY * regression.n
    numbers = lambda chosen: sum(words.terms[i].number is not None for i in chosen)
    plainest = min((chosen for drop, chosen in beam if drop >= same), key=numbers)
    return fitted(regression, stage, side, words, plainest, enough) if plainest else None


def goal(regression: Regression, spline_drop: float) -> float:
    """The fall of χ² from which a formula says as much as the splines, which may follow noise, too."""
    spline_drop = min(spline_drop, max(regression.chi2 - regression.n, 0.0))
    left = max(regression.chi2 - spline_drop, float(regression.n))
    return max((1 - _SAME) * spline_drop, spline_drop - _LITTLE * left)


def _extend(
    gram: np.ndarray, along: np.ndarray, beam: list[_Beginning], together: Sequence[Sequence[int]]
) -> dict[tuple[int, ...], float]:
    """Formulas with one term more, the best of each beginning, or with two that belong together: their falls of χ²."""
    found: dict[tuple[int, ...], float] = {}
    pairs = np.array(together, dtype=int).reshape(-1, 2).T
    for drop, chosen in beam:
        picked = list(chosen)
        solved = np.linalg.solve(gram[np.ix_(picked, picked)], gram[picked]) if picked else np.zeros((0, len(along)))
        left = np.diag(gram) - np.sum(gram[picked] * solved, axis=0)
        rest = along - solved.T @ along[picked]
        gain = rest**2 / np.where(left > _NEW * np.diag(gram), left, np.inf)
        for j in np.argsort(-gain)[:_BEAM]:
            if gain[j] > 0:
                found[tuple(sorted((*chosen, int(j))))] = drop + float(gain[j])
        first, second = pairs
        slope = gram[first, second] - np.sum(gram[picked][:, first] * solved[:, second], axis=0)
        slope = slope / np.where(gain[first] > 0, left[first], np.inf)
        apart = left[second] - slope**2 * left[first]  # what the second leaves of itself beside the first
        own = (rest[second] - slope * rest[first]) ** 2
        new = (gain[first] > 0) & (apart > _NEW * np.diag(gram)[second])
        gains = np.where(new, gain[first] + own / np.where(new, apart, np.inf), 0.0)
        for j in np.argsort(-gains)[:_BEAM]:
            if gains[j] > 0:
                found[tuple(sorted((*chosen, *together[j])))] = drop + float(gains[j])
    return found


def _worth(regression: Regression, before: _Beginning, after: _Beginning, choices: int, longest: int) -> bool:
    """Whether the terms that one formula has more than another remove enough."""
    more, gain = len(after[1]) - len(before[1]), after[0] - before[0]
    left = max(1.0, (regression.chi2 - after[0]) / regression.n)
    price = (np.log(regression.n) + 2 * np.log(choices)) * left
    part = _WORTH if longest <= SHORT else 0.1 * _WORTH
    return gain > more * price and gain > (1 - (1 - part) ** more) * (regression.chi2 - before[0] - regression.n)


def fitted(
    regression: Regression, stage: Stage, side: Side, words: Dictionary, chosen: Sequence[int], enough: float
) -> Formula:
    """The formula of given terms, by least squares; `enough`: the fall of χ² from which it is complete."""
    picked = list(chosen)
    solved = regress(words.rows[picked], regression.residual)
    after = (regression.chi2 - solved.drop) / regression.n
    unit = stage.sensor_unit if side == "sensor" else stage.force_unit
    scale = unit / words.lengths[picked]
    errors = np.linalg.norm(solved.spread, axis=1) * np.sqrt(max(after, 1.0)) * scale
    terms = tuple(words.terms[i] for i in picked)
    coefficients = solved.coefficients * scale
    text = _text(side, terms, coefficients)
    return Formula(side, terms, coefficients, errors, solved.drop, after, solved.drop >= enough, text)


def long_formula(
    regression: Regression, stage: Stage, side: Side, coordinates: tuple[str, ...], spline_drop: float
) -> Formula | None:
    """What a file is written from where no short formula is enough: a table of one coordinate, else many terms.

    None if no term says anything: beside a motion that forgets how it began, all that any force does looks the same.
    """
    words = dictionary(regression, stage, side, coordinates)
    if len(coordinates) == 2 and "history" not in coordinates:
        words = measured(regression, stage, side, [*words.terms, *paired(*coordinates, degree=7)])
    found = write_formula(regression, stage, side, words, spline_drop, _LONGEST)
    name = coordinates[0]
    if found is None and words.terms:
        found = fitted(regression, stage, side, words, [0], np.inf)
    if len(coordinates) > 1 or name == "1":
        return found
    words = measured(regression, stage, side, table(name, stage.ranges(side)[name], gauge=absorbed(side, name)))
    if not words.terms:
        return found
    curve = fitted(regression, stage, side, words, range(len(words.terms)), goal(regression, spline_drop))
    return found if found is not None and found.drop > curve.drop else curve


def _text(side: Side, terms: Sequence[Term], coefficients: np.ndarray) -> str:
    written = [(c / term.written, term.text) for term, c in zip(terms, coefficients, strict=True)]
    parts = [f"{'−' if c < 0 else '+'} {number(abs(c))}{'' if text == '1' else ' ' + text}" for c, text in written]
    joined = " ".join(parts)
    if side == "sensor":
        return f"reading = z {joined}"
    return "F = " + (joined[2:] if joined.startswith("+ ") else "−" + joined[2:])
