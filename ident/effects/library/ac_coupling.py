"""The sensor passes no constant."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude
from ..likeness import LEAKS, SHIFT_OF_PHASE


class AcCoupling(AbstractEffect):
    """First-order high pass between motion and reading: reading = z − r q, q̇ = z − r q.

    An input that is coupled by a capacitor, a charge amplifier, a vibrometer whose decoder starts at a lowest
    frequency: r is 2π times that frequency, typically 0.1-10 Hz, and r = 0 passes everything. It takes every offset out
    of the reading, and with it the sign by which most laws that are not symmetric are known. Its transfer function is
    s/(s + r).
    """

    name = "ac-coupling"
    equation = "reading = z − r q, q̇ = z − r q"
    source = "Horowitz & Hill, The Art of Electronics, 2015, §1.7.1"
    mistaken_for = ("sensor-lag",)
    alike = (LEAKS, SHIFT_OF_PHASE)
    hidden_units = ("m*s",)

    corner = amplitude("1/s", "rate at which a constant dies out, r", positive=True)

    def sensor(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.corner * state.hidden[0]

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0,)

    def rate(self, state: State, drive: Drive, t: Scalar) -> tuple[Scalar, ...]:
        return (state.z - self.corner * state.hidden[0],)
