"""Strain by the square of the electric field."""

from ..effect import AbstractEffect, Drive, Scalar, amplitude
from ..likeness import SAME_HARMONICS, SECOND_ORDER, SQUARE_OF_THE_VOLTAGE


class Electrostriction(AbstractEffect):
    """A force by the square of the voltage, beside the linear one: F = G e V².

    Every dielectric has it, whatever the sign of the field; electrostatic attraction across a wide gap looks the same.
    It shifts the mean and drives at twice the frequency. Typical for PZT: e = 0.01-1 % per volt of the linear drive G.
    """

    name = "electrostriction"
    equation = "F = G e V²"
    source = (
        "Newnham, Sundar, Yimnirun, Su, Zhang, Electrostriction: nonlinear electromechanical coupling in solid "
        "dielectrics, 1997, J. Phys. Chem. B 101, 10141"
    )
    mistaken_for = (
        "quadratic-stiffness",
        "voltage-stiffness",
        "sensor-nonlinearity",
        "static-force",
        "electrostatic-force",
    )
    alike = (SQUARE_OF_THE_VOLTAGE, SECOND_ORDER, SAME_HARMONICS)

    share = amplitude("1/V", "force by V² relative to the linear drive, e")

    def drive(self, hidden: tuple[Scalar, ...], drive: Drive, t: Scalar) -> Scalar:
        return drive.gain * self.share * drive.V**2
