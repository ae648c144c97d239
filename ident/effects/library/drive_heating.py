"""Push of the drive that follows the warmth of the actuator."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, amplitude, shape
from ..likeness import SATURATES, SLOW_CHANGE

LEAST = 0.05  # of 1 + eθ, whatever a search tries
_STRAIGHT = 1e-6  # of e: nearer to zero the power is an exponential


class DriveHeating(AbstractEffect):
    """The actuator pushes less as it warms: F = −G V (1 − (1 + eθ)^(−1/e)), θ = w q, τ q̇ = V² − q.

    The push is G/(1 + θ) with e = 1, as of a resistance that grows; G e^(−θ) with e = 0; and G (1 − θ) with e = −1: how
    it goes on shows where it has changed by a tenth. A coil of copper gains 0.4 % of resistance per kelvin, so that a
    voltage drives less current: power compression of loudspeakers, 1-6 dB. A magnet loses 0.1-0.2 %/K; a piezoelectric
    layer mostly gains (w < 0). Where the drive is steady, θ is w U²/2 in the end: what heats it does not become less.
    At one level it is a gain and how that was reached; several levels, and a pause, tell it from a drift.
    """

    name = "drive-heating"
    equation = "F = −G V (1 − (1 + eθ)^(−1/e)), θ = w q, τ q̇ = V² − q"
    source = (
        "W. Klippel, Nonlinear modeling of the heat transfer in loudspeakers, 2004, J. Audio Eng. Soc. 52, 3 "
        "(coil alone, §2)"
    )
    mistaken_for = ("creep", "damping-heating", "drive-saturation")
    alike = (SLOW_CHANGE, SATURATES)
    hidden_units = ("V^2",)
    settles_to_a_mean = True

    loss = amplitude("1/V^2", "part of the push lost per mean square of the drive, at first, w")
    ease = shape("1", "by which the loss eases off, e", grid=(-1.0, 1.0), positive=False)  # of little loss, any
    time = shape("s", "time in which the actuator warms up, τ", grid=(0.02, 0.1, 0.4, 2.0), scale="duration")

    def drive(self, hidden: tuple[Scalar, ...], drive: Drive, t: Scalar) -> Scalar:
        warm = self.loss * hidden[0]
        straight = jnp.abs(self.ease) < _STRAIGHT
        ease = jnp.where(straight, _STRAIGHT, self.ease)
        lost = jnp.log(jnp.maximum(1.0 + ease * warm, LEAST)) / ease
        return drive.gain * drive.V * jnp.expm1(-jnp.where(straight, warm, lost))

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0,)

    def follow(self, hidden: tuple[Scalar, ...], before: Drive, drive: Drive, step: Scalar) -> tuple[Scalar, ...]:
        # V² and its slope are known at both points: exact for its straight line, and the bend counts by its mean.
        was, now, gone = before.V**2, drive.V**2, -jnp.expm1(-step / self.time)
        bend = step / 6.0 * (before.V * before.rate - drive.V * drive.rate)
        straight = now - was * (1.0 - gone) - (now - was) * self.time / step * gone
        return (hidden[0] * (1.0 - gone) + straight + bend * gone,)

    def settled(self, level: Scalar, drive: Drive) -> tuple[Scalar, ...]:
        # V² = U²/2 + (V² − U²/2), whose second part goes round at 2ω and is followed late.
        turn = 2.0 * drive.omega * self.time
        around, slope = drive.V**2 - 0.5 * level**2, 2.0 * drive.V * drive.rate
        return (0.5 * level**2 + (around - self.time * slope) / (1.0 + turn**2),)
