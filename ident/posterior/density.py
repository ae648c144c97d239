"""The posterior density of a fit's unknowns, compiled and batched: the only file that knows the arrays of a fit.

The unknowns are those of the fit: fitted parameters in coordinates without bounds, in units that the records resolve.
The initial state s of a record that does not start at rest is integrated out. It enters almost linearly, so that with
w(s) = w₀ + J (s − s₀), a prior s ~ N(0, b²) and M = JᵀJ + b⁻²

    χ² = w₀ᵀw₀ + s₀²/b² − gᵀM⁻¹g,   g = Jᵀw₀ + s₀/b²,   ln L gains −½ ln |M| − ln b²

around the states s₀ that fit best at the centre. J is taken anew at every point.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.record import Trace
from ..errors import UserError
from ..fit.assemble import assemble, begin
from ..fit.coordinates import to_coordinates, to_values
from ..fit.problem import Data, Static, Unknowns, evaluate, predict
from ..fit.reading import fit_starts
from ..fit.result import Fit
from ..response import make_groups
from ..response.groups import Layout
from ..runtime import compiler_options
from .noise_model import Noise, group_noise, log_likelihood, precision, whiten
from .priors import Prior, PriorTable, choose_prior, log_prior, table

BATCH = 16
"""Points evaluated at once, always: one compiled program, and a point's density never depends on its neighbours."""

_START_SPREAD = 3.0  # b, in units of the largest displacement and velocity of the group: an initial state is no larger
_WORST = 1e8  # noise floors; a motion without bound is no number, and this is refused as surely


class Material(NamedTuple):
    """Everything numeric, so that nothing recompiles when it changes."""

    data: Data
    starts: tuple[Any, ...]
    noises: tuple[Noise, ...]
    priors: PriorTable


class Linear(NamedTuple):
    """The density around its centre as a regression: `matrix` (p, p) and `gradient` (p,) of −ln L in x, starts moved to
    their best (`starts`), `columns` (p,) lengths of the whitened derivatives."""

    matrix: np.ndarray
    gradient: np.ndarray
    starts: tuple[np.ndarray, ...]
    columns: np.ndarray


@dataclass(frozen=True, eq=False)
class Density:
    """ln posterior of one fit; a value. `names`, `units` and `priors` of the unknowns, in order; `records` that it
    sees."""

    fit: Fit
    records: tuple[Trace, ...]
    static: Static
    material: Material
    layout: Layout
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
        """ln prior (k,) and ln likelihood of every record (k, records)."""
        prior, groups = self._batched(_densities, x)
        return prior, np.stack([groups[g][:, lane] for g, lane, _ in self.layout.places], axis=1)

    def values(self, x: np.ndarray) -> np.ndarray:
        """(k, m) SI, all parameters of the model, fitted or not."""
        found = np.repeat(np.asarray(self.material.data.template, float)[None], len(x), axis=0)
        found[:, list(self.static.free)] = self._free_values(x)
        return found

    def _free_values(self, x: np.ndarray) -> np.ndarray:
        data = self.material.data
        return np.asarray(to_values(np.asarray(x) * data.scale + data.anchor, data.lower, data.upper))

    def readings(self, values: np.ndarray) -> list[np.ndarray]:
        """Readings (k, n) of each record at parameter values (k, m) SI, at the centre's initial states."""
        (groups,) = self._batched(_readings, values)
        return [groups[g][:, lane, :n] for g, lane, n in self.layout.places]

    def innovations(self, x: np.ndarray, seed: int = 0) -> list[np.ndarray]:
        """White residuals (k, n) of each record in units of its floor, initial states drawn given x; zero where none
        counts."""
        rng = np.random.default_rng(seed)
        noise = rng.standard_normal((len(x), len(self.records), 2))
        by_group = [np.zeros((len(x), g.response.shape[0], 2)) for g in self.material.data.groups]
        for i, (group, lane, _) in enumerate(self.layout.places):
            by_group[group][:, lane] = noise[:, i]
        (groups,) = self._batched(_innovations, x, *by_group)
        return [groups[g][:, lane, :n] for g, lane, n in self.layout.places]

    def noise_of(self, record: int) -> tuple[float, float]:
        """(ν, n) of a record: degrees of freedom of its floor, and samples that count."""
        group, lane, _ = self.layout.places[record]
        noise = self.material.noises[group]
        return float(noise.freedom[lane]), float(noise.count[lane])

    def log_sigma_of(self, record: int) -> float:
        """ln of the standard deviation of a record's innovations, SI."""
        group, lane, _ = self.layout.places[record]
        return float(self.material.noises[group].log_sigma[lane])

    def _batched(self, program: Any, *points: np.ndarray) -> list[Any]:
        """A compiled program over points in batches of one size, the last one filled up."""
        k, parts = len(points[0]), []
        for first in range(0, k, BATCH):
            chunk = [np.asarray(p[first : first + BATCH], float) for p in points]
            lacking = BATCH - len(chunk[0])
            chunk = [np.concatenate([c, np.repeat(c[:1], lacking, axis=0)]) for c in chunk]
            parts.append(jax.tree.map(np.asarray, program(self.static, self.material, *chunk)))
        return list(jax.tree.map(lambda *a: np.concatenate(a)[:k], *parts)) if parts else []

    def linearise(self) -> Linear:
        """The likelihood around the centre, initial states eliminated."""
        data, static = self.material.data, self.static
        found = evaluate(static, data, Unknowns(np.zeros(self.size), self.material.starts))
        matrix, gradient = np.zeros((self.size,) * 2), np.zeros(self.size)
        starts, squares = [], np.zeros(self.size)
        for group, noise, residual, by_x, by_start, start in zip(
            data.groups, self.material.noises, found.residuals, found.by_x, found.by_start, self.material.starts,
            strict=True,
        ):  # fmt: skip
            w, jx = np.asarray(whiten(noise, residual)), np.asarray(whiten(noise, by_x))
            js = np.asarray(whiten(noise, by_start)) if static.starts_free else np.zeros((2, *w.shape))
            js = js * group.free.T[:, :, None]
            moved = np.array(start, float)
            weight = precision(noise, np.sum(w**2, axis=1))
            for lane in range(len(w)):
                inner = js[:, lane] @ js[:, lane].T + np.eye(2) / _START_SPREAD**2
                cross = js[:, lane] @ jx[:, lane].T
                pull = js[:, lane] @ w[lane] + group.free[lane] * moved[lane] / _START_SPREAD**2
                solved = np.linalg.solve(inner, np.column_stack([cross, pull]))
                matrix += weight[lane] * (jx[:, lane] @ jx[:, lane].T - cross.T @ solved[:, :-1])
                gradient += weight[lane] * (jx[:, lane] @ w[lane] - cross.T @ solved[:, -1])
                moved[lane] = moved[lane] - solved[:, -1] * group.free[lane]
                squares += np.sum(jx[:, lane] ** 2, axis=1)
            starts.append(moved)
        return Linear(matrix, gradient, tuple(starts), np.sqrt(squares))

    def prior_slope(self) -> tuple[np.ndarray, np.ndarray]:
        """Gradient (p,) and Hessian (p, p) of −ln prior at the centre; where the prior of a logarithm flattens out
        towards a limit, the Hessian is that of its standard deviation, for no posterior is broader."""
        gradient, hessian = (np.array(a) for a in _prior_slope(self.material, np.zeros(self.size)))
        scale = np.asarray(self.material.data.scale)
        floor = [0.0 if p.kind == "normal" else (s / p.deviation) ** 2 for p, s in zip(self.priors, scale, strict=True)]
        hessian[np.diag_indices_from(hessian)] = np.maximum(np.diag(hessian), floor)
        return gradient, hessian

    def likely(self) -> Density | None:
        """The same density centred where parameters that the fit left far outside their priors stand at the middle of
        these; None if there are none. Least squares knows no prior, and goes far where the records leave it free."""
        values = self._free_values(np.zeros((1, self.size)))[0]
        moved = np.array([_likely(p, float(v)) for p, v in zip(self.priors, values, strict=True)])
        if np.array_equal(moved, values):
            return None
        data = self.material.data
        anchor = to_coordinates(moved, np.asarray(data.lower), np.asarray(data.upper))
        return self.moved((anchor - np.asarray(data.anchor)) / np.asarray(data.scale))

    def moved(
        self, x: np.ndarray, starts: Sequence[np.ndarray] | None = None, scale: np.ndarray | None = None
    ) -> Density:
        """The same density with x = 0 at the point `x`, other initial states, coordinates in other units."""
        data = self.material.data
        anchor = np.asarray(data.anchor) + np.asarray(x) * np.asarray(data.scale)
        data = data._replace(anchor=anchor, scale=np.asarray(data.scale if scale is None else scale))
        kept = self.material.starts if starts is None else tuple(starts)
        return replace(self, material=self.material._replace(data=data, starts=kept))

    def with_noise(self, noises: Sequence[Noise]) -> Density:
        """The same density with other noise, one per group."""
        return replace(self, material=self.material._replace(noises=tuple(noises)))

    def frame(self) -> dict[str, np.ndarray]:
        """Origin and units of x, and the initial states, from which `framed` makes the same density again."""
        data = self.material.data
        names = {f"starts_{i}": np.asarray(s) for i, s in enumerate(self.material.starts)}
        return {"anchor": np.asarray(data.anchor), "scale": np.asarray(data.scale), **names}

    def framed(self, kept: dict[str, np.ndarray]) -> Density:
        """This density in the coordinates of a `frame`."""
        data = self.material.data._replace(anchor=kept["anchor"], scale=kept["scale"])
        starts = tuple(kept[f"starts_{i}"] for i in range(len(self.material.starts)))
        return replace(self, material=self.material._replace(data=data, starts=starts))


def make_density(fit: Fit, records: Sequence[Trace] | None = None) -> Density:
    """The posterior density of a fit; or, in the same coordinates and with the same priors, that of other `records`.

    **Raises:** UserError where the fit moved nothing.
    """
    chosen = tuple(fit.campaign.fitted if records is None else records)
    groups, layout = make_groups(chosen, 1.0 / fit.scales.period, float(fit.values[1]), fit.model.steps_per_period)
    campaign = Campaign("", chosen, fit.model.device)
    static, data = assemble(fit.model, campaign, groups, layout, fit.values, fit.scales)
    if not static.free:
        raise UserError("nothing in this model was fitted, so it has no posterior", do="free a parameter and fit again")
    unknowns = begin(groups, static)
    if static.starts_free:
        unknowns = fit_starts(static, data, unknowns)
    members = [[r for r, place in zip(chosen, layout.places, strict=True) if place[0] == g] for g in range(len(groups))]
    noises = tuple(group_noise(m, g.response.shape[1], fit.sigma) for m, g in zip(members, groups, strict=True))
    starts = tuple(np.asarray(s, float) for s in unknowns.starts)
    bare = Density(fit, chosen, static, Material(data, starts, noises, table(())), layout, ())
    if records is not None:
        base = make_density(fit)
        bare = replace(bare, material=bare.material._replace(priors=base.material.priors), priors=base.priors)
        own = base.material.data
        data = data._replace(anchor=own.anchor, scale=own.scale, lower=own.lower, upper=own.upper)
        return replace(bare, material=bare.material._replace(data=data))
    columns = bare.linearise().columns / np.asarray(data.scale)
    signal = np.sqrt(sum(float(np.sum((g.response * g.weight) ** 2)) for g in groups))
    sizes = signal / np.where(columns > 0, columns, np.inf)
    sizes = np.where(sizes > 0, sizes, 1.0)
    parameters = [fit.model.parameters[i] for i in static.free]
    priors = tuple(
        choose_prior(p, float(low), float(high), fit.campaign.priors.get(p.name), float(size), float(fit.values[i]))
        for p, low, high, size, i in zip(parameters, data.lower, data.upper, sizes, static.free, strict=True)
    )
    data = data._replace(scale=1.0 / np.where(columns > 0, columns, 1.0 / np.asarray(data.scale)))
    return replace(bare, material=Material(data, starts, noises, table(priors)), priors=priors)


_FAR = 3.0  # prior standard deviations


def _likely(prior: Prior, value: float) -> float:
    """The value, or the middle of the prior where it is far outside."""
    if prior.kind == "normal":
        return value if abs(value - prior.centre) < _FAR * prior.spread else prior.centre
    middle = np.sqrt(prior.lower * prior.upper) if prior.kind == "log-uniform" else prior.centre
    # Of a uniform logarithm the outer hundredths are "far": a fit that ends there met a limit.
    far = 0.49 * np.sqrt(12.0) if prior.kind == "log-uniform" else _FAR
    return value if abs(np.log(value / middle)) < far * prior.deviation else float(middle)


def _one(static: Static, material: Material, x: Any) -> list[tuple[Any, Any, Any, Any]]:
    """Per group: whitened residual w₀ (lanes, n), J (lanes, n, 2), M (lanes, 2, 2), g (lanes, 2)."""
    data, found = material.data, []

    def white(starts: tuple[Any, ...]) -> tuple[Any, ...]:
        readings = predict(static, data, Unknowns(x, starts))
        residuals = [(r - g.response) * g.weight for r, g in zip(readings, data.groups, strict=True)]
        residuals = [jnp.where(jnp.abs(r) < _WORST, r, _WORST) for r in residuals]
        return tuple(whiten(n, r) for n, r in zip(material.noises, residuals, strict=True))

    starts = tuple(jnp.asarray(s) for s in material.starts)
    if static.starts_free:
        along = lambda step: jax.jvp(white, (starts,), (tuple(jnp.broadcast_to(step, s.shape) for s in starts),))
        whites, tangents = jax.vmap(along, out_axes=(None, 0))(jnp.eye(2))
    else:
        whites, tangents = white(starts), None
    for i, (group, w, s) in enumerate(zip(data.groups, whites, starts, strict=True)):
        if tangents is None:
            slope = jnp.zeros((*w.shape, 2))
        else:
            slope = jnp.moveaxis(tangents[i], 0, -1) * group.free[:, None, :]
        inner = jnp.einsum("lna,lnb->lab", slope, slope) + jnp.eye(2) / _START_SPREAD**2
        pull = jnp.einsum("lna,ln->la", slope, w) + group.free * s / _START_SPREAD**2
        found.append((w, slope, inner, pull))
    return found


@partial(jax.jit, static_argnums=0, compiler_options=compiler_options())
def _densities(static: Static, material: Material, points: Any) -> tuple[Any, list[Any]]:
    data = material.data

    def density(x: Any) -> tuple[Any, list[Any]]:
        likelihoods = []
        for (w, _, inner, pull), group, noise, s in zip(
            _one(static, material, x), data.groups, material.noises, material.starts, strict=True
        ):
            solved = jnp.linalg.solve(inner, pull[..., None])[..., 0]
            start_cost = jnp.sum(group.free * s**2, axis=1) / _START_SPREAD**2
            chi2 = jnp.sum(w**2, axis=1) + start_cost - jnp.sum(pull * solved, axis=1)
            occam = -0.5 * jnp.linalg.slogdet(inner)[1] - 2.0 * jnp.log(_START_SPREAD)
            likelihoods.append(log_likelihood(noise, chi2) + occam)
        prior = log_prior(material.priors, x * data.scale + data.anchor, data.lower, data.upper)
        return prior + jnp.sum(jnp.log(jnp.asarray(data.scale))), likelihoods  # a density in x

    return jax.vmap(density)(points)


@partial(jax.jit, static_argnums=0, compiler_options=compiler_options())
def _innovations(static: Static, material: Material, points: Any, *noise: Any) -> tuple[list[Any]]:
    def white(x: Any, *drawn: Any) -> list[Any]:
        found = []
        for (w, slope, inner, pull), z in zip(_one(static, material, x), drawn, strict=True):
            # s − s₀ ~ N(−M⁻¹g, M⁻¹): the inverse of the transposed Cholesky factor has that covariance.
            factor = jnp.linalg.cholesky(inner)
            spread = jax.scipy.linalg.solve_triangular(jnp.swapaxes(factor, 1, 2), z[..., None], lower=False)[..., 0]
            step = spread - jnp.linalg.solve(inner, pull[..., None])[..., 0]
            found.append(w + jnp.einsum("lna,la->ln", slope, step))
        return found

    return (jax.vmap(white)(points, *noise),)


@partial(jax.jit, static_argnums=0, compiler_options=compiler_options())
def _readings(static: Static, material: Material, values: Any) -> tuple[tuple[Any, ...]]:
    fixed = static._replace(free=())
    empty = np.zeros(0)
    data = material.data._replace(lower=empty, upper=empty, scale=empty, anchor=empty)

    def read(one: Any) -> tuple[Any, ...]:
        return predict(fixed, data._replace(template=one), Unknowns(jnp.zeros(0), material.starts))

    return (jax.vmap(read)(values),)


@jax.jit
def _prior_slope(material: Material, x: Any) -> tuple[Any, Any]:
    data = material.data
    cost = lambda x: -log_prior(material.priors, x * data.scale + data.anchor, data.lower, data.upper)
    return jax.grad(cost)(x), jax.hessian(cost)(x)
