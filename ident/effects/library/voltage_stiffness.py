"""Stiffness that follows the drive voltage."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude
from ..likeness import SECOND_ORDER


class VoltageStiffness(AbstractEffect):
    """The drive changes the stiffness: F = −(k_V V + k_VV V²) z, a parametric excitation.

    k_V from the axial force of a piezoelectric layer, whose sign follows the voltage; k_VV from electrostatic
    attraction, which softens (k_VV < 0). Typical: the stiffness moves by 0.01-1 % per volt. A drive at
    ω moves force to 0 and 2ω; at twice the resonance it pumps.
    """

    name = "voltage-stiffness"
    equation = "F = −(k_V V + k_VV V²) z"
    source = (
        "Rhoads, Shaw, Turner, Nonlinear dynamics and its applications in micro- and nanoresonators, 2010, "
        "J. Dyn. Syst. Meas. Control 132, 034001; Nayfeh & Mook, Nonlinear Oscillations, 1979, ch. 5"
    )
    mistaken_for = ("quadratic-stiffness", "residual-stress", "electrostriction", "electrostatic-force", "force-factor")
    alike = (SECOND_ORDER,)

    per_volt = amplitude("N/m/V", "stiffness per volt, k_V")
    per_volt2 = amplitude("N/m/V^2", "stiffness per squared volt, k_VV")

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -(self.per_volt + self.per_volt2 * drive.V) * drive.V * state.z
