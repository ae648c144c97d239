"""Least squares by optimistix: its Levenberg–Marquardt descent and trust region, on normal equations.

`optimistix.least_squares` would compile the whole simulation a second time inside its own loop, which costs a cold fit
several seconds; here its descent and its search run on the (u, u) normal equations, and the simulation is compiled
once. Every unknown is measured in units of the longest column of the Jacobian that it has had, so that one damping
suits all of them. Damping starts light, because what keeps a far start in its basin is another rule: no positive
parameter changes by more than a factor √e in one step, or leaves its range, and the others take the best step that this
leaves.

A search ends by its Newton decrement, the fall of the cost that an undamped step promises within that rule. The size of
a step says nothing: along a narrow valley every damped step is small. Where valleys bend, the curvature
that Gauss–Newton leaves out is learned on the way (`secant`). At a kink, where trials are refused however short, it
ends when even all the steps that it has would not bring what is worth one, or when a dozen together have not: it has
converged if the minimum that the slopes promise lies within a standard error.

Sources: D. W. Marquardt, An algorithm for least-squares estimation of nonlinear parameters, J. SIAM 11 (1963) 431,
§III; J. J. Moré, The Levenberg–Marquardt algorithm, Lecture Notes in Mathematics 630 (1978) 105, §4 (units);
S. Boyd, L. Vandenberghe, Convex Optimization, 2004, §9.5.1 (decrement).
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from ..programs import program
from .coordinates import slopes
from .curves import Known
from .linear.independent import independent_samples
from .normal import Normal, moving, normal_equations, pack, pulls, slope_by, unpack
from .problem import Data, Evaluation, Static, Unknowns, evaluate, in_ranges
from .secant import Secant
from .squares import squares_of

MAX_STEPS = 400  # from one start
_SMALL_GAIN = 1e-4
"""Of the cost ½χ² per mean squared independent residual, if that is above one: no parameter is then further from its
optimum than 0.014 standard errors, with what is left taken for noise."""
_WITHIN = 0.5  # the same: of one standard error, where the cost jumps as a kink is met in another step
_COMPARED = 0.05  # the same, of models that are only compared: n ln χ² then falls by 0.1 at most
_SMALL_SHARE = 1e-9  # of the cost: more than that of a misfit is not worth a step
_LEAST_STEP = 1e-12  # where damping has grown that much, rounding decides
_PATIENCE = 12  # steps that together bring less than is worth one: 400 would move no parameter by a tenth of its error
_CRAWL = 0.1  # of the cost: a search that gains less in a dozen steps does not see where its valley goes

_FIRST_STEP = 100.0  # the inverse of the first damping
_FARTHEST = 0.5  # in ln p, for positive parameters in one step
_SIZES = (8, 16, 32)  # of the normal equations as they are solved: one program for all that have fewer unknowns


class How(NamedTuple):
    """How a search goes.

    **Arguments:** `robust`: large residuals count linearly; `most` steps, from one start; `until`: the
    `time.monotonic()` after which no step is begun; `compared`: whether the cost is only compared with another model's.
    """

    robust: bool = False
    most: int = MAX_STEPS
    until: float = np.inf
    compared: bool = False


class Solution(NamedTuple):
    """Where one start ended: `unknowns`, the `cost` Σ r² and the model there, the number of `steps`, and whether it
    `converged`."""

    unknowns: Unknowns
    cost: float
    steps: int
    converged: bool
    found: Evaluation


class _Turn(NamedTuple):
    """After a trial: whether it was `accepted`, the `units` (u,) of the unknowns, the next `move` (u,), and the `reach`
    of the trust region."""

    accepted: Any
    units: Any
    move: Any
    reach: Any


@program
def _advance(
    nothing: None,
    point: Normal,
    trial: Normal,
    again: Normal,
    lengths: Any,
    moved: Any,
    units: Any,
    reach: Any,
    first: Any,
    refused: Any,
) -> tuple:
    """Accept or reject a trial that lies `moved` away from the point, then propose the next move; as of `_Turn`.

    `again`: the point with what the trial has told of its curvature; `lengths` of the trial's Jacobian, (u,). After a
    trial that was `refused` the trust region does not grow at once: it would, along a valley, have every second
    trial refused.
    """
    # Here, because whoever has the compiled program needs neither, and importing both takes a third of a second.
    import lineax as lx
    import optimistix as optx

    descent = optx.DampedNewtonDescent(linear_solver=lx.Cholesky())
    search = optx.ClassicalTrustRegion(high_cutoff=0.75, low_cutoff=0.1)

    def info_of(normal: Normal, units: Any) -> Any:
        matrix = lx.MatrixLinearOperator(normal.matrix / jnp.outer(units, units), lx.positive_semidefinite_tag)
        return optx.FunctionInfo.EvalGradHessian(normal.cost, normal.gradient / units, matrix)

    still = jnp.zeros_like(moved)
    old, new = info_of(point, units), info_of(trial, units)
    state, tree = jax.tree.flatten(search.init(still, jax.eval_shape(info_of, point, units)))
    assert len(state) == 1  # a trust region is one number
    step, accept, _, _ = search.step(first, still, moved * units, old, new, jax.tree.unflatten(tree, [reach]))
    accept = accept & jnp.isfinite(trial.cost)
    step = jnp.where(accept & refused, jnp.minimum(step, reach), step)
    here = Normal(*(jnp.where(accept, b, a) for a, b in zip(again, trial, strict=True)))
    units = jnp.where(accept, jnp.maximum(units, lengths), units)
    info = info_of(here, units)
    move, _ = descent.step(step, descent.query(still, info, descent.init(still, info)))
    return accept, units, move / units, step


def _turn(
    point: Normal, trial: Normal, again: Normal, lengths: np.ndarray, moved: np.ndarray, last: _Turn, first: bool
) -> _Turn:
    """`_advance` with unknowns added that change nothing, up to a size for which there is a program."""
    size = len(moved)
    more = next((n for n in _SIZES if n >= size), -(-size // _SIZES[-1]) * _SIZES[-1]) - size
    matrix = lambda normal: np.block([[normal.matrix, np.zeros((size, more))], [np.zeros((more, size)), np.eye(more)]])
    fill = lambda normal: Normal(normal.cost, np.pad(normal.gradient, (0, more)), matrix(normal))
    units = np.pad(last.units, (0, more), constant_values=1.0)
    accept, units, move, reach = _advance(
        None, fill(point), fill(trial), fill(again), np.pad(lengths, (0, more)), np.pad(moved, (0, more)), units,
        last.reach, np.array(first), np.array(not last.accepted),
    )  # fmt: skip
    return _Turn(bool(accept), np.asarray(units)[:size], np.asarray(move)[:size], np.asarray(reach))


def _decrement(normal: Normal, units: np.ndarray, low: np.ndarray, high: np.ndarray) -> float:
    """The largest fall of the cost, by its quadratic model, of an undamped step between limits (u,); infinite where the
    model's motion is so large that it cannot be said.

    Directions that the data leave free promise nothing. As p falls to zero the slope and the curvature by ln p fade
    together, and an unlimited step would promise the same for ever.
    """
    if not (np.all(np.isfinite(normal.matrix)) and np.all(np.isfinite(normal.gradient))):
        return np.inf
    squares = squares_of(normal, units)
    return squares.fall(squares.best(units * low, units * high))


def _limited(normal: Normal, turn: _Turn, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The next move, as damped as it is, between limits (u,)."""
    if np.all((low <= turn.move) & (turn.move <= high)):
        return turn.move
    if not np.all(np.isfinite(turn.move)):
        return np.clip(turn.move, low, high)
    squares = squares_of(normal, turn.units, 1.0 / float(turn.reach))
    return squares.best(turn.units * low, turn.units * high) / turn.units


@np.errstate(over="ignore", invalid="ignore")  # a start whose motion has no bound has no scale either
def rescale(
    static: Static, data: Data, unknowns: Unknowns, found: Evaluation | None = None
) -> tuple[Data, Unknowns, Evaluation]:
    """Choose the unit of every x such that a unit step changes the residuals by one at this point; the model there.

    `found`: the model there in the old units, if it is known.
    """
    found = found or evaluate(static, data, unknowns)
    squares = np.sum(found.by_x**2, axis=1)
    stretch = slopes(found.values[list(static.free)], data.lower, data.upper) * data.scale
    length = np.sqrt(squares + (data.prior_weight * stretch) ** 2)
    coordinates = unknowns.x * data.scale + data.anchor
    usable = np.isfinite(length) & (length > 0)
    share = 1.0 / np.where(usable, length, 1.0)
    scale = data.scale * share
    found = found._replace(by_x=found.by_x * share[:, None])
    return data._replace(scale=scale, anchor=coordinates), Unknowns(np.zeros_like(scale), unknowns.starts), found


def _fall(normal: Normal, move: np.ndarray) -> float:
    """Fall of the cost that a move promises."""
    return -float(normal.gradient @ move + 0.5 * move @ normal.matrix @ move)


class _Limits(NamedTuple):
    """`farthest` that each unknown may go in one step, and the ends `low` and `high` of its range, (u,)."""

    farthest: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def around(self, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Limits of a move from a point, (u,)."""
        return np.maximum(-self.farthest, self.low - at), np.minimum(self.farthest, self.high - at)


def _limits(data: Data, given: Data) -> _Limits:
    """Limits of the unknowns, whose coordinates are logarithms in `data`, and whose ranges are those `given`."""
    positive, ranged = np.isfinite(data.lower), np.isfinite(given.upper)
    ends = [(np.log(np.where(ranged, end, 1.0)) - data.anchor) / data.scale for end in (given.lower, given.upper)]
    starts = np.full(data.start_scale.shape[1] * len(moving(data)), np.inf)
    return _Limits(
        np.concatenate([np.where(positive, _FARTHEST / data.scale, np.inf), starts]),
        np.concatenate([np.where(ranged, ends[0], -np.inf), -starts]),
        np.concatenate([np.where(ranged, ends[1], np.inf), starts]),
    )


class Search:
    """A search from one starting point that can be left and gone on with; `begun`: the model there, if it is known."""

    def __init__(self, static: Static, data: Data, start: Unknowns, how: How, begun: Evaluation | None = None):
        self.static, self._how = static, how
        curves, steady = data.curves, None if begun is None else begun.steady
        self._given = data = data._replace(curves=curves and curves.apart(static.equation, steady))
        opened = in_ranges(
            static, data, start, np.where(np.isfinite(data.lower), 0.0, data.lower), np.full_like(data.upper, np.inf)
        )
        self._data, self._start, self._best = rescale(static, *opened, begun)
        self._known = self._responses()
        self._limits = _limits(self._data, data)
        self._at = pack(self._start, self._data)
        self._point = normal_equations(static, self._data, self._at, self._best, how.robust)
        units = np.sqrt(np.diagonal(self._point.matrix))
        self._next = np.zeros_like(self._at)
        self._turn = _Turn(True, units, self._next, np.array(_FIRST_STEP))
        self._secant = Secant(np.zeros_like(self._point.matrix))
        self._costs: list[float] = []
        self.steps, self.converged, self.ended = 0, False, False

    @property
    def cost(self) -> float:
        """Σ r² at the best point so far."""
        return 2 * float(self._point.cost)

    @property
    def found(self) -> tuple[Data, Solution]:
        """The best point so far in the coordinates of the fit."""
        there = unpack(self._at, self._start, self._data)
        data, unknowns = in_ranges(self.static, self._data, there, self._given.lower, self._given.upper)
        return data, Solution(unknowns, self.cost, self.steps, self.converged, self._best)

    def go_on(self, most: int, watch: Callable[[float], None] = lambda _: None) -> None:
        """Go on until it ends or has taken `most` steps in all; `watch`: called with Σ r² after every step."""
        while self.steps < most and not self.ended:
            self._step()
            watch(self.cost)
            if time.monotonic() > self._how.until:
                return

    def _responses(self) -> Known | None:
        """The steady responses of curves that the next ones are sought from."""
        return None if self._data.curves is None else self._data.curves.known.get(self.static.equation)

    def _each(self) -> float:
        """The cost per independent residual: what a model lacks is no noise, and many samples may say one thing."""
        return max(self.cost / independent_samples(self._best.residuals), 1.0)

    def _step(self) -> None:
        change, found, trial = self._next, self._best, self._point
        if self.steps:
            found = evaluate(self.static, self._data, unpack(self._at + change, self._start, self._data))
            trial = normal_equations(self.static, self._data, self._at + change, found, self._how.robust)
        self.steps += 1
        self._turn = self._taken(change, found, trial)
        if self._turn.accepted:
            self._at, self._point, self._best = self._at + change, trial, found
            self._known = self._responses()
        elif self._data.curves is not None and self._known is not None and np.all(self._known.found.converged):
            # One reading may have several motions: those of a refused trial are not gone on from.
            self._data.curves.known[self.static.equation] = self._known
        low, high = self._limits.around(self._at)
        here, units = self._secant.bend(self._point, self._turn.units), self._turn.units
        self._next = _limited(here, self._turn, low, high)
        promised = _decrement(self._point, units, low, high)
        if self._secant.use and self._secant.proven:
            promised = min(promised, _decrement(here, units, low, high))
        each = self._each()
        worth = (_COMPARED if self._how.compared else _SMALL_GAIN) * each  # a step
        self._costs = [*self._costs[-_PATIENCE:], float(self._point.cost)]
        self.converged = promised < worth + _SMALL_SHARE * float(self._point.cost)
        hopeless = _fall(here, self._next) * MAX_STEPS < worth
        stands = hopeless or self._gained < worth or float(self._turn.reach) < _LEAST_STEP
        self.ended = self.converged or stands
        self.converged = self.converged or (stands and not self._turn.accepted and promised < _WITHIN * each)

    @property
    def _gained(self) -> float:
        """By how much the cost has fallen in the last dozen steps; more than can be told before there were as many."""
        return self._costs[0] - self._costs[-1] if len(self._costs) > _PATIENCE else np.inf

    def _taken(self, change: np.ndarray, found: Evaluation, trial: Normal) -> _Turn:
        """A trial accepted or refused, by what was known of the curvature before; what it tells of that counts for the
        next move."""
        units, secant, point = self._turn.units, self._secant, self._point
        if self.steps > 1:
            pull = pulls(found.residuals, self._how.robust)
            now, before = (slope_by(self.static, self._data, one, pull) for one in (found, self._best))
            self._secant = secant.learn(change, point, trial, now - before, self._gained < _CRAWL * self._costs[-1])
        bend = lambda normal: self._secant.bend(normal, units)
        lengths = np.sqrt(np.diagonal(trial.matrix))
        return _turn(secant.bend(point, units), bend(trial), bend(point), lengths, change, self._turn, self.steps == 1)


def least_squares(
    static: Static,
    data: Data,
    start: Unknowns,
    how: How,
    begun: Evaluation | None = None,
    watch: Callable[[float], None] = lambda _: None,
) -> tuple[Data, Solution]:
    """Minimise from one starting point; the data as rescaled there, and the solution. Arguments as of `Search`."""
    search = Search(static, data, start, how, begun)
    search.go_on(how.most, watch)
    return search.found
