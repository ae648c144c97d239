"""Fig. 9: loops of Eq. 12 at 10 V for several η and ζ.

f(E) = d31 E − η E³ + (ζ/ω³) Ė³;  for E = E0 sin ωt the tip is d31 E0 − η E0³, the loop is open by 2 ζ E0³ at E = 0, and
its area is ∮ f dE = (3π/4) ζ E0⁴.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ident.mechanics import polynomial_strain
from ident.report.figures.style import HELDOUT, MODEL, RESIDUAL, label

from .nominal import PARAMETERS
from .sheet import Figure, names, sheet

FIELD = 10.0 / 17e-6  # V/m: 10 V on 17 µm
TIMES = (0.0, 1.0, 2.0)  # the nominal η, ζ
N = 720
COLOURS = (HELDOUT, MODEL, RESIDUAL)


class Found(NamedTuple):
    """Field (n,) V/m; strains by multiple of η (3, n) and of ζ (3, n)."""

    field: np.ndarray
    by_eta: np.ndarray
    by_zeta: np.ndarray


def study() -> Found:
    phase = 2 * np.pi * np.arange(N) / N
    field, rate = FIELD * np.sin(phase), FIELD * np.cos(phase)
    d31, eta, zeta = (PARAMETERS[n] for n in ("platform.d31", "pzt-hysteresis.eta", "pzt-hysteresis.zeta"))
    strain = lambda a, b: np.asarray(polynomial_strain(field, rate, 1.0, d31, a * eta, b * zeta))
    return Found(field, np.array([strain(k, 1.0) for k in TIMES]), np.array([strain(1.0, k) for k in TIMES]))


def area(found: Found, strain: np.ndarray) -> float:
    """∮ f dE by the trapezium rule on whole periods, exact for so few harmonics."""
    rate = FIELD * np.cos(2 * np.pi * np.arange(N) / N)
    return float(np.mean(strain * rate) * 2 * np.pi)


def check(found: Found) -> str:
    d31, eta, zeta = (PARAMETERS[n] for n in ("platform.d31", "pzt-hysteresis.eta", "pzt-hysteresis.zeta"))
    for k, by_eta, by_zeta in zip(TIMES, found.by_eta, found.by_zeta, strict=True):
        assert np.isclose(by_eta.max(), (d31 - k * eta * FIELD**2) * FIELD, rtol=0.02)
        assert np.isclose(by_zeta[0] - by_zeta[N // 2], 2 * k * zeta * FIELD**3, rtol=1e-9, atol=1e-18)
        assert np.isclose(area(found, by_zeta), 0.75 * np.pi * k * zeta * FIELD**4, rtol=1e-9, atol=1e-14)
        assert np.isclose(area(found, by_eta), 0.75 * np.pi * zeta * FIELD**4, rtol=1e-9)
        for strain in (by_eta, by_zeta):  # odd under half a period: no offset, no even harmonics
            assert np.allclose(strain + np.roll(strain, N // 2), 0, atol=1e-12 * np.max(strain))
    bent, opened = eta * FIELD**2 / d31, 2 * zeta * FIELD**2 / d31
    return (
        f"at 10 V the nominal η takes {100 * bent:.0f} % of the strain's tip, the nominal ζ opens the loop by "
        f"{100 * opened:.0f} % of it; every loop is odd"
    )


def draw(found: Found) -> Figure:
    figure, axes = sheet("η bends the loop, ζ opens it; both leave it symmetric about the origin", 2)
    for a, loops, name in zip(axes, (found.by_eta, found.by_zeta), ("η", "ζ"), strict=True):
        for _k, strain, colour in zip(TIMES, loops, COLOURS, strict=True):
            around = np.append(np.arange(N), 0)
            a.plot(1e-6 * found.field[around], 1e6 * strain[around], color=colour, lw=1.6)
        names(a, [(f"{k:g} {name}", colour) for k, colour in zip(TIMES, COLOURS, strict=True)])
        label(a, "field E (V/µm)", "strain f(E) (10⁻⁶)", f"10 V, {name} changed")
    return figure
