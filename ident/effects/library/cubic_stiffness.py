"""Cubic (Duffing) stiffness."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude
from ..likeness import BENT_RESONANCE, SAME_HARMONICS, STIFFENS, STRETCHES, WARM_SPRING


class CubicStiffness(AbstractEffect):
    """Stiffness that grows (or falls) with the square of the displacement: F = −k3 z³."""

    name = "cubic-stiffness"
    equation = "F = −k3 z³"
    source = "Nayfeh & Mook, Nonlinear Oscillations, 1979, §4.1"
    mistaken_for = ("end-stop", "residual-stress", "sensor-nonlinearity", "pzt-hysteresis", "stiffness-heating",
                     "variable-inertia")  # fmt: skip
    alike = (STRETCHES, STIFFENS, BENT_RESONANCE, WARM_SPRING, SAME_HARMONICS)

    k3 = amplitude("N/m^3", "cubic stiffness")

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.k3 * state.z**3
