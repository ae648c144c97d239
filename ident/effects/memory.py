"""Laws with memory that several effects share: a lag, a yielding contact, a slow relaxation."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp

from .effect import Scalar

_BARELY, _BEYOND = 1e-6, 1.5  # of the yield: below, x^n has no derivative by n; beyond, only an overshoot of the solver


def relaxing(t: Scalar, time: Scalar) -> Scalar:
    """A change that starts at a unit rate and dies out.

    g(t) = τ (1 − e^(−t/τ)), which is t while t ≪ τ and τ in the end

    `t` and `time` τ > 0 in s, any shapes; returns s. Dividing out the rate keeps a fit well posed where τ exceeds the
    record and the change is a straight line.

    Source: F. P. Incropera, D. P. DeWitt, Fundamentals of Heat and Mass Transfer, 2007, §5.1 (lumped capacitance).
    """
    return -time * jnp.expm1(-t / time)


def slip(part: Scalar, rate: Scalar, sharpness: Scalar, softness: Scalar) -> Scalar:
    """The part of a motion that is slip, for a contact loaded to `part` of its yield.

    s = |h|^n where the motion loads the contact further (h ẋ > 0), c |h|^n where it unloads

    `part` h, no unit, between −1 and 1 but for errors of the solver; `rate` ẋ in any unit; `sharpness` n > 0;
    `softness` c of unloading, −1 to 1, beyond which friction would drive. Any shapes; returns a number from −1 to 1,
    and up to 1.5 beyond the yield, so that an overshoot is walked back. The rate of the contact, h' = (ẋ/yield)(1 − s),
    is bounded by twice that of the motion: too large a step costs accuracy, never stability, and `within` keeps it out
    of the force.

    Source: Ismail, Ikhouane, Rodellar, The hysteresis Bouc-Wen model, a survey, 2009, Arch. Comput. Methods Eng. 16,
    161, §2, with β + γ = 1 and c = γ − β; c = 0, n → ∞ is the stop operator of Prandtl.
    """
    loaded = jnp.minimum(jnp.clip(jnp.abs(part), _BARELY, _BEYOND) ** sharpness, _BEYOND)
    return jnp.where(part * rate > 0, 1.0, jnp.clip(softness, -1.0, 1.0)) * loaded


_EDGE = 24  # sharpness of a play's edge: rounded less, it gains nothing at a hundred steps per period


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


def within(part: Scalar, bound: Scalar = 1.0) -> Scalar:
    """The part of a yield that bears force: h itself, with the overshoot of a large step beyond ±`bound` cut off."""
    return jnp.clip(part, -bound, bound)


def lag_time(time: Scalar, shortest: Scalar) -> Scalar:
    """Time constant (s) of the memory behind `lag_change`: τ' = (τ⁴ + τ_s⁴)^¼, never too short for a fixed step."""
    return (time**4 + shortest**4) ** 0.25


def lag_change(signal: Scalar, rate: Scalar, memory: Scalar, time: Scalar, shortest: Scalar) -> Scalar:
    """What a first-order lag changes in a signal, regular as its time constant passes through zero.

    Δ = −τ ẋ + (τ²/τ')(ẋ − (x − q)/τ'),   q' = (x − q)/τ',   τ' = (τ⁴ + τ_s⁴)^¼

    Its transfer function −τs + τ²s²/(1 + τ's) is the exact 1/(1 + τs) − 1 for τ ≫ τ_s, its Taylor series to second
    order for τ ≪ τ_s, and off by less than 1 % of Δ in between where τ_s is 0.03 periods (relative error τ(τ' −
    τ)ω²). Negative τ is a lead, with the same accuracy of second order.

    `signal` x, `rate` ẋ, `memory` q in the signal's unit (per s); `time` τ, `shortest` τ_s in s; any shapes.

    Source: A. V. Oppenheim, A. S. Willsky, Signals and Systems, 1997, §6.5.1; the regular form is this project's.
    """
    slow = lag_time(time, shortest)
    return -time * rate + time**2 / slow * (rate - (signal - memory) / slow)
