"""A spring of another stiffness on either side: a crack that breathes, a joint that opens."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import EVEN_HARMONICS, SAME_HARMONICS


class BilinearStiffness(AbstractEffect):
    """A spring that is stiffer when pushed one way than the other: F = −k_b (√(z² + w²) − w).

    The stiffness is k + k_b above rest and k − k_b below, whatever the amplitude: mean and even harmonics grow in
    proportion to the motion, where those of a quadratic spring grow with its square. As of a crack that opens and
    closes, a bolted joint, or a part that only leans against its support: k_b/k = 0.01-0.5. Rough faces do not close at
    once, but over a displacement w, up to a tenth of the largest: beyond, no kink is seen, and the spring is one that
    bends, a quadratic one or another.
    """

    name = "bilinear-stiffness"
    equation = "F = −k_b (√(z² + w²) − w)"
    source = "S. W. Shaw, P. J. Holmes, A periodically forced piecewise linear oscillator, 1983, J. Sound Vib. 90, 129"
    mistaken_for = ("quadratic-stiffness", "asymmetric-damping")
    alike = (EVEN_HARMONICS, SAME_HARMONICS)
    has_kink = True

    stiffness = amplitude("N/m", "half the difference between the stiffnesses above and below rest, k_b")
    width = shape("m", "displacement over which it closes, w", grid=(0.01,), limits=(1e-4, 0.1), scale="displacement")

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.stiffness * (jnp.sqrt(state.z**2 + self.width**2) - self.width)
