"""Squeeze-film damping: gas pressed out of the gap beside the stage."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import CUBIC_LOSS, SAME_LOSS

_CLOSEST = 0.1  # of the gap: a trial simulation may cross the wall, and must stay finite there
_MOST = 10.0  # times the damping of the stage, of which the open film is a part: laws that only resemble this one are
# met with three times (`experiments.hidden_effects`), and a softening spring beside z²ż, taken for one film, with 2000


class SqueezeFilmDamping(AbstractEffect):
    """Damping that grows as the gap closes: F = −c [(1 − z/g)⁻³ − 1] ż, the constant part being the linear damping.

    g > 0 is a wall above the stage, g < 0 one below it; the sign of z is the sensor's choice, so a fit tries both.
    Valid for films much wider than thick and for slow motion (small squeeze number: no gas spring). Typical: gaps of
    1.5-10 times the travel; c is a part of the damping of the stage, and far beyond it this is another law.
    """

    name = "squeeze-film-damping"
    equation = "F = −c [(1 − z/g)⁻³ − 1] ż"
    source = "Bao & Yang, Squeeze film air damping in MEMS, 2007, Sens. Actuators A 136, 3, §2"
    mistaken_for = ("cubic-damping", "quadratic-damping", "power-law-damping")
    alike = (CUBIC_LOSS, SAME_LOSS)

    damping = amplitude("N*s/m", "damping by the film in the open gap, c", one_sided=True)
    gap = shape(
        "m", "gap above (g > 0) or below the stage", grid=(-4.0, -1.5, 1.5, 4.0), scale="displacement", positive=False
    )  # fmt: skip

    def can_be(self, stiffness: float, damping: float) -> bool:
        return bool(self.damping <= _MOST * damping)

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        closeness = jnp.maximum(1.0 - state.z / self.gap, _CLOSEST)
        return -self.damping * (closeness**-3 - 1.0) * state.v
