"""A function of one coordinate times another: which varies with which is told, and how; it can be fitted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline

import ident
from ident.diagnosis.evidence.enough import speaks_for
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.unknown.effect_file import write_effect
from ident.diagnosis.unknown.find import as_table, find_unknown
from ident.diagnosis.unknown.products import products
from ident.diagnosis.unknown.simulated import curve_of
from ident.diagnosis.unknown.splines import Size
from ident.effects.registry import registry
from ident.report.figures.style import png
from ident.report.figures.unknown import unknown_figure

W, NOISE, RATE = 2 * np.pi * 33.0, 0.003, 900.0
_Law = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]


def brake(z: np.ndarray) -> np.ndarray:
    """A brake at one side of a motion of ±10, as a part of the damping of quality one."""
    return 0.1 * np.exp(-(((z - 2.0) / 2.0) ** 2))


def softer(voltage: np.ndarray) -> np.ndarray:
    """A stiffness that a bias lowers, up to where it saturates; as a part."""
    return 0.12 / (1 + np.exp(-3.0 * (voltage - 0.5)))


NAMES = {"v": ("v",), "z": ("z",), "sign(v)": ("sign(v)", "tanh(v/w)")}  # a noisy velocity blurs where a sign turns
LAWS: dict[str, tuple[_Law, str, str, Callable[[np.ndarray], np.ndarray]]] = {
    "v": (lambda z, v, voltage: -W * brake(z) * v, "z", "N s/m", lambda z: -W * brake(z)),
    "z": (lambda z, v, voltage: W * W * softer(voltage) * z, "V", "N/m", lambda u: W * W * softer(u)),
    "sign(v)": (lambda z, v, voltage: -W * W * (0.02 + 0.5 * brake(z)) * np.tanh(v / (1e-3 * W)), "z", "N",
                lambda z: -W * W * (0.02 + 0.5 * brake(z))),
}  # fmt: skip


def decays(law: _Law) -> ident.Campaign:
    """Three free decays of the same oscillator."""
    time, rng, records = np.arange(900) / RATE, np.random.default_rng(12), []
    for begin in (3.0, 6.0, 9.0):
        rate = lambda t, y: [y[1], -W * W * y[0] - W / 15 * y[1] + law(y[0], y[1], np.zeros(1)[0])]
        z = solve_ivp(rate, (0, time[-1]), [begin, 0], t_eval=time, rtol=1e-8, atol=1e-10, max_step=0.5 / RATE).y[0]
        z = z + rng.normal(0, NOISE * np.std(z), len(time))
        records.append({"data": {"time": time, "response": z}, "drive": "none"})
    return ident.read_campaign({"device": {"kind": "oscillator"}, "record": records})


def sines(law: _Law) -> ident.Campaign:
    """Steady sines of an oscillator of unit mass by SciPy, which begin at rest."""
    time, rng, records = np.arange(1500) / RATE, np.random.default_rng(13), []
    for tone, size in ((24.0, 1.0), (31.5, 0.7), (33.0, 0.5), (34.5, 0.8), (38.0, 1.0)):
        drive = size * np.sin(2 * np.pi * tone * time)
        seen = lambda t, a=size, hz=tone: a * np.sin(2 * np.pi * hz * t)
        rate = lambda t, y, seen=seen: [y[1], W * W * (seen(t) - y[0]) - W / 15 * y[1] + law(y[0], y[1], seen(t))]
        z = solve_ivp(rate, (0, time[-1]), [0, 0], t_eval=time, rtol=1e-8, atol=1e-10, max_step=0.5 / RATE).y[0]
        z = z + rng.normal(0, NOISE * np.std(z), len(time))
        records.append({"data": {"time": time, "drive": drive, "response": z}, "start": "rest"})
    return ident.read_campaign({"device": {"kind": "oscillator"}, "record": records})


def campaign(law: _Law) -> ident.Campaign:
    """Three records of an oscillator of unit mass by SciPy, multisines about its resonance."""
    time, rng, records = np.arange(1800) / RATE, np.random.default_rng(11), []
    for size in (0.5, 1.0, 1.8):
        tones = rng.uniform(3, 60, 24)
        drive = np.sum(np.sin(2 * np.pi * np.outer(tones, time) + rng.uniform(0, 6.3, (24, 1))), axis=0)
        drive *= size / np.std(drive)
        seen = make_interp_spline(time, drive)
        rate = lambda t, y, seen=seen: [y[1], W * W * (seen(t) - y[0]) - W / 15 * y[1] + law(y[0], y[1], seen(t))]
        z = solve_ivp(rate, (0, time[-1]), [0, 0], t_eval=time, rtol=1e-7, atol=1e-9, max_step=0.5 / RATE).y[0]
        z = z + rng.normal(0, NOISE * np.std(z), len(time))
        records.append({"data": {"time": time, "drive": drive, "response": z}, "start": "rest"})
    return ident.read_campaign({"device": {"kind": "oscillator"}, "record": records})


@pytest.mark.parametrize("factor", LAWS)
def test_what_varies_with_what_and_how(factor: str, tmp_path: Path):
    law, of, unit, truth = LAWS[factor]
    fitted = ident.fit(campaign(law), effects=())
    found = find_unknown(prepare(fitted))
    assert found.side == "force" and found.product is not None
    assert found.product.of == of and found.product.name in NAMES[factor]
    assert found.chi2_after < 1.1 and found.of_one_law
    assert f"{found.product.name} times a function of" in found.sentences[0]

    picture = found.picture
    assert (picture.kind, picture.names, picture.unit) == ("factor", (of,), unit)
    height = np.ptp(truth(picture.grids[0]))
    known = picture.error < 0.1 * height
    off = (picture.value - truth(picture.grids[0]))[known]
    off -= np.mean(off) if found.product.factor.linear else 0.0  # the model has the factor times a constant already
    assert np.mean(known) > 0.5
    assert np.sqrt(np.mean(off**2)) < 0.1 * height
    assert png(unknown_figure(found, fitted.campaign.device))[:4] == b"\x89PNG"

    path = tmp_path / "varying.py"
    write_effect(found, path, "varying")
    last = ident.add(ident.fit(campaign(law), effects=()), registry((path,))["varying"])
    assert last.fitted.error_over_noise < 1.05

    effect = last.model.bind(last.values)[1][-1]
    law = curve_of(effect, found, constant=False)
    assert law is not None
    often = picture.error < 0.03 * height  # elsewhere a formula runs on as it will, which the figure shows
    off = (law - truth(picture.grids[0]))[often]
    off -= np.mean(off) if found.product.factor.linear else 0.0
    assert np.sqrt(np.mean(off**2)) < 0.15 * height
    drawn = unknown_figure(found, fitted.campaign.device, law)
    assert [text.get_text() for text in drawn.texts][-2:] == ["as simulated and fitted", "along the measured motion"]


def test_many_splines_of_one_coordinate_do_not_hide_a_product():
    """Under sines a hundred turns over the displacement say all that any force does, and were told in its place."""
    found = find_unknown(prepare(ident.fit(sines(lambda z, v, u: -W * W * 0.01 * z * z * u), effects=())))
    assert found.product is not None and (found.product.of, found.product.name) == ("z", "V")
    assert found.formula is not None and found.formula.text.endswith(" z² V") and len(found.formula.terms) == 1


def test_a_formula_runs_on_beyond_the_records_and_its_table_goes_on_level():
    """Friction that depends on the place, held out further than it was fitted: z² of it was four noise floors off."""
    regression = prepare(ident.fit(campaign(LAWS["v"][0]), effects=()))
    found = find_unknown(regression)
    assert found.formula is not None
    table = as_table(regression, replace(found, formula=found.formula._replace(tabled=False)))
    assert table is not None and table.formula is not None
    assert table.formula.tabled and table.chi2_after < 1.1
    assert "g from" in table.sentences[-1]
    assert as_table(regression, table) is None
    beyond = {"z": np.array([1.5, 3.0]) * regression.fit.scales.displacement, "v": np.ones(2)}
    assert np.ptp(table.formula.coefficients @ np.stack([t.value(beyond) for t in table.formula.terms])) < 1e-9


def test_in_free_decays_nothing_is_multiplied_by_a_drive_that_there_was_not():
    found = find_unknown(prepare(ident.fit(decays(LAWS["v"][0]), effects=())))
    assert found.side == "force" and found.product is not None
    assert (found.product.name, found.product.of) == ("v", "z")
    assert found.chi2_after < 1.2


def test_a_coordinate_that_never_moves_is_in_no_product():
    still, moving = Size(2.0, 2.0, 2.0, mostly=(2.0, 2.0)), Size(-1.0, 1.0, 1.0, mostly=(-0.9, 0.9))
    assert not list(products("z", "V", {"z": moving, "V": still}))
    assert {one.by for one in products("z", "V", {"z": moving, "V": moving})} == {"z", "V"}


def test_excerpts_speak_for_whole_records_only_where_these_are_explained_too():
    whole, part = (SimpleNamespace(fitted=SimpleNamespace(error_over_noise=e)) for e in (5.0, 1.0))
    regression = SimpleNamespace(fit=part, chi2=1010.0, n=1000)
    assert not speaks_for(regression, whole)  # type: ignore[arg-type]
    assert speaks_for(regression, part)  # type: ignore[arg-type]
