"""On which coordinates does what is missing depend, and on which side does it act?

A missing force is pushed through the model's own dynamics, a missing sensor term is added to the readings. Either is
sought as a sum of splines of a few coordinates, by least squares on what the fit leaves, with everything that the model
can absorb projected out. The smallest set of coordinates that explains almost as much as the best one is the answer.

Source: S. F. Masri, T. K. Caughey, 1979, J. Appl. Mech. 46, 433 (force surfaces, here in output-error form);
G. Schwarz, 1978, Ann. Stat. 6, 461 (the criterion).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np

from ...effects.dependence import Side
from ..linearised.regression import Regression
from .coordinates import Stage, rows_of, set_stage
from .products import PIECES, Product, products
from .splines import Places, one, pair

SINGLES = (("z",), ("v",), ("V",), ("dV",), ("t",))
PAIRS = (("z", "v"), ("z", "V"), ("z", "dV"), ("v", "V"), ("v", "dV"), ("V", "dV"), ("z", "t"), ("v", "t"), ("V", "t"))
HISTORIES = (("z", "history"), ("V", "history"))
TRIED = 115  # sets of functions, at most, coarse and fine: what a chance probability is multiplied by
NEAR = 0.01  # of the best set's gain: a smaller set that lacks no more explains "almost as much" …
_NEARLY_ALL, _NEAR_ALL = 0.995, 0.003  # … but less may be lacking where the best set explains everything
_PROMISING = 4  # pairs, the best by the criterion, that are tried as products
_FEW = 2  # blurred forms of a product, the best of them, that are resolved more finely
_SCATTER = 3.0  # standard deviations of the χ² of noise: while more than that is left, more is sought
_FINER = ("z", "v", "V")  # coordinates over which a law may turn to and fro: cogs, fringes, steps of an amplifier
_PIECES = (36, 72, 144)  # splines over one of them, where the first few leave more than these cost: up to thirty turns
_NULL = 1e-7  # squared share of a combination of rows that must survive the projection


Block = tuple[str, ...] | Product


class Ranked(NamedTuple):
    """One set of coordinates on one side.

    **Arguments:** `drop`: fall of χ²; `dof`: directions used; `share`: of the excess over noise that it explains;
    `chi2_per_sample` after; `criterion`: χ² + dof ln n, a width counted too, in units of what is left (Schwarz);
    `product`: whose functions these are, where those of one coordinate times the other say it with less.
    """

    side: Side
    coordinates: tuple[str, ...]
    drop: float
    dof: int
    share: float
    chi2_per_sample: float
    criterion: float
    product: Product | None = None

    @property
    def blocks(self) -> tuple[Block, ...]:
        """The blocks of functions that say it."""
        return blocks_of(self.coordinates) if self.product is None else (self.product,)


def side_of(coordinates: Sequence[str]) -> Side:
    """Where a force of these coordinates acts: what depends on the drive alone comes through the actuator."""
    return "drive" if set(coordinates) & {"V", "dV"} and not set(coordinates) & {"z", "v"} else "force"


def functions_of(stage: Stage, side: Side, block: Block, place: Places) -> np.ndarray:
    """The functions of one block, without dimension, (k, lanes, points)."""
    if isinstance(block, Product):
        return block.functions(place, stage.ranges(side))
    if block == ("1",):
        return np.ones((1, *place["z"].shape))
    if block[-1] == "history":
        return place[f"{block[0]} history"] / stage.ranges(side)[block[0]].largest
    if len(block) == 1:
        return one(block[0], place, stage.ranges(side)[block[0]])
    return pair((block[0], block[1]), place, stage.ranges(side))


def blocks_of(coordinates: tuple[str, ...]) -> tuple[Block, ...]:
    """The blocks of functions of a set of coordinates: those of each alone, and those of both."""
    if len(coordinates) == 1:
        return (coordinates,)
    return (*((name,) for name in coordinates if name != "history"), coordinates)


class Solution(NamedTuple):
    """A regression on k rows.

    **Arguments:** `drop`: fall of χ²; `dof`: directions used; `coefficients` (k,); `spread` (k, dof): the directions,
    so that `rows.T @ spread` is orthonormal and `spread @ spread.T` is the covariance for white noise of one.
    """

    drop: float
    dof: int
    coefficients: np.ndarray
    spread: np.ndarray


def regress(rows: np.ndarray, target: np.ndarray) -> Solution:
    """Least squares on rows (k, n), in the directions that the rows determine."""
    gram = rows @ rows.T
    scale = np.sqrt(np.diag(gram))
    # A function that is absorbed entirely weighs nothing, as one of a drive that there was not.
    scale = np.maximum(scale, max(1e-9 * np.max(scale), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(gram / scale / scale[:, None])
    kept = values > _NULL * values[-1]
    directions = vectors[:, kept] / np.sqrt(values[kept])
    along = directions.T @ ((rows @ target) / scale)
    spread = directions / scale[:, None]
    return Solution(float(along @ along), int(kept.sum()), spread @ along, spread)


_Known = dict[tuple[bool, Block], np.ndarray]  # rows of the blocks of a side


@lru_cache(maxsize=4)  # several parts of a diagnosis ask the same
def rank(regression: Regression) -> tuple[Stage, tuple[Ranked, ...]]:
    """Every set of coordinates on every side, best criterion first, and where they were looked for; more splines and
    pairs only if no single coordinate suffices."""
    stage, known = set_stage(regression), {}
    still = {name for name, over in stage.of_motion.items() if not over.low < over.high}  # a decay has no drive
    moving = lambda sets: [one for one in sets if not still & set(one)]
    found = [_judge(regression, stage, *tried, known) for tried in _candidates((("1",), *moving(SINGLES)))]
    if _lacking(regression, found):
        stage, found = _resolved(regression, stage, found, known)
    histories = [_judge(regression, stage, *tried, known) for tried in _candidates(moving(HISTORIES))]
    if _lacking(regression, found):
        pairs = [_judge(regression, stage, *tried, known) for tried in _candidates(moving(PAIRS))]
        if min(r.criterion for r in pairs) < min(regression.chi2, *(r.criterion for r in found)):
            pairs.sort(key=lambda r: r.criterion)
            pairs[:_PROMISING] = [_with_product(regression, stage, pair) for pair in pairs[:_PROMISING]]
        found += pairs
    found += histories
    return stage, tuple(sorted(found, key=lambda r: r.criterion))


def _left(regression: Regression, found: Ranked) -> float:
    """χ² above that of noise beside the functions of a set."""
    return regression.chi2 - found.drop - (regression.n - found.dof)


def _lacking(regression: Regression, found: Sequence[Ranked]) -> bool:
    """Whether the best of some sets leave more than noise does: of a misfit of thirty noise floors even a thousandth is
    as much as the noise, and a function of one coordinate that follows it so far may be a product of two."""
    return min(_left(regression, one) for one in found) > _SCATTER * np.sqrt(2.0 * regression.n)


def _resolved(
    regression: Regression, stage: Stage, coarse: Sequence[Ranked], known: _Known
) -> tuple[Stage, list[Ranked]]:
    """As many splines over each coordinate as the criterion buys, if they leave less than half of what the first few
    do: those that follow the law leave next to nothing, and those of another coordinate gain little."""
    best, price = [], np.log(regression.n)
    for found in coarse:
        name, first = found.coordinates[0], found
        for pieces in _PIECES if name in _FINER else ():
            dear = _left(regression, found) < (pieces - stage.ranges(found.side)[name].pieces) * price
            if dear or not _lacking(regression, [found]):
                break
            rows: _Known = {}
            trial = stage.resolved(found.side, name, pieces)
            finer = _judge(regression, trial, found.side, found.coordinates, rows)
            if finer.criterion < found.criterion and 1.0 - finer.share < 0.5 * (1.0 - first.share):
                stage, found = trial, finer
                known |= rows
        best.append(found)
    return stage, best


def _with_product(regression: Regression, stage: Stage, pair: Ranked) -> Ranked:
    """The same pair as a product, in as many splines as the criterion buys, where it prefers that."""
    tried = partial(_judge, regression, stage, pair.side, pair.coordinates, {})
    by_criterion = lambda r: r.criterion
    first, second = pair.coordinates
    forms = list(products(first, second, stage.ranges(pair.side)))
    plain = sorted((tried(form) for form in forms), key=by_criterion)
    softer = plain[0].product.softer if plain and plain[0].product else ()
    blurred = sorted((tried(form) for form in softer), key=by_criterion)
    near = [one.product for one in (*plain, *blurred[:_FEW]) if one.product is not None]
    fine = [tried(form._replace(pieces=PIECES)) for form in near]
    return min([pair, *plain, *blurred, *fine], key=by_criterion)


def _candidates(sets: Sequence[tuple[str, ...]]) -> Iterator[tuple[Side, tuple[str, ...]]]:
    for coordinates in sets:
        yield side_of(coordinates), coordinates
        # A reading that follows the velocity is a late one, and a memory of the drive passes through linear dynamics
        # unchanged: both are found under other names.
        if "v" not in coordinates and coordinates != ("V", "history"):
            yield "sensor", coordinates


def _judge(
    regression: Regression,
    stage: Stage,
    side: Side,
    coordinates: tuple[str, ...],
    known: _Known,
    product: Product | None = None,
) -> Ranked:
    blocks = blocks_of(coordinates) if product is None else (product,)
    solved = regress(_rows(regression, stage, side, blocks, known), regression.residual)
    after = (regression.chi2 - solved.drop) / regression.n
    numbers = solved.dof + (product is not None and product.factor.width > 0)
    criterion = regression.chi2 - solved.drop + numbers * np.log(regression.n) * max(1.0, after)
    share = (solved.drop - solved.dof) / max(regression.chi2 - regression.n, 1e-9)
    return Ranked(side, coordinates, solved.drop, solved.dof, share, after, criterion, product)


def _rows(
    regression: Regression,
    stage: Stage,
    side: Side,
    blocks: Iterable[Block],
    known: _Known,
) -> np.ndarray:
    parts = []
    for block in blocks:
        rows = known.get((side == "sensor", block))
        if rows is None:
            rows = regression.project(rows_of(regression, stage, side, partial(functions_of, stage, side, block)))
            if len(block) == 1:
                known[side == "sensor", block] = rows
        parts.append(rows)
    return np.concatenate(parts)


def spline_rows(regression: Regression, stage: Stage, side: Side, blocks: Iterable[Block]) -> np.ndarray:
    """Projected whitened rows (k, n) of all functions of some blocks."""
    return _rows(regression, stage, side, blocks, {})


def spline_functions(stage: Stage, side: Side, blocks: Iterable[Block], place: Places) -> np.ndarray:
    """The same functions at given places, (k, lanes, points)."""
    return np.concatenate([functions_of(stage, side, block, place) for block in blocks])


def smallest_sufficient(ranked: Sequence[Ranked]) -> list[Ranked]:
    """Those that explain almost as much as the best one, the smallest set first.

    Functions of the measured motion move with its noise, memories most of all: what a set explains beyond the excess is
    noise that it follows. It is no gain, and where it is there shares are not so fine.
    """
    best = max(ranked, key=lambda r: r.share)
    beyond = best.share > 1.0 + _NEAR_ALL
    most = (best.drop - best.dof) / (best.share if beyond else 1.0)
    gain = lambda r: min(r.drop - r.dof, most)
    near = NEAR if beyond or best.share < _NEARLY_ALL else _NEAR_ALL
    chance = 3.0 * np.sqrt(2.0 * best.dof) * max(1.0, best.chi2_per_sample)
    enough = [r for r in ranked if gain(r) > gain(best) - max(near * gain(best), chance)]
    return sorted(enough, key=lambda r: (dimension(r.coordinates), r.criterion))


def dimension(coordinates: Sequence[str]) -> int:
    """How much a set of coordinates supposes: nothing for a constant, one for each coordinate, and for a memory."""
    return 0 if tuple(coordinates) == ("1",) else len(coordinates)
