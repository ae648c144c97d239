"""Friction that holds before it slides, and less once it slides fast."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..memory import slip, within


class StribeckFriction(AbstractEffect):
    """Dry friction from sticking to sliding: F = −F_s h g(ż), h' = (ż/z_s)(1 − h sgn ż), g = s + (1 − s) e^(−(ż/v_s)²).

    Before it slides a contact is a spring F_s/z_s (presliding), so that it stops where a step in the velocity creeps;
    once it slides it resists with F_s while slow and with s F_s when faster than v_s (Stribeck). s = 1 is Dahl's
    friction and, for small z_s, Coulomb's; s = 0 lets go altogether, as the edge of a liquid does that hangs on a wall
    at small amplitudes only. Motors, guides, seals and gears: s = 0.4-0.9, v_s a few hundredths of the largest velocity.
    The fall acts on the force and not on the yield, as it does in the model of Canudas de Wit et al.: while sliding
    both are the same, and no step is too large.
    """

    name = "stribeck-friction"
    equation = "F = −F_s h (s + (1 − s) e^(−(ż/v_s)²)), h' = (ż/z_s)(1 − h sgn ż)"
    source = (
        "Canudas de Wit, Olsson, Åström, Lischinsky, A new model for control of systems with friction, 1995, IEEE "
        "Trans. Autom. Control 40, 419; Dahl, Solid friction damping of mechanical vibrations, 1976, AIAA J. 14, 1675"
    )
    mistaken_for = ("coulomb-friction", "bouc-wen", "power-law-damping")
    contains = ("coulomb-friction",)
    steps_per_period = 250
    hidden_units = ("1",)

    friction = amplitude("N", "force at which it starts to slide, F_s", one_sided=True)
    travel = shape("m", "travel before it slides, z_s", grid=(0.03, 0.15), limits=(0.002, 1.0), scale="displacement")
    sliding = shape("1", "share of the force that is left in fast sliding, s", grid=(0.05, 0.5), limits=(0.005, 1.0))
    velocity = shape(
        "m/s", "velocity at which the force falls, v_s", grid=(0.03, 0.2), limits=(0.003, 1.0), scale="velocity"
    )

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        kept = self.sliding + (1.0 - self.sliding) * jnp.exp(-((state.v / self.velocity) ** 2))
        return -self.friction * within(state.hidden[0]) * kept

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0,)

    def rate(self, state: State, drive: Drive, t: Scalar) -> tuple[Scalar, ...]:
        return (state.v / self.travel * (1.0 - slip(state.hidden[0], state.v, 1.0, 1.0)),)
