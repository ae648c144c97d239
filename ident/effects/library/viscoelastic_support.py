"""A support that gives way slowly."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape


class ViscoelasticSupport(AbstractEffect):
    """A Maxwell element beside the spring: F = −k_v (z − q), τ q̇ = z − q, as of glue or polymer in the support.

    With the suspension it makes a Zener (standard linear) solid: stiffer by k_v above 1/τ, with a loss that peaks at
    ωτ = 1. Typical: k_v 0.1-10 % of the suspension. With τ far from 1/ω it is absorbed by damping (short) or by
    stiffness (long), and only records at several frequencies show it.
    """

    name = "viscoelastic-support"
    equation = "F = −k_v (z − q), τ q̇ = z − q"
    source = "R. Lakes, Viscoelastic Materials, 2009, ch. 2 (standard linear solid)"
    mistaken_for = ("creep", "drive-lag", "sensor-lag", "bouc-wen")
    hidden_units = ("m",)

    stiffness = amplitude("N/m", "stiffness that relaxes, k_v")
    time = shape("s", "relaxation time, τ", grid=(0.05, 0.2, 0.8, 3.0, 12.0), scale="period")

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.stiffness * (state.z - state.hidden[0])

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0,)

    def rate(self, state: State, drive: Drive, t: Scalar) -> tuple[Scalar, ...]:
        return ((state.z - state.hidden[0]) / self.time,)
