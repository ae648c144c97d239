"""Finite elements against the three closures of `residual-stress`: `python -m experiments.closures.closures`.

The stiffness F/z of the stage over ±60 µm, for three ways in which the stage can be held in its plane, at the stress of
the nominal device, (90, 20, −10) MPa. The finite elements (data/fe_beam) have no in-plane shear and no mean force, so
neither has the frame here. Prints a table, asserts its numbers, draws closures.png beside this file.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.optimize import minimize_scalar

from ident import mechanics, runtime

HERE = Path(__file__).resolve().parent
CURVES = HERE.parents[1] / "data" / "fe_beam" / "force_displacement.csv"
L1, L2 = 2.4e-3, 2.8e-3
CLOSURES = ("frame", "axial-force", "sign-change")
WIDTH = 3e-6

# name in the data: (what it means, in_plane, beam_end)
HELD = {
    "clamped": ("held in plane", "clamped", (0.0, 0.0)),
    "rotz_c": ("free to turn about its centre", "yaw", (0.0, -1.5e-3)),
    "free": ("free in plane", "free", (0.0, 0.0)),
}


class Found(NamedTuple):
    """What the table shows for one way of holding the stage.

    `errors`: largest deviation over ±60 µm in % of the largest force, per closure with ρ = 1; `restraint`: the ρ with
    which "axial-force" comes closest, `fitted`: its error then, %; `asymmetry`: (F(60 µm) + F(−60 µm))/(F(60 µm) −
    F(−60 µm)) of the finite elements, of the frame and of "axial-force" with that ρ, %.
    """

    errors: dict[str, float]
    restraint: float
    fitted: float
    asymmetry: tuple[float, float, float]


EXPECTED = {
    "clamped": Found({"frame": 1.78, "axial-force": 15.65, "sign-change": 24.01}, 2.882, 6.54, (4.45, 4.86, 9.64)),
    "rotz_c": Found({"frame": 0.96, "axial-force": 10.82, "sign-change": 19.09}, 0.598, 12.63, (-6.15, -6.58, 2.62)),
    "free": Found({"frame": 0.03, "axial-force": 14.44, "sign-change": 4.44}, 0.002, 0.01, (0.0, 0.0, 0.01)),
}


def section() -> mechanics.Section:
    """The nominal section."""
    return mechanics.section(
        silicon_modulus=169e9,
        silicon_poisson=0.22,
        pzt_modulus=63e9,
        pzt_poisson=0.30,
        silicon_thickness=30e-6,
        pzt_thickness=17e-6,
        width=1e-3,
    )


def stage_force(z: np.ndarray, closure: mechanics.Closure, held: str, restraint: float = 1.0) -> np.ndarray:
    """Restoring force of the stage (four beams), N, at displacements z (n,) in m."""
    _, in_plane, beam_end = HELD[held]
    layers = section()
    # The stress (90, 20, −10) MPa without its mean force: the same moment from σ12 and σ23 that balance.
    moment = mechanics.residual_moment(layers, 70e6, 30e6, 20e6)
    balanced = mechanics.residual_moment(layers, 1.0, 17 / 30)
    sigma12 = float(moment / balanced)
    constants = mechanics.restoring(
        layers,
        L1,
        L2,
        sigma12=sigma12,
        sigma23=sigma12 * 17 / 30,
        restraint=restraint,
        width=WIDTH,
        closure=closure,
        in_plane=in_plane,
        beam_end=beam_end,
        shear=False,
    )
    return np.asarray(mechanics.restoring_force(constants, z))


def curves() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Displacement (m) and force on the stage (N) of the finite elements, per way of holding."""
    table = pd.read_csv(CURVES)
    table = table[table.kappa_multiple == 1]
    groups = {held: table[table.stage_constraint == held] for held in HELD}
    return {held: (g.z_m.to_numpy(), 4 * g.F_N_per_beam.to_numpy()) for held, g in groups.items()}


def error(force: np.ndarray, reference: np.ndarray) -> float:
    """Largest deviation in per cent of the largest force."""
    return float(100 * np.max(np.abs(force - reference)) / np.max(np.abs(reference)))


def asymmetry(force: np.ndarray) -> float:
    """Difference of the stiffness at the two ends over its sum, %."""
    return float(100 * (force[-1] + force[0]) / (force[-1] - force[0]))


def best_restraint(z: np.ndarray, reference: np.ndarray, held: str) -> float:
    """The ρ ≥ 0 with which "axial-force" comes closest in least squares."""

    def misfit(restraint: float) -> float:
        return float(np.sum((stage_force(z, "axial-force", held, restraint) - reference) ** 2))

    return float(minimize_scalar(misfit, bounds=(0.0, 5.0), method="bounded", options={"xatol": 1e-5}).x)


def study() -> dict[str, Found]:
    """All numbers of the table, in the layout of EXPECTED."""
    found = {}
    for held, (z, reference) in curves().items():
        errors = {closure: error(stage_force(z, closure, held), reference) for closure in CLOSURES}
        restraint = best_restraint(z, reference, held)
        fitted = stage_force(z, "axial-force", held, restraint)
        leaning = (asymmetry(reference), asymmetry(stage_force(z, "frame", held)), asymmetry(fitted))
        found[held] = Found(errors, restraint, error(fitted, reference), leaning)
    return found


def check(found: dict[str, Found]) -> None:
    """Assert what the table and the figure show."""
    for held, expected in EXPECTED.items():
        got = found[held]
        for closure, value in expected.errors.items():
            assert abs(got.errors[closure] - value) < 0.02, (held, closure, got)
        assert abs(got.restraint - expected.restraint) < 0.01, (held, got)
        assert abs(got.fitted - expected.fitted) < 0.05, (held, got)
        assert np.allclose(got.asymmetry, expected.asymmetry, atol=0.05), (held, got)


def draw(found: dict[str, Found], path: Path) -> None:
    """Three panels of stiffness over displacement, errors in the legends."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    looks = {"frame": ("C0", "-"), "axial-force": ("C3", "--"), "sign-change": ("0.6", ":")}
    figure, axes = plt.subplots(1, 3, figsize=(12.5, 4.4), sharey=True, layout="constrained")
    for axis, (held, (z, reference)) in zip(axes, curves().items(), strict=True):
        moved = np.abs(z) > 1e-9
        axis.plot(z[moved] * 1e6, (reference / np.where(moved, z, 1.0))[moved], "ko", ms=4, label="finite elements")
        fine = np.linspace(-60e-6, 60e-6, 400)  # even count: never zero
        errors, restraint, fitted, _ = found[held]
        for closure in CLOSURES:
            colour, line = looks[closure]
            label = f"{closure}: off by {errors[closure]:.2g} %"
            axis.plot(fine * 1e6, stage_force(fine, closure, held) / fine, line, color=colour, lw=2, label=label)
        label = f"axial-force, best ρ = {restraint:.2g}: {fitted:.2g} %"
        axis.plot(fine * 1e6, stage_force(fine, "axial-force", held, restraint) / fine, "C1-", lw=1, label=label)
        axis.set_title(f"Stage {HELD[held][0]}")
        axis.set_xlabel("displacement from rest z (µm)")
        axis.legend(fontsize=8, loc="upper center")
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("stiffness of the stage F/z (N/m)")
    axes[0].set_ylim(540, 1000)
    claim = "Frame closure follows the finite elements; axial-force law leans the wrong way where the stage can turn"
    figure.suptitle(f"{claim}\n(residual stress 90, 20, −10 MPa; legends: largest error in force)")
    figure.savefig(path, dpi=90)
    plt.close(figure)


def main() -> None:
    """Print, assert, draw."""
    runtime.configure()
    found = study()
    print("largest error over ±60 µm, % of the largest force (ρ = 1); best ρ of axial-force; asymmetry F(60)+F(−60), %")
    for held, (errors, restraint, fitted, (true, frame, axial)) in found.items():
        row = "  ".join(f"{closure} {value:5.2f}" for closure, value in errors.items())
        leaning = f"finite elements {true:+.2f}, frame {frame:+.2f}, axial-force {axial:+.2f}"
        print(f"{HELD[held][0]:30s} {row}  ρ = {restraint:.3f} ({fitted:.2f} %)  {leaning}")
    check(found)
    draw(found, HERE / "closures.png")


if __name__ == "__main__":
    main()
