"""Friction that holds before it slides, and less once it slides fast."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape


class StribeckFriction(AbstractEffect):
    """Friction from sticking to sliding: F = −F_s (h + τ h') [s + (1 − s) e^(−(ż/v_s)²)].

    h' = (ż − |ż| h)/(z_s + |ż| τ): before it slides a contact is a spring F_s/z_s (presliding), so that it stops where
    a step in the velocity creeps; once it slides it resists with F_s while slow and with s F_s when faster than v_s
    (Stribeck). s = 1 is Dahl's friction and, for small z_s, Coulomb's; s = 0 lets go altogether, as the edge of a
    liquid does that hangs on a wall at small amplitudes only.
    Motors, guides, seals, gears: s = 0.4-0.9, v_s some hundredths of the largest velocity.
    The fall acts on the force and not on the yield, as it does in the model of Canudas de Wit et al.: while sliding
    both are the same. Their damping of the contact, τ, is held at a few thousandths of a period: no contact yields
    faster than the solver steps, and where it would, h + τ h' is the sign of the velocity.
    """

    name = "stribeck-friction"
    equation = "F = −F_s (h + τ h') (s + (1 − s) e^(−(ż/v_s)²)), h' = (ż − |ż| h)/(z_s + |ż| τ)"
    source = (
        "Canudas de Wit, Olsson, Åström, Lischinsky, A new model for control of systems with friction, 1995, IEEE "
        "Trans. Autom. Control 40, 419; Dahl, Solid friction damping of mechanical vibrations, 1976, AIAA J. 14, 1675"
    )
    mistaken_for = ("coulomb-friction", "bouc-wen")
    contains = ("coulomb-friction",)
    steps_per_period = 250
    hidden_units = ("1",)

    friction = amplitude("N", "force at which it starts to slide, F_s", one_sided=True)
    travel = shape(
        "m", "travel before it slides, z_s", grid=(0.002, 0.03, 0.15), limits=(0.0002, 1.0), scale="displacement"
    )
    sliding = shape(
        "1", "share of the force that is left in fast sliding, s", grid=(0.05, 0.5, 1.0), limits=(0.005, 1.0)
    )
    velocity = shape(
        "m/s", "velocity at which the force falls, v_s", grid=(0.03, 0.2), limits=(0.003, 1.0), scale="velocity"
    )
    shortest = shape("s", "shortest time in which it yields, τ", grid=(0.0035,), scale="period", fitted=False)

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        kept = self.sliding + (1.0 - self.sliding) * jnp.exp(-((state.v / self.velocity) ** 2))
        return -self.friction * (state.hidden[0] + self.shortest * self._yielding(state)) * kept

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0,)

    def rate(self, state: State, drive: Drive, t: Scalar) -> tuple[Scalar, ...]:
        return (self._yielding(state),)

    def _yielding(self, state: State) -> Scalar:
        speed = jnp.abs(state.v)
        return (state.v - speed * state.hidden[0]) / (self.travel + speed * self.shortest)
