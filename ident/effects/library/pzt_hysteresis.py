"""Polynomial hysteresis of the PZT, the paper's Eq. 12."""

from __future__ import annotations

import jax.numpy as jnp

from ...campaign.device import Platform
from ...mechanics import Scalar, drive_force_coefficient, l_beam, polynomial_strain
from ..effect import AbstractEffect, Drive, amplitude
from ..likeness import LOOP_OF_THE_DRIVE, SATURATES, SHIFT_OF_PHASE
from ..section import device_section


class PztHysteresis(AbstractEffect):
    """Free strain of the PZT with a cubic term and a loop.

    F = K_f [−η E³ + (ζ/ω³) Ė³], E = V/T_p, with K_f from the geometry (1 for a generic oscillator, where E is the
    drive). It follows one frequency well and transfers badly to others: real PZT needs play operators
    (`prandtl-ishlinskii`).
    """

    name = "pzt-hysteresis"
    equation = "F = K_f [−η E³ + (ζ/ω³) Ė³]"
    source = "Sensors 2020, 20, 3959, Eq. 12"
    mistaken_for = ("prandtl-ishlinskii", "bouc-wen-drive", "cubic-stiffness", "drive-lag", "drive-saturation",
                     "slew-limit", "backlash")  # fmt: skip
    alike = (LOOP_OF_THE_DRIVE, SATURATES, SHIFT_OF_PHASE)

    eta = amplitude("m^3/V^3", "cubic saturation η")
    zeta = amplitude("m^3/V^3", "loop width ζ")

    def prepare(self) -> tuple[Scalar, Scalar]:
        device = self.device
        if not isinstance(device, Platform):
            return 1.0, 1.0
        section = device_section(device)
        beam = l_beam(section, device.length_1, device.length_2)
        return drive_force_coefficient(section, beam), device.pzt_thickness

    def drive(self, hidden: tuple[Scalar, ...], drive: Drive, t: Scalar) -> Scalar:
        coefficient, thickness = self.prepared
        field, rate = drive.V / thickness, drive.rate / thickness
        omega = jnp.where(drive.omega > 0, drive.omega, jnp.inf)  # a constant drive has no loop
        return coefficient * polynomial_strain(field, rate, omega, 0.0, self.eta, self.zeta)

    def caution(self, lowest: float, highest: float) -> tuple[str, bool]:
        low, high = round(lowest), round(highest)
        span = f"fitted here from {low} to {high} Hz" if low != high else f"fitted here at {low} Hz only"
        text = (
            "The polynomial of pzt-hysteresis has no memory and carries over badly to other frequencies than those "
            f"it was fitted at ({span}): on measured PZT stages, trained at 20 Hz, it left 9.6 % at others where "
            "play operators (prandtl-ishlinskii) left 4.0 %."
        )
        own = " Its eta and zeta, like d31, enter as products with K_f." if isinstance(self.device, Platform) else ""
        return text + own, high > 3 * low
