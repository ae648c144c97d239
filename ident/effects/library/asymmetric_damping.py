"""A damper that resists one way more than the other."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import EVEN_HARMONICS


class AsymmetricDamping(AbstractEffect):
    """A damper with another coefficient either way: F = −c_a (√(ż² + w²) − w).

    The damping is c + c_a where the stage rises and c − c_a where it falls, whatever the velocity. Shock absorbers damp
    the rebound two to four times as much as the bump; check valves, ratchets and cloths that peel do likewise. A sine
    is answered by a mean displacement, which grows in proportion to the motion, and by even harmonics. Valves do not
    open at once but over a velocity w, up to a tenth of the largest: beyond, no kink is seen.
    """

    name = "asymmetric-damping"
    equation = "F = −c_a (√(ż² + w²) − w)"
    source = "J. C. Dixon, The Shock Absorber Handbook, 2nd ed., 2007, §1.7 and §8.3"
    mistaken_for = ("bilinear-stiffness", "quadratic-stiffness")
    alike = (EVEN_HARMONICS,)
    has_kink = True

    damping = amplitude("N*s/m", "half the difference between the dampings rising and falling, c_a")
    width = shape("m/s", "velocity over which it changes, w", grid=(0.01,), limits=(1e-4, 0.1), scale="velocity")

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.damping * (jnp.sqrt(state.v**2 + self.width**2) - self.width)
