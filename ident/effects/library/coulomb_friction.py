"""Dry friction."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import CONSTANT_FRICTION, SAME_LOSS


class CoulombFriction(AbstractEffect):
    """Friction of constant size against the motion: F = −F_c σ (1 + a σ), σ = tanh(ż/v_s), v_s a few hundredths of the
    largest velocity.

    The smooth step stands for the sign function, which no fixed-step solver follows. a, which refines the law, is 0
    where friction is the same either way; guides, seals and gears rub differently to and fro.
    """

    name = "coulomb-friction"
    equation = "F = −F_c σ (1 + a σ), σ = tanh(ż/v_s)"
    source = (
        "Olsson, Åström, Canudas de Wit, Gäfvert, Lischinsky, Friction models and compensation, 1998, Eur. J. Control 4"
    )
    mistaken_for = ("bouc-wen", "quadratic-damping", "stribeck-friction")
    alike = (CONSTANT_FRICTION, SAME_LOSS)
    steps_per_period = 250
    has_kink = True

    friction = amplitude("N", "friction force", one_sided=True)
    velocity = shape(
        "m/s", "velocity over which the force turns", grid=(0.01, 0.05), limits=(0.0003, 0.15), scale="velocity"
    )
    asymmetry = shape("1", "excess of the friction upwards, a", grid=(0.0,), limits=(-1.0, 1.0), positive=False,
                      refines=True)  # fmt: skip

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        way = jnp.tanh(state.v / self.velocity)
        return -self.friction * way * (1.0 + self.asymmetry * way)
