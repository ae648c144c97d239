"""A spring of another stiffness on either side: a crack that breathes, a joint that opens."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude
from ..likeness import EVEN_HARMONICS, SAME_HARMONICS


class BilinearStiffness(AbstractEffect):
    """A spring that is stiffer when pushed one way than the other: F = −k_b |z|.

    The stiffness is k + k_b above rest and k − k_b below, whatever the amplitude: mean and even harmonics grow in
    proportion to the motion, where those of a quadratic spring grow with its square. As of a crack that opens and
    closes, a bolted joint, or a part that only leans against its support: k_b/k = 0.01-0.5.
    """

    name = "bilinear-stiffness"
    equation = "F = −k_b |z|"
    source = "S. W. Shaw, P. J. Holmes, A periodically forced piecewise linear oscillator, 1983, J. Sound Vib. 90, 129"
    mistaken_for = ("quadratic-stiffness",)
    alike = (EVEN_HARMONICS, SAME_HARMONICS)
    has_kink = True

    stiffness = amplitude("N/m", "half the difference between the stiffnesses above and below rest, k_b")

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.stiffness * jnp.abs(state.z)
