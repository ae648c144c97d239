"""Laws with memory that several effects share: a lag, a yielding contact, a slow relaxation."""

from __future__ import annotations

import jax.numpy as jnp

from .effect import Scalar

_BARELY, _BEYOND = 1e-6, 1.1  # of the yield: below, x^n has no derivative by n; beyond, only an overshoot of the solver


def relaxing(t: Scalar, time: Scalar) -> Scalar:
    """A change that starts at a unit rate and dies out.

    g(t) = τ (1 − e^(−t/τ)), which is t while t ≪ τ and τ in the end

    `t` and `time` τ > 0 in s, any shapes; returns s. Dividing out the rate keeps a fit well posed where τ exceeds the
    record and the change is a straight line.

    Source: F. P. Incropera, D. P. DeWitt, Fundamentals of Heat and Mass Transfer, 2007, §5.1 (lumped capacitance).
    """
    return -time * jnp.expm1(-t / time)


def slip(part: Scalar, rate: Scalar, sharpness: Scalar) -> Scalar:
    """The part of a motion that is slip, for a contact loaded to `part` of its yield.

    s = |h|^n where the motion loads the contact further (h ẋ > 0), 0 where it unloads

    `part` h, no unit, between −1 and 1 but for errors of the solver; `rate` ẋ in any unit; `sharpness` n > 0. Any
    shapes; returns a number from 0 to 1, a little more beyond the yield, so that an overshoot is walked back. The rate
    of the contact, h' = (ẋ/yield)(1 − s), is bounded by that of the motion: too large a step costs accuracy, never
    stability.

    Source: Ismail, Ikhouane, Rodellar, The hysteresis Bouc-Wen model, a survey, 2009, Arch. Comput. Methods Eng. 16,
    161, §2, with β = γ = 1/2; n → ∞ is the stop operator of Prandtl.
    """
    return jnp.where(part * rate > 0, jnp.clip(jnp.abs(part), _BARELY, _BEYOND) ** sharpness, 0.0)


def lag_time(time: Scalar, shortest: Scalar) -> Scalar:
    """Time constant (s) of the memory behind `lag_change`: τ' = √(τ² + τ_s²), never too short for a fixed step."""
    return jnp.sqrt(time**2 + shortest**2)


def lag_change(signal: Scalar, rate: Scalar, memory: Scalar, time: Scalar, shortest: Scalar) -> Scalar:
    """What a first-order lag changes in a signal, regular as its time constant passes through zero.

    Δ = −τ ẋ + (τ²/τ')(ẋ − (x − q)/τ'),   q' = (x − q)/τ',   τ' = √(τ² + τ_s²)

    Its transfer function −τs + τ²s²/(1 + τ's) is the exact 1/(1 + τs) − 1 for τ ≫ τ_s, its Taylor series to second
    order for τ ≪ τ_s, and at most τ²(τ' − |τ|)ω³ off in between. Negative τ is a lead, with the same accuracy of
    second order.

    `signal` x, `rate` ẋ, `memory` q in the signal's unit (per s); `time` τ, `shortest` τ_s in s; any shapes.

    Source: A. V. Oppenheim, A. S. Willsky, Signals and Systems, 1997, §6.5.1; the regular form is this project's.
    """
    slow = lag_time(time, shortest)
    return -time * rate + time**2 / slow * (rate - (signal - memory) / slow)
