"""A warmth that follows the power which a device takes up, and is lost again: the memory of the effects of heating."""

from __future__ import annotations

from typing import Any

from .effect import AbstractEffect, Drive, Scalar, State, shape


class Heated(AbstractEffect):
    """Base of what changes with the warmth of a device: by W = w_V q_V + w_v q_v, with τ q̇_V = V² − q_V of the power
    of the drive and τ q̇_v = ż² − q_v of the power that the motion loses.

    A record that begins at rest begins cold. Where the drive is steady q follows it in τ and stays at its mean square.

    Source: F. P. Incropera, D. P. DeWitt, Fundamentals of Heat and Mass Transfer, 2007, §5.1 (lumped capacitance).
    """

    hidden_units = ("V^2", "m^2/s^2")
    settles_to_a_mean = True

    by_drive: Any  # w_V and w_v, each in the unit of what changes
    by_motion: Any

    time = shape("s", "time in which it warms up, τ", grid=(0.02, 0.1, 0.4, 2.0), scale="duration")

    def warmth(self, state: State) -> Scalar:
        """By how much what warms has changed, W."""
        return self.by_drive * state.hidden[0] + self.by_motion * state.hidden[1]

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0, 0.0)

    def rate(self, state: State, drive: Drive, t: Scalar) -> tuple[Scalar, ...]:
        powers = (drive.V**2, state.v**2)
        return tuple((power - q) / self.time for q, power in zip(state.hidden, powers, strict=True))
