"""Effects that need the geometry of the platform, and what they do where a formula has no meaning."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign.device import Platform
from ident.effects.effect import Drive, State
from ident.effects.registry import built_in
from ident.mechanics import axial_forces

STILL = Drive(0.0, 0.0, 2e3, 1e-4)


def pair(closure: str, share: float = 1.0):
    """An arch force beside a residual stress of that closure, 50 MPa across the PZT."""
    stress = built_in()["residual-stress"](Platform(), {"closure": closure}, sigma12=50e6)
    return built_in()["arch-force"](Platform(), None, share=share).beside(stress), stress


@pytest.mark.parametrize("closure", ["axial-force", "sign-change"])
def test_the_arch_force_is_the_virtual_work_of_the_axial_forces(closure):
    # F dz = Σ N_i dΔ_i of the part of the shortening that is linear in z, four beams: by differences of the shortening.
    arch, stress = pair(closure)
    law, z, dz = stress.prepared.law, 3e-6, 1e-9
    beam, shape = law.beam, law.shape
    forces = [float(n) for n in axial_forces(law.law, z, 0.0)]
    linear = [
        [rise * share * at / length for at in (z, z + dz)]
        for rise, share, length in (
            (shape.rise_1, beam.share_1, beam.length_1),
            (shape.rise_2, beam.share_2, beam.length_2),
        )
    ]
    work = 4 * sum(n * float(after - before) for n, (before, after) in zip(forces, linear, strict=True))
    assert float(arch.force(State(z, 0.0), STILL, 0.0)) == pytest.approx(-work / dz, rel=1e-6)


def test_the_frame_closure_contains_the_arch_already():
    arch, _ = pair("frame")
    assert float(arch.force(State(3e-6, 0.0), STILL, 0.0)) == 0.0


@pytest.mark.parametrize("closure", ["axial-force", "sign-change", "frame"])
def test_residual_stress_adds_no_force_at_rest(closure):
    _, stress = pair(closure)
    assert float(stress.force(State(0.0, 0.0), STILL, 0.0)) == 0.0


def test_a_constant_drive_has_no_hysteresis_loop():
    effect = built_in()["pzt-hysteresis"](Platform(), None, eta=1e-20, zeta=1e-20)
    force = float(effect.drive((), Drive(5.0, 0.0, 0.0, 1e-4), 0.0))
    assert np.isfinite(force) and force < 0.0
