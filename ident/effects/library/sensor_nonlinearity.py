"""A sensor that is not linear."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import SAME_HARMONICS

_LEAST = 0.05  # of the denominator: a trial simulation may go beyond where a steepening characteristic ends


class SensorNonlinearity(AbstractEffect):
    """A bent characteristic: reading = z + b z² − c z³/(1 + s |c| z²).

    c > 0 saturates, c < 0 expands. s = 1.2 follows (tanh κz)/κ with c = κ²/3 (to 0.3 % at κz = 1.5), s = 1.8 the
    arctangent, s = 0 is a plain polynomial. With s < 0 it steepens, if it expands: −1.2 with c = −κ²/3 is (tan κz)/κ
    (to 0.1 % at κz = 1), as of a beam of light on a flat scale. Typical: 0.1-5 % of full scale. The stage itself stays
    linear: no shift of the resonance with amplitude, and the same curve in every record.
    """

    name = "sensor-nonlinearity"
    equation = "reading = z + b z² − c z³/(1 + s |c| z²)"
    source = "J. Fraden, Handbook of Modern Sensors, 2010, ch. 2 (nonlinearity, saturation)"
    mistaken_for = ("cubic-stiffness", "quadratic-stiffness", "end-stop", "electrostriction", "cogging")
    alike = (SAME_HARMONICS,)

    quadratic = amplitude("1/m", "quadratic term, b")
    cubic = amplitude("1/m^2", "cubic saturation, c")
    saturation = shape("1", "how the saturation levels off, s", grid=(-1.2, 1.2, 0.02), limits=(-3.6, 36.0),
                       positive=False)  # fmt: skip

    def can_be(self, stiffness: float, damping: float) -> bool:
        return bool(self.saturation >= 0 or self.cubic <= 0)  # what saturates does not turn back

    def sensor(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        bend = self.cubic * state.z**2
        return state.z * (self.quadratic * state.z - bend / jnp.maximum(1.0 + self.saturation * jnp.abs(bend), _LEAST))
