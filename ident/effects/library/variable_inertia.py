"""An inertia that changes with the place."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude
from ..likeness import BENT_RESONANCE, EVEN_HARMONICS, SAME_HARMONICS


class VariableInertia(AbstractEffect):
    """A mass that moves along more or less as the stage moves: F = −m(z) z̈ − m'(z) ż²/2, m = m1 z + m2 z².

    As of a linkage, whose parts turn faster at one end of its path than at the other, a cantilever, whose end moves in
    as it bends (m2 > 0), or a pendulum that is not read by its angle. The second term is what Lagrange's equation makes
    of the kinetic energy (M + m) ż²/2. Near the resonance m2 lowers its frequency with the amplitude, as a softening
    spring does, and with it makes a third harmonic; far below nothing of it is seen.
    """

    name = "variable-inertia"
    equation = "F = −m(z) z̈ − m'(z) ż²/2, m = m1 z + m2 z²"
    source = (
        "H. Goldstein, Classical Mechanics, 1980, §1-6 (kinetic energy in generalised coordinates); M. R. M. Crespo da "
        "Silva, C. C. Glynn, Nonlinear flexural-flexural-torsional dynamics of inextensional beams, 1978, "
        "J. Struct. Mech. 6, 437 (cantilevers)"
    )
    mistaken_for = ("cubic-stiffness", "quadratic-stiffness")
    alike = (BENT_RESONANCE, EVEN_HARMONICS, SAME_HARMONICS)

    slope = amplitude("kg/m", "mass that moves along per displacement, m1")
    curvature = amplitude("kg/m^2", "mass that moves along per squared displacement, m2")

    def inertia(self, z: Scalar) -> Scalar:
        return (self.slope + self.curvature * z) * z

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -(self.slope / 2 + self.curvature * state.z) * state.v**2
