"""What refines a law is held at its usual value, and free where the records clearly choose that."""

from __future__ import annotations

import numpy as np
from scipy.signal import lsim

import ident
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.ranking.confirm import confirm
from ident.diagnosis.ranking.score import score
from ident.diagnosis.ranking.starts import all_free
from ident.effects.registry import built_in
from tests.effects.test_drive import plays

NAME = "prandtl-ishlinskii"
ORDERS = {f"{NAME}.order_{k}" for k in range(2, 6)}
TIME = np.arange(2400) / 20e3
OMEGA, QUALITY, GAIN, NOISE = 2 * np.pi * 500.0, 30.0, 2.0, 2e-9


def _confirmed(widths, weights):
    """Of a linear oscillator by SciPy behind exact plays of own widths and weights."""
    rng, records = np.random.default_rng(3), {}
    for level, tone in ((3.0, 470.0), (5.5, 317.0), (8.0, 505.0)):
        drive = level * np.sin(2 * np.pi * tone * TIME) * (1 - 0.4 * TIME / TIME[-1])
        bent = drive + sum(w * plays(drive, r) for w, r in zip(weights, widths, strict=True))
        system = ([GAIN * 1e-8 * OMEGA**2], [1.0, OMEGA / QUALITY, OMEGA**2])
        moved = lsim(system, bent, TIME)[1] + NOISE * rng.standard_normal(len(TIME))
        records[f"{tone:.0f}"] = {"time (s)": TIME, "drive (V)": drive, "z (m)": moved}
    fitted = ident.fit(records, (), start="rest", noise="2 nm")
    regression, effect = prepare(fitted), built_in()[NAME]
    (candidate, *_) = score(regression, {NAME: effect})
    return regression, confirm(regression, effect, candidate)


def test_weights_that_no_straight_line_follows_are_free():
    regression, found = _confirmed((0.4, 1.2, 2.6, 4.4), (0.03, 0.11, 0.02, 0.08))
    assert found.model.freed >= ORDERS
    assert found.chi2 < 1.3 * regression.n


def test_equal_weights_need_no_refinement():
    _, found = _confirmed(tuple(0.5 * k - 0.25 for k in range(1, 13)), (0.02,) * 12)
    assert not found.model.freed & ORDERS
    names = [p.name for p in found.model.parameters]
    assert all(found.values[names.index(name)] == 0.0 for name in ORDERS)


def test_an_effect_is_scored_with_what_refines_it():
    effect = built_in()[NAME]
    free = {p.name: p.fitted for p in all_free(effect)().declared()}
    assert all(free.values()) and free.keys() == {p.name for p in effect().declared()}
    assert not any(p.fitted for p in effect().declared() if p.refines)
