"""Damping by any power of the velocity, between dry friction and drag of the third order."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..power import beyond_linear


class PowerLawDamping(AbstractEffect):
    """Damping that grows or falls with the velocity by a power of it: F = −c ż (|ż/v₀|ⁿ⁻¹ − 1)/(n − 1), n fitted.

    v₀ is the largest velocity measured; there the linear damping has its whole force, so that the quality factor is
    that of the largest motion, and c is how much the damping F/ż grows with ln ż. c > 0 is damping that grows with the
    velocity, c < 0 one that falls, whatever n. A law |ż|ⁿ with no linear damping beside it is c = (n − 1) times the
    linear one. n = 0 is dry friction, 2 the drag of a turbulent flow, 3 drag of third order; those have names of their
    own, and are named where they do as well. Between them lie fluid dampers (n = 0.2-0.6 and 1.8), drag in the
    transition from laminar to turbulent flow (1.5-1.9) and losses of materials and joints (1.2-2.5); n → 1 is a damping
    c ln ż. Below a hundred-thousandth of v₀ it is linear.
    """

    name = "power-law-damping"
    equation = "F = −c ż (|ż/v₀|ⁿ⁻¹ − 1)/(n − 1)"
    source = (
        "Soong & Constantinou (eds.), Passive and Active Structural Vibration Control in Civil Engineering, 1994 "
        "(fluid dampers); n = 0 and 2: Nayfeh & Mook, Nonlinear Oscillations, 1979, ch. 3"
    )
    mistaken_for = ("squeeze-film-damping", "eddy-current-brake")
    contains = ("coulomb-friction", "quadratic-damping", "cubic-damping")
    steps_per_period = 120
    has_kink = True

    damping = amplitude("N*s/m", "growth of F/ż with ln ż at the reference velocity, c")
    exponent = shape("1", "power of the velocity, n", grid=(0.4, 1.5, 2.5), limits=(0.1, 4.0))
    velocity = shape("m/s", "reference velocity, v₀", grid=(1.0,), scale="velocity", fitted=False)

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.damping * self.velocity * beyond_linear(state.v / self.velocity, self.exponent)
