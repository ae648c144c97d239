"""A second vibration mode in what the sensor sees."""

import math

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import FOLLOWS_AT_ONCE, SHIFT_OF_PHASE


class SecondMode(AbstractEffect):
    """Another mode, driven by the same voltage, adds to the reading: reading = z + a x, ẍ + (ω₂/Q₂) ẋ + ω₂² x = ω₂² V.

    Modes of a linear structure superpose, so it neither loads nor is loaded by the stage's own mode; a is its static
    travel per volt (also of the other sign), the sum of every higher mode if they are far away. Typical: 1-10 % of
    the stage's static travel, at 1.5-5 times its frequency. Far below ω₂ it cannot be told from crosstalk: drive near
    ω₂, or in bursts. The mode follows the voltage itself: a loop or a lag of the drive does not reach it. A sensor of
    velocity or acceleration reads a ẋ or a ẍ. It is looked for at 0.3 to 6 times the stage's frequency.
    """

    name = "second-mode"
    equation = "reading = z + a x, ẍ + (ω₂/Q₂) ẋ + ω₂² x = ω₂² V, ω₂ = 2π/T₂"
    source = "D. J. Ewins, Modal Testing, 2000, ch. 2 (modal superposition)"
    mistaken_for = ("sensor-crosstalk", "drive-lag", "sensor-lag", "attached-mass")
    alike = (FOLLOWS_AT_ONCE, SHIFT_OF_PHASE)
    further_mode = 2
    gains = ("travel",)
    steps_per_period = 120
    hidden_units = ("V", "V/s")

    travel = amplitude("m/V", "static travel per volt, a")
    period = shape(
        "s", "period of the mode, T₂", scale="period",
        grid=(0.17, 0.2, 0.22, 0.25, 0.28, 0.32, 0.36, 0.4, 0.45, 0.5, 0.56, 0.63, 0.7, 0.8, 0.88, 1.15, 1.3, 1.6, 2.2,
              3.0),
    )  # fmt: skip
    quality = shape("1", "quality factor of the mode, Q₂", grid=(30.0,))

    def sensor(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        x, speed = state.hidden
        _, acceleration = self.rate(state, drive, t)
        return self.travel * jnp.where(drive.order > 1, acceleration, jnp.where(drive.order > 0, speed, x))

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0, 0.0)

    def swing(self) -> Scalar:
        return max(1.0, self.quality)

    def rate(self, state: State, drive: Drive, t: Scalar) -> tuple[Scalar, ...]:
        x, speed = state.hidden
        omega = 2 * math.pi / self.period
        return speed, omega**2 * (drive.V - x) - omega / self.quality * speed
