"""Squeeze-film damping: gas pressed out of the gap under the stage."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape

_CLOSEST = 0.1  # of the gap: a trial simulation may cross the wall, and must stay finite there


class SqueezeFilmDamping(AbstractEffect):
    """Damping that grows as the gap closes: F = −c [(1 − z/g)⁻³ − 1] ż, the constant part being the linear damping."""

    name = "squeeze-film-damping"
    equation = "F = −c [(1 − z/g)⁻³ − 1] ż"
    source = "Bao & Yang, Squeeze film air damping in MEMS, 2007, Sens. Actuators A 136, §2"
    mistaken_for = ("cubic-damping", "quadratic-damping")

    damping = amplitude("N*s/m", "damping in the open gap")
    gap = shape("m", "gap under the stage", grid=(1.5, 2.5, 6.0), scale="displacement")

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        closeness = jnp.maximum(1.0 - state.z / self.gap, _CLOSEST)
        return -self.damping * (closeness**-3 - 1.0) * state.v
