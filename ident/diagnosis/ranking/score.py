"""Which effect is missing: score statistics of every candidate, from the one definition of each effect.

The residual of the fit is regressed on what each candidate would add to the readings, after everything that the model
can already absorb (its parameters, initial states, mains hum) is projected out. Shapes are tried on their grids. The
drop of χ² ranks the candidates; whether the best one is real is judged after whitening by the colour of what is left,
so that coloured noise raises no alarm.

Source: C. R. Rao, 1948, Proc. Camb. Phil. Soc. 44, 50; L. G. Godfrey, Misspecification Tests in Econometrics, 1988, §1.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from scipy.special import fdtrc

from ...campaign.device import Platform
from ...campaign.held_drive import jumps
from ...effects.dependence import needs_a_smooth_drive
from ...effects.effect import AbstractEffect
from ...effects.registry import Registry
from ...model import Model, make_effect, open_words
from ...pulse import Report
from ...response import Equation
from ..evidence.coloured_noise import chance
from ..evidence.family import is_family_of
from ..linearised.balance import Balanced, balanced, samples_of
from ..linearised.basis import orthonormal
from ..linearised.curve_columns import Moves, curve_columns
from ..linearised.histories import begun_apart, histories
from ..linearised.pass_columns import pass_columns
from ..linearised.regression import Regression, stack
from ..side_by_side import at_once


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
    - `words`: those of its choices that nobody decided, the usual ones if they explain about as much as any.
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


class _Point(NamedTuple):
    """One point of an effect's grid: fall of χ², 0 if a sign cannot be (friction that drives); parameters; orthonormal
    columns (n, q), and those that no history of the records could give; where its columns are among those of all
    points; the model's own parameters beside it, if they were found on the way."""

    drop: float
    values: Mapping[str, float]
    basis: np.ndarray
    beyond: np.ndarray
    rows: slice
    beside: np.ndarray | None = None


NAMED_BY_CHANCE = 0.002  # probability with which noise alone would name an effect, all candidates together
_USUAL = 0.5  # of what other words promise: refits keep as little of a promise, or twice as much
_NEAR_POINTS = 5  # of a grid, kept as starts: the best of them may lead into a local minimum


def score(
    regression: Regression, library: Registry, report: Report = lambda _: None, forms: bool = False
) -> list[Candidate]:
    """Every candidate of the library that the model does not have, best first; each is scored once on a regression.

    A family of which the model has a member is none: that one with other numbers would stand in its place, not beside.
    Nor is another form of an effect, which would stand in the place of that, unless `forms` are asked for.
    """
    there = regression.fit.model.effects
    missing = [
        effect
        for effect in library.values()
        if effect.name not in regression.fit.model.names
        and not any(is_family_of(effect, one) for one in there)
        and (forms or not effect.form_of)
    ]
    new = [effect for effect in missing if effect not in regression.scored]
    regression.scored.update(
        zip(new, at_once(lambda effect: _score_one(regression, effect), new, report, "scores"), strict=True)
    )
    return _in_order([c for effect in missing if (c := regression.scored[effect]) is not None], regression.n)


def score_beside(regressions: Sequence[Regression], library: Registry) -> list[list[Candidate]]:
    """The same on several regressions of one fit that differ in what they absorb: the columns are the same."""
    effects = [effect for effect in library.values() if effect.name not in regressions[0].fit.model.names]

    def on_each(effect: type[AbstractEffect]) -> list[Candidate | None]:
        asked = _asked(regressions[0], effect)
        return [_best_weighed(one, asked) for one in regressions]

    by_effect = at_once(on_each, effects)
    found = [[c for c in of_one if c is not None] for of_one in zip(*by_effect, strict=True)]
    return [_in_order(own, one.n) for own, one in zip(found, regressions, strict=True)]


def _in_order(found: Sequence[Candidate], n: int) -> list[Candidate]:
    return sorted(found, key=lambda c: -(c.drop - c.dof * np.log(n)))


class _Asked(NamedTuple):
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


def _score_one(regression: Regression, effect: type[AbstractEffect]) -> Candidate | None:
    return _best_weighed(regression, _asked(regression, effect))


def _best_weighed(regression: Regression, asked: Sequence[_Asked]) -> Candidate | None:
    """The candidate with its usual words, unless others promise what a refit with these can hardly keep."""
    found = [candidate for one in asked if (candidate := _weighed(regression, one)) is not None]
    most = max((candidate.drop for candidate in found), default=0.0)
    return next((candidate for candidate in found if candidate.drop >= _USUAL * most), None)


def _asked(regression: Regression, effect: type[AbstractEffect]) -> list[_Asked]:
    """What an effect would add with each of the words that its choices may have; nothing if it cannot act here."""
    fitted = regression.fit
    if effect.platform_only and not isinstance(fitted.model.device, Platform):
        return []
    if effect.needs and effect.needs not in fitted.model.names:
        return []
    if effect.settles_to_a_mean and fitted.campaign.shows_settled_motion_only:
        return []
    if any(r.edge is not None and jumps(r.drive) for r in fitted.campaign.fitted) and needs_a_smooth_drive(effect):
        return []
    return [_asked_with(regression, effect, words) for words in open_words(fitted.campaign, effect)]


def _asked_with(regression: Regression, effect: type[AbstractEffect], words: Mapping[str, str]) -> _Asked:
    fitted = regression.fit
    # The candidate alone (with the effect it builds on) pushes: the same program then serves every model and campaign.
    # Its own push does not depend on the mass, which stays the nominal one.
    alone = make_effect(fitted.campaign, effect.name, {effect.name: effect}, words)
    own_effects = (*fitted.model.beneath(effect), alone)
    model = Model(fitted.model.device, own_effects, form=fitted.model.form)
    instance = model.effects[-1]
    own = [p.name for p in model.parameters[: len(model.parameters) - len(instance.parameters)]]
    known = np.array([fitted.value(name) for name in own])
    first = len(known)
    amplitudes = [i for i, p in enumerate(instance.declared()) if p.kind == "amplitude" and (p.fitted or p.default)]
    axes = _grid(instance, regression)
    points = [np.array(point) for point in itertools.product(*axes)]
    values = np.array([np.concatenate([known, point]) for point in points])
    directions = np.eye(values.shape[1])[[first + a for a in amplitudes]]
    moves = None
    if regression.plane is not None:
        moves = curve_columns(regression.plane, Equation(model), values, directions)
    passed = None
    if regression.passes is not None:
        there = np.array([np.concatenate([fitted.values, point]) for point in points])
        places = [len(fitted.values) + a for a in amplitudes]
        passed = pass_columns(regression, fitted.model + instance, there, places)
    raw = stack(regression, model, values, directions, moves=moves, passed=passed)
    apart, changed = begun_apart(regression, model, len(values)), None
    if apart is not None:
        again, begun = np.tile(values, (len(apart), 1)), apart.reshape(-1, *apart.shape[2:])
        held = moves and moves.rows(np.tile(np.arange(len(raw)), len(apart)))
        still = None if passed is None else np.tile(passed, (len(apart), 1))
        changed = stack(regression, model, again, directions, begun=begun, moves=held, passed=still)
        changed = changed.reshape(len(apart), *raw.shape)
    return _Asked(instance, words, points, [len(axis) for axis in axes], amplitudes, raw, changed, moves)


def _weighed(regression: Regression, asked: _Asked) -> Candidate | None:
    instance, words, points, sides, amplitudes, raw, changed, moves = asked
    q, begun = len(amplitudes), None
    if changed is not None:
        raw = raw.copy()
        begun = histories(regression, changed, raw)
    projected = regression.project(raw)
    names = [p.name for p in instance.declared()]
    tried = []
    for k, point in enumerate(points):
        rows = slice(k * q, (k + 1) * q)
        price, seen = 0.0, raw[rows].copy()
        if begun is not None:
            raw[rows], price = begun.fitted(regression, seen, rows)
            projected[rows] = regression.project(raw[rows])
        basis = orthonormal(projected[rows], raw[rows])
        own = None if moves is None else moves.rows(rows)
        if own is not None and (basis.shape[1] or np.any(own.bends) or np.any(own.share_bends) or np.any(own.heard)):
            tried.append(_balanced_point(regression, instance, amplitudes, point, raw[rows], own, rows))
            even = np.any(np.einsum("ddp->dp", own.bends), axis=1) & ~np.any(own.drives, axis=1)
            if np.any(even) and not np.all(even):  # with the others it may be left at zero, where it has no slope
                tried.append(_balanced_point(regression, instance, amplitudes, point, raw[rows], own, rows, even))
        elif basis.shape[1]:
            found = _estimate(regression, names, amplitudes, point, projected[rows])
            impossible = regression.credible and _of_wrong_sign(instance, found)
            drop = 0.0 if impossible else max(float(np.sum((basis.T @ regression.residual) ** 2)) - price, 0.0)
            size = np.array([found[names[a]] for a in amplitudes])
            beyond = basis if begun is None else begun.beyond(regression, seen, size, rows)
            tried.append(_Point(drop, found, basis, beyond, rows))
    if not tried:
        return None
    shown = np.any(raw, axis=1)
    if moves is not None:
        shown |= np.any(moves.bends, axis=(1, 2)) | np.any(moves.share_bends, axis=(1, 2))
        shown |= np.any(moves.heard, axis=(1, 2))
    unseen = frozenset(names[a] for j, a in enumerate(amplitudes) if not np.any(shown[j::q]))
    best, *others = sorted(tried, key=lambda tried: -tried.drop)
    beside = best.beside
    if beside is None:
        beside = regression.moved(np.array([best.values[names[a]] for a in amplitudes]) @ raw[best.rows])
    errors = {names[a]: float(x) for a, x in zip(amplitudes, _spread(projected[best.rows]), strict=True)}
    units = {p.name: p.unit for p in instance.declared()}
    dof = best.basis.shape[1] + sum(p.kind == "shape" and p.fitted for p in instance.declared())
    excess = max(regression.chi2 - regression.n, 1e-9)
    p = chance(regression, best.beyond, dof) if best.drop > 0 and best.beyond.shape[1] else 1.0
    near = _apart(others, tried, sides, q)[: _NEAR_POINTS - 1]
    return Candidate(
        name=instance.name,
        drop=best.drop,
        predicted_gain=min(best.drop / excess, 1.0),
        dof=dof,
        p_value=p,
        values=best.values,
        errors=errors,
        units=units,
        signature=best.basis.T,
        near=tuple(other.values for other in near),
        near_signatures=tuple(other.basis.T for other in near),
        beside=beside,
        unseen=unseen,
        words=words,
    )


def _balanced_point(
    regression: Regression, effect: AbstractEffect, amplitudes: list[int], point: np.ndarray, raw: np.ndarray, moves:
    Moves, rows: slice, some: np.ndarray | None = None,
) -> _Point:  # fmt: skip
    """One point of an effect's grid where there are sweeps: amplitudes, or `some` (q,) of them with the others at zero,
    by the balance of the fundamental."""
    if some is not None:
        raw, moves = raw[some], moves.among(some)
        amplitudes = [a for a, kept in zip(amplitudes, some, strict=True) if kept]
    declared = effect.declared()
    positive = np.array([declared[a].positive for a in amplitudes])
    found: Balanced = balanced(regression, raw[:, : samples_of(regression)], moves, positive)
    own = len(regression.directions)
    values = {p.name: float(x) for p, x in zip(declared, point, strict=True)}
    values |= {declared[a].name: float(x) for a, x in zip(amplitudes, found.step[own:], strict=True)}
    drop = 0.0 if _of_wrong_sign(effect, values) else max(regression.chi2 - float(found.left @ found.left), 0.0)
    explained = (regression.residual - found.left)[None]  # where the effect is small, its own projected column
    basis = orthonormal(np.concatenate([explained, regression.project(found.slopes[own:])])[: len(raw)])
    return _Point(drop, values, basis, basis, rows, regression.stepped(found.step[:own]))


def _estimate(
    regression: Regression, names: list[str], amplitudes: list[int], point: np.ndarray, rows: np.ndarray
) -> dict[str, float]:
    """Parameters of an effect at one point of its grid: the amplitudes by regression."""
    lengths = np.maximum(np.linalg.norm(rows, axis=1), 1e-300)
    size, _, _, _ = np.linalg.lstsq((rows / lengths[:, None]).T, regression.residual, rcond=1e-10)
    size = size / lengths
    found = dict(zip(names, (float(x) for x in point), strict=True))
    return found | {names[a]: float(x) for a, x in zip(amplitudes, size, strict=True)}


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


def _grid(effect: AbstractEffect, regression: Regression) -> list[Sequence[float]]:
    """The grids of the shapes, amplitudes at zero, SI; every combination is tried."""
    axes = []
    for p in effect.declared():
        if p.kind == "amplitude":
            axes.append([0.0])
        else:
            told = regression.fit.campaign.settings.get(effect.name, {}).get(p.name)
            grid = p.grid if p.fitted or len(p.grid) == 1 else (p.default,)
            axes.append(
                [float(told)]
                if isinstance(told, float)
                else [g * getattr(regression.fit.scales, p.scale) for g in grid]
            )
    return axes


def significant(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Those that chance would hardly produce, however many were tried (Bonferroni)."""
    return [c for c in candidates if c.p_value * len(candidates) < NAMED_BY_CHANCE]


def kept_more_than_chance(candidate: Candidate, chi2: float, regression: Regression) -> bool:
    """Whether what a refit has kept of a candidate's promise, which leaves `chi2`, is significant too.

    A score is of first order, or of second in few of the terms: without phases one may promise what no refit can keep.
    """
    tried = sum(c is not None for c in regression.scored.values())
    return refit_chance(candidate, chi2, regression) * tried < NAMED_BY_CHANCE


def refit_chance(candidate: Candidate, chi2: float, regression: Regression) -> float:
    """The probability that noise alone lets a refit of a candidate fall to `chi2`."""
    freedom = max(regression.n - candidate.dof - regression.absorbed.shape[1], 1)
    fall = max(regression.best_chi2 - chi2, 0.0) / candidate.dof
    return float(fdtrc(candidate.dof, freedom, fall / max(chi2 / freedom, 1e-300)))
