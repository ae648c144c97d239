"""The periodic orbit of a model under a drive that repeats itself: where a record begins whose transient has died away.

    s = Φ(s; p),   ds/dp = (1 − ∂Φ/∂s)⁻¹ ∂Φ/∂p

Φ carries the state at the first sample through one period of the drive, hidden states included. Its fixed point s is
the start of the record, a function of the parameters p and no unknown. The period is marched through by the program
that marches through the records (`transient`), whatever the waveform.

Source: the implicit function theorem; A. H. Nayfeh, B. Balachandran, Applied Nonlinear Dynamics, 1995, §3.2 (Floquet
theory), §6.5 (shooting).
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from ..programs import program
from .ensemble import march_many
from .lane import Lane, Numbers
from .memory import shaping
from .steady_memory import STUCK
from .system import Equation, assemble, tangents
from .tape import BLOCK, BLOCKS, Span, Tape
from .transient import filled, fitting_width, march, rest

_CLOSE = 1e-4  # of the unit of a state: the last step of Newton's method, which leaves its square
_ROUNDS = 12  # of Newton's method, before the motion is left to itself for a while
_LEFT = (0, 30, 150)  # periods that it is then left to itself: it comes nearer to where it settles
_LEAST = 1 / 16  # of a step
_CHORDS = 12  # steps of the chord method
_CHORD_CLOSE = 1e-6  # of the unit of a state: its last step, which leaves a small part of itself
_STABLE = 1e-3  # by which a multiplier may lie outside the unit circle: that of a play that is stuck lies on it


class Orbit(NamedTuple):
    """A periodic orbit.

    **Arguments:** `start`, (s,) as `respond` takes it; `slopes`, (d, s) its derivatives along directions of the values;
    `answer`, (s, s) the step of Newton's method by what a period misses; `found`, whether the method came to its end;
    `multiplier`, the largest modulus of the period map's: below one where the orbit is stable.
    """

    start: np.ndarray
    slopes: np.ndarray
    answer: np.ndarray
    found: bool
    multiplier: float

    @property
    def stable(self) -> bool:
        """Whether the motion comes back to it."""
        return self.found and self.multiplier < 1.0 + _STABLE


def prelude_of(lane: Lane, period: float) -> Tape:
    """The mean period, s, of the drive of a `lane`, which ends at the first sample, in steps that are no longer than
    its own; it fills its tape."""
    blocks = math.ceil(period / (BLOCK * lane.step) - 1e-9)
    phases = np.arange(2 * BLOCK * blocks + 1) * (period / (2 * BLOCK * blocks))
    voltage, rate = (_folded(signal, 0.5 * lane.step, phases, period) for signal in (lane.voltage, lane.rate))
    once = lane._replace(step=period / (BLOCK * blocks), voltage=voltage, rate=rate)
    return Tape((once,), (Span(0, blocks, 1, blocks * BLOCK),))


def _folded(signal: np.ndarray, spacing: float, phases: np.ndarray, period: float) -> np.ndarray:
    """A signal (points,) at some phases, s, after its first point, the mean over all its periods."""
    from scipy.interpolate import CubicSpline  # here, because its import costs more than reading a campaign

    curve, end = CubicSpline(spacing * np.arange(len(signal)), signal), spacing * (len(signal) - 1)
    total, count = np.zeros(len(phases)), np.zeros(len(phases))
    for k in range(math.floor(end / period + 1e-9) + 1):
        inside = phases + k * period <= end * (1 + 1e-12)
        total[inside] += curve(phases[inside] + k * period)
        count += inside
    found = total / count
    found[0] = found[-1] = 0.5 * (found[0] + found[-1])  # the same phase
    return found


@np.errstate(over="ignore", invalid="ignore")  # a motion without bound has no orbit
def find_orbit(
    equation: Equation, prelude: Tape, values: np.ndarray, directions: np.ndarray, guess: np.ndarray,
    unit: np.ndarray, width: int = 0,
) -> Orbit:  # fmt: skip
    """The orbit to which Newton's method leads from a guess of the start, (s,).

    **Arguments:** `values`, (m,) SI; `directions`, (d, m) of them; `unit`, (s,) sizes of displacement, velocity and
    hidden states; `width`, how many directions a march takes at least, as that of the records does.
    """
    d, n = len(directions), len(guess)
    along, kicks = np.zeros((d + n, len(values))), np.zeros((d + n, n))
    along[:d], kicks[d:] = directions, np.diag(unit)
    width = fitting_width(max(d + n, width))
    base, by_base = _fresh(equation, prelude.lanes[0], values, along, width)
    start = np.array(guess, float)
    for left in _LEFT:
        for _ in range(left):
            start = _end(equation, prelude, values, start, along[:0], kicks[:0], width)[0] - base
        before, share = np.inf, 1.0
        for _ in range(_ROUNDS):
            end, slopes = _end(equation, prelude, values, start, along, kicks, width)
            miss, once = (end - base - start) / unit, slopes[d:].T / unit[:, None]
            answer = _answer(np.eye(n) - once)
            if answer is None or not (np.all(np.isfinite(miss)) and np.all(np.isfinite(slopes))):
                break
            step, now = answer @ miss, float(np.max(np.abs(miss)))
            # At the kink of a play full steps may lead to and fro for ever.
            share = float(np.clip(0.5 * share if now > before else 2.0 * share, _LEAST, 1.0))
            before, close = now, float(np.max(np.abs(step))) < _CLOSE
            start = start + (1.0 if close else share) * step * unit
            if close:
                answer = unit[:, None] * answer / unit
                largest = float(np.max(np.abs(np.linalg.eigvals(once))))
                return Orbit(start, (slopes[:d] - by_base[:d]) @ answer.T, answer, True, largest)
        if not np.all(np.isfinite(start)):
            start = np.zeros(n)
    return Orbit(np.array(guess, float), np.zeros((d, n)), np.zeros((n, n)), False, np.inf)


@np.errstate(over="ignore", invalid="ignore")  # a motion without bound has no orbit
def find_orbits(
    equation: Equation, prelude: Tape, values: np.ndarray, guesses: np.ndarray, near: Orbit, unit: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The starts of the orbits at k sets of values (k, m), from guesses (k, s), and which were found, (k,).

    By the chord method: all steps are taken with the derivatives of one orbit that is `near`, and none is computed.
    """
    starts = np.array(guesses, float)
    base = np.zeros_like(starts)
    if starts.shape[1] > 2:
        base[:, 2:] = fresh_many(equation, equation.constants, values, _seen(prelude.lanes[0]))
    found = np.zeros(len(starts), bool)
    for _ in range(_CHORDS):
        step = (_ends(equation, prelude, values, starts) - base - starts) @ near.answer.T
        starts += np.where(found[:, None], 0.0, step)
        found |= np.max(np.abs(step / unit), axis=1) < _CHORD_CLOSE
        if np.all(found | ~np.isfinite(starts).all(axis=1)):
            break
    return starts, found


def _ends(equation: Equation, tape: Tape, values: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """The states (k, s) at the end of a tape with one record, which it fills, at k sets of values."""
    k, known = starts.shape
    carry = jax.tree.map(lambda x: np.broadcast_to(x, (k, *x.shape)).copy(), rest(equation, None, known > 2))
    begin = np.broadcast_to(starts[:, None], (k, BLOCKS, known))
    for chunk in tape.chunks:
        carry, _ = march_many(equation, equation.constants, values, begin, carry, chunk)
    y, _, memories = carry
    ends, moving, remembered = np.zeros_like(starts), 2, iter(memories)
    ends[:, :2] = np.array(y[:2]).T
    for own, before in zip(equation.histories, equation.follow_drive, strict=True):
        if before:
            ends[:, own] = np.asarray(next(remembered)[0])
        else:
            stop = moving + own.stop - own.start
            ends[:, own] = np.array(y[moving:stop]).reshape(stop - moving, k).T
            moving = stop
    return ends


def _answer(away: np.ndarray) -> np.ndarray | None:
    """Newton's steps (n, n) by what a period misses, which leave alone what is stuck; None where a motion without bound
    leaves no equations."""
    square = away.T @ away + STUCK * np.eye(len(away))
    if not np.all(np.isfinite(square)):
        return None
    try:
        return np.linalg.solve(square, away.T)
    except np.linalg.LinAlgError:
        return None


def _end(
    equation: Equation, tape: Tape, values: np.ndarray, start: np.ndarray, along: np.ndarray, kicks: np.ndarray,
    width: int,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """The state (s,) at the end of a tape with one record, which it fills, and its derivatives (d, s)."""
    known, parts = len(start), []
    begin = np.broadcast_to(start, (BLOCKS, known))
    for first in range(0, max(len(along), 1), width):
        own = slice(first, first + width)
        directions, kick = filled(along[own], width), filled(kicks[own], width)
        carry = rest(equation, width, known > 2)
        for chunk in tape.chunks:
            each = np.broadcast_to(kick, (BLOCKS, *kick.shape))
            carry, *_ = march(equation, equation.constants, values, directions, begin, each, carry, chunk)
        parts.append(_said(equation, carry, directions, kick))
    return parts[0][0], np.concatenate([slopes for _, slopes in parts])[: len(along)]


def _fresh(
    equation: Equation, lane: Lane, values: np.ndarray, along: np.ndarray, width: int
) -> tuple[np.ndarray, np.ndarray]:
    """What a record begins with that has no history, (s,), and its derivatives (d, s)."""
    known = 2 + len(equation.history_units)
    base, slopes = np.zeros(known), np.zeros((len(along), known))
    if known == 2:
        return base, slopes
    drive = _seen(lane)
    for first in range(0, max(len(along), 1), width):
        rows = along[first : first + width]
        hidden, changes = fresh(equation, equation.constants, values, filled(rows, width), drive)
        base[2:], slopes[first : first + width, 2:] = hidden, np.asarray(changes)[: len(rows)]
    return base, slopes


def _seen(lane: Lane) -> np.ndarray:
    """V, V̇, ω, whether the record begins in motion, and the order of what is measured, at the first sample."""
    return np.array([lane.voltage[0], lane.rate[0], lane.omega, lane.moving, lane.order])


@program
def fresh(equation: Equation, constants: Numbers, values: Numbers, directions: Numbers, drive: Numbers) -> tuple:
    """Hidden states of all effects in a record that begins with the drive, (h,), and their derivatives (d, h)."""
    return tangents(lambda values: _begun(equation, constants, values, drive), (values,), (directions,))


@program
def fresh_many(equation: Equation, constants: Numbers, values: Numbers, drive: Numbers) -> Any:
    """The same at many sets of values, (k, h)."""
    return jax.vmap(lambda values: _begun(equation, constants, values, drive))(values)


def _begun(equation: Equation, constants: Numbers, values: Any, drive: Numbers) -> Any:
    system = assemble(equation, constants, values)
    seen = system._replace(omega=drive[2], moving=drive[3], order=drive[4]).drive(drive[0], drive[1])
    return jnp.stack([jnp.asarray(h, float) for effect in system.effects for h in effect.begun(seen)])


def _said(equation: Equation, carry: tuple, directions: np.ndarray, kick: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What a carry says, in the order of `Equation.histories`: the state (s,) and its derivatives (d, s)."""
    y, dy, memories = carry
    state, slopes = np.zeros(kick.shape[1]), np.zeros(kick.shape)
    state[:2], slopes[:, :2] = np.asarray(y[:2]), np.asarray(dy[:2]).T
    moving, remembered = 2, iter(memories)
    for own, before, bends in zip(equation.histories, equation.follow_drive, _shapes(equation), strict=True):
        if before:
            hidden, by_shape = (np.asarray(part) for part in next(remembered))
            state[own] = hidden
            slopes[:, own] = np.concatenate([directions[:, bends], kick[:, own]], axis=1) @ by_shape
        else:
            stop = moving + own.stop - own.start
            for place, k in zip(range(own.start, own.stop), range(moving, stop), strict=True):
                state[place], slopes[:, place] = float(y[k]), np.asarray(dy[k])
            moving = stop
    return state, slopes


@lru_cache(maxsize=512)
def _shapes(equation: Equation) -> tuple[tuple[int, ...], ...]:
    """Per effect, where among the values the parameters are on which a memory of the drive alone depends."""
    found, first = [], 3
    for effect, before in zip(equation.model.effects, equation.follow_drive, strict=True):
        names = list(effect.values)
        # Sorted: so a program carries the values of an effect.
        found.append(tuple(first + names.index(name) for name in sorted(shaping(effect))) if before else ())
        first += len(effect.parameters)
    return tuple(found)
