"""Steady responses of a given amplitude: which drive would the model need, to answer at a frequency as measured?

At a given drive level a nonlinear resonance has one, three or more amplitudes, and where they meet its slope is
infinite. The other way round there is one answer: at a given frequency and amplitude one level, and one phase, which
move smoothly with every parameter. A point that was measured lies on no branch and beyond no fold; nothing jumps.

The unknowns are the state y at the beginning of a period and the level U; the equations Φ(y; U) = y and |Y₁| = A are
solved by Newton's method from the balance of the fundamental alone.

Source: D. A. W. Barton, J. Sieber, Systematic experimental exploration of bifurcations with noninvasive control, Phys.
Rev. E 87 (2013) 052916 (the same idea in the laboratory); W. Krack, J. Gross, Harmonic Balance for Nonlinear Vibration
Problems, 2019, §3 (the start).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .periodic import LEVEL, Look, Periodic, Seat, ride

_ENOUGH = 1e-10  # of the amplitude: so well a period closes
_MOST = 40  # steps of Newton's method
_LEAST = 1 / 16  # of a step
_FARTHEST = 0.5  # of the scale of an unknown, in one step
_STUCK = 1e-12  # squared share below which a memory neither forgets nor moves: it stays where it is


class Points(NamedTuple):
    """What was measured, (points,): `frequency` Hz, `amplitude` m, `load` kg, a `level` to start from, V; `swing`:
    whether the amplitude is half the peak-to-peak value instead of the fundamental."""

    frequency: np.ndarray
    level: np.ndarray
    amplitude: np.ndarray
    load: np.ndarray
    swing: np.ndarray


@dataclass(frozen=True, eq=False)
class Controlled:
    """Steady responses of given amplitudes.

    **Arguments:** `unknowns`: (points, n + 2) y, U, f; `jacobian`: (points, n + 1, n + 1) of the equations by y and U;
    `converged`: (points,), what did not is the balance of the fundamental alone.
    """

    model: Periodic
    points: Points
    unknowns: np.ndarray
    seat: Seat
    jacobian: np.ndarray
    seen: Look
    converged: np.ndarray

    @property
    def level(self) -> np.ndarray:
        """(points,) V that the model needs."""
        return self.unknowns[:, LEVEL]

    @property
    def tone(self) -> np.ndarray:
        """(points,) complex fundamental relative to the drive, m."""
        return self.seen.tone

    @property
    def needed(self) -> np.ndarray:
        """(points,) complex drive relative to the response, V: the level, ahead of the response as it is."""
        return self.level * np.exp(-1j * np.angle(self.tone))

    def slopes(self, directions: np.ndarray) -> np.ndarray:
        """Derivatives of `needed` along directions (d, m) of the values, (d, points)."""
        n = self.model.size
        found = self.model.look(self.unknowns, self.seat, np.zeros((len(directions), n + 2)), directions)
        size, turn = self._shown(found)
        equations = np.concatenate([found.miss_slope / self.seat.scale[None, :, :n], size[..., None]], axis=2)
        return self._answer(equations, turn)

    @property
    def by_amplitude(self) -> np.ndarray:
        """Derivative of `needed` by the amplitude, (points,) V/m."""
        n = self.model.size
        equations = np.zeros((1, len(self.unknowns), n + 1))
        equations[..., n] = -1.0 / self.points.amplitude
        return self._answer(equations, np.zeros((1, len(self.unknowns))))[0]

    @property
    def by_frequency(self) -> np.ndarray:
        """Derivative of `needed` by the frequency, (points,) V/Hz."""
        n = self.model.size
        size, turn = self._shown(self.seen)
        scale = self.seat.scale
        equations = np.concatenate([self.seen.miss_slope[-1] / scale[:, :n], size[-1][:, None]], axis=1)
        return self._answer(equations[None], turn[-1:])[0] / scale[:, -1]

    def multipliers(self) -> np.ndarray:
        """Floquet multipliers, (points, n): inside the unit circle where the response is stable at its level."""
        n = self.model.size
        return np.linalg.eigvals(self.jacobian[:, :n, :n] + np.eye(n))

    def _shown(self, look: Look) -> tuple[np.ndarray, np.ndarray]:
        """Relative changes of the amplitude and changes of the phase along the directions of a look, (d, points)."""
        turn = np.imag(look.tone_slope / look.tone)
        size = np.where(self.points.swing, look.swing_slope / look.swing, np.real(look.tone_slope / look.tone))
        return size, turn

    def _answer(self, equations: np.ndarray, turn: np.ndarray) -> np.ndarray:
        """How `needed` answers where the equations change by (d, points, n + 1) and the phase by (d, points)."""
        step = -_solved(self.jacobian, np.moveaxis(equations, 0, 2))  # (points, n + 1, d)
        n = self.model.size
        _, own = self._shown(self.seen)
        turn = turn + np.einsum("kp,pkd->dp", own[: n + 1], step)
        level = step[:, n].T * self.seat.scale[:, LEVEL]
        return np.where(self.converged, self.needed * (level / self.level - 1j * turn), 0.0)


def at_amplitude(model: Periodic, points: Points, start: np.ndarray | None = None) -> Controlled:
    """The steady responses of a model with the amplitudes of the points; `start`, (points, n + 2), from where the
    search begins if they are known nearly."""
    n = model.size
    first = begin(model, points) if start is None else start
    hidden = np.max(np.abs(first[:, 2:n]), axis=0, initial=0.0)
    omega = 2 * np.pi * points.frequency
    scale = np.column_stack([points.amplitude, omega * points.amplitude,
                             np.broadcast_to(np.where(hidden > 0, hidden, 1.0), (len(first), n - 2)),
                             points.level, 1e-3 * points.frequency])  # fmt: skip
    seat = Seat(points.load, scale)
    w, good = _newton(model, points, first.copy(), seat)
    if start is not None and not np.all(good):
        return at_amplitude(model, points)
    w = np.where(good[:, None], w, first)
    seen = model.look(w, seat, np.eye(n + 2))
    return Controlled(model, points, w, seat, _equations(seen, seat, points)[1], seen, good)


def _newton(model: Periodic, points: Points, w: np.ndarray, seat: Seat) -> tuple[np.ndarray, np.ndarray]:
    """The unknowns after Newton's method, and where it found a response."""
    n, left = model.size, np.arange(len(w))
    miss, share = np.full(len(w), np.inf), np.ones(len(w))
    for _ in range(_MOST):
        own, there = (
            points._replace(**{k: v[left] for k, v in points._asdict().items()}),
            Seat(*(x[left] for x in seat)),
        )
        seen = model.look(w[left], there, np.eye(n + 1, n + 2))
        equations, jacobian = _equations(seen, there, own)
        now = np.max(np.abs(equations), axis=1)
        # At the kink of a play full steps may lead to and fro for ever.
        share[left] = np.where(now > miss[left], 0.5, 2.0) * share[left]
        share = np.clip(share, _LEAST, 1.0)
        miss[left] = now
        with np.errstate(invalid="ignore", over="ignore"):
            step = -_solved(np.nan_to_num(jacobian), np.nan_to_num(equations)[..., None])[..., 0]
        farthest = np.max(np.abs(step[:, [0, 1, n]]), axis=1)  # a memory may be far from where it settles
        step *= np.minimum(share[left], _FARTHEST / np.maximum(farthest, 1e-300))[:, None]
        more = (miss[left] > _ENOUGH) & np.isfinite(miss[left])
        w[left[more], : n + 1] += step[more] * there.scale[more, : n + 1]
        left = left[more]
        if not len(left):
            break
    return w, (miss < np.sqrt(_ENOUGH)) & (w[:, LEVEL] > 0)


def begin(model: Periodic, points: Points) -> np.ndarray:
    """Unknowns by the balance of the fundamental alone, (points, n + 2)."""
    gain = _gain(model)
    still = ride(model, points.level, points.frequency, points.load, points.amplitude + 0j)
    needed = still.force / gain  # the drive that moves the stage as A cos ωt
    motion = points.amplitude * np.exp(-1j * np.angle(needed))
    moved = ride(model, points.level, points.frequency, points.load, motion)
    velocity = np.real(2j * np.pi * points.frequency * motion)
    level = np.maximum(np.abs(needed), 1e-6 * points.level)
    return np.column_stack([np.real(motion), velocity, moved.hidden, level, points.frequency])


def _gain(model: Periodic) -> float:
    return float(model.values[2] * model.equation.constants[1])


def _equations(seen: Look, seat: Seat, points: Points) -> tuple[np.ndarray, np.ndarray]:
    """Equations (points, n + 1), each in units of its scale, and their derivatives by y and U."""
    n = seen.miss.shape[1]
    size = np.where(points.swing, seen.swing, np.abs(seen.tone))
    turned = np.real(np.conj(seen.tone) * seen.tone_slope) / np.maximum(np.abs(seen.tone), 1e-300)
    change = np.where(points.swing, seen.swing_slope, turned) / points.amplitude
    equations = np.column_stack([seen.miss / seat.scale[:, :n], size / points.amplitude - 1.0])
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
    return np.linalg.solve(square + _STUCK * largest[:, None, None] * np.eye(matrix.shape[1]), aim)
