"""Creep of the piezoelectric drive."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import LEAKS, RELAXES, SHIFT_OF_PHASE, SLOW_CHANGE


class Creep(AbstractEffect):
    """Domains follow the field late: F = G [m (q₁ + q₂ + q₃)/3 + c V ln(1 + t/τ)], τ_j q̇_j = V − q_j, τ_j = τ s^(j−2).

    m is the part of the strain that comes late. Three times spread by a factor s ≈ 6 follow the logarithmic creep 1 +
    γ log₁₀(t/t₀) of PZT over two decades (m ≈ 2.6 γ); s near 1 is one exponential. c is growth of the whole response
    with the logarithm of the time since switching-on, as of domains freed by the alternating drive. Typical: γ = 1-2
    % per decade. Records at one frequency do not tell creep from a lag.
    """

    name = "creep"
    equation = "F = G [m (q₁ + q₂ + q₃)/3 + c V ln(1 + t/τ)], τ s^(j−2) q̇_j = V − q_j"
    source = (
        "Jung & Gweon, Creep characteristics of piezoelectric actuators, 2000, Rev. Sci. Instrum. 71, 1896; "
        "Adriaens, de Koning, Banning, Modeling piezoelectric actuators, 2000, IEEE/ASME Trans. Mechatron. 5, 331"
    )
    mistaken_for = (
        "drive-lag", "viscoelastic-support", "stiffness-drift", "damping-drift", "prandtl-ishlinskii",
        "drive-heating",
    )  # fmt: skip
    alike = (RELAXES, LEAKS, SLOW_CHANGE, SHIFT_OF_PHASE)
    hidden_units = ("V", "V", "V")

    late = amplitude("1", "part of the drive that comes late, m")
    growth = amplitude("1", "growth of the drive with ln t, c")
    time = shape("s", "time of creep, τ", grid=(0.05, 0.3, 2.0), scale="duration")
    spread = shape("1", "ratio of neighbouring times, s", grid=(1.5, 6.0))

    def drive(self, hidden: tuple[Scalar, ...], drive: Drive, t: Scalar) -> Scalar:
        return drive.gain * (self.late * sum(hidden) / 3 + self.growth * drive.V * jnp.log1p(t / self.time))

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0, 0.0, 0.0)

    def rate(self, state: State, drive: Drive, t: Scalar) -> tuple[Scalar, ...]:
        return tuple((drive.V - q) / time for q, time in zip(state.hidden, self._times, strict=True))

    def settled(self, level: Scalar, drive: Drive) -> tuple[Scalar, ...]:
        return tuple((drive.V - time * drive.rate) / (1 + (drive.omega * time) ** 2) for time in self._times)

    @property
    def _times(self) -> tuple[Scalar, ...]:
        return self.time / self.spread, self.time, self.time * self.spread
