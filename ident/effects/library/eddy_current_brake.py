"""A brake of eddy currents, which fades beyond its critical speed."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape


class EddyCurrentBrake(AbstractEffect):
    """A conductor that moves through a magnet's field: the brake F = −c ż/(1 + (ż/w)²), largest at the speed w.

    To first order it is a damper, which the linear damping holds already: c ż (ż/w)²/(1 + (ż/w)²) is what it falls
    short of one, and what is added here. So c is a part of the linear damping; what is left of that are other losses.
    Flywheels and pendulums with magnets, magnetic dampers and bearings; an induction motor at rest pulls by the same
    law of its slip. Slow against w it is a cubic damping below zero.
    """

    name = "eddy-current-brake"
    equation = "F = c ż (ż/w)²/(1 + (ż/w)²)"
    source = (
        "W. R. Smythe, On eddy currents in a rotating disk, 1942, Trans. AIEE 61, 681; J. H. Wouterse, Critical torque "
        "and speed of eddy current brake with widely separated soft iron poles, 1991, IEE Proc. B 138, 153"
    )
    mistaken_for = ("cubic-damping", "power-law-damping")

    damping = amplitude("N*s/m", "the brake's damping at low speed, c", one_sided=True)
    # Brakes are not driven to ten times their critical speed; there the law would be a friction that rises gently.
    critical = shape("m/s", "critical speed, w", grid=(0.3, 0.6, 1.2), limits=(0.15, 5.0), scale="velocity")

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        part = (state.v / self.critical) ** 2
        return self.damping * state.v * part / (1.0 + part)
