"""A voice coil under voltage that warms as it works."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import SLOW_CHANGE
from .drive_heating import LEAST


class CoilHeating(AbstractEffect):
    """A coil's resistance grows by a part θ as it warms: F = −θ/(1 + θ) G (V − B ż), τ θ̇ = w (V − B ż)²/(1 + θ) − θ.

    The current is (V − B ż)/(R (1 + θ)), with B the voltage that a velocity induces: the push and the damping by the
    coil fall together, by 0.4 % per kelvin of copper, and near the resonance, where B ż eats up the voltage, the coil
    stays cold. Power compression of loudspeakers: 1-6 dB; τ is 1-10 s of a coil, and minutes of a magnet. Without B it
    is drive-heating. A coil under current does not change.
    """

    name = "coil-heating"
    equation = "F = −θ/(1 + θ) G (V − B ż), τ θ̇ = w (V − B ż)²/(1 + θ) − θ"
    source = (
        "W. Klippel, Nonlinear modeling of the heat transfer in loudspeakers, 2004, J. Audio Eng. Soc. 52, 3, §2; "
        "R. H. Small, Direct-radiator loudspeaker system analysis, 1972, J. Audio Eng. Soc. 20, 383"
    )
    mistaken_for = ("damping-heating",)
    alike = (SLOW_CHANGE,)
    contains = ("drive-heating",)
    hidden_units = ("V^2",)  # θ/w
    settles_to_a_mean = True

    rise = amplitude("1/V^2", "part by which the resistance grows per mean square of the voltage, w", one_sided=True)
    induced = shape("V*s/m", "voltage that a velocity induces, B", grid=(0.1, 0.4, 1.0), scale="induction",
                    limits=(0.003, 5.0))  # fmt: skip
    time = shape("s", "time in which the coil warms up, τ", grid=(0.02, 0.1, 0.4, 2.0), scale="duration")

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        warm = self.rise * state.hidden[0]
        return -drive.gain * warm / self._grown(state) * self._left(state, drive)

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0,)

    def rate(self, state: State, drive: Drive, t: Scalar) -> tuple[Scalar, ...]:
        return ((self._left(state, drive) ** 2 / self._grown(state) - state.hidden[0]) / self.time,)

    def _left(self, state: State, drive: Drive) -> Scalar:
        """The voltage that drives a current, V."""
        return drive.V - self.induced * state.v

    def _grown(self, state: State) -> Scalar:
        return jnp.maximum(1.0 + self.rise * state.hidden[0], LEAST)
