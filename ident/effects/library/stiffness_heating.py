"""Stiffness that follows the warmth of the device."""

from ..effect import Drive, Scalar, State, amplitude
from ..heated import Heated
from ..likeness import SLOW_CHANGE, WARM_SPRING


class StiffnessHeating(Heated):
    """The device softens as it warms: F = −(w_V q_V + w_v q_v) z, with mean squares q of drive and velocity.

    τ q̇_V = V² − q_V is the warmth by what the drive brings in (current in a beam, losses of a piezoelectric layer),
    τ q̇_v = ż² − q_v that by what damping turns to heat (rubber, a polymer hinge), with one time of cooling τ. Silicon
    loses about 60 ppm/K, rubber up to 1 %/K (w < 0). Where τ is as long as a record, q at one level is a drift; where
    it is far shorter, a stiffness that follows the squared amplitude.
    """

    name = "stiffness-heating"
    equation = "F = −(w_V q_V + w_v q_v) z, τ q̇_V = V² − q_V, τ q̇_v = ż² − q_v"
    source = "Incropera & DeWitt, Fundamentals of Heat and Mass Transfer, 2007, §5.1 (lumped capacitance)"
    mistaken_for = ("stiffness-drift", "cubic-stiffness", "damping-heating")
    alike = (SLOW_CHANGE, WARM_SPRING)

    by_drive = amplitude("N/m/V^2", "stiffness per mean square of the drive, w_V")
    by_motion = amplitude("N*s^2/m^3", "stiffness per mean square of the velocity, w_v")

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.warmth(state) * state.z
