"""The term of a spring beyond the cubic one."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude


class QuinticStiffness(AbstractEffect):
    """What the fourth power of the displacement adds to the stiffness, beside the cubic term: F = −k5 z⁵.

    The spring of a pendulum is g/l (z − z³/6 + z⁵/120); one that softens first and hardens then has k3 < 0 < k5.
    """

    name = "quintic-stiffness"
    equation = "F = −k5 z⁵"
    source = "Kovacic & Brennan (eds.), The Duffing Equation, 2011, ch. 2 (what the cubic term is the beginning of)"
    mistaken_for = ("end-stop",)
    needs = "cubic-stiffness"

    k5 = amplitude("N/m^5", "stiffness by the fourth power of the displacement")

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.k5 * state.z**5
