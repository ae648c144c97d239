"""Damping that follows the warmth of the device."""

import jax.numpy as jnp

from ..effect import Drive, Scalar, State, amplitude, shape
from ..heated import Heated
from ..likeness import SLOW_CHANGE, WARM_DAMPER

_SMALL = 1e-5  # exponent, below which its series is as good as the function
_MOST, _LEAST = 30.0, -5.0  # of s q_v: a trial simulation may go beyond what any oil does


class DampingHeating(Heated):
    """Damping changes as the device warms: F = −(w_V q_V + w_v (1 − e^(−s q_v))/s) ż, with mean squares q of drive and
    velocity; w_v q_v where s = 0.

    τ q̇_V = V² − q_V is the warmth by what the drive brings in, τ q̇_v = e^(−s q_v) ż² − q_v that by what damping turns
    to heat, with one time of cooling τ. Oil thins by 2-5 %/K and rubber loses less as it warms (w < 0); gas grows more
    viscous (w > 0). s refines the law: by Reynolds's law of viscosity oil thins exponentially (w_v = −s c of a damper
    that has c when cold), and as it thins it turns less to heat. With s < 0 it turns more to heat as it warms, and runs
    away beyond s q_v = −1/e. Where τ is as long as a record, q at one level is a drift; where it is far shorter,
    damping that follows the squared amplitude.
    """

    name = "damping-heating"
    equation = "F = −(w_V q_V + w_v (1 − e^(−s q_v))/s) ż, τ q̇_V = V² − q_V, τ q̇_v = e^(−s q_v) ż² − q_v"
    source = (
        "Incropera & DeWitt, Fundamentals of Heat and Mass Transfer, 2007, §5.1 (lumped capacitance); "
        "J. C. Dixon, The Shock Absorber Handbook, 2007, ch. 6 (oil that thins); "
        "O. Reynolds, 1886, Phil. Trans. R. Soc. 177, 157 (exponentially)"
    )
    mistaken_for = ("damping-drift", "cubic-damping", "stiffness-heating", "drive-heating", "coil-heating")
    alike = (SLOW_CHANGE, WARM_DAMPER)

    by_drive = amplitude("N*s/m/V^2", "damping per mean square of the drive, w_V")
    by_motion = amplitude("N*s^3/m^3", "damping per mean square of the velocity, w_v")
    fading = shape("s^2/m^2", "how soon that levels off, s", grid=(-0.4, 0.0, 2.0), limits=(-0.7, 60.0),
                   scale="per_squared_velocity", positive=False, refines=True)  # fmt: skip

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        exponent = self._exponent(state)
        small = jnp.abs(exponent) < _SMALL
        levelled = jnp.where(small, 1.0 - 0.5 * exponent, -jnp.expm1(-exponent) / jnp.where(small, 1.0, exponent))
        return -(self.by_drive * state.hidden[0] + self.by_motion * state.hidden[1] * levelled) * state.v

    def rate(self, state: State, drive: Drive, t: Scalar) -> tuple[Scalar, ...]:
        return super().rate(state._replace(v=jnp.exp(-0.5 * self._exponent(state)) * state.v), drive, t)

    def _exponent(self, state: State) -> Scalar:
        return jnp.clip(self.fading * state.hidden[1], _LEAST, _MOST)
