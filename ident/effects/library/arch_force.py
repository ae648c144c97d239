"""The axial forces of bent beams push the stage out of plane."""

from __future__ import annotations

from ...mechanics import Scalar, axial_forces
from ...mechanics import arch_force as arch
from ...mechanics.frame import FrameLaw
from ..effect import AbstractEffect, Drive, State, amplitude
from ..likeness import QUADRATIC_FORCE, SAME_HARMONICS


class ArchForce(AbstractEffect):
    """Out-of-plane component of the axial forces along the initial slope of the beams.

    F = −4 a Σ N_i z0_i s_i/l_i, with the axial forces N of `residual-stress`; a = 1 is what the geometry says. The
    closure "frame" of `residual-stress` contains the arch already, so there this effect adds nothing.
    """

    name = "arch-force"
    equation = "F = −4 a Σ N_i z0_i s_i/l_i"
    source = "Sensors 2020, 20, 3959, Fig. 14; shallow-arch statics"
    mistaken_for = ("quadratic-stiffness", "residual-stress")
    alike = (QUADRATIC_FORCE, SAME_HARMONICS)
    platform_only = True
    needs = "residual-stress"

    share = amplitude("1", "part of the geometric arch force that acts", default=1.0)

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        law = self.partner.prepared.law
        if isinstance(law.law, FrameLaw):
            return 0.0
        n1, n2 = axial_forces(law.law, state.z, drive.V)
        return -self.share * arch(law.beam, law.shape, n1, n2)
