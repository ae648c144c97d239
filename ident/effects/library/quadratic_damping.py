"""Quadratic damping, as of turbulent flow around the stage."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude
from ..likeness import SAME_LOSS


class QuadraticDamping(AbstractEffect):
    """Drag that grows with the square of the velocity: F = −c2 ż|ż|."""

    name = "quadratic-damping"
    equation = "F = −c2 ż|ż|"
    source = "Nayfeh & Mook, Nonlinear Oscillations, 1979, ch. 3"
    mistaken_for = ("cubic-damping", "squeeze-film-damping", "coulomb-friction", "contact-loss")
    alike = (SAME_LOSS,)

    c2 = amplitude("N*s^2/m^2", "quadratic damping", one_sided=True)

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.c2 * state.v * jnp.abs(state.v)
