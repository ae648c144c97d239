"""Hysteresis of the suspension: a spring with memory, that yields or stiffens."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import SAME_LOSS, SHIFT_OF_PHASE
from ..memory import slip, stiffened, within


class BoucWen(AbstractEffect):
    """A spring with memory: F = −F_y h, h' = (ż/z_y)(1 − |h|ⁿ if ż h > 0, else 1 − (1 − 2β) |h|ⁿ).

    Below the yield displacement z_y it is a spring F_y/z_y, far beyond it Coulomb friction of size F_y; n says how
    sharply it yields (1 is soft, 2 and more sharp), β how it unloads: ½ as a spring, 1 twice as stiffly at first, in
    the usual form of the law with β + γ = 1. Below ½ a loop could give energy back (Erlicher & Point, 2004, C. R.
    Mécanique 332, 51), and near 0 it is no loop but a softening spring: a fit keeps above 0.4. Loops in joints, clamps
    and electrode layers; typical F_y 0.1-5 % of the peak restoring force.

    A negative z_y is the other half of the family, β + γ = −1: a loop that stiffens while it loads,
    h' = (ż/|z_y|)(1 + |h|ⁿ), and more so, 1 + (1 + 2β) |h|ⁿ, while it unloads. It dissipates for any β > 0, and has no
    yield; F_y is then the force at which its stiffness has doubled.
    """

    name = "bouc-wen"
    equation = "F = −F_y h, h' = (ż/|z_y|)(1 − s |h|ⁿ [ż h > 0] − (s − 2β) |h|ⁿ [ż h < 0]), s = sign z_y"
    source = (
        "Ismail, Ikhouane, Rodellar, The hysteresis Bouc-Wen model, a survey, 2009, "
        "Arch. Comput. Methods Eng. 16, 161, §2"
    )
    mistaken_for = (
        "coulomb-friction", "stribeck-friction", "presliding-friction", "viscoelastic-support", "bouc-wen-drive",
    )  # fmt: skip
    alike = (SAME_LOSS, SHIFT_OF_PHASE)
    steps_per_period = 120
    hidden_units = ("1",)

    friction = amplitude("N", "force when fully slipping, F_y", one_sided=True)
    travel = shape("m", "yield displacement, z_y; negative: the loop stiffens", grid=(0.05, 0.15, 0.4, 1.0, -0.4, -1.5),
                   limits=(-30.0, 3.0), scale="displacement", positive=False)  # fmt: skip
    sharpness = shape("1", "sharpness of the yield, n", grid=(1.0, 2.0))
    fullness = shape("1", "fullness of the loop, β", grid=(0.5,), limits=(0.4, 10.0))

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        h = state.hidden[0]
        return -self.friction * jnp.where(self.travel > 0, within(h), h)

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0,)

    def rate(self, state: State, drive: Drive, t: Scalar) -> tuple[Scalar, ...]:
        h = state.hidden[0]
        yields = slip(h, state.v, self.sharpness, self.fullness)
        stiffens = stiffened(h, state.v, self.sharpness, self.fullness)
        return (state.v / jnp.abs(self.travel) * (1.0 - jnp.where(self.travel > 0, yields, -stiffens)),)
