"""Dry friction that falls once it slides."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import CONSTANT_FRICTION, SAME_LOSS


class StribeckFriction(AbstractEffect):
    """Friction that is larger while it slides slowly: F = −F_s [s + (1 − s) e^(−(ż/v_S)²)] tanh(ż/v_t).

    F_s is what breaks a contact loose, s F_s what is left in fast sliding (Stribeck); s = 1 is Coulomb's friction.
    Motors, guides, seals, gears: s = 0.4-0.9, v_S some hundredths of the largest velocity. v_t, over which the force
    turns, stands for the sign function as in `coulomb-friction`. A contact that is a spring before it slides is
    `presliding-friction`, or `bouc-wen`.
    """

    name = "stribeck-friction"
    equation = "F = −F_s [s + (1 − s) e^(−(ż/v_S)²)] tanh(ż/v_t)"
    source = (
        "Armstrong-Hélouvry, Dupont, Canudas de Wit, A survey of models, analysis tools and compensation methods for "
        "the control of machines with friction, 1994, Automatica 30, 1083, §2.1"
    )
    mistaken_for = ("coulomb-friction", "bouc-wen", "presliding-friction")
    alike = (CONSTANT_FRICTION, SAME_LOSS)
    contains = ("coulomb-friction",)
    steps_per_period = 250
    has_kink = True

    friction = amplitude("N", "force that breaks it loose, F_s", one_sided=True)
    sliding = shape("1", "share of it that is left in fast sliding, s", grid=(0.1, 0.5), limits=(0.01, 1.0))
    fall = shape(
        "m/s", "velocity at which the force falls, v_S", grid=(0.02, 0.1), limits=(0.001, 1.0), scale="velocity"
    )
    velocity = shape(
        "m/s", "velocity over which the force turns, v_t", grid=(0.01,), limits=(3e-6, 0.15), scale="velocity"
    )

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        kept = self.sliding + (1.0 - self.sliding) * jnp.exp(-((state.v / self.fall) ** 2))
        return -self.friction * kept * jnp.tanh(state.v / self.velocity)
