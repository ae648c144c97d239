"""The sensor follows the motion late."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import LAG_ON_EITHER_SIDE, SHIFT_OF_PHASE


class SensorLag(AbstractEffect):
    """First-order low pass between motion and reading: reading = z_τ, τ ż_τ = z − z_τ.

    The electronics of the sensor, or the clocks of two channels that are apart. Typical: 1-100 µs. On a linear device
    it is the same as a lag of the drive; only records with nonlinear response, or a test of the sensor alone, tell
    them apart. Written so that τ may pass through zero, with a memory q that is never too short for a fixed step:

        reading − z = −τ ż + (τ²/τ')(ż − (z − q)/τ'),   q̇ = (z − q)/τ',   τ' = (τ⁴ + τ_s⁴)^¼

    Its transfer function −τs + τ²s²/(1 + τ's) is the exact 1/(1 + τs) − 1 for τ ≫ τ_s, its Taylor series to second
    order for τ ≪ τ_s and for a lead, τ < 0, and off by less than 1 % in between (relative error τ(τ' − τ)ω²).
    """

    name = "sensor-lag"
    equation = "reading = z_τ, τ ż_τ = z − z_τ"
    source = "Oppenheim & Willsky, Signals and Systems, 1997, §6.5.1"
    mistaken_for = ("drive-lag", "sensor-crosstalk", "second-mode", "viscoelastic-support", "ac-coupling")
    alike = (LAG_ON_EITHER_SIDE, SHIFT_OF_PHASE)
    hidden_units = ("m",)

    time = amplitude("s", "time constant, τ")
    shortest = shape("s", "shortest memory that is simulated", grid=(0.03,), scale="period", fitted=False)

    def sensor(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        slow = self._slow()
        return -self.time * state.v + self.time**2 / slow * (state.v - (state.z - state.hidden[0]) / slow)

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0,)

    def rate(self, state: State, drive: Drive, t: Scalar) -> tuple[Scalar, ...]:
        return ((state.z - state.hidden[0]) / self._slow(),)

    def _slow(self) -> Scalar:
        return (self.time**4 + self.shortest**4) ** 0.25
