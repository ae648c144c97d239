"""Dry friction."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import CONSTANT_FRICTION, SAME_LOSS


class CoulombFriction(AbstractEffect):
    """Friction of constant size against the motion: F = −F_c tanh(ż/v_s), v_s a few hundredths of the largest velocity.

    The smooth step stands for the sign function, and may be as steep as the records ask for: where a contact sticks it
    creeps by v_s times the share of F_c that pulls, and a cart that stood for seconds was held by a thousandth of the
    largest velocity only in part.
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
        "m/s", "velocity over which the force turns", grid=(0.01, 0.05), limits=(3e-6, 0.15), scale="velocity"
    )

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.friction * jnp.tanh(state.v / self.velocity)
