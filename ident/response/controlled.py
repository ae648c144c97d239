"""Steady responses of a given amplitude: how strong would the drive have to act, to be answered as was measured?

At a given drive level a nonlinear resonance has one, three or more amplitudes, and where they meet its slope is
infinite. The other way round there is one answer: at a given frequency and amplitude one force, and one phase, which
move smoothly with every parameter. A point that was measured lies on no branch and beyond no fold; nothing jumps.

It is the force of the actuator that is asked about, s times what the measured level gives, and not another level: an
actuator that saturates may have none with which it reaches as far. What the drive adds to the reading past the stage
counts s times, too: beside a force alone it would leave two answers beyond an antiresonance, and none at it.

A sensor that is bent may read the same of two motions, or never as much as was measured. Not the amplitude alone is
asked for then, but amplitude and share on a line across the curve, |Y₁| s^λ = A, which the motion crosses once where it
grows with the force and the reading falls no faster than its power λ.

The unknowns are the state y at the beginning of a period and the share s; the equations Φ(y; s) = y and |Y₁| s^λ = A
are solved by Newton's method from the balance of the fundamental alone, or from the next point.

Source: D. A. W. Barton, J. Sieber, Systematic experimental exploration of bifurcations with noninvasive control, Phys.
Rev. E 87 (2013) 052916 (the same idea in the laboratory); W. Krack, J. Gross, Harmonic Balance for Nonlinear Vibration
Problems, 2019, §3 (the start).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .periodic import BY_FREQUENCY, BY_SHARE, FREQUENCY, SHARE, Look, Periodic, Seat, empty_look, ride
from .steady_memory import STUCK

_CLOSE = 1e-4  # of the scale of an unknown: the last step of Newton's method, which leaves its square
_MOST, _PATIENCE = 40, 10  # steps of Newton's method in all, and without coming half as near again
_LEAST = 1 / 16  # of a step
_DETOURS = 8  # searches for points on the way to one that is not found from its neighbour: a sixteenth of it is four
_FARTHEST = 0.5  # of the scale of an unknown, in one step


class Points(NamedTuple):
    """What was measured, (points,): `frequency` Hz, drive `level` V, `amplitude` m, `load` kg; `swing`: whether the
    amplitude is half the peak-to-peak value instead of the fundamental; `tilt`: λ, () or (points,)."""

    frequency: np.ndarray
    level: np.ndarray
    amplitude: np.ndarray
    load: np.ndarray
    swing: np.ndarray
    tilt: np.ndarray = np.zeros(())

    def some(self, rows: np.ndarray) -> Points:
        """Some of them."""
        return Points(*(part[rows] if part.ndim else part for part in self))

    def between(self, others: Points, share: np.ndarray) -> Points:
        """Points on the way from the others of the same sweep to these, (points,) a share of it."""
        part = lambda name: getattr(others, name) + share * (getattr(self, name) - getattr(others, name))
        return self._replace(frequency=part("frequency"), amplitude=part("amplitude"))


@dataclass(frozen=True, eq=False)
class Controlled:
    """Steady responses of given amplitudes.

    **Arguments:** `unknowns`: (points, n + 2) y, s, f; `jacobian`: (points, n + 1, n + 1) of the equations by y and s;
    `seen`: one period from there, along y and s; `converged`: (points,), what did not is the balance of the fundamental
    alone; `beside`: the same period along directions of the values that were asked for beforehand.
    """

    model: Periodic
    points: Points
    unknowns: np.ndarray
    seat: Seat
    jacobian: np.ndarray
    seen: Look
    converged: np.ndarray
    beside: Beside | None = None

    @property
    def share(self) -> np.ndarray:
        """(points,) of the actuator's force at the measured level that the model needs."""
        return self.unknowns[:, SHARE]

    @property
    def tone(self) -> np.ndarray:
        """(points,) complex fundamental relative to the drive, m."""
        return self.seen.tone

    @property
    def needed(self) -> np.ndarray:
        """(points,) complex drive relative to the response, V, if the actuator were linear: the share of the level,
        ahead of the response as it is."""
        return self.share * self.points.level * np.exp(-1j * np.angle(self.tone))

    def moves(self, directions: np.ndarray) -> Moved:
        """Derivatives along directions (d, m) of the values."""
        if self.beside is None or not np.array_equal(self.beside.directions, directions):
            seen = self.model.look(self.unknowns, self.seat, BY_SHARE, directions)
            return self._answer(*self._asked(seen.along(slice(self.model.size + 1, None))))
        return self._answer(*self._asked(self.beside.seen))

    def overtones(self, orders: tuple[int, ...]) -> np.ndarray:
        """(orders, points) complex harmonics of the reading relative to the drive, m."""
        return self.model.overtones(orders, self.unknowns, self.seat)[0]

    def overtone_slopes(self, orders: tuple[int, ...], directions: np.ndarray) -> np.ndarray:
        """Derivatives of `overtones` along directions (d, m) of the values, (orders, d, points)."""
        n = self.model.size
        _, slopes = self.model.overtones(orders, self.unknowns, self.seat, directions)
        moved = self.moves(directions).unknowns / self.seat.scale[:, : n + 1]
        return np.einsum("knp,dpn->kdp", slopes[:, : n + 1], moved) + slopes[:, n + 1 :]

    def slopes(self, directions: np.ndarray) -> np.ndarray:
        """Derivatives of `needed` along directions (d, m) of the values, (d, points)."""
        return self.moves(directions).needed

    @property
    def by_amplitude(self) -> np.ndarray:
        """Derivative of `needed` by the amplitude, (points,) V/m."""
        n = self.model.size
        equations = np.zeros((1, len(self.unknowns), n + 1))
        equations[..., n] = -1.0 / self.points.amplitude
        return self._answer(equations, np.zeros((1, len(self.unknowns)))).needed[0]

    @property
    def by_frequency(self) -> np.ndarray:
        """Derivative of `needed` by the frequency, (points,) V/Hz."""
        n = self.model.size
        found = self.model.look(self.unknowns, self.seat, BY_FREQUENCY).along(slice(n, n + 1))
        return self._answer(*self._asked(found)).needed[0] / self.seat.scale[:, FREQUENCY]

    def multipliers(self) -> np.ndarray:
        """Floquet multipliers, (points, n): inside the unit circle where the response is stable."""
        n = self.model.size
        return np.linalg.eigvals(self.jacobian[:, :n, :n] + np.eye(n))

    def _asked(self, look: Look) -> tuple[np.ndarray, np.ndarray]:
        """How the equations, (d, points, n + 1), and the phase, (d, points), change along the directions of a look."""
        turn = np.imag(look.tone_slope / look.tone)
        size = np.where(self.points.swing, look.swing_slope / look.swing, np.real(look.tone_slope / look.tone))
        scaled = look.miss_slope / self.seat.scale[None, :, : self.model.size]
        return np.concatenate([scaled, size[..., None]], axis=2), turn

    def _answer(self, equations: np.ndarray, turn: np.ndarray) -> Moved:
        """How the responses answer where the equations change by (d, points, n + 1) and the phase by (d, points)."""
        n = self.model.size
        step = -_solved(self.jacobian, np.moveaxis(equations, 0, 2))  # (points, n + 1, d)
        _, own = self._asked(self.seen)
        turn = turn + np.einsum("kp,pkd->dp", own[: n + 1], step)
        step = np.where(self.converged[:, None, None], step, 0.0) * self.seat.scale[:, : n + 1, None]
        needed = self.needed * (step[:, n].T / self.share - 1j * np.where(self.converged, turn, 0.0))
        return Moved(np.moveaxis(step, 2, 0), needed)


class Moved(NamedTuple):
    """Derivatives of steady responses along d directions: of the `unknowns` y and s, (d, points, n + 1), and of the
    drive that is `needed`, (d, points)."""

    unknowns: np.ndarray
    needed: np.ndarray


class Beside(NamedTuple):
    """One period of all points, `seen` along `directions` (d, m) of the values."""

    directions: np.ndarray
    seen: Look


@np.errstate(over="ignore", invalid="ignore")  # a motion without bound does not converge, which is told
def at_amplitude(
    model: Periodic, points: Points, start: np.ndarray | None = None, directions: np.ndarray | None = None
) -> Controlled:
    """The steady responses of a model with the amplitudes of the points; `start`, (points, n + 2), from where the
    search begins if they are known nearly. Points that are not found from there, or of which nothing is known (NaN),
    are searched from the balance, and those that it leads astray from their neighbours.

    `directions`, (d, m) of the values, along which derivatives will be asked for: where one look finds all points it
    brings them along, and no second one is needed.
    """
    n = model.size
    first = np.full((len(points.level), n + 2), np.nan) if start is None else start.copy()
    new = ~np.all(np.isfinite(first), axis=1)
    if np.any(new):
        first[new] = begin(model, points.some(new))
    hidden = np.max(np.abs(first[:, 2:n]), axis=0, initial=0.0)
    omega = 2 * np.pi * points.frequency
    size = points.amplitude + np.abs(_past(model, points))  # near an antiresonance the stage moves more than is read
    scale = np.column_stack([size, omega * size,
                             np.broadcast_to(np.where(hidden > 0, hidden, 1.0), (len(first), n - 2)),
                             np.ones(len(first)), 1e-3 * points.frequency])  # fmt: skip
    seat = Seat(points.level, points.load, scale)
    search = _newton(model, points, first, seat, directions)
    lost = ~search.found & ~new
    if np.any(lost):
        few = points.some(lost)
        first[lost] = begin(model, few)
        search.put(lost, _newton(model, few, first[lost], seat.some(lost)))
    _lead_on(model, points, seat, search)
    w, seen, found = search.unknowns, search.look, search.found
    lost = ~found
    if np.any(lost):
        w[lost] = first[lost]
        seen.put(lost, model.look(w[lost], seat.some(lost), BY_SHARE))
    jacobian = _equations(seen, seat, points, w[:, SHARE])[1]
    return Controlled(model, points, w, seat, jacobian, seen, found, search.beside)


class _Search(NamedTuple):
    """Newton's method on its way: `unknowns`; what the last look there said, its `tone` moved on with the last step;
    and which points are `found`; what the first look said `beside`, if it found them all."""

    unknowns: np.ndarray
    look: Look
    found: np.ndarray
    beside: Beside | None = None

    def put(self, rows: np.ndarray, other: _Search) -> None:
        """Take over some points of another search."""
        self.unknowns[rows], self.found[rows] = other.unknowns, other.found
        self.look.put(rows, other.look)


def _newton(
    model: Periodic, points: Points, start: np.ndarray, seat: Seat, directions: np.ndarray | None = None
) -> _Search:
    """Newton's method from a start. Once a step is small the next would be its square: none is taken to see that."""
    n, left = model.size, np.arange(len(start))
    search = _Search(start.copy(), empty_look(len(start), n, n + 1), np.zeros(len(start), bool))
    w, miss, damped = search.unknowns, np.full(len(start), np.inf), np.ones(len(start))
    least, waited = miss.copy(), np.zeros(len(start), int)
    for _ in range(_MOST):
        own, there = points.some(left), seat.some(left)
        seen = model.look(w[left], there, BY_SHARE, directions)
        more, seen = seen.along(slice(n + 1, None)), seen.along(slice(n + 1))
        equations, jacobian = _equations(seen, there, own, w[left, SHARE])
        now = np.max(np.abs(equations), axis=1)
        # At the kink of a play full steps may lead to and fro for ever.
        damped[left] = np.clip(np.where(now > miss[left], 0.5, 2.0) * damped[left], _LEAST, 1.0)
        miss[left] = now
        nearer = now < 0.5 * least[left]
        least[left] = np.where(nearer, now, least[left])
        waited[left] = np.where(nearer, 0, waited[left] + 1)
        with np.errstate(invalid="ignore", over="ignore"):
            step = -_solved(np.nan_to_num(jacobian), np.nan_to_num(equations)[..., None])[..., 0]
        farthest = np.max(np.abs(step[:, [0, 1, n]]), axis=1)  # a memory may be far from where it settles
        close = np.maximum(now, farthest) < _CLOSE
        step *= np.where(close, 1.0, np.minimum(damped[left], _FARTHEST / np.maximum(farthest, 1e-300)))[:, None]
        on = np.isfinite(now) & (waited[left] < _PATIENCE)
        w[left[on], : n + 1] += step[on] * there.scale[on, : n + 1]
        search.look.put(left, seen.moved(step))
        search.found[left] = close & (w[left, SHARE] > 0)
        if directions is not None and np.all(search.found):
            search = search._replace(beside=Beside(directions, more))
        left, directions = left[on & ~close], None
        if not len(left):
            break
    return search


def _lead_on(model: Periodic, points: Points, seat: Seat, search: _Search) -> None:
    """Search what was not found from the points beside it that were, as long as that finds more: where forces move the
    mean of a motion far, the balance of its fundamental is no place to begin. Where the next point is too far for one
    search, it is reached by points between."""
    asked = np.zeros((2, len(search.found)), bool)  # from the point before and from that after: once each
    while True:
        known = np.concatenate([[False], search.found, [False]])
        before = ~search.found & known[:-2] & ~asked[0]
        after = ~search.found & known[2:] & ~asked[1] & ~before
        edge = np.flatnonzero(before | after)
        if not len(edge):
            return
        asked |= [before, after]
        near = np.where(before[edge], edge - 1, edge + 1)
        search.put(edge, _along(model, points.some(near), points.some(edge), search.unknowns[near], seat.some(edge)))


def _along(model: Periodic, known: Points, wanted: Points, first: np.ndarray, seat: Seat) -> _Search:
    """Search wanted points from known ones beside them, `first`: at once, or else, on one sweep, from points on the
    way."""
    start, way, step = first.copy(), np.zeros(len(first)), np.full(len(first), 0.5)
    start[:, FREQUENCY] = wanted.frequency
    search = _newton(model, wanted, start, seat)
    alike = (known.level == wanted.level) & (known.load == wanted.load) & (known.swing == wanted.swing)
    for _ in range(_DETOURS):
        lost = np.flatnonzero(~search.found & alike)
        if not len(lost):
            break
        to = way[lost] + step[lost] * (1.0 - way[lost])
        own = wanted.some(lost).between(known.some(lost), to)
        start[lost, FREQUENCY] = own.frequency
        nearer = _newton(model, own, start[lost], seat.some(lost))
        reached = lost[nearer.found]
        start[reached] = nearer.unknowns[nearer.found]
        way[reached] = to[nearer.found]
        step[lost[~nearer.found]] /= 2
        start[reached, FREQUENCY] = wanted.frequency[reached]
        if len(reached):
            search.put(reached, _newton(model, wanted.some(reached), start[reached], seat.some(reached)))
    return search


def begin(model: Periodic, points: Points) -> np.ndarray:
    """Unknowns by the balance of the fundamental alone, (points, n + 2)."""
    still = ride(model, points.level, points.frequency, points.load, points.amplitude + 0j)
    needed = still.force / np.where(still.given == 0, np.inf, still.given)  # if the stage moves as A cos ωt
    motion, share = points.amplitude * np.exp(-1j * np.angle(needed)), np.maximum(np.abs(needed), 1e-6)
    # Beside what the drive adds to the reading the stage moves more than is read, or less.
    less = points.amplitude / np.maximum(np.abs(motion + share * _past(model, points)), 1e-3 * points.amplitude)
    less *= (less * share) ** (-points.tilt / (1 + points.tilt))
    motion, share = less * motion, less * share
    moved = ride(model, points.level, points.frequency, points.load, motion)
    velocity = np.real(2j * np.pi * points.frequency * motion)
    return np.column_stack([np.real(motion), velocity, moved.hidden, share, points.frequency])


def _past(model: Periodic, points: Points) -> np.ndarray:
    """(points,) complex fundamental of what the drive adds to the reading past the stage, m."""
    if not any(effect.overrides("sensor") for effect in model.equation.model.effects):
        return np.zeros(len(points.level), complex)
    return ride(model, points.level, points.frequency, points.load, np.zeros(len(points.level), complex)).added


def _equations(seen: Look, seat: Seat, points: Points, share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Equations (points, n + 1), each in units of its scale, and their derivatives by y and s."""
    n, share = seen.miss.shape[1], np.maximum(share, 1e-6)
    across = share**points.tilt / points.amplitude
    size = np.where(points.swing, seen.swing, np.abs(seen.tone))
    turned = np.real(np.conj(seen.tone) * seen.tone_slope) / np.maximum(np.abs(seen.tone), 1e-300)
    change = np.where(points.swing, seen.swing_slope, turned) * across
    change[n] += points.tilt * size * across / share
    equations = np.column_stack([seen.miss / seat.scale[:, :n], size * across - 1.0])
    slopes = np.concatenate([seen.miss_slope / seat.scale[None, :, :n], change[..., None]], axis=2)
    return equations, np.moveaxis(slopes[: n + 1], 0, 2)


def _solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Least-squares solutions, (points, n, k), that leave alone what the equations do not see; none where a motion
    without bound leaves no equations."""
    turned = np.swapaxes(matrix, 1, 2)
    with np.errstate(over="ignore", invalid="ignore"):
        square, aim = turned @ matrix, turned @ right
    known = np.all(np.isfinite(square), axis=(1, 2)) & np.all(np.isfinite(aim), axis=(1, 2))
    square, aim = np.where(known[:, None, None], square, 0.0), np.where(known[:, None, None], aim, 0.0)
    largest = np.maximum(np.einsum("kii->ki", square).max(axis=1, initial=0.0), 1.0)
    return np.linalg.solve(square + STUCK * largest[:, None, None] * np.eye(matrix.shape[1]), aim)
