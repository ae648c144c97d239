"""How far a model and a possible effect together could describe sweeps: the balance of the fundamental, refitted.

The drive that is needed is linear in the amplitudes, or of second order, but its modulus is not: where phases were not
measured, a spring that turns the drive by a right angle changes nothing to first order and much to second. The few
numbers are therefore searched, which takes milliseconds. Along a parabola each answer has a second one, on the other
side of its vertex: of an amplitude that cannot be negative it may be the only one that can be. Weights are those of the
model where a search ends, as in a fit: a drive that does not depend on the amplitude agrees with any that was measured
at one level, and says nothing. Traces beside the sweeps count as linear.

Source: G. A. F. Seber, C. J. Wild, Nonlinear Regression, 1989, §14.2 (Levenberg and Marquardt).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .curve_columns import Moves, Plane

if TYPE_CHECKING:
    from .regression import Regression

_ROUNDS = 60  # at most
_STARTS = (0.0, 0.3, -0.3)  # of the drive that was there, as size of the effect
_TRIED = 0.01  # of the drive that was there: by so much an amplitude moves to tell its square from its slope
_SMALL = 1e-9  # fall of χ², as a share, that ends a search
_REWEIGHED, _SETTLED = 3, 0.01  # times that weights are renewed, at most; fall of χ² by that, as a share, that ends it


class Balanced(NamedTuple):
    """`step` (k + q,) of the model's own parameters and of the amplitudes; what is `left` (n,), white; `slopes` (k + q,
    n) of what the readings do there.

    An amplitude that acts by its square alone, as an even force does, or a turn of the drive where phases were not
    measured, has no slope at zero that would lead a refit away from there: where the search leaves it, it steps off.
    """

    step: np.ndarray
    left: np.ndarray
    slopes: np.ndarray


def balanced(
    regression: Regression, samples: np.ndarray, moves: Moves, positive: np.ndarray | bool = False
) -> Balanced:
    """The best of a model and q amplitudes.

    **Arguments:** `samples`, (q, samples) white: what a unit of each does to the traces; `moves`, of q: to the points
    of the sweeps; `positive`, (q,): which of them cannot be negative.
    """
    plane, own = regression.plane, len(regression.directions)
    assert plane is not None  # there are sweeps
    first = samples.shape[1]
    both = moves.beside_others(plane.own)
    rows = np.concatenate([regression.known[:, :first], samples])
    typical = np.median(plane.curves.points.level)
    largest = np.max(np.abs(both.drives), axis=1) / typical + np.max(np.abs(both.shares), axis=1)
    for part, unit in ((moves.bends, typical), (moves.share_bends, 1.0)):
        largest[own:] += np.sqrt(np.max(np.abs(np.einsum("ddp->dp", part)), axis=1, initial=0.0) / unit)
    size = np.median(plane.curves.points.amplitude)
    largest += np.max(np.abs(both.heard), axis=(1, 2), initial=0.0) / size
    usable = np.isfinite(largest) & ((largest > 0) | (np.abs(rows).max(axis=1, initial=0.0) > 0))
    scale = np.where(usable, 1.0 / np.where(largest > 0, largest, 1.0), 0.0)
    both = both.scaled(scale)
    rows = rows * scale[:, None]
    needed = np.stack([one.needed for one in plane.steady])

    def at(x: np.ndarray, plane: Plane) -> tuple[np.ndarray, np.ndarray]:
        bent, turned = (np.einsum("d,dqp->qp", x, part) for part in (both.bends, both.share_bends))
        drives, given = needed[0] + x @ both.drives + x[own:] @ bent, 1.0 + x @ both.shares + x[own:] @ turned
        heard = plane.heard + np.einsum("d,dkp->kp", x, both.heard)
        left = np.concatenate([regression.left[:first] - x @ rows, plane.left(drives, given, heard)])
        steeper, turning = (
            straight + np.einsum("dqp,q->dp", square, x[own:])
            for straight, square in ((both.drives, both.bends), (both.shares, both.share_bends))
        )
        steeper[own:] += bent
        turning[own:] += turned
        along = both._replace(drives=steeper, shares=turning)
        return left, np.concatenate([rows, -plane.slopes(drives, given, heard, along)], axis=1)

    def weighed(x: np.ndarray) -> _End:
        """With the noise carried through the model as it is there."""
        with np.errstate(all="ignore"):
            bent = np.einsum("d,dqp,q->p", x, both.bends, x[own:])
            beside = np.einsum("d,dsp->sp", x, both.beside) + np.einsum("d,dqsp,q->sp", x, both.beside_bends, x[own:])
            there = plane.weighed(needed[0] + x @ both.drives + bent, needed[1:] + beside)
            return _End(x, there, *at(x, there))

    above = np.concatenate([np.zeros(own, bool), np.broadcast_to(positive, len(moves.drives))])
    ends = []
    for sizes in _starts(both.drives[own:], both.bends[own:]):
        x = np.concatenate([np.zeros(own), sizes])
        x = np.where(above, np.maximum(np.abs(x), _TRIED), x)
        ends.append(weighed(_searched(lambda x: at(x, plane), x, above)))
    best = min(ends, key=_End.cost)
    for _ in range(_REWEIGHED):
        other = weighed(_searched(lambda x, there=best.plane: at(x, there), best.x, above))
        if not other.cost() < best.cost() * (1 - _SETTLED):
            break
        best = other
    step = best.x.copy()
    for i in range(own, len(step)):
        step[i] = _off_zero(best, lambda x: at(x, best.plane)[0], i)
    return Balanced(step * scale, best.left, best.slopes)


def _starts(drives: np.ndarray, bends: np.ndarray) -> list[np.ndarray]:
    """Sizes of q amplitudes from where to search: all at once, and each where its square takes away what its slope
    does, so that the search begins on the other side of the vertex."""
    if not len(drives):
        return [np.zeros(0)]
    found = [np.full(len(drives), size) for size in _STARTS]
    for i, (slope, square) in enumerate(zip(drives, np.einsum("ddp->dp", bends), strict=True)):
        power = float(np.sum(np.abs(square) ** 2))
        if power > 0 and np.any(slope):
            found.append(np.zeros(len(drives)))
            found[-1][i] = -float(np.real(np.vdot(square, slope))) / power
    return found


class _End(NamedTuple):
    """Where a search ended: `x`, the plane with the weights there, and what is left there, with its slopes."""

    x: np.ndarray
    plane: Plane
    left: np.ndarray
    slopes: np.ndarray

    def cost(self) -> float:
        """χ²; infinite where it is no number."""
        cost = float(self.left @ self.left)
        return cost if np.isfinite(cost) else np.inf


def _off_zero(end: _End, left: Callable[[np.ndarray], np.ndarray], i: int) -> float:
    """Number i of a search's end; where it acts by its square rather than its slope, not nearer to zero than where its
    square moves all numbers together by one noise floor."""
    tried, slope = end.x.copy(), end.slopes[i]
    tried[i] += _TRIED
    with np.errstate(all="ignore"):
        square = np.linalg.norm(left(tried) - end.left + _TRIED * slope) / _TRIED**2
    faint = 1.0 / np.sqrt(square) if np.isfinite(square) and square > 0 else 0.0
    by_square = np.linalg.norm(slope) * faint < 1.0
    return float(np.copysign(max(abs(end.x[i]), faint), end.x[i])) if by_square else float(end.x[i])


def samples_of(regression: Regression) -> int:
    """How many of the regression's numbers are samples of traces."""
    return len(regression.left) - (0 if regression.plane is None else len(regression.plane.order))


def _searched(
    at: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]], x: np.ndarray, above: np.ndarray
) -> np.ndarray:
    """Where Levenberg's and Marquardt's search from x ends; numbers that stay `above` zero by their logarithms."""
    left, slopes = at(x)
    damping, cost = 1e-3, float(left @ left)
    if not np.isfinite(cost):
        return x
    for _ in range(_ROUNDS):
        slopes = slopes * np.where(above, x, 1.0)[:, None]
        with np.errstate(all="ignore"):
            gram = slopes @ slopes.T
        if not np.all(np.isfinite(gram)):  # nothing to go by: from here on a step has no bound
            break
        units = np.maximum(np.diag(gram), 1e-300)
        move = np.linalg.lstsq(gram + damping * np.diag(units), slopes @ left, rcond=1e-14)[0]
        with np.errstate(all="ignore"):
            there = np.where(above, x * np.exp(np.where(above, move, 0.0)), x + move)
            tried = at(there)
            new = float(tried[0] @ tried[0])
        if not new < cost:
            damping *= 8
            if damping > 1e8:
                break
            continue
        small = cost - new < _SMALL * cost
        x, (left, slopes), cost, damping = there, tried, new, damping / 5
        if small:
            break
    return x
