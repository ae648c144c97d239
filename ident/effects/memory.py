"""Laws with memory that several effects share: a yielding contact, a play, a slow relaxation."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp

from .effect import Drive, Scalar

_FULLEST = 10.0  # of a loop, β: beyond, unloading is a jump
_STIFFEST = 30.0  # of the force at which a stiffness has doubled: beyond, no solver follows
_BARELY, _BEYOND = 1e-6, 1.5  # of the yield: below, x^n has no derivative by n; beyond, only an overshoot of the solver


def relaxing(t: Scalar, time: Scalar) -> Scalar:
    """A change that starts at a unit rate and dies out.

    g(t) = τ (1 − e^(−t/τ)), which is t while t ≪ τ and τ in the end

    `t` and `time` τ > 0 in s, any shapes; returns s. Dividing out the rate keeps a fit well posed where τ exceeds the
    record and the change is a straight line.

    Source: F. P. Incropera, D. P. DeWitt, Fundamentals of Heat and Mass Transfer, 2007, §5.1 (lumped capacitance).
    """
    return -time * jnp.expm1(-t / time)


def slip(part: Scalar, rate: Scalar, sharpness: Scalar, fullness: Scalar) -> Scalar:
    """The part of a motion that is slip, for a contact loaded to `part` of its yield.

    s = |h|^n where the motion loads the contact further (h ẋ > 0), (1 − 2β) |h|^n where it unloads

    `part` h, no unit, between −1 and 1 but for errors of the solver; `rate` ẋ in any unit; `sharpness` n > 0;
    `fullness` β of the loop: 0 closes it, ½ unloads along a straight line, 1 is the fullest. Any shapes; returns a
    number from −1 to 1, and up to 1.5 beyond the yield, so that an overshoot is walked back. The rate of the contact,
    h' = (ẋ/yield)(1 − s), is bounded by twice that of the motion: too large a step costs accuracy, never stability,
    and `within` keeps it out of the force.

    Source: Ismail, Ikhouane, Rodellar, The hysteresis Bouc-Wen model, a survey, 2009, Arch. Comput. Methods Eng. 16,
    161, §2, with β + γ = 1; β = ½, n → ∞ is the stop operator of Prandtl.
    """
    loaded = jnp.minimum(jnp.clip(jnp.abs(part), _BARELY, _BEYOND) ** sharpness, _BEYOND)
    return jnp.where(part * rate > 0, 1.0, 1.0 - 2.0 * jnp.clip(fullness, 0.0, _FULLEST)) * loaded


def stiffened(part: Scalar, rate: Scalar, sharpness: Scalar, fullness: Scalar) -> Scalar:
    """By how much a spring with memory is stiffer than unloaded, for one that stiffens where `slip` yields.

    s = |h|^n where the motion loads it further (h ẋ > 0), (1 + 2β) |h|^n where it unloads; arguments as of `slip`.

    Source: as `slip`, with β + γ = −1, which dissipates for β > 0.
    """
    loaded = jnp.clip(jnp.abs(part), _BARELY, _STIFFEST) ** sharpness
    return jnp.where(part * rate > 0, 1.0, 1.0 + 2.0 * jnp.clip(fullness, 0.0, _FULLEST)) * loaded


_EDGE = 24  # sharpness of a play's edge: rounded less, it gains nothing at a hundred steps per period
EDGE = 24.0  # the same where the path is known in closed form, k
_DEEPEST = 12.0  # k times an overshoot: e^−12 is still told from zero


def dragged(part: Scalar, rate: Scalar) -> Scalar:
    """The part of a motion that drags a play along: |h|²⁴ where it pushes on (h ẋ > 0), 0 where it turns back.

    `part` h of the way to the edge, `rate` ẋ; as `slip`, but its derivative is kept below one. The true one, 24, makes
    tangents of narrow plays grow without bound at any affordable step, although the play itself is bounded; below one
    they still forget the past within a few widths of travel, as those of a dragged play do.
    """
    return jnp.where(part * rate > 0, _edge(part), 0.0)


@jax.custom_jvp
def _edge(part: Scalar) -> Scalar:
    return jnp.minimum(jnp.clip(jnp.abs(part), _BARELY, _BEYOND) ** _EDGE, _BEYOND)


@_edge.defjvp
def _edge_jvp(primals: tuple[Any], tangents: tuple[Any]) -> tuple[Any, Any]:
    (part,), (change,) = primals, tangents
    slope = jnp.minimum(_EDGE * jnp.clip(jnp.abs(part), _BARELY, 1.0) ** (_EDGE - 1), 1.0)
    return _edge(part), jnp.sign(part) * slope * change


def pushed(part: Scalar, travel: Scalar, edge: Scalar = EDGE) -> Scalar:
    """Where between its edges a play is, h = (V − p)/r, after V has travelled further.

    dh/dx = 1 − e^(−k (1 − h)),   1 − h = ln(1 + (e^(k (1 − h₀)) − 1) e^(−k x))/k

    while V rises; mirrored while it falls. `part` h₀ and `travel` x in half widths r, of either sign, `edge` k; any
    shapes; returns h, no unit, below one in size. As the path is in closed form, neither a play nor its derivatives
    depend on the number of points in which it is followed. Of k = 24, 60 and 150 only the first let every search
    arrive on records of exact plays (four devices of `experiments.recovery.steady`).

    Source: Visintin, Differential Models of Hysteresis, 1994, §III.2 (the play, k → ∞); the rounded edge is ours.
    """
    way = jnp.where(travel > 0, 1.0, -1.0)
    overshoot = jnp.minimum(_BEYOND, 1.0 + _DEEPEST / edge)
    return way * _nearer(1.0 - way * within(part, overshoot), way * travel, edge)


def _nearer(left: Scalar, travel: Scalar, edge: Scalar) -> Scalar:
    """h after a `travel` > 0 that began at a distance `left` from h = 1."""
    return 1.0 - jnp.log1p(jnp.expm1(edge * left) * jnp.exp(-edge * travel)) / edge


def drawn(play: Scalar, before: Drive, drive: Drive, step: Scalar, width: Scalar, edge: Scalar = EDGE) -> Scalar:
    """Where the drive takes a `play` p of half width `width` r from one point to the next, `step` s later, V.

    If it turns between them, by way of the voltage where a straight line of its rate passes zero. Any shapes.
    """
    turns = before.rate * drive.rate < 0
    time = step * before.rate / jnp.where(turns, before.rate - drive.rate, 1.0)
    peak = jnp.where(turns, before.V + 0.5 * time * before.rate, drive.V)
    there = pushed((before.V - play) / width, (peak - before.V) / width, edge)
    return drive.V - width * pushed(there, (drive.V - peak) / width, edge)


def played(level: Scalar, drive: Drive, width: Scalar, edge: Scalar = EDGE) -> Scalar:
    """Where between its edges a play is, h = (V − p)/r, where V has been a sine of amplitude U for ever.

    h as of `pushed`, from −m where V turns at −U and from m where it turns at U: it is pushed from −m to m by 2U/r, and

    e^(k m) = 2 e^k/(1 − q + √((1 − q)² + 4 e^(2k) q)),   q = e^(−2kU/r)

    `level` U and half width `width` r > 0 in V, `edge` k; `drive` with V and its rate; returns h, no unit, from −1 to
    1. A play wider than the swing rests.
    """
    swing = jnp.abs(level) / width
    way = jnp.where(drive.rate > 0, 1.0, -1.0)
    kept, full = jnp.exp(-2.0 * edge * swing), jnp.exp(edge)
    turn = jnp.log(2.0 * full / (1.0 - kept + jnp.sqrt((1.0 - kept) ** 2 + 4.0 * full**2 * kept))) / edge
    return way * _nearer(1.0 + turn, swing + way * drive.V / width, edge)


def within(part: Scalar, bound: Scalar = 1.0) -> Scalar:
    """The part of a yield that bears force: h itself, with the overshoot of a large step beyond ±`bound` cut off."""
    return jnp.clip(part, -bound, bound)
