"""A constant force on the stage."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude
from ..likeness import CONSTANT, NEARLY_CONSTANT


class StaticForce(AbstractEffect):
    """A force that does not change: weight, a bias of the drive, relaxed stress. F = F0.

    On a linear device it looks exactly like an offset of the sensor; only a nonlinear one tells them apart.
    """

    name = "static-force"
    equation = "F = F0"
    source = "statics"
    mistaken_for = ("sensor-offset", "sensor-drift", "electrostriction")
    alike = (CONSTANT, NEARLY_CONSTANT)
    is_constant = True

    force0 = amplitude("N", "constant force")

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return self.force0
