"""A drive that does nothing, or less, until it is large enough."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, amplitude, shape


class DriveDeadZone(AbstractEffect):
    """An actuator that gives nothing between two voltages: F = −s G (D(V) − D(0)), beside the linear drive G V.

    D(V) = (√((V + a d)² + (r a d)²) − √((V − d)² + (r d)²))/2; D(V) − D(0) is V between −a d and d and level outside,
    with corners rounded over a part r of either end. s = 1 is a dead zone, as of the overlap of a valve's spool, of a
    loose screw or a gear that has to be driven through its play; s between 0 and 1 a lower gain about zero, as where an
    amplifier crosses over; s < 0 a higher one. The same curve at every frequency, and no loop.
    """

    name = "drive-dead-zone"
    equation = "F = −s G clip(V, −a d, d), its corners rounded over a part r"
    source = (
        "G. Tao, P. V. Kokotović, Adaptive Control of Systems with Actuator and Sensor Nonlinearities, 1996, ch. 2; "
        "H. E. Merritt, Hydraulic Control Systems, 1967, §5.6"
    )
    mistaken_for = ("drive-saturation", "backlash")
    steps_per_period = 120
    has_kink = True

    share = amplitude("1", "of the gain that is missing in the zone, s")
    zone = shape("V", "voltage at which the zone ends, d", grid=(0.03, 0.06, 0.1, 0.16, 0.25, 0.4, 0.6),
                 limits=(0.01, 0.9), scale="voltage")  # fmt: skip
    asymmetry = shape("1", "lower end of the zone over the upper, a", grid=(1.0,), limits=(0.1, 10.0))
    corner = shape(
        "1", "rounding of the corners, part of either end, r", grid=(0.05,), limits=(0.005, 0.5), refines=True
    )

    def drive(self, hidden: tuple[Scalar, ...], drive: Drive, t: Scalar) -> Scalar:
        return -self.share * drive.gain * (self._clipped(drive.V) - self._clipped(0.0))

    def _clipped(self, voltage: Scalar) -> Scalar:
        above, below = self.zone, self.asymmetry * self.zone
        rounded = lambda x, end: jnp.sqrt(x**2 + (self.corner * end) ** 2)
        return (rounded(voltage + below, below) - rounded(voltage - above, above)) / 2
