"""The drive voltage leaks into the sensor."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude
from ..likeness import FOLLOWS_AT_ONCE, SHIFT_OF_PHASE


class SensorCrosstalk(AbstractEffect):
    """Part of the drive appears in the reading: reading = z + a V + b V̇.

    a by a shared ground or resistance; b by a stray capacitance into a low impedance. Typical: 0.1-5 % of the signal;
    plain above resonance, where the stage hardly moves and the voltage still shows.
    """

    name = "sensor-crosstalk"
    equation = "reading = z + a V + b V̇"
    source = (
        "Lee & Seshia, Parasitic feedthrough cancellation techniques for enhanced electrical characterization of "
        "electrostatic microresonators, 2009, Sens. Actuators A 156, 36"
    )
    mistaken_for = ("second-mode", "sensor-lag", "drive-lag")
    alike = (FOLLOWS_AT_ONCE, SHIFT_OF_PHASE)

    leak = amplitude("m/V", "reading per volt, a")
    capacitive = amplitude("m*s/V", "reading per rate of the voltage, b")

    def sensor(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return self.leak * drive.V + self.capacitive * drive.rate
