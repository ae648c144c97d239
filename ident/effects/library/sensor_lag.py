"""The sensor follows the displacement late."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..memory import lag_change, lag_time


class SensorLag(AbstractEffect):
    """First-order low pass between displacement and reading: reading = z_τ, τ ż_τ = z − z_τ.

    The electronics of the sensor, or the clocks of two channels that are apart. Typical: 1-100 µs. On a linear device
    it is the same as a lag of the drive; only records with nonlinear response, or a test of the sensor alone, tell
    them apart. Written so that τ may pass through zero: exact for τ ≫ 0.03 periods, second order in ωτ below
    (`memory.lag_change`).
    """

    name = "sensor-lag"
    equation = "reading = z_τ, τ ż_τ = z − z_τ"
    source = "Oppenheim & Willsky, Signals and Systems, 1997, §6.5.1"
    mistaken_for = ("drive-lag", "sensor-crosstalk", "second-mode", "viscoelastic-support")
    hidden_units = ("m",)

    time = amplitude("s", "time constant, τ")
    shortest = shape("s", "shortest memory that is simulated", grid=(0.03,), scale="period", fitted=False)

    def sensor(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return lag_change(state.z, state.v, state.hidden[0], self.time, self.shortest)

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0,)

    def rate(self, state: State, drive: Drive, t: Scalar) -> tuple[Scalar, ...]:
        return ((state.z - state.hidden[0]) / lag_time(self.time, self.shortest),)
