"""A drive that levels off."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, amplitude, shape
from ..likeness import SATURATES


class DriveSaturation(AbstractEffect):
    """An amplifier or a coil that gives less and less: F = −G c V³/(1 + s |c| V²), beside the linear drive G V.

    c > 0 saturates, c < 0 is a drive that begins slowly. s = 1.2 follows V_s tanh(V/V_s) with c = 1/(3 V_s²) (to 0.3 %
    of it at V = 1.5 V_s), s = 1.8 the arctangent, s near 0 is a plain cubic. The same curve at every frequency, and no
    loop. Typical: 1-20 % at full level.
    """

    name = "drive-saturation"
    equation = "F = −G c V³/(1 + s |c| V²)"
    source = "W. Klippel, Tutorial: Loudspeaker nonlinearities, 2006, J. Audio Eng. Soc. 54, 907"
    mistaken_for = ("pzt-hysteresis", "drive-heating")
    alike = (SATURATES,)

    cubic = amplitude("1/V^2", "cubic saturation, c")
    levelling = shape("1", "how it levels off, s", grid=(0.02, 1.2))

    def drive(self, hidden: tuple[Scalar, ...], drive: Drive, t: Scalar) -> Scalar:
        bend = self.cubic * drive.V**2
        return -drive.gain * drive.V * bend / (1.0 + self.levelling * jnp.abs(bend))
