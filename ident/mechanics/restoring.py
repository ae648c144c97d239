"""Restoring force of the stage: constants once per trajectory, a few operations per step."""

from __future__ import annotations

from typing import Literal, NamedTuple

from .axial import AxialForce, SignChange, axial_force, axial_forces, sign_change
from .frame import FrameLaw, InPlane, frame_law
from .l_frame import shortening_stiffness
from .residual import InitialShape, Moment, initial_shape, mean_force, residual_moment
from .scalar import Scalar
from .section import Section
from .stage import BEAMS, Beam, l_beam, stage_stiffness

Closure = Literal["axial-force", "sign-change", "frame"]


class Restoring(NamedTuple):
    """Everything of the restoring force that is constant along a trajectory.

    - `law`: axial forces of "axial-force" or "sign-change", or the polynomial of "frame".
    - `beam`: stiffness constants; `shape`: initial deflections.
    - `rise`: initial displacement of the stage, m (with "frame" including the equilibrium's shift).
    """

    law: AxialForce | SignChange | FrameLaw
    beam: Beam
    shape: InitialShape
    rise: Scalar


def restoring(
    section: Section,
    length_1: Scalar,
    length_2: Scalar,
    *,
    sigma12: Scalar,
    sigma23: Scalar,
    sigma2: Scalar = 0.0,
    restraint: Scalar = 1.0,
    voltage: Scalar = 0.0,
    width: Scalar = 1e-6,
    closure: Closure = "axial-force",
    moment: Moment = "neutral-axis",
    in_plane: InPlane = "yaw",
    beam_end: tuple[float, float] = (0.0, -1.5e-3),
    shear: bool = True,
) -> Restoring:
    """Constants of the restoring force from residual stress, differentiable in every scalar.

    σ → M_res, N_res → z01, z02 → axial forces N1(z, V), N2(z, V) or the frame's k1, k2, k3

    Lengths in m; `sigma12` = σ1 − σ2, `sigma23` = σ2 − σ3, `sigma2` in Pa; `restraint` ρ, no unit; `voltage` β_V in
    N/V; `width` w in m; scalars. `closure`, `moment`, `in_plane`, `shear` are static. ρ and β_V belong to "axial-force"
    and "sign-change", w to "sign-change", `in_plane`, `beam_end`, `shear` to "frame"; the others ignore them.

    Source: Sensors 2020, 20, 3959, §3.1; "frame": this project.
    """
    beam = l_beam(section, length_1, length_2)
    bending_moment = residual_moment(section, sigma12, sigma23, sigma2, moment=moment)
    shape = initial_shape(section, length_1, length_2, bending_moment)
    rise = shape.rise_1 + shape.rise_2
    if closure == "frame":
        force = mean_force(section, sigma12, sigma23, sigma2)
        frame = frame_law(section, length_1, length_2, shape, force, in_plane=in_plane, beam_end=beam_end, shear=shear)
        return Restoring(frame, beam, shape, frame.rise)
    stiffness = shortening_stiffness(section, length_1, length_2)
    if closure == "axial-force":
        return Restoring(axial_force(beam, shape, stiffness, restraint, voltage), beam, shape, rise)
    if closure == "sign-change":
        return Restoring(sign_change(beam, shape, stiffness, restraint, voltage, width), beam, shape, rise)
    raise ValueError(f"unknown closure {closure!r}: choose axial-force, sign-change or frame")


def restoring_stiffness(constants: Restoring, displacement: Scalar, voltage: Scalar = 0.0) -> Scalar:
    """Secant stiffness of the stage; the restoring force is K(z, V) z.

    "axial-force", "sign-change":  K = K_stage(N1(z, V), N2(z, V))
    "frame":                       K = 4 (k1 + k2 z + k3 z²)

    `displacement` z in m, from rest; `voltage` V in V; any broadcastable shapes; returns N/m.

    Source: Sensors 2020, 20, 3959, Eqs. 11 and 13.
    """
    law, z = constants.law, displacement
    if isinstance(law, FrameLaw):
        return BEAMS * (law.k1 + z * (law.k2 + law.k3 * z))
    return stage_stiffness(constants.beam, *axial_forces(law, z, voltage))


def restoring_force(constants: Restoring, displacement: Scalar, voltage: Scalar = 0.0) -> Scalar:
    """Restoring force of the stage, F = K(z, V) z, in N.

    Arguments as in `restoring_stiffness`.

    Source: Sensors 2020, 20, 3959, Eq. 13.
    """
    return restoring_stiffness(constants, displacement, voltage) * displacement
