"""Damping that grows with the square of the motion."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude
from ..likeness import CUBIC_LOSS, SAME_LOSS, WARM_DAMPER


class CubicDamping(AbstractEffect):
    """Damping of third order: F = −(c3 ż² + c_z z²) ż.

    c3 is drag of third order in the velocity; c_z the amplitude-dependent loss of micromechanical resonators. At one
    frequency the two look alike: only sines far from resonance, or a dc bias, tell them apart.
    Typical: the quality factor falls by 1-50 % from small to full amplitude.
    """

    name = "cubic-damping"
    equation = "F = −(c3 ż² + c_z z²) ż"
    source = (
        "Ravindra & Mallik, Stability analysis of a non-linearly damped Duffing oscillator, 1994, "
        "J. Sound Vib. 171, 708; "
        "c_z: Zaitsev, Shtempluck, Buks, Gottlieb, Nonlinear damping in a micromechanical oscillator, 2012, Nonlinear "
        "Dyn. 67, 859"
    )
    mistaken_for = (
        "quadratic-damping",
        "squeeze-film-damping",
        "damping-heating",
        "force-factor",
        "eddy-current-brake",
    )
    alike = (CUBIC_LOSS, SAME_LOSS, WARM_DAMPER)

    c3 = amplitude("N*s^3/m^3", "damping by the cube of the velocity")
    c_z = amplitude("N*s/m^3", "damping by the square of the displacement")

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -(self.c3 * state.v**2 + self.c_z * state.z**2) * state.v
