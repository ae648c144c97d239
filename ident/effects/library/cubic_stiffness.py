"""Cubic (Duffing) stiffness."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import BENT_RESONANCE, SAME_HARMONICS, STIFFENS, STRETCHES, WARM_SPRING, WITHIN_A_PITCH

_LEAST = 0.05  # of the denominator: a trial simulation may go beyond where a steepening law ends


class CubicStiffness(AbstractEffect):
    """Stiffness that grows (or falls) with the square of the displacement: F = −k3 z³/(1 + s z²).

    s, which refines the law, is 0 for a plain cube (Duffing). With s > 0 it levels off at displacements beyond 1/√s,
    and is then another straight spring: a softening one of F = k x tanh(z/x) is k3 = −k/(3 x²), s = 0.4/x² to 0.3 % up
    to z = 1.3 x; a stretched string, k3 > 0, levels off too. With s < 0 it steepens.
    """

    name = "cubic-stiffness"
    equation = "F = −k3 z³/(1 + s z²)"
    source = (
        "Nayfeh & Mook, Nonlinear Oscillations, 1979, §4.1; G. A. Baker, Essentials of Padé Approximants, 1975, ch. 1"
    )
    mistaken_for = ("end-stop", "residual-stress", "sensor-nonlinearity", "pzt-hysteresis", "stiffness-heating",
                     "variable-inertia", "cogging")  # fmt: skip
    alike = (STRETCHES, STIFFENS, BENT_RESONANCE, WARM_SPRING, WITHIN_A_PITCH, SAME_HARMONICS)

    k3 = amplitude("N/m^3", "cubic stiffness")
    levelling = shape("1/m^2", "how soon it levels off, s", grid=(-0.2, 0.0, 0.6), limits=(-0.9, 60.0),
                      scale="squared_nearness", positive=False, refines=True)  # fmt: skip

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.k3 * state.z**3 / jnp.maximum(1.0 + self.levelling * state.z**2, _LEAST)
