"""A constant offset of the sensor."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude
from ..likeness import CONSTANT, NEARLY_CONSTANT


class SensorOffset(AbstractEffect):
    """The zero of the sensor is not the rest position: reading = z + z_s."""

    name = "sensor-offset"
    equation = "reading = z + z_s"
    source = "JCGM 200:2012, International vocabulary of metrology, §4.28 (zero error)"
    mistaken_for = ("static-force", "sensor-drift")
    alike = (CONSTANT, NEARLY_CONSTANT)
    is_constant = True

    offset = amplitude("m", "offset")

    def sensor(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return self.offset
