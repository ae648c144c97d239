"""Residual stress in the beams, which makes their stiffness depend on displacement and drive."""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp

from ...campaign.device import Platform
from ...mechanics import Restoring, Scalar, restoring, restoring_stiffness, stage_stiffness
from ..effect import AbstractEffect, Drive, Expected, State, amplitude, choice, shape
from ..likeness import QUADRATIC_FORCE, SAME_HARMONICS, SECOND_ORDER, STIFFENS, STRETCHES
from ..section import device_section

_STRENGTH = 10e9  # Pa; micromachined silicon breaks at 1-8 GPa (Petersen, Silicon as a mechanical material, 1982)
# By the curvature of the wafer: sol-gel PZT 100 to 150 MPa of tension, Hong et al., Thin Solid Films 510 (2006) 213; a
# whole Pt/PZT/Pt stack 150 MPa of compression, Zhang et al., Ferroelectrics 273 (2002) 83. A gradient is no larger.
_FILM = Expected(0.0, 100e6, "films of PZT on silicon carry up to some 100 MPa, either sign")
_SUBSTRATE = Expected(0.0, 50e6, "what a film leaves in the silicon is less than what it carries")
_HELD = Expected(1.0, 1.1, "finite elements need 0.06 (stage free in plane) to 2.6 (clamped)")


class Stressed(NamedTuple):
    """`law`: the restoring force under stress; `unstressed`: stiffness of the stage without it, N/m."""

    law: Restoring
    unstressed: Scalar


class ResidualStress(AbstractEffect):
    """Residual stress bends the beams; vibration then stretches or compresses them and changes their stiffness.

    F = −[K(N1, N2) − K(0, 0)] z with axial forces N from one of three closures: "axial-force" (the paper's argument),
    "sign-change" (the sharp change of its Fig. 8) and "frame" (the L beam as an in-plane frame, nothing fitted but the
    stress; finite elements confirm it within 2 %). The closure decides the stress gradient that a fit returns, even its
    sign: where the stage may turn in its plane, only "frame" gives one that can be trusted.

    Only one combination of the two gradients, the free curvature, reaches the displacement: they cannot be told apart.
    """

    name = "residual-stress"
    equation = "F = −[K(N(z, V)) − K(0)] z"
    source = "Sensors 2020, 20, 3959, Eqs. 1-11"
    mistaken_for = ("quadratic-stiffness", "cubic-stiffness", "voltage-stiffness", "arch-force")
    alike = (STRETCHES, STIFFENS, QUADRATIC_FORCE, SECOND_ORDER, SAME_HARMONICS)
    contains = ("quadratic-stiffness", "cubic-stiffness", "voltage-stiffness")
    platform_only = True

    closure = choice("axial-force", "sign-change", "frame")
    sigma12 = shape("Pa", "stress gradient in the PZT, top − interface", positive=False,
                    grid=(-100e6, -25e6, 25e6, 100e6), limits=(-_STRENGTH, _STRENGTH), expected=_FILM)  # fmt: skip
    sigma23 = shape("Pa", "stress gradient in the silicon, interface − bottom", positive=False, grid=(0.0,),
                    limits=(-_STRENGTH, _STRENGTH), expected=_SUBSTRATE)  # fmt: skip
    sigma2 = shape("Pa", "stress at the interface", positive=False, grid=(0.0,), fitted=False)
    restraint = amplitude("1", "in-plane restraint ρ of the stage", default=1.0, positive=True, expected=_HELD)
    voltage_force = amplitude("N/V", "axial force per volt of drive, β_V")
    width = shape("m", "displacement over which the force changes sign", grid=(0.02, 0.1, 0.4), scale="displacement")

    def unused(self) -> tuple[str, ...]:
        return {
            "axial-force": ("width",),
            "sign-change": (),
            "frame": ("width", "restraint", "voltage_force"),
        }[self.closure]

    def prepare(self) -> Stressed | None:
        if not isinstance(self.device, Platform):
            return None
        law = restoring(
            device_section(self.device),
            self.device.length_1,
            self.device.length_2,
            sigma12=self.sigma12,
            sigma23=self.sigma23,
            sigma2=self.sigma2,
            restraint=self.restraint,
            voltage=self.voltage_force,
            width=self.width,
            closure=self.closure,
            moment=self.device.moment,
            in_plane=self.device.in_plane,
            beam_end=self.device.beam_end,
        )
        return Stressed(law, stage_stiffness(law.beam, jnp.zeros(()), jnp.zeros(())))

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        scale = self.restraint if self.closure == "frame" else 1.0
        return -scale * (restoring_stiffness(self.prepared.law, state.z, drive.V) - self.prepared.unstressed) * state.z

    def caution(self, lowest: float, highest: float) -> tuple[str, bool]:
        if not isinstance(self.device, Platform):
            return "", False
        if self.closure == "frame":
            legs = max(self.device.length_1, self.device.length_2) / min(self.device.length_1, self.device.length_2)
            unequal = " Legs as unequal as these cost up to 10 % at double stress." if legs > 1.5 else ""
            text = (
                'The stress gradient rests on the closure "frame", which finite elements confirm within 1–2 % over '
                f"±60 µm. It is beam theory: no plate effects, no finite corner.{unequal}"
            )
            return text, False
        if self.closure == "sign-change":
            text = (
                'The stress gradient rests on the closure "sign-change", a phenomenological law for the force near '
                "zero: its parameters describe the records and are not stresses. Only the closure "
                '"frame" agrees with finite elements.'
            )
            return text, True
        turns = self.device.in_plane == "yaw"
        yaw = " The stage of this device may turn in its plane, so this applies here." if turns else ""
        text = (
            'The closure decides the stress gradient. "axial-force" (the paper\'s) is 11–16 % off finite elements with '
            "restraint = 1, needs a restraint from 0.002 to 2.9 depending on how the stage is held in plane, and where "
            f"the stage may turn about z it can give the gradient the wrong sign.{yaw} Its buckling under high stress "
            'belongs to the closure too. Before reading the gradient as a stress, fit again with closure = "frame" '
            "(within 1–2 % of finite elements)."
        )
        return text, True
