"""The force follows the voltage late."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, amplitude
from ..likeness import LAG_ON_EITHER_SIDE, SHIFT_OF_PHASE

_FORGOTTEN = 50.0  # time constants after which nothing is left of a memory


class DriveLag(AbstractEffect):
    """First-order lag between the measured voltage and the force: F = G (V_τ − V), τ V̇_τ = V − V_τ.

    The resistance of leads with the capacitance of the PZT, or an amplifier behind the point of measurement. Typical:
    1-100 µs. Being linear, it cannot be told from a lag of the sensor; the clocks of two channels that are apart look
    the same. Exact for a drive whose rate goes straight between the points of the solver's grid; τ may pass through
    zero: a lead is simulated to second order in τ.
    """

    name = "drive-lag"
    equation = "F = G (V_τ − V), τ V̇_τ = V − V_τ"
    source = "Oppenheim & Willsky, Signals and Systems, 1997, §6.5.1"
    mistaken_for = (
        "sensor-lag", "second-mode", "creep", "viscoelastic-support", "sensor-crosstalk", "pzt-hysteresis",
        "prandtl-ishlinskii", "bouc-wen-drive", "backlash", "slew-limit",
    )  # fmt: skip
    alike = (LAG_ON_EITHER_SIDE, SHIFT_OF_PHASE)
    hidden_units = ("V/s",)  # (V_τ − V)/τ

    time = amplitude("s", "time constant, τ")

    def drive(self, hidden: tuple[Scalar, ...], drive: Drive, t: Scalar) -> Scalar:
        return drive.gain * self.time * hidden[0]

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0,)

    def begun(self, drive: Drive) -> tuple[Scalar, ...]:
        late = self.time > 0  # the voltage is switched on with the record
        return (jnp.where(late, -drive.V / jnp.where(late, self.time, 1.0), 0.0),)

    def follow(self, hidden: tuple[Scalar, ...], before: Drive, drive: Drive, step: Scalar) -> tuple[Scalar, ...]:
        late = jnp.maximum(self.time, step / _FORGOTTEN)
        kept = jnp.where(self.time > 0, jnp.exp(-step / late), 0.0)
        bend = (drive.rate - before.rate) / step
        return (kept * (hidden[0] + before.rate) - drive.rate + self.time * bend * (1.0 - kept),)

    def settled(self, level: Scalar, drive: Drive) -> tuple[Scalar, ...]:
        turn = drive.omega * self.time
        late = jnp.where(turn > 0, 1.0 + turn**2, 1.0)
        return (-(drive.rate + drive.omega * turn * drive.V) / late,)
