"""The zero of the sensor wanders."""

from ..drifting import Drifting
from ..effect import Drive, Scalar, State, amplitude, shape
from ..likeness import NEARLY_CONSTANT, SLOW_CHANGE
from ..memory import relaxing


class SensorDrift(Drifting):
    """The zero of the sensor drifts once the drive is switched on: reading = z + d τ (1 − e^(−t/τ)).

    A τ far beyond the record is a drift linear in time; a shorter one an exponential warm-up that ends at d τ. Typical:
    0.1-5 % of the signal within a record. Every record that begins at rest starts afresh; where one begins in motion,
    and others at rest, t counts from a time a before, the same for all of them.
    """

    name = "sensor-drift"
    equation = "reading = z + d τ (1 − e^(−t/τ))"
    source = "J. Fraden, Handbook of Modern Sensors, 2010, ch. 2 (warm-up and drift)"
    mistaken_for = ("sensor-offset", "static-force", "stiffness-drift")
    alike = (NEARLY_CONSTANT, SLOW_CHANGE)

    rate0 = amplitude("m/s", "drift per second when switched on, d")
    time = shape("s", "time in which the drift dies out, τ", grid=(0.1, 0.3, 1.0, 10.0), scale="duration")

    def sensor(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return self.rate0 * relaxing(self.since_switched_on(t, drive), self.time)
