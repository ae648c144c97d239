"""What the paper's printed formulas would change: each as printed beside the corrected one, on the nominal device."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ident.campaign import Platform
from ident.effects.section import device_section
from ident.mechanics import l_beam, residual_moment, segment_stiffness
from ident.report.figures.style import MODEL, RESIDUAL, label
from ident.runtime import configure

from . import printed
from .sheet import Figure, names, sheet

STRESSES = 90e6, 20e6, -10e6
FORCES = np.linspace(-0.6, 2.0, 104)  # N; none near zero, where the printed form is 0/0


class Found(NamedTuple):
    """Jump of the printed stress at the interface, Pa; moments by name, N·m; deflection of a free segment printed over
    corrected for each stress step; stiffness of both segments (2, forces) N/m, printed and corrected and by ident."""

    jump: float
    moments: dict[str, float]
    deflections: tuple[float, float]
    printed: np.ndarray
    corrected: np.ndarray
    ident: np.ndarray


def study() -> Found:
    configure()
    device = Platform()
    section, ts, tp = device_section(device), device.silicon_thickness, device.pzt_thickness
    below, above = printed.stress_profile(np.array([ts - 1e-15, ts + 1e-15]), STRESSES, ts, tp, printed=True)
    moment = lambda name: float(residual_moment(section, 70e6, 30e6, 20e6, moment=name))
    moments = {name: moment(name) for name in ("neutral-axis", "paper-printed", "paper-integral")}
    bending, torsion = float(section.bending), float(section.torsion)
    tip = lambda a, b, p: printed.free_deflection(device.length_1, a, b, ts, tp, device.width, bending, printed=p)
    ratios = tip(1.0, 0.0, True) / tip(1.0, 0.0, False), tip(0.0, 1.0, True) / tip(0.0, 1.0, False)
    own, other = (device.length_1, device.length_2), (device.length_2, device.length_1)
    beam = l_beam(section, device.length_1, device.length_2)
    table = {
        p: np.array([[printed.stiffness(k, f, bending, long, torsion / o, printed=p) for f in FORCES]
                     for k, long, o in zip((1, 2), own, other, strict=True)])
        for p in (True, False)
    }  # fmt: skip
    reduced = [
        np.asarray(segment_stiffness(FORCES * long**2 / bending, spring)) * bending / long**3
        for long, spring in zip(own, (beam.spring_1, beam.spring_2), strict=True)
    ]
    return Found(float(above - below), moments, ratios, table[True], table[False], np.array(reduced))


def check(found: Found) -> str:
    assert np.allclose(found.corrected, found.ident, rtol=1e-7), np.max(np.abs(found.corrected / found.ident - 1))
    wrong = np.abs(found.printed / found.ident - 1)
    smallest = [float(np.min(w[FORCES < 0])) for w in wrong], [float(np.min(w[FORCES > 0])) for w in wrong]
    assert min(map(min, smallest)) > 0.01, smallest
    right, printed, integral = found.moments.values()
    at = lambda k: ", ".join(f"{found.printed[k, np.argmin(np.abs(FORCES - f))]:.0f}" for f in (-0.4, 0.4))
    true = lambda k: ", ".join(f"{found.ident[k, np.argmin(np.abs(FORCES - f))]:.0f}" for f in (-0.4, 0.4))
    return (
        f"Eq. 1 jumps by {1e-6 * found.jump:.1f} MPa at the interface; the moment of 90, 20, −10 MPa is {right:.3e} "
        f"N·m, as printed {printed / right:.2f} and by the printed integrals {integral / right:.2f} times that; Eq. 5 "
        f"gives {found.deflections[0]:.2f} (σ12) and {found.deflections[1]:.2f} (σ23) times the free deflection; "
        f"stiffness at −0.4 and 0.4 N, segment 1: {at(0)} for {true(0)} N/m, segment 2: {at(1)} for {true(1)}"
    )


def draw(found: Found) -> Figure:
    figure, axes = sheet("Table 1 as printed gives no stiffness; with its slips mended it is ident's one function", 2)
    for k, a in enumerate(axes):
        a.plot(FORCES, found.printed[k], ".", color=RESIDUAL, ms=4)
        a.plot(FORCES, found.corrected[k], color="#bbbbbb", lw=5)
        a.plot(FORCES, found.ident[k], color=MODEL, lw=1.5)
        a.set_ylim(-1500, 2500)
        label(a, "axial force (N), tension positive", "stiffness (N/m)", f"segment {k + 1}")
        names(a, [("as printed", RESIDUAL), ("mended", "#8a8a8a"), ("ident", MODEL)])
    return figure
