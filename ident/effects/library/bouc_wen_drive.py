"""Hysteresis of the piezoelectric drive as one yielding element."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import LOOP_OF_THE_DRIVE, SHIFT_OF_PHASE
from ..memory import slip, within


class BoucWenDrive(AbstractEffect):
    """The drive force lags the voltage in a loop: F = −G V_h h, with the h of `bouc-wen` for the voltage.

    n and β are those of `bouc-wen`, G is the drive gain, V_h the half height of the loop in volts: typically 2-15 % of
    the voltage for soft PZT. The loop does not depend on the frequency, unlike a lag. One element with one yield
    voltage V_y: for records at several drive levels `prandtl-ishlinskii` is usually nearer.
    """

    name = "bouc-wen-drive"
    equation = "F = −G V_h h, h' = (V̇/V_y)(1 − |h|ⁿ [V̇ h > 0] − (1 − 2β) |h|ⁿ [V̇ h < 0])"
    source = (
        "Low & Guo, Modeling of a three-layer piezoelectric bimorph beam with hysteresis, 1995, "
        "J. Microelectromech. Syst. 4, 230"
    )
    mistaken_for = ("prandtl-ishlinskii", "backlash", "pzt-hysteresis", "bouc-wen", "drive-lag", "slew-limit")
    alike = (LOOP_OF_THE_DRIVE, SHIFT_OF_PHASE)
    steps_per_period = 80
    hidden_units = ("1",)

    loop = amplitude("V", "half height of the loop, V_h")
    travel = shape("V", "yield voltage, V_y", grid=(0.1, 0.3, 0.8), scale="voltage")
    sharpness = shape("1", "sharpness of the yield, n", grid=(1.0, 2.0))
    fullness = shape("1", "fullness of the loop, β", grid=(0.5,), limits=(0.4, 1.0))

    def drive(self, hidden: tuple[Scalar, ...], drive: Drive, t: Scalar) -> Scalar:
        return -drive.gain * self.loop * within(hidden[0])

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0,)

    def begun(self, drive: Drive) -> tuple[Scalar, ...]:
        return (jnp.tanh(drive.V / self.travel),)  # risen from zero: exact for n = 2, and within 0.15 for others

    def rate(self, state: State, drive: Drive, t: Scalar) -> tuple[Scalar, ...]:
        return (drive.rate / self.travel * (1.0 - slip(state.hidden[0], drive.rate, self.sharpness, self.fullness)),)
