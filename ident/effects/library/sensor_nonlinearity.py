"""A sensor that is not linear."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import SAME_HARMONICS


class SensorNonlinearity(AbstractEffect):
    """A bent characteristic: reading = z + b z² − c z³/(1 + s |c| z²) + d z⁵.

    c > 0 saturates, c < 0 expands. s = 1.2 follows (tanh κz)/κ with c = κ²/3 (to 0.3 % at κz = 1.5), s = 1.8 the
    arctangent, s near 0 is a plain polynomial. d, which refines the law, is for what steepens: with c = −κ²/3, s = 0
    and d = 2κ⁴/15 it is (tan κz)/κ (to 1 % at κz = 0.7), as of a beam of light on a flat scale. Typical: 0.1-5 % of
    full scale. The stage itself stays linear: no shift of the resonance with amplitude, and the same curve in every
    record.
    """

    name = "sensor-nonlinearity"
    equation = "reading = z + b z² − c z³/(1 + s |c| z²) + d z⁵"
    source = "J. Fraden, Handbook of Modern Sensors, 2010, ch. 2 (nonlinearity, saturation)"
    mistaken_for = ("cubic-stiffness", "quadratic-stiffness", "end-stop", "electrostriction", "cogging")
    alike = (SAME_HARMONICS,)

    quadratic = amplitude("1/m", "quadratic term, b")
    cubic = amplitude("1/m^2", "cubic saturation, c")
    saturation = shape("1", "how the saturation levels off, s", grid=(0.02, 1.2))
    quintic = amplitude("1/m^4", "term of the fifth order, d", refines=True)

    def sensor(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        bend = self.cubic * state.z**2
        odd = self.quintic * state.z**4 - bend / (1.0 + self.saturation * jnp.abs(bend))
        return state.z * (self.quadratic * state.z + odd)
