"""What refines a law is held at its usual value, and free where the records clearly choose that."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import lsim

import ident
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.ranking.confirm import confirm
from ident.diagnosis.ranking.look import first_look
from ident.diagnosis.ranking.score import score
from ident.diagnosis.ranking.starts import all_free, refinements
from ident.effects.registry import built_in
from tests.effects.test_drive import plays

NAME = "prandtl-ishlinskii"
ORDERS = {f"{NAME}.order_{k}" for k in range(2, 6)}
TIME = np.arange(2400) / 20e3
OMEGA, QUALITY, GAIN, NOISE = 2 * np.pi * 500.0, 30.0, 2.0, 2e-9


def _refitted(records, name, noise):
    fitted = ident.fit(records, (), start="rest", noise=noise)
    regression, effect = prepare(fitted), built_in()[name]
    (candidate, *_) = score(regression, {name: effect})
    return regression, confirm(regression, effect, candidate)


def _confirmed(widths, weights):
    """Of a linear oscillator by SciPy behind exact plays of own widths and weights."""
    rng, records = np.random.default_rng(3), {}
    for level, tone in ((3.0, 470.0), (5.5, 317.0), (8.0, 505.0)):
        drive = level * np.sin(2 * np.pi * tone * TIME) * (1 - 0.4 * TIME / TIME[-1])
        bent = drive + sum(w * plays(drive, r) for w, r in zip(weights, widths, strict=True))
        system = ([GAIN * 1e-8 * OMEGA**2], [1.0, OMEGA / QUALITY, OMEGA**2])
        moved = lsim(system, bent, TIME)[1] + NOISE * rng.standard_normal(len(TIME))
        records[f"{tone:.0f}"] = {"time (s)": TIME, "drive (V)": drive, "z (m)": moved}
    return _refitted(records, NAME, "2 nm")


def test_weights_that_no_straight_line_follows_are_free():
    regression, found = _confirmed((0.4, 1.2, 2.6, 4.4), (0.03, 0.11, 0.02, 0.08))
    assert found.model.freed >= ORDERS
    assert found.chi2 < 1.3 * regression.n


def test_equal_weights_need_no_refinement():
    _, found = _confirmed(tuple(0.5 * k - 0.25 for k in range(1, 13)), (0.02,) * 12)
    assert not found.model.freed & ORDERS
    names = [p.name for p in found.model.parameters]
    assert all(found.values[names.index(name)] == 0.0 for name in ORDERS)


# An oscillator of 1.3 Hz in m: acceleration by (z, v, V).
W, DAMPED = 2 * np.pi * 1.3, 2 * np.pi * 1.3 / 6.0


def _magnet(z, v, u):
    """A magnet at 0.2 m below: the linear part of its force is the spring itself."""
    return 2.0 * u - DAMPED * v - W**2 * 0.1 * (1 - (1 + z / 0.2) ** -2)


def _coil(z, v, u):
    """A coil off the middle of its gap, which brakes by its own voltage."""
    own = 1 + 2.5 * z - 120 * z**2
    return 2.0 * own * u - 0.4 * DAMPED * v - 0.6 * DAMPED * own**2 * v - W**2 * z


def _drive(t, level, tone):
    return level * (np.sin(2 * np.pi * tone * t) + 0.7 * np.sin(2 * np.pi * 2.13 * tone * t + 1.0))


def _measured(law, levels):
    rng, time, records = np.random.default_rng(5), np.arange(1500) / 60.0, {}
    for level, tone in zip(levels, (0.9, 1.25, 0.6), strict=True):

        def rate(t, y, level=level, tone=tone):
            return [y[1], law(y[0], y[1], _drive(t, level, tone))]

        moved = solve_ivp(rate, (0, time[-1]), [0.0] * 2, "LSODA", time, rtol=1e-8, atol=1e-10, max_step=0.02).y[0]
        told = {"time (s)": time, "drive (V)": _drive(time, level, tone)}
        records[f"{tone}"] = {**told, "z (m)": moved + 1e-4 * rng.standard_normal(len(time))}
    return records


@pytest.mark.parametrize(
    ("law", "levels", "name", "told"),
    [
        (_magnet, (0.7, 0.35, 0.5), "quadratic-stiffness", {"nearness": 5.0}),
        (_coil, (1.0, 0.6, 1.2), "force-factor", {}),
    ],
)  # fmt: skip
def test_a_law_covers_its_family_by_what_refines_it(law, levels, name, told):
    regression, found = _refitted(_measured(law, levels), name, "0.1 mm")
    assert found.model.freed
    assert found.chi2 < 1.2 * regression.n
    values = dict(zip((p.name for p in found.model.parameters), found.values, strict=True))
    for parameter, value in told.items():
        assert values[f"{name}.{parameter}"] == pytest.approx(value, rel=0.05)


def test_an_effect_is_scored_with_what_refines_it():
    effect = built_in()[NAME]
    free = {p.name: p.fitted for p in all_free(effect)().declared()}
    assert all(free.values()) and [*free] == [p.name for p in effect().declared()]
    assert not any(p.fitted for p in effect().declared() if p.refines)


@pytest.mark.parametrize("name", [name for name, effect in built_in().items() if refinements(effect)])
def test_a_law_with_all_its_numbers_has_them_where_its_program_reads_them(name):
    effect = built_in()[name]
    assert [p.name for p in all_free(effect).parameters] == [p.name for p in effect.parameters]


def _near_magnet(z, v, u):
    """A magnet 6 mm above a mass of 21.8 Hz on a shaker, that pulls: an even law and an odd one at once."""
    w, d = 2 * np.pi * 21.8, 6e-3
    return -u - w / 34 * v - w**2 * z + 0.05 * w**2 * d**3 * ((d - z) ** -2 - d**-2)


def test_a_law_whose_plain_form_explains_nothing_is_asked_for_with_its_finer_numbers():
    """Along the measured motion of a resonance its square is as good as nothing: it shifts a mean that is free."""
    rng, time, records = np.random.default_rng(8), np.arange(2000) / 500.0, {}
    for level, tone in ((0.9, 19.5), (1.5, 20.2), (1.2, 18.6)):
        base = lambda t, a=level, f=tone: a * np.sin(2 * np.pi * f * t) * np.minimum(t, 1.0)
        rate = lambda t, y, base=base: [y[1], _near_magnet(y[0], y[1], base(t))]
        moved = solve_ivp(rate, (0, time[-1]), [0.0] * 2, "DOP853", time, rtol=1e-8, atol=1e-12).y[0]
        told = {"time (s)": time, "base (m/s^2)": base(time)}
        records[f"{tone}"] = {**told, "z (mm)": 1e3 * moved + 5e-3 * rng.standard_normal(len(time))}
    fitted = ident.fit(records, (), start="rest", noise="5 um")
    look = first_look(fitted, built_in(), lambda _: None)
    (found,) = [one for one in look.tried if one.candidate.name == "quadratic-stiffness"]
    values = dict(zip((p.name for p in found.model.parameters), found.values, strict=True))
    assert found.chi2 < 1.1 * look.regression.n
    assert values["quadratic-stiffness.nearness"] == pytest.approx(-1 / 6e-3, rel=0.03)
