"""Dry friction."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import CONSTANT_FRICTION, SAME_LOSS


class CoulombFriction(AbstractEffect):
    """Friction of constant size against the motion: F = −F_c tanh(ż/v_s), v_s a few hundredths of the largest velocity.

    The smooth step stands for the sign function, which no fixed-step solver follows.
    """

    name = "coulomb-friction"
    equation = "F = −F_c tanh(ż/v_s)"
    source = (
        "Olsson, Åström, Canudas de Wit, Gäfvert, Lischinsky, Friction models and compensation, 1998, Eur. J. Control 4"
    )
    mistaken_for = ("bouc-wen", "quadratic-damping", "stribeck-friction", "presliding-friction")
    alike = (CONSTANT_FRICTION, SAME_LOSS)
    steps_per_period = 250
    has_kink = True

    friction = amplitude("N", "friction force", one_sided=True)
    velocity = shape(
        "m/s", "velocity over which the force turns", grid=(0.01, 0.05), limits=(0.0003, 0.15), scale="velocity"
    )

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.friction * jnp.tanh(state.v / self.velocity)
