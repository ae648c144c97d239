"""A force that repeats itself along the way."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import SAME_HARMONICS, WITHIN_A_PITCH


class Cogging(AbstractEffect):
    """A force periodic in the position: F = −s sin(2πz/λ) − c (1 − cos(2πz/λ)).

    Magnets and teeth of a linear motor, a rotor in a field, comb fingers that pass each other, a pendulum (λ = 2π).
    s draws to rest (s > 0) or away from it; c, which refines that, says that rest is not in the middle of a tooth (of
    a single sine it alone is but a constant force). Pitches are sought from a sixth to two and a half times the travel
    to either side: beyond, the force has not come back, and sine and cosine are but a cubic and a quadratic spring.
    """

    name = "cogging"
    equation = "F = −s sin(2πz/λ) − c (1 − cos(2πz/λ))"
    source = (
        "Otten, de Vries, van Amerongen, Rankers & Gaal, Linear motor motion control using a learning feedforward "
        "controller, 1997, IEEE/ASME Trans. Mechatronics 2, 179"
    )
    mistaken_for = ("cubic-stiffness", "quadratic-stiffness", "sensor-nonlinearity")
    alike = (WITHIN_A_PITCH, SAME_HARMONICS)

    sine = amplitude("N", "part that vanishes at rest and is odd, s")
    cosine = amplitude("N", "part that is even, c", refines=True)
    # In steps of a quarter of a turn over the travel: further apart, the force would miss what lies between.
    pitch = shape("m", "length after which it repeats, λ", grid=tuple(4.0 / n for n in range(24, 1, -1)),
                  limits=(0.15, 2.5), scale="displacement")  # fmt: skip

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        turn = 2 * jnp.pi * state.z / self.pitch
        return -self.sine * jnp.sin(turn) - self.cosine * (1.0 - jnp.cos(turn))
