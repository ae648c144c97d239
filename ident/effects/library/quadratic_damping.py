"""Quadratic damping, as of turbulent flow around the stage."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import SAME_LOSS


class QuadraticDamping(AbstractEffect):
    """Drag that grows with the square of the velocity: F = −c2 ((ż − u)|ż − u| + u|u|).

    u, which refines the law, is the stream in which the device stands, a wind or a current: 0 in what is still. Drag is
    least where the device moves along with it; that by which it leans at rest belongs to where it rests.
    """

    name = "quadratic-damping"
    equation = "F = −c2 ((ż − u)|ż − u| + u|u|)"
    source = (
        "Nayfeh & Mook, Nonlinear Oscillations, 1979, ch. 3; J. R. Morison et al., The force exerted by surface waves "
        "on piles, 1950, J. Pet. Technol. 2, 149 (of the velocity relative to a current)"
    )
    mistaken_for = ("cubic-damping", "squeeze-film-damping", "coulomb-friction", "contact-loss")
    alike = (SAME_LOSS,)

    c2 = amplitude("N*s^2/m^2", "quadratic damping", one_sided=True)
    stream = shape("m/s", "velocity of what surrounds it, u", grid=(-0.4, 0.0, 0.4), limits=(-3.0, 3.0),
                   scale="velocity", positive=False, refines=True)  # fmt: skip

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        along = state.v - self.stream
        return -self.c2 * (along * jnp.abs(along) + self.stream * jnp.abs(self.stream))
