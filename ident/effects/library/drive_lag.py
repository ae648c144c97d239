"""The force follows the voltage late."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..memory import lag_change, lag_time


class DriveLag(AbstractEffect):
    """First-order lag between the measured voltage and the force: F = G (V_τ − V), τ V̇_τ = V − V_τ.

    The resistance of leads with the capacitance of the PZT, or an amplifier behind the point of measurement. Typical:
    1-100 µs. Being linear, it cannot be told from a lag of the sensor; the clocks of two channels that are apart look
    the same. Written so that τ may pass through zero: exact for τ ≫ 0.03 periods, second order in ωτ below
    (`memory.lag_change`).
    """

    name = "drive-lag"
    equation = "F = G (V_τ − V), τ V̇_τ = V − V_τ"
    source = "Oppenheim & Willsky, Signals and Systems, 1997, §6.5.1"
    mistaken_for = (
        "sensor-lag", "second-mode", "creep", "viscoelastic-support", "sensor-crosstalk", "pzt-hysteresis",
        "prandtl-ishlinskii", "bouc-wen-drive",
    )  # fmt: skip
    hidden_units = ("V",)

    time = amplitude("s", "time constant, τ")
    shortest = shape("s", "shortest memory that is simulated", grid=(0.03,), scale="period", fitted=False)

    def drive(self, hidden: tuple[Scalar, ...], drive: Drive, t: Scalar) -> Scalar:
        return drive.gain * lag_change(drive.V, drive.rate, hidden[0], self.time, self.shortest)

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0,)

    def rate(self, state: State, drive: Drive, t: Scalar) -> tuple[Scalar, ...]:
        return ((drive.V - state.hidden[0]) / lag_time(self.time, self.shortest),)
