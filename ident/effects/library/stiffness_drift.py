"""Stiffness that changes while the record lasts, as when the device warms up."""

from ..drifting import Drifting
from ..effect import Drive, Scalar, State, amplitude, shape
from ..likeness import SLOW_CHANGE
from ..memory import relaxing


class StiffnessDrift(Drifting):
    """Stiffness that drifts once the drive is switched on: F = −k̇ τ (1 − e^(−t/τ)) z.

    A τ far beyond the record is a drift linear in time; a shorter one an exponential approach to k̇ τ. Self-heating
    lowers the stiffness of silicon by about 60 ppm/K (k̇ < 0), with thermal times from ms (a beam) to minutes (a
    package). It follows the switching-on, not ageing from record to record: every record that begins at rest starts
    afresh; where one begins in motion, and others at rest, t counts from a time a before, the same for all
    of them.
    """

    name = "stiffness-drift"
    equation = "F = −k̇ τ (1 − e^(−t/τ)) z"
    source = "Incropera & DeWitt, Fundamentals of Heat and Mass Transfer, 2007, §5.1 (lumped capacitance)"
    mistaken_for = ("creep", "damping-drift", "sensor-drift", "stiffness-heating")
    alike = (SLOW_CHANGE,)

    rate0 = amplitude("N/m/s", "stiffness per second when switched on, k̇")
    time = shape("s", "time in which the drift dies out, τ", grid=(0.1, 0.3, 1.0, 10.0), scale="duration")

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.rate0 * relaxing(self.since_switched_on(t, drive), self.time) * state.z
