"""A support that gives way slowly."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import RELAXES, SHIFT_OF_PHASE


class ViscoelasticSupport(AbstractEffect):
    """Two Maxwell elements beside the spring: F = −k_v [(1 − w)(z − q₁) + w (z − q₂)], τ_j q̇_j = z − q_j,
    τ_1,2 = τ/√s, τ √s.

    As of glue or polymer in the support: stiffer by k_v above 1/τ, with a loss around ωτ = 1 that is the wider the
    larger s; s near 1 is the Zener (standard linear) solid. w is the share of the slow element, usually ½. Real
    polymers relax over decades of time, and two elements follow about one and a half. Typical: k_v 0.1-10 % of the
    suspension. With τ far from 1/ω it is absorbed by damping (short) or by stiffness (long), and only records at
    several frequencies show it.
    """

    name = "viscoelastic-support"
    equation = "F = −k_v [(1 − w)(z − q₁) + w (z − q₂)], τ_j q̇_j = z − q_j, τ_j = τ/√s, τ √s"
    source = "R. Lakes, Viscoelastic Materials, 2009, ch. 2 (standard linear solid; generalised Maxwell model)"
    mistaken_for = ("creep", "drive-lag", "sensor-lag", "bouc-wen")
    alike = (RELAXES, SHIFT_OF_PHASE)
    hidden_units = ("m", "m")

    stiffness = amplitude("N/m", "stiffness that relaxes, k_v", one_sided=True)
    time = shape("s", "relaxation time, τ", grid=(0.05, 0.2, 0.8, 3.0, 12.0), scale="period")
    spread = shape("1", "ratio of the two times, s", grid=(1.5, 8.0), limits=(1.0, 50.0))
    share = shape("1", "share of the slow element, w", grid=(0.5,), limits=(0.02, 0.98), refines=True)

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        fast, slow = state.hidden
        return -self.stiffness * ((1 - self.share) * (state.z - fast) + self.share * (state.z - slow))

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0, 0.0)

    def rate(self, state: State, drive: Drive, t: Scalar) -> tuple[Scalar, ...]:
        apart = self.spread**0.5
        times = (self.time / apart, self.time * apart)
        return tuple((state.z - q) / time for q, time in zip(state.hidden, times, strict=True))
