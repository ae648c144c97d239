"""Damping that changes while the record lasts."""

from ..drifting import Drifting
from ..effect import Drive, Scalar, State, amplitude, shape
from ..likeness import SLOW_CHANGE
from ..memory import relaxing


class DampingDrift(Drifting):
    """Damping that drifts once the drive is switched on: F = −ċ τ (1 − e^(−t/τ)) ż.

    A τ far beyond the record is a drift linear in time; a shorter one an exponential approach to ċ τ. Gas that warms,
    outgassing in a sealed cavity, a contact that runs in: typically 1-20 % of the damping. Every record that begins at
    rest starts afresh; where one begins in motion, and others at rest, t counts from a time a before, the same for all
    of them.
    """

    name = "damping-drift"
    equation = "F = −ċ τ (1 − e^(−t/τ)) ż"
    source = "Incropera & DeWitt, Fundamentals of Heat and Mass Transfer, 2007, §5.1 (lumped capacitance)"
    mistaken_for = ("stiffness-drift", "creep", "damping-heating")
    alike = (SLOW_CHANGE,)

    rate0 = amplitude("N*s/m/s", "damping per second when switched on, ċ")
    time = shape("s", "time in which the drift dies out, τ", grid=(0.1, 0.3, 1.0, 10.0), scale="duration")

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.rate0 * relaxing(self.since_switched_on(t, drive), self.time) * state.v
