"""A brake of eddy currents, which fades beyond its critical speed."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape

_MOST = 1.2  # times the linear damping, of which the brake is a part: with more it would drive the motion beyond w


class EddyCurrentBrake(AbstractEffect):
    """A conductor that moves through a magnet's field: the brake F = −c ż/(1 + (ż/w)²), largest at the speed w.

    To first order it is a damper, which the linear damping holds already: c ż (ż/w)²/(1 + (ż/w)²) is what it falls
    short of one, and what is added here. So c is a part of the linear damping; what is left of that are other losses.
    Flywheels and pendulums with magnets, magnetic dampers and bearings, induction motors braked by a direct current.
    Slow against w it is a cubic damping below zero.
    """

    name = "eddy-current-brake"
    equation = "F = c ż (ż/w)²/(1 + (ż/w)²)"
    source = (
        "J. H. Wouterse, Critical torque and speed of eddy current brake with widely separated soft iron poles, 1991, "
        "IEE Proc. B 138, 153"
    )
    mistaken_for = ("cubic-damping", "power-law-damping")

    damping = amplitude("N*s/m", "the brake's damping at low speed, c", one_sided=True)
    # Far beyond its critical speed it would be a friction that falls, far below it a cubic damping: both have names.
    critical = shape("m/s", "critical speed, w", grid=(0.3, 0.6, 1.2), limits=(0.15, 5.0), scale="velocity")

    def can_be(self, stiffness: float, damping: float) -> bool:
        return bool(self.damping <= _MOST * damping)

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        part = (state.v / self.critical) ** 2
        return self.damping * state.v * part / (1.0 + part)
