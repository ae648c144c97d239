"""What no library explains: coordinates, side, curve and formula are those of the hidden law, and it can be fitted."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline

import ident
from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import Case, draw
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.search.lacking import lacking
from ident.diagnosis.unknown.effect_file import write_effect
from ident.diagnosis.unknown.find import Unknown, find_unknown
from ident.effects.registry import registry
from ident.errors import UserError
from ident.fit import Fit, fit
from ident.model import Model
from ident.report.figures.style import png
from ident.report.figures.unknown import unknown_figure


def hidden(seed: int, *effects: str, **options: object) -> tuple[Case, Fit, Unknown]:
    case = draw(seed, effects, **{"size": 0.04, "noise": 0.005, "records": 4, "length": 800, **options})  # type: ignore[arg-type]
    campaign = campaign_of(case)
    fitted = fit(Model(campaign.device), campaign)
    return case, fitted, find_unknown(prepare(fitted))


@pytest.fixture(scope="module")
def root() -> Unknown:
    return hidden(40, "power-law-stiffness", detail="plain")[2]


def test_a_simple_law_is_found_to_the_letter(root):
    assert (root.side, root.coordinates) == ("force", ("z",))
    assert root.formula is not None and root.formula.text.endswith("z √|z|")


@pytest.mark.parametrize(
    ("effect", "side", "coordinates"),
    [
        ("voltage-damping", "force", ("v", "V")),
        ("sensor-nonlinearity", "sensor", ("z",)),
        ("prandtl-ishlinskii", "drive", ("V", "history")),
    ],
)
def test_side_and_coordinates_are_those_of_the_hidden_law(effect, side, coordinates):
    _, fitted, found = hidden(40, effect)
    assert (found.side, found.coordinates) == (side, coordinates)
    assert found.share > 0.98
    assert found.chi2_after < 1.1
    assert found.p_value < 1e-6
    assert found.as_json()["coordinates"] == list(coordinates)
    assert png(unknown_figure(found, fitted.model.device))[:4] == b"\x89PNG"


def test_the_curve_is_the_law_within_its_error_and_the_formula_has_its_coefficient():
    case, fitted, found = hidden(41, "cubic-stiffness", detail="plain")
    law = case.truth["laws"]["cubic-stiffness"]  # type: ignore[index]
    mass, omega = fitted.model.linear.mass, 2 * np.pi * case.device.frequency
    unit = case.device.unit
    force = lambda z: -law["coefficient"] * mass * omega**2 * unit * (z / unit) ** 3
    picture = found.picture
    assert picture.kind == "curve"
    # Both are known up to a straight line, which the stiffness absorbs.
    z = picture.grids[0]
    weight = 1 / picture.error
    both = np.stack([picture.value - force(z), z / z[-1]])
    line = np.linalg.lstsq((weight * both[1])[:, None], weight * both[0], rcond=None)[0]
    apart = (both[0] - line * both[1]) * weight
    assert np.sqrt(np.mean(apart**2)) < 2.5
    assert found.formula is not None and found.formula.complete
    assert found.formula.text.endswith("z³")
    coefficient = float(found.formula.coefficients[0])
    assert coefficient == pytest.approx(force(1.0), rel=0.02)
    assert abs(coefficient - force(1.0)) < 6 * found.formula.errors[0]


@pytest.mark.parametrize("effect", ["sine-force", "creep"])
def test_what_was_found_is_written_loaded_and_fitted(effect, tmp_path: Path):
    _, fitted, found = hidden(42, effect)
    file = tmp_path / "runs" / "missing.py"  # in a folder that is not there yet
    write_effect(found, file, "unknown-effect")
    written = registry([file])["unknown-effect"]
    again = fit(fitted.model + written(), fitted.campaign)
    assert again.converged
    assert fitted.fitted.error_over_noise > 4
    assert again.fitted.error_over_noise < 1.1
    assert fitted.holdout is not None and again.holdout is not None
    assert again.holdout.error_over_noise < 1.3 < 3 < fitted.holdout.error_over_noise
    with pytest.raises(UserError, match="exists already"):
        write_effect(found, file, "unknown-effect")


def test_where_nothing_is_missing_chance_is_said_to_do_as_much():
    _, _, found = hidden(59, noise_kind="ar")  # slow noise, which functions of time follow well
    assert found.p_value > 1e-3
    assert "by chance" in " ".join(found.sentences)


def test_the_sentences_read_as_sentences(root):
    text = " ".join(root.sentences)
    assert "depends on the displacement z" in text
    assert all(sentence.endswith(".") and "  " not in sentence for sentence in root.sentences)
    assert not re.search(r"e[+-]0\d", text)


def test_a_name_that_is_none_is_refused(root, tmp_path: Path):
    with pytest.raises(UserError, match="no name of an effect"):
        write_effect(root, tmp_path / "x.py", "My Effect")


@pytest.mark.parametrize(
    ("push", "word", "number"),
    [(lambda u: 1.7 * np.tanh(u / 1.7), "tanh", 1.7), (lambda u: u - np.clip(u, -0.43, 0.43), "clip", 0.43)],
    ids=["an amplifier at its limit", "a drive with a dead zone"],
)
def test_numbers_of_a_formula_are_sought_between_those_of_a_grid(push, word, number):
    time, rng, w, records = np.arange(1200) / 600, np.random.default_rng(3), 2 * np.pi * 33.0, []
    for size in (1.0, 2.0):
        tones = rng.uniform(3, 60, 20)
        drive = np.sum(np.sin(2 * np.pi * np.outer(tones, time) + rng.uniform(0, 6.3, (20, 1))), axis=0)
        drive *= size / np.std(drive)
        seen = make_interp_spline(time, drive)
        law = lambda t, y, seen=seen: [y[1], w * w * (push(seen(t)) - y[0]) - w / 12 * y[1]]
        z = solve_ivp(law, (0, time[-1]), [0, 0], t_eval=time, rtol=1e-7, atol=1e-9, max_step=1 / 600).y[0]
        z = z + rng.normal(0, 0.003 * np.std(z), len(time))
        records.append({"data": {"time": time, "drive": drive, "response": z}, "start": "rest"})
    found = find_unknown(prepare(ident.fit({"device": {"kind": "oscillator"}, "record": records}, effects=())))
    assert (found.side, found.coordinates) == ("drive", ("V",))
    assert found.formula is not None and found.formula.complete and len(found.formula.terms) == 1
    (term,) = found.formula.terms
    assert term.text.startswith(word) and term.number is not None
    assert term.number.value == pytest.approx(number, rel=0.05)


def test_a_law_that_turns_to_and_fro_is_found_with_its_phase():
    """Cogs: eight turns over the range of the motion, micrometres, no cog at rest."""
    rng, w, length, records = np.random.default_rng(5), 2 * np.pi * 475.0, 6.4e-6, []
    cogs = lambda z: 0.097e-6 * w * w * np.sin(2 * np.pi * z / length + 0.9)
    for volts, hertz in ((1.5, 431.0), (2.1, 470.0), (0.4, 505.0)):
        time = np.arange(1500) / 15e3
        push = lambda t, volts=volts, hertz=hertz: 0.3e-6 * w * w * volts * np.sin(2 * np.pi * hertz * t)
        law = lambda t, y, push=push: [y[1], push(t) - w * w * y[0] - w / 42 * y[1] - cogs(y[0])]
        z = solve_ivp(law, (0, time[-1]), [0, 0], t_eval=time, rtol=1e-8, atol=1e-13, max_step=1 / 15e3).y[0]
        drive = volts * np.sin(2 * np.pi * hertz * time)
        data = {"time": time, "drive": drive, "response": z + rng.normal(0, 0.01 * np.std(z), len(time))}
        records.append({"data": data, "units": {"response": "m"}, "start": "rest"})
    found = find_unknown(prepare(ident.fit({"record": records}, effects=())))
    assert (found.side, found.coordinates) == ("force", ("z",)) and found.chi2_after < 1.1
    assert found.formula is not None and found.formula.complete
    assert {term.text.split("(")[0] for term in found.formula.terms} == {"sin", "cos"}
    for term in found.formula.terms:
        assert term.number is not None and term.number.value == pytest.approx(length / (2 * np.pi), rel=0.01)


def test_beside_sweeps_it_is_asked_of_the_traces_alone():
    data = Path(__file__).parents[2] / "data"
    traces, sweeps = (ident.read_campaign(data / name) for name in ("platform_317hz", "platform_sweeps"))
    both = replace(traces, records=(*traces.records[1:3], *sweeps.records[:1]))
    regression = prepare(fit(Model(both.device), both))
    found = find_unknown(regression)
    assert regression.plane is not None and len(regression.of_traces().residual) < len(regression.residual)
    assert found.share > 0.9
    assert lacking(regression, regression) > 0.9
