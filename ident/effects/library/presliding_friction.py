"""Dry friction that is a spring before it slides, and falls once it does."""

from __future__ import annotations

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import CONSTANT_FRICTION, SAME_LOSS
from ..memory import slip, within


class PreslidingFriction(AbstractEffect):
    """A contact of bristles that bend before they slip: F = −F_s (h + τ h'), h' = (ż − |ż| h/g)/z_y.

    F_s breaks it loose; it slides at g F_s, g = s + (1 − s) e^(−(ż/v_S)²) (Stribeck). Before, it is a spring F_s/z_y
    with a damper τ F_s/z_y (the LuGre model: σ₀ = F_s/z_y, σ₁ = τ σ₀). Guides, belts, seals, bearings: z_y from
    micrometres to some percent of the motion. Where z_y and τ are short this is `stribeck-friction`; where s = 1 and
    τ = 0, `bouc-wen` with n = 1, β = 1. It is looked for in the place of these, where they leave more than noise. A
    damper that is strong beside the slip, τ |ż| ≫ z_y, would drive the motion at times: τ keeps below a tenth period.
    """

    name = "presliding-friction"
    equation = "F = −F_s (h + τ h'), h' = (ż − |ż| h/g)/z_y, g = s + (1 − s) e^(−(ż/v_S)²)"
    source = (
        "Canudas de Wit, Olsson, Åström, Lischinsky, A new model for control of systems with friction, 1995, "
        "IEEE Trans. Autom. Control 40, 419, §II"
    )
    mistaken_for = ("coulomb-friction", "stribeck-friction", "bouc-wen")
    alike = (CONSTANT_FRICTION, SAME_LOSS)
    form_of = ("coulomb-friction", "stribeck-friction", "bouc-wen")
    contains = ("coulomb-friction", "stribeck-friction")
    steps_per_period = 250
    has_kink = True
    hidden_units = ("1",)

    friction = amplitude("N", "force that breaks it loose, F_s", one_sided=True)
    travel = shape(
        "m", "way over which it bends, z_y", grid=(0.005, 0.02, 0.1, 0.3), limits=(0.001, 3.0), scale="displacement"
    )
    sliding = shape("1", "share of it that is left in fast sliding, s", grid=(0.7,), limits=(0.01, 1.0))
    fall = shape(
        "m/s", "velocity at which the force falls, v_S", grid=(0.02, 0.1), limits=(0.001, 1.0), scale="velocity"
    )
    damping = shape(
        "s", "damping while it sticks, in units of its stiffness, τ",
        grid=(0.0,), limits=(-0.001, 0.1), scale="period", positive=False,
    )  # fmt: skip

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        (rate,) = self.rate(state, drive, t)
        return -self.friction * (within(state.hidden[0]) + self.damping * rate)

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0,)

    def rate(self, state: State, drive: Drive, t: Scalar) -> tuple[Scalar, ...]:
        level = self.sliding + (1.0 - self.sliding) * jnp.exp(-((state.v / self.fall) ** 2))
        return (state.v / self.travel * (1.0 - slip(state.hidden[0] / level, state.v, 1.0, 1.0)),)
