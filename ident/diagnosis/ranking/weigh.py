"""What a candidate explains: the best point of its grid, with the sizes that suit the residual there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ...effects.effect import AbstractEffect
from ..evidence.coloured_noise import chance
from ..linearised.balance import Balanced, balanced, samples_of
from ..linearised.basis import ABSORBED, orthonormal
from ..linearised.curve_columns import Moves
from ..linearised.histories import Histories, histories
from ..linearised.inner import inner
from ..linearised.regression import Regression

_NEAR_POINTS = 5  # of a grid, kept as starts: the best of them may lead into a local minimum


class Candidate(NamedTuple):
    """A possible missing effect.

    **Arguments:**

    - `drop`: predicted fall of χ²; `predicted_gain`: the same as a share of the excess over noise; `dof`: columns used.
    - `p_value`: probability of such a fall by chance, coloured noise allowed for.
    - `values`: estimated parameters by short name (SI), the shapes at their best grid point; `errors`: of the
      amplitudes.
    - `signature`: (dof, n) orthonormal projected columns, by which candidates are compared; `near`: `values` at the
      next best points of the grid, and `near_signatures` there; `beside`: the model's own parameters with the candidate
      at `values`; `unseen`: amplitudes that the records do not show at all, as curves do not show an even sensor.
    - `words`: those of its choices that nobody decided, the usual ones if they explain about as much as any;
      `otherwise`: the effect with other words that promise about as much, between which refits decide.
    """

    name: str
    drop: float
    predicted_gain: float
    dof: int
    p_value: float
    values: Mapping[str, float]
    errors: Mapping[str, float]
    units: Mapping[str, str]
    signature: np.ndarray
    near: tuple[Mapping[str, float], ...] = ()
    near_signatures: tuple[np.ndarray, ...] = ()
    beside: np.ndarray | None = None
    unseen: frozenset[str] = frozenset()
    words: Mapping[str, str] = MappingProxyType({})
    otherwise: tuple[Candidate, ...] = ()

    def promised(self, regression: Regression) -> float:
        """The fall of χ² that it promises with the words that promise most, counted from the best fit as refits are."""
        own = self.drop if regression.instead_of is None else self.predicted_gain * regression.to_explain
        return max([own, *(other.promised(regression) for other in self.otherwise)])

    def schwarz(self, n: int) -> float:
        """By how much Schwarz's criterion falls with it if the noise is known, χ² + k ln n of n samples."""
        return self.drop - self.dof * np.log(n)


class Asked(NamedTuple):
    """What an effect, with some `words`, would add at the `points` of its grid, `sides` of which are that long.

    `amplitudes`: their places; `raw` (points × amplitudes, n) columns; `changed` (h, …), the same with other histories,
    if the records do not begin with the drive; `moves` of the sweeps.
    """

    effect: AbstractEffect
    words: Mapping[str, str]
    points: list[np.ndarray]
    sides: list[int]
    amplitudes: list[int]
    raw: np.ndarray
    changed: np.ndarray | None
    moves: Moves | None


class _Point(NamedTuple):
    """One point of an effect's grid: fall of χ², 0 if a sign cannot be (friction that drives); parameters; where its
    columns are among those of all points; the histories of its records; orthonormal columns (n, q) and the model's own
    parameters beside it, if they were found on the way."""

    drop: float
    values: Mapping[str, float]
    rows: slice
    past: np.ndarray | None = None
    basis: np.ndarray | None = None
    beside: np.ndarray | None = None


class _Columns(NamedTuple):
    """Of all points of a grid, `q` rows each: as the effect itself would have them, `raw` (points × q, n), and how
    histories of the records change that."""

    raw: np.ndarray
    q: int
    begun: Histories | None

    def at(self, one: _Point) -> np.ndarray:
        """The rows (q, n) of a point, with the histories that suit them best."""
        alone = self.raw[one.rows]
        return alone if self.begun is None or one.past is None else self.begun.added(alone, one.past, one.rows)


def weighed(regression: Regression, asked: Asked) -> Candidate | None:
    """What an effect explains at the best point of its grid; None if the model can do all that it does."""
    effect, moves, amplitudes = asked.effect, asked.moves, asked.amplitudes
    q, names = len(amplitudes), [p.name for p in effect.declared()]
    begun = None if asked.changed is None else histories(regression, asked.changed, asked.raw)
    columns = _Columns(asked.raw, q, begun)
    tried = _tried(regression, asked, columns) if q else []
    if not tried:
        return None
    best, *others = sorted(tried, key=lambda tried: -tried.drop)
    near = _apart(others, tried, asked.sides, q)[: _NEAR_POINTS - 1]
    (best, basis), *others = (_told(regression, asked, columns, one) for one in (best, *near))
    own = columns.at(best)
    size = np.array([best.values[names[a]] for a in amplitudes])
    beyond = basis
    if moves is None and begun is not None:
        beyond = begun.beyond(regression, asked.raw[best.rows], size, best.rows)
    spread = _spread(regression.project(own))
    dof = basis.shape[1] + sum(p.kind == "shape" and p.fitted for p in effect.declared())
    excess = max(regression.chi2 - regression.n, 1e-9)
    return Candidate(
        name=effect.name,
        drop=best.drop,
        predicted_gain=min(best.drop / excess, 1.0),
        dof=dof,
        p_value=chance(regression, beyond, dof) if best.drop > 0 and beyond.shape[1] else 1.0,
        values=best.values,
        errors={names[a]: float(x) for a, x in zip(amplitudes, spread, strict=True)},
        units={p.name: p.unit for p in effect.declared()},
        signature=basis.T,
        near=tuple(other.values for other, _ in others),
        near_signatures=tuple(its_basis.T for _, its_basis in others),
        beside=regression.moved(size @ own) if best.beside is None else best.beside,
        unseen=_unseen(asked, names),
        words=asked.words,
    )


def _tried(regression: Regression, asked: Asked, columns: _Columns) -> list[_Point]:
    """Every point of the grid at which the effect does something that the model cannot."""
    effect, amplitudes, q, begun = asked.effect, asked.amplitudes, columns.q, columns.begun
    declared = effect.declared()
    names, positive = [p.name for p in declared], np.array([declared[a].positive for a in amplitudes])
    by_point = asked.raw.reshape(len(asked.points), q, -1)
    alone = inner(by_point, regression.absorbed, regression.residual) if begun is None else []
    tried = []
    for k, point in enumerate(asked.points):
        rows, past, price = slice(k * q, (k + 1) * q), None, 0.0
        if begun is None:
            seen = alone[k]
        else:
            past, seen, price = begun.fitted(regression, by_point[k], rows)
        # What only a size that cannot be would explain, no refit keeps.
        below = positive & (seen.sizes < 0)
        if regression.credible and np.any(below):
            seen = seen.without(below)
        drop, own = seen.drop, None if asked.moves is None else asked.moves.rows(rows)
        here = _Point(0.0, _with_sizes(names, amplitudes, point, seen.sizes), rows, past)
        if own is not None and (drop is not None or np.any(own.bends) or np.any(own.share_bends) or np.any(own.heard)):
            on_curves = partial(_balanced_point, regression, asked, here, point, columns.at(here), own)
            tried.append(on_curves())
            even = np.any(np.einsum("ddp->dp", own.bends), axis=1) & ~np.any(own.drives, axis=1)
            if np.any(even) and not np.all(even):  # with the others it may be left at zero, where it has no slope
                tried.append(on_curves(even))
        elif drop is not None:
            impossible = regression.credible and _of_wrong_sign(effect, here.values)
            tried.append(here if impossible else here._replace(drop=max(drop - price, 0.0)))
    return tried


def _told(regression: Regression, asked: Asked, columns: _Columns, one: _Point) -> tuple[_Point, np.ndarray]:
    """A point with its sizes to the last digit, and its basis (n, q); for the best few of a grid."""
    if one.basis is not None:
        return one, one.basis
    own, point = columns.at(one).copy(), asked.points[one.rows.start // columns.q]
    names = [p.name for p in asked.effect.declared()]
    own[[one.values[names[a]] == 0.0 for a in asked.amplitudes]] = 0.0
    left = regression.project(own)
    left[np.linalg.norm(left, axis=1) < ABSORBED * np.linalg.norm(own, axis=1)] = 0.0  # rounding has no size
    return one._replace(values=_estimate(regression, names, asked.amplitudes, point, left)), orthonormal(left, own)


def _unseen(asked: Asked, names: list[str]) -> frozenset[str]:
    """Amplitudes that the records do not show at any point."""
    shown, moves = np.any(asked.raw, axis=1), asked.moves
    if moves is not None:
        shown |= np.any(moves.bends, axis=(1, 2)) | np.any(moves.share_bends, axis=(1, 2))
        shown |= np.any(moves.heard, axis=(1, 2))
    q = len(asked.amplitudes)
    return frozenset(names[a] for j, a in enumerate(asked.amplitudes) if not np.any(shown[j::q]))


def _balanced_point(
    regression: Regression,
    asked: Asked,
    here: _Point,
    point: np.ndarray,
    raw: np.ndarray,
    moves: Moves,
    some: np.ndarray | None = None,
) -> _Point:
    """One point of an effect's grid where there are sweeps: amplitudes, or `some` (q,) of them with the others at zero,
    by the balance of the fundamental."""
    amplitudes = asked.amplitudes
    if some is not None:
        raw, moves = raw[some], moves.among(some)
        amplitudes = [a for a, kept in zip(amplitudes, some, strict=True) if kept]
    declared = asked.effect.declared()
    positive = np.array([declared[a].positive for a in amplitudes])
    found: Balanced = balanced(regression, raw[:, : samples_of(regression)], moves, positive)
    own = len(regression.directions)
    values = {p.name: float(x) for p, x in zip(declared, point, strict=True)}
    values |= {declared[a].name: float(x) for a, x in zip(amplitudes, found.step[own:], strict=True)}
    possible = not _of_wrong_sign(asked.effect, values)
    drop = max(regression.chi2 - float(found.left @ found.left), 0.0) if possible else 0.0
    explained = (regression.residual - found.left)[None]  # where the effect is small, its own projected column
    basis = orthonormal(np.concatenate([explained, regression.project(found.slopes[own:])])[: len(raw)])
    return here._replace(drop=drop, values=values, basis=basis, beside=regression.stepped(found.step[:own]))


def _estimate(
    regression: Regression, names: list[str], amplitudes: list[int], point: np.ndarray, rows: np.ndarray
) -> dict[str, float]:
    """Parameters of an effect at one point of its grid: the amplitudes by regression."""
    lengths = np.maximum(np.linalg.norm(rows, axis=1), 1e-300)
    size, _, _, _ = np.linalg.lstsq((rows / lengths[:, None]).T, regression.residual, rcond=1e-10)
    return _with_sizes(names, amplitudes, point, size / lengths)


def _with_sizes(names: list[str], amplitudes: list[int], point: np.ndarray, sizes: np.ndarray) -> dict[str, float]:
    found = dict(zip(names, (float(x) for x in point), strict=True))
    return found | {names[a]: float(x) for a, x in zip(amplitudes, sizes, strict=True)}


def _spread(rows: np.ndarray) -> np.ndarray:
    """Standard errors (q,) of the amplitudes of columns (q, n), in noise of one."""
    lengths = np.maximum(np.linalg.norm(rows, axis=1), 1e-300)  # amplitudes differ in unit, and so by powers of ten
    unit = rows / lengths[:, None]
    return np.sqrt(np.maximum(np.diag(np.linalg.pinv(unit @ unit.T, rcond=1e-10)), 0.0)) / lengths


def _of_wrong_sign(effect: AbstractEffect, values: Mapping[str, float]) -> bool:
    """Whether the amplitudes that mean something with one sign only have none of it, and one of the other."""
    sizes = [values[p.name] for p in effect.declared() if p.one_sided]
    return max(sizes, default=0.0) <= 0 > min(sizes, default=0.0)


def _apart(others: Sequence[_Point], tried: Sequence[_Point], sides: Sequence[int], q: int) -> list[_Point]:
    """The other points in the order in which they are worth a start: those first that no neighbour on the grid outdoes,
    for the best ones may all lie about one maximum; `sides`: lengths of the grid, `q` rows a point."""
    drops = np.full([side for side in sides if side > 1] or [1], -np.inf)  # amplitudes and what is held are no axes
    for one in tried:
        at = np.unravel_index(one.rows.start // q, drops.shape)
        drops[at] = max(drops[at], one.drop)
    around = np.lib.stride_tricks.sliding_window_view(np.pad(drops, 1, constant_values=-np.inf), (3,) * drops.ndim)
    peak = drops >= around.max(axis=tuple(range(drops.ndim, 2 * drops.ndim)))
    return sorted(others, key=lambda one: not peak.flat[one.rows.start // q])
