"""What a missing effect looks like when no effect of the library is it: where it acts, on what it depends, its formula.

Source: S. F. Masri, T. K. Caughey, 1979, J. Appl. Mech. 46, 433 (force surfaces, here in output-error form);
M. C. Kennedy, A. O'Hagan, 2001, J. R. Stat. Soc. B 63, 425 (what a model lacks as a function of its inputs).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from ...effects.dependence import Side
from ...model import FREQUENCY, QUALITY
from ..evidence.coloured_noise import chance_of
from ..linearised.regression import Regression
from .coordinates import Stage, rows_of
from .formula import SHORT, Formula, dictionary, long_formula, write_formula
from .picture import Picture, draw
from .products import Product
from .subsets import TRIED, Ranked, dimension, rank, regress, smallest_sufficient, spline_rows
from .tables import curve, tabled
from .words import describe, noise_followed

_LACKING = 0.1  # of what another description leaves: one that lacks no more says as much
_MOST_TERMS = 6  # a formula has fewer; where none says it, so many count
# What a term of a formula counts, and that there is none, in coordinates, where several sets explain the same.
_PER_TERM, _WORDLESS = 0.08, 1.0


@dataclass(frozen=True, eq=False)
class Unknown:
    """The missing term, as far as these records show it.

    **Arguments:**

    - `side`: "force" on the stage, "drive" (through the actuator) or "sensor"; `coordinates`: of "z", "v", "V", "dV"
      (V̇/ω, V), "t", "1" (a constant) and "history" (what came before of the coordinate named with it).
    - `drop` of χ² by `dof` spline directions; `share` of the excess over noise explained and `chi2_after` per sample,
      by these or by the formula, whichever leaves less; `chi2_before`; `p_value`: of such a `drop` by chance, coloured
      noise and the number of tries allowed for.
    - `alike`: other sets that explain as much; `others`: the best of the rest.
    - `product`: if it is best said as a function of one coordinate times another.
    - `picture`: the function with its error; `formula`: in at most three terms, or a table, None if no term helps;
      `written`: what an effect file is written from, the formula if it says as much as the splines; None if no term
      says anything.
    - `sentences`: all this in words.
    """

    side: Side
    coordinates: tuple[str, ...]
    drop: float
    dof: int
    share: float
    chi2_before: float
    chi2_after: float
    p_value: float
    alike: tuple[Ranked, ...]
    others: tuple[Ranked, ...]
    picture: Picture
    formula: Formula | None
    written: Formula | None
    sentences: tuple[str, ...]
    product: Product | None = None

    def as_json(self) -> dict[str, Any]:
        """The entry `unknown` of diagnosis.json."""
        alike = [{"side": r.side, "coordinates": list(r.coordinates), "share": r.share} for r in self.alike]
        return {
            "side": self.side,
            "coordinates": list(self.coordinates),
            "formula": self.formula.text if self.formula is not None else "",
            "formula_explains": self.explained(self.formula),
            "explains": self.share,
            "p_value": self.p_value,
            "product": None if self.product is None else {"of": self.product.of, "by": self.product.name},
            "alike": alike,
            "sentences": list(self.sentences),
        }

    @property
    def told(self) -> bool:
        """Whether a short formula or a product says it, or at least no other coordinates explain the same: else it is
        one of many descriptions, and no law."""
        short = self.formula is not None and self.formula.complete and (not self.formula.tabled or self.product)
        return bool(short) or not self.alike

    @property
    def dimension(self) -> int:
        """How many coordinates it supposes."""
        return dimension(self.coordinates)

    @property
    def of_one_law(self) -> bool:
        """Whether it is one law and not several: a function of a single coordinate, or one term or product of two, or
        terms that all need both. What is remembered the library may have in pieces."""
        single = self.formula is not None and self.formula.complete and self.formula.one
        return self.dimension < 2 or (single and "history" not in self.coordinates)

    def explained(self, formula: Formula | None) -> float:
        """Share of the excess over noise that a formula explains."""
        return 0.0 if formula is None else (self.chi2_before - formula.chi2_per_sample) / (self.chi2_before - 1.0)


@lru_cache(maxsize=4)  # several parts of a diagnosis ask the same
def find_unknown(regression: Regression) -> Unknown:
    """The smallest set of coordinates whose functions explain what the fit leaves, and what that function is.

    The answer is meant for a misfit that no effect of the library explains; `p_value` says whether there is any.
    Sweeps beside the traces are not asked: their points are no motion, along which a function could be known.
    """
    regression = regression.of_traces()
    return _told(regression, *rank(regression))


def better_than(regression: Regression, refuted: Unknown) -> Unknown | None:
    """The same of the sets that the criterion prefers to one whose simulation left more than noise; None without any.

    Along a measured motion noise makes a law leave more, by as much as nobody knows: a simpler one that explains almost
    as much is asked first, and is the answer unless its simulation says otherwise.
    """
    regression = regression.of_traces()
    stage, ranked = rank(regression)
    itself = next(r for r in ranked if (r.side, r.coordinates) == (refuted.side, refuted.coordinates))
    better = [r for r in ranked if r.criterion < itself.criterion]
    return _told(regression, stage, better) if better else None


def without_memory(regression: Regression) -> Unknown | None:
    """The same of the sets without what came before, if there are any: a memory follows what noise does to the kinks of
    a law along the measured motion, and only a simulation tells whether it is one."""
    regression = regression.of_traces()
    stage, ranked = rank(regression)
    known = [r for r in ranked if "history" not in r.coordinates]
    return _told(regression, stage, known) if known else None


def _told(regression: Regression, stage: Stage, ranked: Sequence[Ranked]) -> Unknown:
    """What is missing, as the smallest of some sets that is sufficient."""
    enough = smallest_sufficient(ranked)
    chosen, formula = _settle(regression, stage, enough)
    side, coordinates = chosen.side, chosen.coordinates
    rows = spline_rows(regression, stage, side, chosen.blocks)
    solved = regress(rows, regression.residual)
    p = min(1.0, TRIED * chance_of(regression, rows.T @ solved.spread))
    if len(coordinates) == 1 and coordinates != ("1",) and not (formula and formula.complete):
        formula = curve(regression, stage, side, coordinates[0], chosen.drop) or formula
    complete = formula is not None and formula.complete
    written = formula if formula and complete else long_formula(regression, stage, side, coordinates, chosen.drop)
    if formula is not None and (written is None or formula.drop >= written.drop):
        written = formula
    of_both = len(coordinates) == 2 and "history" not in coordinates and chosen.product is None
    if of_both and written is not None and written.complete and not complete and len(written.terms) <= SHORT:
        formula = written  # of words that a short formula is not looked for in, powers up to the seventh
    alike = tuple(r for r in enough if r is not chosen and dimension(r.coordinates) <= dimension(chosen.coordinates))
    others = tuple(r for r in ranked if r not in enough and not set(coordinates) < set(r.coordinates))[:3]
    picture = draw(regression, stage, chosen, solved)
    before = regression.chi2 / regression.n
    found = Unknown(side, coordinates, chosen.drop, chosen.dof, chosen.share, before, chosen.chi2_per_sample, p, alike,
                    others, picture, formula, written, (), chosen.product)  # fmt: skip
    spline = formula is not None and formula.tabled and chosen.product is None  # and says no more than those do
    if formula is not None and not spline and formula.chi2_per_sample < chosen.chi2_per_sample and before > 1.0:
        # It has the law's own shape, and splines of two coordinates are few: what they leave is no measure.
        least = _as_much(regression, formula.drop)
        alike = tuple(one for one in alike if one.drop - one.dof > least)
        found = replace(found, share=found.explained(formula), chi2_after=formula.chi2_per_sample, alike=alike)
    return replace(found, sentences=describe(found))


def as_table(regression: Regression, found: Unknown) -> Unknown | None:
    """A product that a short formula says, with its function as a table in the place of that; None if there is none.

    Where the records have been it says the same. Beyond, where held-out ones may go, terms run on as they will, each
    its own way, and the table goes on level.
    """
    if found.product is None or found.formula is None or found.formula.tabled:
        return None
    regression = regression.of_traces()
    stage, _ = rank(regression)
    table = tabled(regression, stage, found.side, found.product, found.drop)
    if table is None or not table.complete:
        return None
    found = replace(found, formula=table, written=table, chi2_after=table.chi2_per_sample, share=found.explained(table))
    return replace(found, sentences=describe(found))


def followed_noise(found: Unknown, kept: float) -> Unknown:
    """What was estimated, with the word that its simulation keeps only a share `kept` of what it explains along the
    measured motion: slow noise that no floor holds moves that too, and is then read as its own cause."""
    return replace(found, sentences=(*found.sentences, noise_followed(kept)))


def _settle(regression: Regression, stage: Stage, enough: Sequence[Ranked]) -> tuple[Ranked, Formula | None]:
    """Of sets that explain the same, the one with the shortest formula: one coordinate's splines may mimic a memory,
    and many of them a product of two."""
    first = enough[0]
    within = lambda r: set(first.coordinates) <= set(r.coordinates) and r.side == first.side
    rivals = [r for r in enough[1:] if not within(r) or (r.product is not None and r.dof < first.dof)]
    rivals = [r for r in rivals if dimension(r.coordinates) <= 2][:4]
    weakest = min(r.drop - r.dof for r in (first, *rivals))
    least = _as_much(regression, weakest)
    judged = []
    for found in (first, *rivals):
        words = dictionary(regression, stage, found.side, found.coordinates, found.product)
        formula = write_formula(regression, stage, found.side, words, found.drop)
        if found.product is not None and not (formula and formula.complete):
            formula = tabled(regression, stage, found.side, found.product, found.drop) or formula
        says_it = formula if formula and formula.drop >= least else None
        if not says_it and len(enough) > 1:
            longer = write_formula(regression, stage, found.side, words, found.drop, _MOST_TERMS - 1)
            says_it = longer if longer and longer.drop >= least else None
        terms = min(len(says_it.terms), _MOST_TERMS) if says_it else _MOST_TERMS
        if says_it is not None and not _possible(regression, stage, says_it):
            says_it = None
        cost = dimension(found.coordinates) + _PER_TERM * terms + _WORDLESS * (says_it is None)
        judged.append((cost, found.criterion, found, formula))
        if len(judged) == 1 and terms <= 2 and dimension(first.coordinates) <= 1:
            break
    best = min(judged, key=lambda j: j[:2])
    return best[2], best[3]


def _as_much(regression: Regression, drop: float) -> float:
    """The fall of χ² from which something says as much as what lowers it by `drop`."""
    return drop - _LACKING * max(regression.chi2 - drop, float(regression.n))


def _possible(regression: Regression, stage: Stage, formula: Formula) -> bool:
    """Whether the linear part that a formula goes with is one: a memory may ask for a damping below zero."""
    if formula.side == "sensor":
        return True
    terms = lambda place: np.stack([term.value(place) for term in formula.terms])
    by_terms = formula.coefficients @ (rows_of(regression, stage, "force", terms) / stage.force_unit)
    velocity = stage.of_motion["v"].largest
    linear = lambda place: np.stack([place["z"] / stage.of_motion["z"].largest, place["v"] / velocity,
                                     place["V"] / stage.of_motion["V"].largest])  # fmt: skip
    known = rows_of(regression, stage, "force", linear)
    change = np.linalg.lstsq(known.T, regression.left - by_terms, rcond=1e-10)[0][1] * stage.force_unit / velocity
    model, values = regression.fit.model, regression.fit.values
    _, damping = model.spring_and_damper(float(values[FREQUENCY]), float(values[QUALITY]), model.mass_of(values))
    return damping - change > 0.0
