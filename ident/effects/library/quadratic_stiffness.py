"""Quadratic stiffness: the spring is stiffer on one side."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import BENT_RESONANCE, EVEN_HARMONICS, QUADRATIC_FORCE, SAME_HARMONICS, SECOND_ORDER, WITHIN_A_PITCH

_CLOSEST = 0.05  # of the distance: a trial simulation may come nearer, and must stay finite there


class QuadraticStiffness(AbstractEffect):
    """A restoring force that is not odd, as of a curved beam: F = −k2 z² (1 + 2 u z/3)/(1 + u z)².

    It shifts the mean and makes even harmonics. u, which refines the law, is 0 for a plain square. An attraction or
    repulsion by the inverse square of a distance g, of a magnet or an electrode at a constant voltage, is u = 1/g below
    the stage and −1/g above it: (2/3) {(g²/2) [(1 + z/g)⁻² − 1] + g z}, which has no constant and no linear part.
    """

    name = "quadratic-stiffness"
    equation = "F = −k2 z² (1 + 2 u z/3)/(1 + u z)²"
    source = "Nayfeh & Mook, Nonlinear Oscillations, 1979, §4.2"
    mistaken_for = (
        "residual-stress", "arch-force", "voltage-stiffness", "electrostriction", "electrostatic-force", "end-stop",
        "sensor-nonlinearity", "bilinear-stiffness", "asymmetric-damping", "variable-inertia", "cogging",
    )  # fmt: skip
    alike = (QUADRATIC_FORCE, BENT_RESONANCE, EVEN_HARMONICS, SECOND_ORDER, WITHIN_A_PITCH, SAME_HARMONICS)

    k2 = amplitude("N/m^2", "quadratic stiffness")
    nearness = shape("1/m", "inverse distance of what acts, u", grid=(-0.4, 0.0, 0.4), limits=(-0.95, 0.95),
                     scale="nearness", positive=False, refines=True)  # fmt: skip

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        near = jnp.maximum(self.nearness * state.z, _CLOSEST - 1.0)
        return -self.k2 * state.z**2 * (1.0 + 2.0 / 3.0 * near) / (1.0 + near) ** 2
