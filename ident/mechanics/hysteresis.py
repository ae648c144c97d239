"""Polynomial hysteresis of the PZT (Eq. 12) and the force that its strain puts on the stage."""

from __future__ import annotations

from .scalar import Scalar
from .section import Section
from .stage import Beam, stage_stiffness


def polynomial_strain(
    field: Scalar, rate: Scalar, frequency: Scalar, linear: Scalar, cubic: Scalar, loop: Scalar
) -> Scalar:
    """Free strain of the PZT with a polynomial loop.

    f(E) = d31 E − η E³ + (ζ/ω³) Ė³

    `field` E in V/m, `rate` Ė in V/(m·s), `frequency` ω in rad/s, `linear` d31 in m/V, `cubic` η and `loop` ζ in
    (m/V)³; broadcastable shapes. No unit.

    Source: Sensors 2020, 20, 3959, Eq. 12.
    """
    return linear * field - cubic * field**3 + loop * (rate / frequency) ** 3


def drive_force_coefficient(section: Section, beam: Beam) -> Scalar:
    """Force on the stage per free strain of the PZT, for electrodes of opposite sign on a segment's halves.

    K_f = K_stage(N=0) E_p b Tp d (l1² + l2²)/(4 EI)

    Each segment bends into an S with free tip travel κ_p l²/4, κ_p = E_p b Tp d f/EI. Returns N.

    Source: this project, for Eq. 13 of Sensors 2020, 20, 3959.
    """
    curvature = section.pzt_modulus * section.width * section.pzt_thickness * section.pzt_arm / section.bending
    travel = curvature * (beam.length_1**2 + beam.length_2**2) / 4
    return stage_stiffness(beam, 0.0, 0.0) * travel
