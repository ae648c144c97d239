"""Damping that follows the warmth of the device."""

from ..effect import Drive, Scalar, State, amplitude
from ..heated import Heated
from ..likeness import SLOW_CHANGE, WARM_DAMPER


class DampingHeating(Heated):
    """Damping changes as the device warms: F = −(w_V q_V + w_v q_v) ż, with mean squares q of drive and velocity.

    τ q̇_V = V² − q_V is the warmth by what the drive brings in, τ q̇_v = ż² − q_v that by what damping turns to heat,
    with one time of cooling τ. Oil thins by 2-5 %/K and rubber loses less as it warms (w < 0); gas grows more viscous
    (w > 0). Where τ is as long as a record, q at one level is a drift; where it is far shorter, damping that follows
    the squared amplitude.
    """

    name = "damping-heating"
    equation = "F = −(w_V q_V + w_v q_v) ż, τ q̇_V = V² − q_V, τ q̇_v = ż² − q_v"
    source = (
        "Incropera & DeWitt, Fundamentals of Heat and Mass Transfer, 2007, §5.1 (lumped capacitance); "
        "J. C. Dixon, The Shock Absorber Handbook, 2007, ch. 6 (oil that thins)"
    )
    mistaken_for = ("damping-drift", "cubic-damping", "stiffness-heating", "drive-heating", "coil-heating")
    alike = (SLOW_CHANGE, WARM_DAMPER)

    by_drive = amplitude("N*s/m/V^2", "damping per mean square of the drive, w_V")
    by_motion = amplitude("N*s^3/m^3", "damping per mean square of the velocity, w_v")

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.warmth(state) * state.v
