"""What a contact with a stop dissipates."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape


class ContactLoss(AbstractEffect):
    """Damping that acts in the contact of `end-stop` only: F = −c ((z − g)₊/g)ᵖ ż − c ((−z − a g)₊/g)ᵖ ż.

    It is what makes a ball bounce less high than it fell; with p as the exponent of the contact it is the law of Hunt
    and Crossley. p near zero is a dashpot that is met at once (Kelvin and Voigt). c is the damping at a penetration of
    one gap.
    """

    name = "contact-loss"
    equation = "F = −c ((z − g)₊/g)ᵖ ż − c ((−z − a g)₊/g)ᵖ ż"
    source = "Hunt & Crossley, Coefficient of restitution interpreted as damping in vibroimpact, J. Appl. Mech., 1975"
    mistaken_for = ("quadratic-damping",)
    needs = "end-stop"
    steps_per_period = 120
    has_kink = True

    damping = amplitude("N*s/m", "damping at a penetration of one gap, c", one_sided=True)
    # What stands in the middle of a grid is the value that is held where nobody fits it.
    exponent = shape("1", "exponent of the penetration, p", grid=(0.3, 1.5, 1.0), limits=(0.1, 2.0))

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        stop = self.partner
        reach = state.z / stop.gap
        above = self._depth(reach - 1.0, stop.above)
        below = self._depth(-reach - stop.asymmetry, stop.below)
        return -self.damping * (above + below) * state.v

    def _depth(self, depth: Scalar, stiffness: Scalar) -> Scalar:
        touching = (depth > 0) & (stiffness > 0)  # a stop that is not there loses nothing
        return jnp.where(touching, jnp.where(touching, depth, 1.0) ** self.exponent, 0.0)
