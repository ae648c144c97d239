"""Hysteresis of the suspension: friction that first bends, then slips."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..memory import slip, within


class BoucWen(AbstractEffect):
    """Friction with an elastic start: F = −F_y h, h' = (ż/z_y)(1 − |h|ⁿ if ż h > 0, else 1 − (1 − 2β) |h|ⁿ).

    Below the yield displacement z_y it is a spring F_y/z_y, far beyond it Coulomb friction of size F_y; n says how
    sharply it yields (1 is soft, 2 and more sharp), β how it unloads: ½ as a spring, 1 twice as stiffly at first, in
    the usual form of the law with β + γ = 1. Below ½ a loop could give energy back (Erlicher & Point, 2004, C. R.
    Mécanique 332, 51), and near 0 it is no loop but a softening spring: a fit keeps above 0.4. Loops in joints, clamps
    and electrode layers; typical F_y 0.1-5 % of the peak restoring force.
    """

    name = "bouc-wen"
    equation = "F = −F_y h, h' = (ż/z_y)(1 − |h|ⁿ [ż h > 0] − (1 − 2β) |h|ⁿ [ż h < 0])"
    source = (
        "Ismail, Ikhouane, Rodellar, The hysteresis Bouc-Wen model, a survey, 2009, "
        "Arch. Comput. Methods Eng. 16, 161, §2"
    )
    mistaken_for = ("coulomb-friction", "viscoelastic-support", "bouc-wen-drive")
    steps_per_period = 120
    hidden_units = ("1",)

    friction = amplitude("N", "force when fully slipping, F_y", one_sided=True)
    travel = shape("m", "yield displacement, z_y", grid=(0.05, 0.15, 0.4, 1.0), scale="displacement")
    sharpness = shape("1", "sharpness of the yield, n", grid=(1.0, 2.0))
    fullness = shape("1", "fullness of the loop, β", grid=(0.5,), limits=(0.4, 1.0))

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.friction * within(state.hidden[0])

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0,)

    def rate(self, state: State, drive: Drive, t: Scalar) -> tuple[Scalar, ...]:
        return (state.v / self.travel * (1.0 - slip(state.hidden[0], state.v, self.sharpness, self.fullness)),)
