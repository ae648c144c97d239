"""Contact with a stop above or below the stage."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import SAME_HARMONICS, STIFFENS


class EndStop(AbstractEffect):
    """Elastic contact beyond a gap: F = −k_a g (δ_a/g)ⁿ + k_b g (δ_b/g)ⁿ, δ_a = (z − g)₊, δ_b = (−z − a g)₊.

    n = 3/2 is the contact of round bodies (Hertz), n = 1 a linear bumper; k is the secant stiffness at a penetration
    of one gap. One amplitude at zero leaves a stop on one side only, of which a says nothing; gaps are sought as equal
    and fitted as they are. Gaps of 0.05-1 of the travel, k from 1 to 1000 times the suspension.
    """

    name = "end-stop"
    equation = "F = −k_a g ((z − g)₊/g)ⁿ + k_b g ((−z − a g)₊/g)ⁿ"
    source = "K. L. Johnson, Contact Mechanics, 1985, §4.2"
    mistaken_for = (
        "cubic-stiffness", "quadratic-stiffness", "quintic-stiffness", "power-law-stiffness", "sensor-nonlinearity"
    )  # fmt: skip
    alike = (STIFFENS, SAME_HARMONICS)
    steps_per_period = 120
    has_kink = True

    above = amplitude("N/m", "contact stiffness of the upper stop, k_a", one_sided=True)
    below = amplitude("N/m", "contact stiffness of the lower stop, k_b", one_sided=True)
    gap = shape("m", "gap from rest to the upper stop, g", grid=(0.08, 0.13, 0.2, 0.3, 0.42, 0.55, 0.7, 0.85),
                limits=(0.05, 1.0), scale="displacement")  # fmt: skip
    exponent = shape("1", "exponent of the contact law, n", grid=(1.0, 1.5), limits=(0.8, 1.8))
    asymmetry = shape("1", "lower gap over upper gap, a", grid=(1.0,), limits=(0.2, 5.0))

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        reach = state.z / self.gap
        pushed = self.above * self._contact(reach - 1.0) - self.below * self._contact(-reach - self.asymmetry)
        return -self.gap * pushed

    def _contact(self, depth: Scalar) -> Scalar:
        touching = depth > 0
        return jnp.where(touching, jnp.where(touching, depth, 1.0) ** self.exponent, 0.0)  # 0ⁿ has no derivative by n
