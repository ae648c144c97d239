"""Fig. 8: stiffness of the stage against its displacement at several voltages.

The paper: "a sharp increase of stiffness around zero displacement, because the axial force changed from a compressive
state of negative displacement to a tensile state of positive displacement"; "the level of stiffness variation is also
related to the driving voltage"; "the stiffening effect also appeared in the stage of large deformation".
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ident import mechanics
from ident.campaign import Platform
from ident.effects.section import device_section
from ident.mechanics.axial import AxialForce, SignChange, axial_forces
from ident.report.figures.style import MODEL, RESIDUAL, label

from .nominal import CLOSURE, PARAMETERS
from .sheet import Figure, names, sheet

VOLTS = (-9.0, 0.0, 9.0)
Z = np.linspace(-60e-6, 60e-6, 1201)
SHADES = ("#56b4e9", MODEL, "#08306b")


class Found(NamedTuple):
    """Stiffness (volts, z) N/m, axial forces of both segments without drive (2, z) N."""

    stiffness: np.ndarray
    forces: np.ndarray


def law(closure: mechanics.Closure = CLOSURE, multiple: float = 1.0) -> mechanics.Restoring:
    """The nominal device's restoring force under so many times its stress."""
    own, device = {k.split(".")[1]: v for k, v in PARAMETERS.items()}, Platform()
    return mechanics.restoring(
        device_section(device), device.length_1, device.length_2,
        sigma12=multiple * own["sigma12"], sigma23=multiple * own["sigma23"], restraint=own["restraint"],
        voltage=own["voltage_force"], width=own["width"], closure=closure,
    )  # fmt: skip


def stiffness(constants: mechanics.Restoring, volts: float = 0.0) -> np.ndarray:
    """F/z of the stage with the stiffening of large deformations, (z,) N/m."""
    return np.asarray(mechanics.restoring_stiffness(constants, Z, volts)) + PARAMETERS["cubic-stiffness.k3"] * Z**2


def study() -> Found:
    constants = law()
    assert isinstance(constants.law, AxialForce | SignChange)
    forces = np.array(np.broadcast_arrays(*axial_forces(constants.law, Z)))
    return Found(np.array([stiffness(constants, v) for v in VOLTS]), forces)


def steps(found: Found) -> tuple[float, float, float, float]:
    """Rise of the stiffness over ±2 µm and between 2 µm and 20 µm, spread by the drive at 20 µm, rise from 20 to 60 µm;
    N/m."""
    at = lambda z, v=1: float(np.interp(z, Z, found.stiffness[v]))
    outside = max(abs(at(20e-6) - at(2e-6)), abs(at(-20e-6) - at(-2e-6)))
    return at(2e-6) - at(-2e-6), outside, at(20e-6, 2) - at(20e-6, 0), at(60e-6) - at(20e-6)


def check(found: Found) -> str:
    sharp, outside, driven, large = steps(found)
    assert sharp > 3 * outside, (sharp, outside)
    assert driven > 0 and large > 0, (driven, large)
    left, right = found.forces[:, Z < -2e-6], found.forces[:, Z > 2e-6]
    # The paper speaks of one axial force; the two segments are bent the opposite way and carry opposite ones.
    assert np.all(left[1] < 0) and np.all(right[1] > 0) and np.all(left[0] > 0) and np.all(right[0] < 0)
    return (
        f"within ±2 µm of zero the stiffness rises by {sharp:.1f} N/m, from there to ±20 µm by {outside:.1f} N/m, "
        f"from 20 to 60 µm by {large:.1f} N/m; ±9 V move it by {driven:.1f} N/m. The root segment goes from "
        f"{1e3 * left[1].min():.0f} mN (compression) to {1e3 * right[1].max():.0f} mN (tension), the other one from "
        f"{1e3 * left[0].max():.0f} to {1e3 * right[0].min():.0f} mN"
    )


def draw(found: Found) -> Figure:
    figure, (a, b) = sheet("The stiffness jumps where the axial force of the root segment turns from push to pull", 2)
    for _volts, curve, shade in zip(VOLTS, found.stiffness, SHADES, strict=True):
        a.plot(1e6 * Z, curve, color=shade, lw=1.8)
    names(a, [(f"{volts:+g} V" if volts else "0 V", shade) for volts, shade in zip(VOLTS, SHADES, strict=True)][::-1])
    label(a, "displacement (µm)", "stiffness F/z (N/m)", "stiffness of the stage")
    b.axhline(0, color="#cccccc", lw=0.8)
    for force, name, colour in zip(
        found.forces, ("segment 1: corner to stage", "segment 2: root to corner"), (RESIDUAL, MODEL), strict=True
    ):
        b.plot(1e6 * Z, 1e3 * force, color=colour, lw=1.8)
        b.annotate(
            name, (58, 1e3 * force[-1]), (0, 5), textcoords="offset points", color=colour, fontsize=8, ha="right"
        )
    b.margins(y=0.2)
    label(
        b,
        "displacement (µm)",
        "axial force (mN)",
        "axial force of the two segments, tension positive",
    )
    return figure
