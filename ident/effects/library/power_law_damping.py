"""Damping by any power of the velocity, between dry friction and drag of the third order."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape

_SMALL = 0.01  # of the reference velocity: below, the force is linear, for powers under one have no slope at zero


class PowerLawDamping(AbstractEffect):
    """Damping by a power of the velocity: F = −c |ż/v₀|ⁿ sign ż, with n fitted; v₀ is the largest velocity measured.

    n = 0 is dry friction, 2 the drag of a turbulent flow, 3 drag of third order; those have names of their own, and
    are named where they do as well. Between them lie fluid dampers (n = 0.2-0.6 and 1.8), drag in the transition
    from laminar to turbulent flow (1.5-1.9) and losses of materials and joints (1.2-2.5). Near n = 1 only linear
    damping is seen. Below a hundredth of v₀ the force is linear: ż [(ż/v₀)² + 10⁻⁴]^((n−1)/2).
    """

    name = "power-law-damping"
    equation = "F = −c |ż/v₀|ⁿ sign ż"
    source = (
        "Soong & Constantinou (eds.), Passive and Active Structural Vibration Control in Civil Engineering, 1994 "
        "(fluid dampers); n = 0 and 2: Nayfeh & Mook, Nonlinear Oscillations, 1979, ch. 3"
    )
    mistaken_for = ("squeeze-film-damping",)
    contains = ("coulomb-friction", "quadratic-damping", "cubic-damping")
    steps_per_period = 120

    damping = amplitude("N", "force at the reference velocity, c", one_sided=True)
    exponent = shape("1", "power of the velocity, n", grid=(0.4, 1.5, 2.5), limits=(0.1, 4.0))
    velocity = shape("m/s", "reference velocity, v₀", grid=(1.0,), scale="velocity", fitted=False)

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        part = state.v / self.velocity
        return -self.damping * part * (part**2 + _SMALL**2) ** ((self.exponent - 1.0) / 2.0)
