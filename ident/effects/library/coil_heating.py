"""A voice coil under voltage that warms as it works."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import GROWS_WITH_THE_SQUARE, SLOW_CHANGE
from .drive_heating import LEAST

_NOTHING = 1e-100  # beside the square of any push: a coil that does not warm induces nothing that shows


class CoilHeating(AbstractEffect):
    """A coil's resistance grows by a part θ as it warms: F = −θ/(1 + θ) G (V − B ż), τ θ̇ = w (V − B ż)²/(1 + θ) − θ.

    The current is (V − B ż)/(R (1 + θ)), with B the voltage that a velocity induces: the push and the damping by the
    coil fall together, by 0.4 % per kelvin of copper, and near the resonance, where B ż eats up the voltage, the coil
    stays cold. Power compression of loudspeakers: 1-6 dB; τ is 1-10 s of a coil, and minutes of a magnet. Without B it
    is drive-heating. A coil under current does not change.
    """

    name = "coil-heating"
    equation = "F = −θ/(1 + θ) (G V − c ż), τ θ̇ = w (V − B ż)²/(1 + θ) − θ, B = c/G"
    source = (
        "W. Klippel, Nonlinear modeling of the heat transfer in loudspeakers, 2004, J. Audio Eng. Soc. 52, 3, §2; "
        "R. H. Small, Direct-radiator loudspeaker system analysis, 1972, J. Audio Eng. Soc. 20, 383 (c = B²/R)"
    )
    mistaken_for = ("damping-heating",)
    alike = (SLOW_CHANGE, GROWS_WITH_THE_SQUARE)
    contains = ("drive-heating",)
    hidden_units = ("V^2",)  # θ/w
    settles_to_a_mean = True

    rise = amplitude("1/V^2", "part by which the resistance grows per mean square of the voltage, w", one_sided=True)
    induced = amplitude("N*s/m/V^2", "damping by the coil times that, w c")
    time = shape("s", "time in which the coil warms up, τ", grid=(0.02, 0.1, 0.4, 2.0), scale="duration")

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        (warm,) = state.hidden
        return -warm / self._grown(warm) * (self.rise * drive.gain * drive.V - self.induced * state.v)

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0,)

    def rate(self, state: State, drive: Drive, t: Scalar) -> tuple[Scalar, ...]:
        (warm,) = state.hidden
        push = self.rise * drive.gain
        left = drive.V - self.induced * push / (push**2 + _NOTHING) * state.v
        return ((left**2 / self._grown(warm) - warm) / self.time,)

    def _grown(self, warm: Scalar) -> Scalar:
        return jnp.maximum(1.0 + self.rise * warm, LEAST)
