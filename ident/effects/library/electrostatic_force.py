"""Attraction of the stage by a plate under voltage."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import SECOND_ORDER, SQUARE_OF_THE_VOLTAGE

_CLOSEST = 0.1  # of the gap: a trial simulation may be pulled in, and must stay finite there


class ElectrostaticForce(AbstractEffect):
    """Attraction by a plate at the distance g, F = ± k (V + V₀)² / (1 − z/g)² towards it, as in every parallel-plate
    actuator.

    k = ε A / (2 g²). g > 0 is a plate above the stage, g < 0 one below it; the sign of z is the sensor's choice, so a
    fit tries both. It shifts the mean, drives at twice the frequency and softens by V²; beyond a third of the gap a
    constant voltage pulls the stage in. Typical: gaps of 1.5-10 times the travel. V₀, which refines that, is a bias
    that the drive column does not have: another contact potential, charge in a dielectric, a supply of its own.
    """

    name = "electrostatic-force"
    equation = "F = sgn(g) k (V + V₀)² / (1 − z/g)²"
    source = "Senturia, Microsystem Design, 2001, Kluwer, §6.4 (parallel-plate electrostatic actuator)"
    mistaken_for = ("electrostriction", "voltage-stiffness", "quadratic-stiffness")
    alike = (SQUARE_OF_THE_VOLTAGE, SECOND_ORDER)
    contains = ("electrostriction",)  # a plate so far away that its distance does not show

    attraction = amplitude("N/V^2", "force by the squared voltage on the stage at rest, k", one_sided=True)
    gap = shape(
        "m", "gap above (g > 0) or below the stage", grid=(-6.0, -2.0, 2.0, 6.0), scale="displacement", positive=False
    )  # fmt: skip
    bias = shape("V", "voltage at the plate beside the drive, V₀", grid=(-1.0, 0.0, 1.0), limits=(-3.0, 3.0),
                 scale="voltage", positive=False, refines=True)  # fmt: skip

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        openness = jnp.maximum(1.0 - state.z / self.gap, _CLOSEST)
        return jnp.sign(self.gap) * self.attraction * (drive.V + self.bias) ** 2 / openness**2
