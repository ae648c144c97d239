"""Quadratic stiffness: the spring is stiffer on one side."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude
from ..likeness import BENT_RESONANCE, EVEN_HARMONICS, QUADRATIC_FORCE, SAME_HARMONICS, SECOND_ORDER


class QuadraticStiffness(AbstractEffect):
    """A restoring force that is not odd, as of a curved beam: F = −k2 z². Shifts the mean and makes even harmonics."""

    name = "quadratic-stiffness"
    equation = "F = −k2 z²"
    source = "Nayfeh & Mook, Nonlinear Oscillations, 1979, §4.2"
    mistaken_for = (
        "residual-stress", "arch-force", "voltage-stiffness", "electrostriction", "electrostatic-force", "end-stop",
        "sensor-nonlinearity", "bilinear-stiffness", "variable-inertia",
    )  # fmt: skip
    alike = (QUADRATIC_FORCE, BENT_RESONANCE, EVEN_HARMONICS, SECOND_ORDER, SAME_HARMONICS)

    k2 = amplitude("N/m^2", "quadratic stiffness")

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.k2 * state.z**2
