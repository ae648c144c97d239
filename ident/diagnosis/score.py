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
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..campaign.device import Platform
from ..effects.effect import AbstractEffect
from ..fit import Fit
from ..model import Model, make_effect
from ..pulse import Report
from ..response import Equation
from .balance import Balanced, balanced, samples_of
from .basis import orthonormal
from .colour_test import chance
from .columns import Terms, contributions, no_histories, push_columns
from .curve_columns import Moves, Plane, curve_columns, curve_order, plane_of
from .histories import begun_apart, histories
from .side_by_side import at_once
from .trajectory import Scene, lay_out
from .whiten import Piece, make_piece, whiten


@dataclass(frozen=True, eq=False)
class Bench:
    """A fit prepared for regressions: whitened residual (n,) without what the model absorbs, and how to project a
    column.

    The numbers of the sweeps follow those of the traces, one sweep after another.

    **Arguments:** `starts`: first sample of each record within n; `absorbed`: (n, q) orthonormal, the span of `known`
    (k, n), which moving the parameters along `directions` (k, m) does; `left` (n,) and `fit_chi2`: the whitened
    residual as the fit left it and its χ², with which refits are compared; `plane`: what the sweeps say while
    parameters move; `credible`: whether the model's own
    parameters could be followed along the measured motion, on which the score statistics rest (see `prepare`);
    `instead_of`: the bench of the best fit, if this one is of other values (see `lone_record`).
    """

    fit: Fit
    scene: Scene
    pieces: tuple[Piece, ...]
    starts: tuple[int, ...]
    absorbed: np.ndarray
    residual: np.ndarray
    left: np.ndarray
    known: np.ndarray
    directions: np.ndarray
    plane: Plane | None = None
    credible: bool = True
    instead_of: Bench | None = None

    @property
    def n(self) -> int:
        """How many samples count."""
        silent = sum(np.count_nonzero(piece.masked) for piece in self.pieces if piece.masked is not None)
        return len(self.residual) - int(silent)

    @property
    def ends(self) -> tuple[int, ...]:
        """One past the last sample of each record, and of each sweep, within the residual."""
        return (*self.starts[1:], len(self.residual))

    @property
    def chi2(self) -> float:
        return float(self.residual @ self.residual)

    @property
    def fit_chi2(self) -> float:
        return float(self.left @ self.left)

    @property
    def excess(self) -> float:
        """χ² of the best fit above that of noise."""
        best = self.instead_of or self
        return max(best.fit_chi2 - best.n, 1e-9)

    @property
    def numbers(self) -> int:
        """How many numbers of the fit the records determine."""
        return self.fit.freedom

    def moved(self, added: np.ndarray) -> np.ndarray | None:
        """Where the model's own parameters (m,) go when something is added that does (n,) to the readings; None if
        they could not be followed along the measured motion."""
        if not self.credible:
            return None
        step, _, _, _ = np.linalg.lstsq(self.known.T, self.left - added, rcond=1e-10)
        return self.stepped(step)

    def stepped(self, step: np.ndarray) -> np.ndarray:
        """The model's own parameters (m,) after a step (k,) along the directions."""
        return self.fit.values + np.clip(step, -_FARTHEST, _FARTHEST) @ self.directions

    def project(self, stacked: np.ndarray) -> np.ndarray:
        """Whitened rows (k, n) without what the model absorbs."""
        return stacked - (stacked @ self.absorbed) @ self.absorbed.T


class Candidate(NamedTuple):
    """A possible missing effect.

    **Arguments:**

    - `drop`: predicted fall of χ²; `predicted_gain`: the same as a share of the excess over noise; `dof`: columns used.
    - `p_value`: probability of such a fall by chance, coloured noise allowed for.
    - `values`: estimated parameters by short name (SI), the shapes at their best grid point; `errors`: of the
      amplitudes.
    - `signature`: (dof, n) orthonormal projected columns, by which candidates are compared; `near`: `values` at the
      next best points of the grid, and `near_signatures` there; `beside`: the model's own parameters with the candidate
      at `values`.
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


_NEAR_POINTS = 5  # of a grid, kept as starts: the best of them may lead into a local minimum
_FARTHEST = 0.7  # of its value: so far a parameter may be moved in one step, which keeps its sign
_CREDIBLE = 0.25  # of the excess that a fit left: the most that its own parameters can be believed to absorb still


def prepare(fit: Fit, believed: bool = False) -> Bench:
    """Lay out a fit for regressions; `believed`, that its parameters are the device's own.

    What the model's own parameters absorb is taken along the measured motion, so that a large misfit does not bend
    it. Where inertia hardly matters that is too much: displacement is then the drive force over the stiffness, and a
    change of stiffness seen on the measured motion, with one of gain, "explains" whatever was measured. A fit has no
    such freedom, and shows it by having left what they claim to absorb; its own Jacobian is then taken instead.
    """
    scene = lay_out(fit)
    records = fit.campaign.fitted
    solved = scene.solved
    pieces = []
    for record, own in zip(records, scene.tape.slices, strict=True):
        rows = solved.found.by_start[:, own] if record.start != "rest" else None
        pieces.append(make_piece(record, rows))
    lengths = [len(r.time) - r.skip for r in records]
    white = [whiten(piece, r[None])[0] for piece, r in zip(pieces, scene.residuals, strict=True)]
    left = list(white)
    curves = solved.data.curves
    if curves is not None:
        lengths += [len(curves.places(own)) for own in curves.slices]
        left.append(-solved.found.residuals[scene.tape.samples :][curve_order(solved)])
    starts = tuple(int(x) for x in np.concatenate([[0], np.cumsum(lengths)[:-1]]))
    residual = np.concatenate(left)
    empty = np.zeros((0, len(residual)))
    bench = Bench(fit, scene, tuple(pieces), starts, empty.T, residual, residual, empty, np.zeros((0, len(fit.values))))
    # A shape at its bound cannot move as its column says: to project that out would hide a misfit that remains.
    fitted = [i for i in solved.static.free if "at-bound" not in fit.estimates[i].flags]
    # A quality factor that had to be held (steady sines of one frequency) may be wrong: its error is no missing effect.
    bent = "held" in fit.estimates[1].flags and fit.model.form != "quasi-static"
    free = sorted({*fitted, 1}) if bent else fitted
    directions = np.eye(len(fit.values))[free] * np.where(fit.values[free] == 0, 1.0, fit.values[free])[:, None]
    if curves is not None:
        bench = replace(bench, plane=plane_of(solved, directions))
    past = np.tile(scene.histories, (len(free), 1, 1))
    along_measured = stack(bench, fit.model, np.tile(fit.values, (len(free), 1)), directions, True, past)
    measured = _without(bench, along_measured, directions)
    if believed or not records or bench.fit_chi2 - measured.chi2 < _CREDIBLE * max(bench.fit_chi2 - bench.n, bench.n):
        return measured
    chosen = [solved.static.free.index(i) for i in fitted]
    bench = replace(bench, credible=False)
    rows = by_record(bench, solved.found.by_x[chosen][:, : scene.tape.samples])
    if curves is not None:
        rows = np.concatenate(
            [rows, solved.found.by_x[chosen][:, scene.tape.samples :][:, curve_order(solved)]], axis=1
        )
    return _without(bench, rows, np.zeros((0, 0)))


def _without(bench: Bench, known: np.ndarray, directions: np.ndarray) -> Bench:
    """The bench with what rows (k, n) can absorb taken out of its residual."""
    absorbed = orthonormal(known)
    residual = bench.left - absorbed @ (absorbed.T @ bench.left)
    found = replace(bench, absorbed=absorbed, residual=residual, known=known, directions=directions)
    if bench.plane is None or not len(directions):
        return found
    nothing = Moves(*(part[:0] for part in bench.plane.own))
    own = balanced(found, np.zeros((0, samples_of(found))), nothing)
    absorbed = orthonormal(own.slopes)
    return replace(found, absorbed=absorbed, residual=own.left - absorbed @ (absorbed.T @ own.left))


def stack(
    bench: Bench,
    model: Model,
    values: np.ndarray,
    directions: np.ndarray,
    linear: bool = False,
    begun: np.ndarray | None = None,
) -> np.ndarray:
    """Whitened columns of all fitted records, (d, n): what moving the parameters of `model` along each direction does.

    `values` and `directions` are (d, m). The terms of `model` push, its linear ones only if asked for; the bench's own
    model answers. `begun`, (d, records, h): their histories, if the records do not begin with the drive.
    """
    scene, solved, parts = bench.scene, bench.scene.solved, []
    if scene.tape.spans:
        equation = Equation(model)
        pasts = no_histories(equation, len(values), scene.tape) if begun is None else begun
        parts.append(_along_traces(bench, Terms(equation, linear), values, directions, pasts))
    if solved.data.curves is not None:
        plane = bench.plane
        assert plane is not None  # there are sweeps
        # Of its own parameters the model itself says what they do, all harmonics together.
        moved = plane.own if linear else curve_columns(plane, Equation(model), values, directions)
        parts.append(-plane.slopes(plane.needed, np.ones_like(plane.needed), moved))
    return np.concatenate(parts, axis=1)


def _along_traces(
    bench: Bench, asked: Terms, values: np.ndarray, directions: np.ndarray, pasts: np.ndarray
) -> np.ndarray:
    """`stack` of the traces."""
    scene = bench.scene
    both = contributions(asked, scene.tape, values, directions, scene.moved, scene.seen, pasts)
    forces, shown = zip(*both, strict=True)
    rows = np.zeros((len(values), scene.tape.samples))
    if asked.push:
        rows += push_columns(scene.tape, scene.dynamics, forces)
    if asked.show:
        rows += scene.tape.at_samples([np.moveaxis(part, 0, -1) for part in shown])
    return by_record(bench, rows)


def by_record(bench: Bench, rows: np.ndarray) -> np.ndarray:
    """Readings (d, samples) as whitened rows of the counted ones, (d, n)."""
    pairs = zip(bench.pieces, bench.scene.tape.slices, strict=True)
    return np.concatenate([whiten(piece, rows[:, own]) for piece, own in pairs], axis=1)


def score(
    bench: Bench, library: Mapping[str, type[AbstractEffect]], report: Report = lambda _: None
) -> list[Candidate]:
    """Every candidate of the library that the model does not have, best first."""
    missing = [effect for effect in library.values() if effect.name not in bench.fit.model.names]
    found = at_once(lambda effect: _score_one(bench, effect), missing, report, "scores")
    return sorted((c for c in found if c is not None), key=lambda c: -(c.drop - c.dof * np.log(bench.n)))


def _score_one(bench: Bench, effect: type[AbstractEffect]) -> Candidate | None:
    if effect.platform_only and not isinstance(bench.fit.model.device, Platform):
        return None
    fitted = bench.fit
    if effect.needs and effect.needs not in fitted.model.names:
        return None
    # The candidate alone (with the effect it builds on) pushes: the same program then serves every model and campaign.
    alone = tuple(e for e in fitted.model.effects if e.name == effect.needs)
    own_effects = (*alone, make_effect(fitted.campaign, effect.name, {effect.name: effect}))
    model = Model(fitted.model.device, own_effects, form=fitted.model.form)
    instance = model.effects[-1]
    own = [p.name for p in model.parameters[: len(model.parameters) - len(instance.parameters)]]
    known = np.array([fitted.value(name) for name in own])
    first = len(known)
    amplitudes = [i for i, p in enumerate(instance.declared()) if p.kind == "amplitude" and (p.fitted or p.default)]
    points = _grid(instance, bench)
    values = np.array([np.concatenate([known, point]) for point in points for _ in amplitudes])
    directions = np.array([np.eye(values.shape[1])[first + a] for _ in points for a in amplitudes])
    raw = stack(bench, model, values, directions)
    apart, begun = begun_apart(bench, model, len(values)), None
    if apart is not None:
        again, along = (np.tile(x, (len(apart), 1)) for x in (values, directions))
        changed = stack(bench, model, again, along, begun=apart.reshape(-1, *apart.shape[2:]))
        begun = histories(bench, changed.reshape(len(apart), *raw.shape), raw)
    moves = None if bench.plane is None else curve_columns(bench.plane, Equation(model), values, directions)
    projected = bench.project(raw)
    names = [p.name for p in instance.declared()]
    one_sided = [p.name for p in instance.declared() if p.one_sided]
    tried = []
    for k, point in enumerate(points):
        rows = slice(k * len(amplitudes), (k + 1) * len(amplitudes))
        price, seen = 0.0, raw[rows].copy()
        if begun is not None:
            raw[rows], price = begun.fitted(bench, seen, rows)
            projected[rows] = bench.project(raw[rows])
        basis = orthonormal(projected[rows], raw[rows])
        if basis.shape[1] and moves is not None:
            tried.append(
                _balanced_point(
                    bench, names, amplitudes, point, one_sided, raw[rows], Moves(*(part[rows] for part in moves)), rows
                )
            )
        elif basis.shape[1]:
            found = _estimate(bench, names, amplitudes, point, projected[rows])
            sizes = [found[name] for name in one_sided]
            impossible = bench.credible and max(sizes, default=0.0) <= 0 > min(sizes, default=0.0)
            drop = 0.0 if impossible else max(float(np.sum((basis.T @ bench.residual) ** 2)) - price, 0.0)
            size = np.array([found[names[a]] for a in amplitudes])
            beyond = basis if begun is None else begun.beyond(bench, seen, size, rows)
            tried.append(_Point(drop, found, basis, beyond, rows))
    if not tried:
        return None
    best, *others = sorted(tried, key=lambda tried: -tried.drop)
    beside = best.beside
    if beside is None:
        beside = bench.moved(np.array([best.values[names[a]] for a in amplitudes]) @ raw[best.rows])
    rows = projected[best.rows]
    lengths = np.maximum(np.linalg.norm(rows, axis=1), 1e-300)  # amplitudes differ in unit, and so by powers of ten
    unit = rows / lengths[:, None]
    spread = np.sqrt(np.maximum(np.diag(np.linalg.pinv(unit @ unit.T, rcond=1e-10)), 0.0)) / lengths
    errors = {names[a]: float(x) for a, x in zip(amplitudes, spread, strict=True)}
    units = {p.name: p.unit for p in instance.declared()}
    dof = best.basis.shape[1] + sum(p.kind == "shape" and p.fitted for p in instance.declared())
    excess = max(bench.chi2 - bench.n, 1e-9)
    p = chance(bench, best.beyond, dof) if best.drop > 0 and best.beyond.shape[1] else 1.0
    near = others[: _NEAR_POINTS - 1]
    return Candidate(
        effect.name,
        best.drop,
        min(best.drop / excess, 1.0),
        dof,
        p,
        best.values,
        errors,
        units,
        best.basis.T,
        tuple(other.values for other in near),
        tuple(other.basis.T for other in near),
        beside,
    )


def _balanced_point(
    bench: Bench, names: list[str], amplitudes: list[int], point: np.ndarray, one_sided: list[str], raw: np.ndarray,
    moves: Moves, rows: slice,
) -> _Point:  # fmt: skip
    """One point of an effect's grid where there are sweeps: amplitudes by the balance of the fundamental."""
    found: Balanced = balanced(bench, raw[:, : samples_of(bench)], moves)
    own = len(bench.directions)
    values = dict(zip(names, (float(x) for x in point), strict=True))
    values |= {names[a]: float(x) for a, x in zip(amplitudes, found.step[own:], strict=True)}
    sizes = [values[name] for name in one_sided]
    impossible = max(sizes, default=0.0) <= 0 > min(sizes, default=0.0)
    drop = 0.0 if impossible else max(bench.chi2 - float(found.left @ found.left), 0.0)
    explained = (bench.residual - found.left)[None]  # where the effect is small, its own projected column
    basis = orthonormal(np.concatenate([explained, bench.project(found.slopes[own:])])[: len(raw)])
    return _Point(drop, values, basis, basis, rows, bench.stepped(found.step[:own]))


def _estimate(
    bench: Bench, names: list[str], amplitudes: list[int], point: np.ndarray, rows: np.ndarray
) -> dict[str, float]:
    """Parameters of an effect at one point of its grid: the amplitudes by regression."""
    lengths = np.maximum(np.linalg.norm(rows, axis=1), 1e-300)
    size, _, _, _ = np.linalg.lstsq((rows / lengths[:, None]).T, bench.residual, rcond=1e-10)
    size = size / lengths
    found = dict(zip(names, (float(x) for x in point), strict=True))
    return found | {names[a]: float(x) for a, x in zip(amplitudes, size, strict=True)}


def _grid(effect: AbstractEffect, bench: Bench) -> list[np.ndarray]:
    """Every combination of the shapes' grids, amplitudes at zero, SI."""
    axes = []
    for p in effect.declared():
        if p.kind == "amplitude":
            axes.append([0.0])
        else:
            told = bench.fit.campaign.settings.get(effect.name, {}).get(p.name)
            grid = p.grid if p.fitted or len(p.grid) == 1 else (p.default,)
            axes.append(
                [float(told)] if isinstance(told, float) else [g * getattr(bench.fit.scales, p.scale) for g in grid]
            )
    return [np.array(point) for point in itertools.product(*axes)]


def significant(candidates: Sequence[Candidate], alarms: float = 0.002) -> list[Candidate]:
    """Those that chance would produce with at most the given probability, however many were tried (Bonferroni)."""
    return [c for c in candidates if c.p_value * len(candidates) < alarms]
