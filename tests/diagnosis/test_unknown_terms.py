"""Every term of a formula is the same in the regression and in the file that is written from it, and has its unit."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from ident.campaign.device import Oscillator
from ident.diagnosis.unknown.effect_file import effect_source
from ident.diagnosis.unknown.formula import Formula, goal
from ident.diagnosis.unknown.products import _LINEAR as LINEAR
from ident.diagnosis.unknown.products import _SIGN as SIGN
from ident.diagnosis.unknown.products import Product
from ident.diagnosis.unknown.splines import Size, plays, relaxed, sharp, splines
from ident.diagnosis.unknown.tables import _level
from ident.diagnosis.unknown.terms import Term, bumps, monomial, paired, remembered, single, table
from ident.effects.dependence import Side
from ident.effects.effect import AbstractEffect, Drive, State
from ident.effects.registry import registry

SIZES = {"z": Size(-2e-5, 1.8e-5, 2e-5), "v": Size(-0.06, 0.06, 0.06), "V": Size(-9.0, 9.0, 9.0),
         "dV": Size(-9.0, 9.0, 9.0), "t": Size(0.0, 0.04, 0.04)}  # fmt: skip
OMEGA = 3000.0


def loaded(side: Side, terms: list[Term], folder: Path) -> type[AbstractEffect]:
    coefficients = np.linspace(1.0, 2.0, len(terms))
    formula = Formula(side, tuple(terms), coefficients, coefficients, 1.0, 1.0, True, "F = …")
    file = folder / "written.py"
    file.write_text(effect_source(formula, "written"), encoding="utf-8")
    return registry([file])["written"]  # which checks the units


def at(k: int) -> dict[str, float]:
    part = np.random.default_rng(k).uniform(-0.9, 0.9, 5)
    names = ("z", "v", "V", "dV", "t")
    return {n: float(abs(p) if n == "t" else p) * SIZES[n].largest for n, p in zip(names, part, strict=True)}


def test_a_formula_need_not_follow_the_noise_that_splines_follow() -> None:
    """|z| left the noise floor, a table of twenty terms nine tenths of it: "no short formula says as much"."""
    regression: Any = SimpleNamespace(chi2=1660.0, n=1000)
    assert goal(regression, 885.0) <= 660.0
    assert goal(regression, 400.0) > 300.0  # above the floor all of it is asked for


@pytest.mark.parametrize("name", ["z", "v", "V", "dV", "t"])
def test_terms_of_one_coordinate_are_written_as_they_are(name, tmp_path):
    side: Side = "drive" if name in ("V", "dV") else "force"
    for terms in (single(name, SIZES[name]), table(name, SIZES[name], gauge=True)):
        assert_same(side, terms, loaded(side, terms, tmp_path))


@pytest.mark.parametrize("side", ["force", "drive"])
@pytest.mark.parametrize("factor", [LINEAR, SIGN])
def test_a_table_is_written_with_what_the_linear_part_has_of_it(side, factor, tmp_path):
    of, by = ("z", "v") if side == "force" else ("V", "dV")
    sizes = {name: size._replace(mostly=(0.8 * size.low, 0.7 * size.high)) for name, size in SIZES.items()}
    x = np.random.default_rng(5).uniform(-1, 1, (5, 1, 400))
    seen = [{name: part * SIZES[name].largest for name, part in zip(SIZES, x, strict=True)}]
    terms = Product(of, by, factor, 24).table(side, sizes, seen)
    assert_same(side, terms, loaded(side, terms, tmp_path))
    slanted = [_level(t, of, sizes[of], seen) for t in bumps(of, sizes[of], gauge=True, knots=12)]
    assert_same(side, slanted, loaded(side, slanted, tmp_path))
    text = (tmp_path / "written.py").read_text(encoding="utf-8")
    assert "slope = jnp.array" in text and max(map(len, text.splitlines())) < 120


@pytest.mark.parametrize("names", [("z", "v"), ("z", "V"), ("v", "t"), ("V", "dV")])
def test_terms_of_two_coordinates_are_written_as_they_are(names, tmp_path):
    terms = [monomial([]), *paired(*names)]
    assert_same("sensor", terms, loaded("sensor", terms, tmp_path))


def assert_same(side: Side, terms: list[Term], effect: type[AbstractEffect]) -> None:
    for k in range(2):
        x = at(k)
        state, drive = State(x["z"], x["v"]), Drive(x["V"], x["dV"] * OMEGA, OMEGA, 1.0)
        amplitudes = [p.name for p in effect.parameters if p.kind == "amplitude"]
        for term, own in zip(terms, amplitudes, strict=True):
            alone = effect(Oscillator(), **{a: float(a == own) for a in amplitudes})
            written = alone.drive((), drive, x["t"]) if side == "drive" else getattr(alone, side)(state, drive, x["t"])
            points = {n: np.array([[0.999, 1.0, 1.001]]) * value for n, value in x.items()}
            assert float(written) == pytest.approx(term.value(points)[0, 1], rel=2e-3, abs=1e-30), term.text


def test_terms_with_memory_are_written_with_their_hidden_states(tmp_path):
    terms = remembered("V", SIZES["V"], 2e-3)
    plays_of, late = ([t for t in terms if t.memory == kind] for kind in ("play", "late"))
    terms = [terms[0], plays_of[0], plays_of[-1], late[0], late[-1]]
    effect = loaded("drive", terms, tmp_path)(Oscillator())
    assert len(effect.state0()) == len(effect.hidden_units) == sum(bool(term.memory) for term in terms)
    step = 2e-6
    t = step * np.arange(6000)
    voltage, rate = 6 * np.sin(OMEGA * t), 6 * OMEGA * np.cos(OMEGA * t)
    amplitudes = [p.name for p in effect.parameters if p.kind == "amplitude"]

    def advance(hidden: tuple, now: tuple) -> tuple:
        drive = Drive(*now, OMEGA, 1.0)
        each = [effect.with_values(**{a: float(a == own) for a in amplitudes}) for own in amplitudes]
        forces = jnp.stack([one.drive(hidden, drive, 0.0) for one in each])
        rates = effect.rate(State(0.0, 0.0, hidden), drive, 0.0)
        return tuple(h + step * r for h, r in zip(hidden, rates, strict=True)), forces

    _, written = jax.lax.scan(advance, effect.state0(), (voltage, rate))
    place = {"V": voltage[None], "rate": rate[None], "step": np.array([step])}
    for term, found in zip(terms, np.asarray(written).T, strict=True):
        expected = term.value(place)[0]
        rounded = term.number.value if term.memory == "play" and term.number is not None else 0.0
        assert np.max(np.abs(found - expected)) < 0.03 * max(rounded, np.max(np.abs(expected))), term.text


def test_a_play_rests_until_it_is_dragged():
    long, short = np.array([0.0, 1.0, 0.5, -0.5, -2.0]), np.array([0.0, -1.0])
    found = plays([long, short], np.array([0.4]))
    assert found[0][0] == pytest.approx([0.0, 0.6, 0.6, -0.1, -1.6])
    assert found[1][0] == pytest.approx([0.0, -0.6])


def test_a_relaxation_follows_its_differential_equation():
    t = np.linspace(0, 1.0, 2001)
    found = relaxed(np.sin(9 * t)[None], np.array([t[1]]), 0.2)[0]
    slope = np.gradient(found, t)
    assert np.max(np.abs(0.2 * slope + found - np.sin(9 * t))[1:-1]) < 1e-5 + 0.2 * 9 * 2 * t[1]
    assert found[0] == 0.0


def test_splines_sum_to_one_and_a_step_keeps_its_impulse():
    x = np.linspace(-3.0, 4.0, 50)[None]
    assert np.sum(splines(x, Size(-2.0, 2.0, 2.0), 9), axis=0) == pytest.approx(np.ones((1, 50)))
    weights = np.where(np.arange(101) % 2 == 0, 2.0, 4.0) / 6  # of the Runge–Kutta method
    for shift in (0.0, 0.3, 0.8):
        path = np.linspace(-5.0, 5.0, 101) + 0.1 * shift
        impulse = float(weights[1:-1] @ sharp(path)[1:-1])
        assert impulse == pytest.approx(shift, abs=1e-6)
