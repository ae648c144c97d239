"""Where the axial force comes from: the laws "axial-force" and "sign-change"."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp

from .residual import InitialShape
from .scalar import Scalar, vector
from .stage import BEAMS, Beam


class AxialForce(NamedTuple):
    """Axial forces of the two segments as polynomials of the stage's displacement and of the drive.

    N_j = linear_j z + quadratic_j z² + voltage_j V;   `linear_j` N/m, `quadratic_j` N/m², `voltage_j` N/V.
    """

    linear_1: Scalar
    linear_2: Scalar
    quadratic_1: Scalar
    quadratic_2: Scalar
    voltage_1: Scalar
    voltage_2: Scalar


class SignChange(NamedTuple):
    """Axial forces of the two segments that change sign around zero displacement.

    N_j = step_j tanh(z/width) + voltage_j V;   `step_j` N, `width` m, `voltage_j` N/V.
    """

    step_1: Scalar
    step_2: Scalar
    width: Scalar
    voltage_1: Scalar
    voltage_2: Scalar


def shortening(share: Scalar, length: Scalar, rise: Scalar, displacement: Scalar) -> Scalar:
    """Shortening of a guided segment over an initial shape of linear slope.

    Δ_j = (3/5) z_j²/l_j + z0_j z_j/l_j,   z_j = s_j z

    `share` s_j no unit; `length` l_j, `rise` z0_j, `displacement` z in m, broadcastable shapes; returns m.

    Source: Sensors 2020, 20, 3959, text under Eq. 11, made explicit by this project.
    """
    own = share * displacement
    return (0.6 * own**2 + rise * own) / length


def axial_force(
    beam: Beam, shape: InitialShape, stiffness: jax.Array, restraint: Scalar, voltage: Scalar
) -> AxialForce:
    """Axial forces of the closure "axial-force".

    N_i = ρ Σ_j A_ij Δ_j(z) + β_V V

    `stiffness` A (2, 2) N/m from `shortening_stiffness`; `restraint` ρ ≥ 0, no unit; `voltage` β_V in N/V, the direct
    axial effect of the drive (0 where the electrode halves cancel); scalars.

    Source: Sensors 2020, 20, 3959, text under Eq. 11, made explicit by this project.
    """
    share_1, share_2 = beam.share_1 / beam.length_1, beam.share_2 / beam.length_2
    linear = restraint * (stiffness @ vector(shape.rise_1 * share_1, shape.rise_2 * share_2))
    quadratic = restraint * 0.6 * (stiffness @ vector(beam.share_1 * share_1, beam.share_2 * share_2))
    return AxialForce(linear[0], linear[1], quadratic[0], quadratic[1], voltage, voltage)


def sign_change(
    beam: Beam,
    shape: InitialShape,
    stiffness: jax.Array,
    restraint: Scalar,
    voltage: Scalar,
    width: Scalar,
) -> SignChange:
    """Axial forces of the closure "sign-change", the sharp change of Fig. 8.

    N_i = ρ N0_i tanh(z/w) + β_V V,   N0_i = A_ii z0_i |z0_i|/l_i

    `width` w > 0 in m, the rest as in `axial_force`.

    Source: Sensors 2020, 20, 3959, Fig. 8 (phenomenological).
    """
    step_1 = restraint * stiffness[0, 0] * shape.rise_1 * jnp.abs(shape.rise_1) / beam.length_1
    step_2 = restraint * stiffness[1, 1] * shape.rise_2 * jnp.abs(shape.rise_2) / beam.length_2
    return SignChange(step_1, step_2, width, voltage, voltage)


def axial_forces(law: AxialForce | SignChange, displacement: Scalar, voltage: Scalar = 0.0) -> tuple[Scalar, Scalar]:
    """Axial forces (N1, N2) in N at a displacement (m) and a drive (V), any broadcastable shapes.

    "axial-force":  N_j = linear_j z + quadratic_j z² + voltage_j V
    "sign-change":  N_j = step_j tanh(z/w) + voltage_j V

    Source: Sensors 2020, 20, 3959, text under Eq. 11.
    """
    z = displacement
    if isinstance(law, SignChange):
        side = jnp.tanh(z / law.width)
        return law.step_1 * side + law.voltage_1 * voltage, law.step_2 * side + law.voltage_2 * voltage
    return (
        z * (law.linear_1 + law.quadratic_1 * z) + law.voltage_1 * voltage,
        z * (law.linear_2 + law.quadratic_2 * z) + law.voltage_2 * voltage,
    )


def arch_force(beam: Beam, shape: InitialShape, force_1: Scalar, force_2: Scalar) -> Scalar:
    """Restoring force of the axial forces on the initial slope, the arch term that the secant stiffness leaves out.

    F = 4 Σ_i N_i z0_i s_i/l_i

    `force_1`, `force_2` in N, any broadcastable shapes; returns N, positive where it adds to the restoring force K z.

    Source: virtual work, N_i dΔ_i/dz with Δ_i of `shortening`; this project.
    """
    return BEAMS * (
        force_1 * shape.rise_1 * beam.share_1 / beam.length_1 + force_2 * shape.rise_2 * beam.share_2 / beam.length_2
    )
