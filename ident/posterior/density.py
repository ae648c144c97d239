"""The posterior density of a fit's unknowns, in batches: the only file that knows the arrays of a fit.

The unknowns are those of the fit: fitted parameters in coordinates without bounds, in units that the records resolve.
The initial state of a steady record is that of the periodic orbit, and moves with them. An initial state s that is
unknown, hidden states of memories included, is integrated out. It enters almost linearly, so that with
w(s) = w₀ + J (s − s₀), a prior s ~ N(0, 1) in units of its likely size and M = JᵀJ + 1

    χ² = w₀ᵀw₀ + s₀² − gᵀM⁻¹g,   g = Jᵀw₀ + s₀,   ln L gains −½ ln |M|

around the states s₀ that fit best at the centre. J is taken anew at every point, by differences over a standard error.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.record import Trace
from ..errors import UserError
from ..fit.assemble import assemble, begin
from ..fit.coordinates import to_coordinates, to_values
from ..fit.fit_starts import fit_starts
from ..fit.on_orbits import on_orbits
from ..fit.problem import WORST, Data, Static, Unknowns, evaluate
from ..fit.result import Fit
from ..model import QUALITY
from ..response import lay_out, respond_many
from ..response.tape import Tape
from .noise_model import Noise, log_likelihood, precision, record_noise, whiten
from .priors import Prior, choose_prior, log_prior, table

BATCH = 16
"""Points evaluated at once, always: one compiled program, and a point's density never depends on its neighbours."""


class Linear(NamedTuple):
    """The density around its centre as a regression: `matrix` (p, p) and `gradient` (p,) of −ln L in x, starts moved to
    their best (`starts`, (records, s)), `columns` (p,) lengths of the whitened derivatives."""

    matrix: np.ndarray
    gradient: np.ndarray
    starts: np.ndarray
    columns: np.ndarray


class White(NamedTuple):
    """One record at points (k, …): w₀ (k, n), and for its initial state J (k, n, s), M (k, s, s), g (k, s)."""

    residual: np.ndarray
    slope: np.ndarray
    inner: np.ndarray
    pull: np.ndarray


@dataclass(frozen=True, eq=False)
class Density:
    """ln posterior of one fit; a value.

    **Arguments:** `records` that it sees, with their `noises`; `data`, whose anchor and scale are origin and unit of x;
    `starts` s₀ (records, s); `kick` (s,) the difference by which J is taken; `priors` of the unknowns, in order.
    """

    fit: Fit
    records: tuple[Trace, ...]
    noises: tuple[Noise, ...]
    static: Static
    data: Data
    starts: np.ndarray
    kick: np.ndarray
    priors: tuple[Prior, ...]

    @property
    def size(self) -> int:
        return len(self.static.free)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(p.name for p in self.priors)

    def log_posterior(self, x: np.ndarray) -> np.ndarray:
        """ln(prior × likelihood) at points (k, p); −∞ where the model has no finite motion."""
        prior, likelihood = self.parts(x)
        total = prior + likelihood.sum(axis=1)
        return np.where(np.isfinite(total), total, -np.inf)

    def parts(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """ln prior, a density in x, (k,), and ln likelihood of every record (k, records)."""
        data = self.data
        coordinates = np.asarray(x) * data.scale + data.anchor
        prior = log_prior(table(self.priors), coordinates, data.lower, data.upper).sum(axis=1)
        likelihood = self._batched(
            lambda part: np.stack([self._one(i, w) for i, w in enumerate(self._white(part))], 1), x
        )
        return prior + float(np.sum(np.log(data.scale))), likelihood

    def _one(self, record: int, white: White) -> np.ndarray:
        start_cost = float(np.sum(self.starts[record] ** 2)) if self._moving(record) else 0.0
        solved = np.linalg.solve(white.inner, white.pull[..., None])[..., 0]
        chi2 = np.sum(white.residual**2, axis=1) + start_cost - np.sum(white.pull * solved, axis=1)
        occam = -0.5 * np.linalg.slogdet(white.inner)[1]
        return log_likelihood(self.noises[record], chi2) + occam

    def values(self, x: np.ndarray) -> np.ndarray:
        """(k, m) SI, all parameters of the model, fitted or not."""
        found = np.repeat(np.asarray(self.data.template, float)[None], len(x), axis=0)
        coordinates = np.asarray(x) * self.data.scale + self.data.anchor
        found[:, list(self.static.free)] = to_values(coordinates, self.data.lower, self.data.upper)
        return found

    def _centre(self) -> np.ndarray:
        """(p,) SI of the unknowns at x = 0."""
        return self.values(np.zeros((1, self.size)))[0, list(self.static.free)]

    def readings(self, values: np.ndarray) -> list[np.ndarray]:
        """Readings (k, n) of each record at parameter values (k, m) SI, at the centre's initial states."""
        whole = self._batched(lambda part: self._simulate(part, self.starts), values)
        return [whole[:, own] for own in self.data.tape.slices]

    def innovations(self, x: np.ndarray) -> list[np.ndarray]:
        """White residuals (k, count) of each record in units of its floor, initial states drawn given x."""
        noise = np.random.default_rng(0).standard_normal((len(x), len(self.records), self.starts.shape[1]))

        def drawn(part: np.ndarray, z: np.ndarray) -> np.ndarray:
            found = []
            for i, white in enumerate(self._white(part)):
                # s − s₀ ~ N(−M⁻¹g, M⁻¹): the inverse of the transposed Cholesky factor has that covariance.
                factor = np.swapaxes(np.linalg.cholesky(white.inner), 1, 2)
                step = np.linalg.solve(factor, z[:, i, :, None]) - np.linalg.solve(white.inner, white.pull[..., None])
                found.append(white.residual + (white.slope @ step)[..., 0])
            return np.concatenate(found, axis=1)

        whole = self._batched(drawn, x, noise)
        edges = np.cumsum([0, *(len(r.time) - n.first for r, n in zip(self.records, self.noises, strict=True))])
        return [whole[:, a:b] for a, b in zip(edges[:-1], edges[1:], strict=True)]

    def _moving(self, record: int) -> bool:
        return bool(np.any(self.data.start_scale[record]))

    def _simulate(
        self, values: np.ndarray, starts: np.ndarray, orbits: Sequence[np.ndarray] | None = None
    ) -> np.ndarray:
        states = np.repeat((starts * self.data.start_scale)[None], len(values), axis=0)
        for one, begun in zip(self.data.steady, self._orbits(values) if orbits is None else orbits, strict=True):
            states[:, one.record] = begun
        return respond_many(self.static.equation, self.data.tape, values, states)

    def _orbits(self, values: np.ndarray) -> list[np.ndarray]:
        """Initial states (k, s) of each steady record: they move with the parameters (k, m)."""
        return [one.many(self.static.equation, values) for one in self.data.steady]

    def _white(self, x: np.ndarray) -> list[White]:
        values = self.values(x)
        with np.errstate(over="ignore", invalid="ignore"):
            orbits = self._orbits(values)
            at = [self._simulate(values, self.starts, orbits)]
            if self.static.starts_free:
                at += [self._simulate(values, self.starts + kick, orbits) for kick in np.diag(self.kick)]
            off = [self.data.beside_zeros(a - self.data.response) * self.data.weight for a in at]
            off = [np.where(np.abs(a) < WORST, a, WORST) for a in off]
        found = []
        for i, (noise, own) in enumerate(zip(self.noises, self.data.tape.slices, strict=True)):
            first, *kicked = (whiten(noise, a[:, own]) for a in off)
            k = len(first)
            s = len(self.kick)
            slope, pull = np.zeros((*first.shape, s)), np.zeros((k, s))
            inner = np.tile(np.eye(s), (k, 1, 1))
            if self._moving(i):
                slope = np.stack([(other - first) / self.kick[a] for a, other in enumerate(kicked)], axis=-1)
                pull = (first[:, None] @ slope)[:, 0] + self.starts[i]
                inner = inner + np.swapaxes(slope, 1, 2) @ slope
            found.append(White(first, slope, inner, pull))
        return found

    def _batched(self, program: Callable[..., np.ndarray], *points: np.ndarray) -> np.ndarray:
        """A program over points in batches of one size, the last one filled up."""
        k, parts = len(points[0]), []
        for first in range(0, k, BATCH):
            chunk = [np.asarray(p[first : first + BATCH], float) for p in points]
            lacking = BATCH - len(chunk[0])
            parts.append(program(*(np.concatenate([c, np.repeat(c[:1], lacking, axis=0)]) for c in chunk)))
        return np.concatenate(parts)[:k]

    def linearise(self) -> Linear:
        """The likelihood around the centre, initial states eliminated."""
        found = evaluate(self.static, self.data, Unknowns(np.zeros(self.size), self.starts))
        matrix, gradient = np.zeros((self.size,) * 2), np.zeros(self.size)
        starts, squares = self.starts.copy(), np.zeros(self.size)
        for i, (noise, own) in enumerate(zip(self.noises, self.data.tape.slices, strict=True)):
            w, jx = whiten(noise, found.residuals[own]), whiten(noise, found.by_x[:, own])
            weight = precision(noise, float(w @ w))
            squares += np.sum(jx**2, axis=1)
            if self._moving(i):
                js = whiten(noise, found.by_start[:, own])
                inner = js @ js.T + np.eye(len(js))
                cross, pull = js @ jx.T, js @ w + starts[i]
                solved = np.linalg.solve(inner, np.column_stack([cross, pull]))
                matrix -= weight * cross.T @ solved[:, :-1]
                gradient -= weight * cross.T @ solved[:, -1]
                starts[i] -= solved[:, -1]
            matrix += weight * jx @ jx.T
            gradient += weight * jx @ w
        return Linear(matrix, gradient, starts, np.sqrt(squares))

    def prior_slope(self) -> tuple[np.ndarray, np.ndarray]:
        """Gradient (p,) and Hessian (p, p) of −ln prior at the centre; where the prior of a logarithm flattens out
        towards a limit, the Hessian is that of its standard deviation, for no posterior is broader."""
        data = self.data
        anchor, scale = np.asarray(data.anchor), np.asarray(data.scale)
        # Each prior is a function of its own coordinate, smooth over its own width.
        width = np.array([_width(p, v) for p, v in zip(self.priors, self._centre(), strict=True)])
        step = 1e-3 * width
        low, here, high = (
            -log_prior(table(self.priors), anchor + k * step, data.lower, data.upper) for k in (-1, 0, 1)
        )
        gradient = (high - low) / (2 * step) * scale
        bend = np.maximum((high - 2 * here + low) / step**2, 0.0)
        floor = np.array([0.0 if p.kind == "normal" else p.deviation**-2 for p in self.priors])
        return gradient, np.diag(np.maximum(bend, floor) * scale**2)

    def likely(self) -> Density | None:
        """The same density centred where parameters that the fit left far outside their priors stand at the middle of
        these; None if there are none. Least squares knows no prior, and goes far where the records leave it free."""
        values = self._centre()
        moved = np.array([_likely(p, float(v)) for p, v in zip(self.priors, values, strict=True)])
        if np.array_equal(moved, values):
            return None
        data = self.data
        anchor = to_coordinates(moved, np.asarray(data.lower), np.asarray(data.upper))
        return self.moved((anchor - np.asarray(data.anchor)) / np.asarray(data.scale))

    def moved(self, x: np.ndarray, starts: np.ndarray | None = None) -> Density:
        """The same density with x = 0 at the point `x`, and other initial states."""
        anchor = np.asarray(self.data.anchor) + np.asarray(x) * np.asarray(self.data.scale)
        return replace(
            self, data=self.data._replace(anchor=anchor), starts=self.starts if starts is None else np.asarray(starts)
        )

    def over(self, records: Sequence[Trace]) -> Density:
        """The density of the same fit given other records, in the same coordinates and with the same priors."""
        bare, own = _without_priors(self.fit, tuple(records)), self.data
        data = bare.data._replace(anchor=own.anchor, scale=own.scale, lower=own.lower, upper=own.upper)
        return replace(bare, data=data, priors=self.priors)

    def mirrored(self) -> Density:
        """The same density with every drive and every initial state turned round: what `readings` symmetric physics
        would answer with the same motion turned round."""
        turned = tuple(replace(record, drive=-record.drive) for record in self.records)
        tape = _tape(self.fit, turned)
        steady = tuple(s.mirrored(turned[s.record], tape.spans[s.record].substeps) for s in self.data.steady)
        return replace(self, records=turned, data=self.data._replace(tape=tape, steady=steady), starts=-self.starts)

    def with_noise(self, noises: Sequence[Noise]) -> Density:
        """The same density with other noise of each record."""
        return replace(self, noises=tuple(noises))

    def frame(self) -> dict[str, np.ndarray]:
        """Origin and units of x, and the initial states, from which `framed` makes the same density again."""
        data = self.data
        return {
            "anchor": np.asarray(data.anchor),
            "scale": np.asarray(data.scale),
            "starts": self.starts,
            "kick": self.kick,
        }

    def framed(self, kept: dict[str, Any]) -> Density:
        """This density in the coordinates of a `frame`."""
        data = self.data._replace(anchor=kept["anchor"], scale=kept["scale"])
        return replace(self, data=data, starts=kept["starts"], kick=kept["kick"])


def make_density(fit: Fit) -> Density:
    """The posterior density of a fit.

    **Raises:** UserError where the fit moved nothing, or rests on sweeps.
    """
    bare = _without_priors(fit, tuple(fit.campaign.fitted))
    static, data = bare.static, bare.data
    columns = bare.linearise().columns / np.asarray(data.scale)
    signal = float(np.linalg.norm(data.response * data.weight))
    sizes = signal / np.where(columns > 0, columns, np.inf)
    sizes = np.where(sizes > 0, sizes, 1.0)
    parameters = [fit.model.parameters[i] for i in static.free]
    priors = tuple(
        choose_prior(p, float(low), float(high), fit.campaign.priors.get(p.name), float(size), float(fit.values[i]))
        for p, low, high, size, i in zip(parameters, data.lower, data.upper, sizes, static.free, strict=True)
    )
    scale = 1.0 / np.where(columns > 0, columns, 1.0 / np.asarray(data.scale))
    return replace(bare, data=data._replace(scale=scale), priors=priors)


def _without_priors(fit: Fit, records: tuple[Trace, ...]) -> Density:
    """What records say of a fit's unknowns, in units of its own."""
    if fit.campaign.fitted_sweeps:
        what = "this fit rests on sweeps, whose posterior is not sampled yet"
        raise UserError(what, do="take the error bars of the fit (or a --profile), or fit the traces alone")
    campaign = Campaign("", records, fit.model.device)
    static, data = assemble(fit.model, campaign, records, _tape(fit, records), fit.values, fit.scales)
    if not static.free:
        raise UserError(
            "nothing in this model was fitted, so it has no posterior",
            do='free a parameter (free = ["…"] under its [effect.…]) and fit again',
        )
    unknowns, kick = begin(data, static), np.ones(data.start_scale.shape[1])
    if static.starts_free:
        unknowns, found = fit_starts(static, data, unknowns)
        static, data, unknowns = on_orbits(static, data, records, unknowns)
        found = evaluate(static, data, unknowns) if data.steady else found
    if static.starts_free:
        kick = 1.0 / np.maximum(np.sqrt(np.sum(found.by_start**2, axis=1)), 1.0)
    noises = tuple(record_noise(r, fit.sigma) for r in records)
    return Density(fit, records, noises, static, data, np.asarray(unknowns.starts, float), kick, ())


def _tape(fit: Fit, records: tuple[Trace, ...]) -> Tape:
    return lay_out(records, 1.0 / fit.scales.period, float(fit.values[QUALITY]), fit.model)


def _width(prior: Prior, value: float) -> float:
    """Over which a prior changes, in the coordinate: its deviation there."""
    if prior.kind == "normal" and np.isfinite(prior.lower):
        return float(np.clip(prior.spread / abs(value or 1.0), 1e-3, 1.0))
    return prior.deviation


_FAR = 3.0  # prior standard deviations


def _likely(prior: Prior, value: float) -> float:
    """The value, or the middle of the prior where it is far outside."""
    if prior.kind == "normal":
        return value if abs(value - prior.centre) < _FAR * prior.spread else prior.centre
    middle = np.sqrt(prior.lower * prior.upper) if prior.kind == "log-uniform" else prior.centre
    # Of a uniform logarithm the outer hundredths are "far": a fit that ends there met a limit.
    far = 0.49 * np.sqrt(12.0) if prior.kind == "log-uniform" else _FAR
    return value if abs(np.log(value / middle)) < far * prior.deviation else float(middle)
