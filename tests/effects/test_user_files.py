"""An effect in a file of the user's own: found, simulated, and every mistake answered with its place."""

from __future__ import annotations

from pathlib import Path
from textwrap import dedent

import numpy as np
import pytest

from ident.campaign.device import Oscillator
from ident.effects.dimensions import check_units
from ident.effects.effect import AbstractEffect, amplitude, choice
from ident.effects.registry import built_in, find, registry
from ident.errors import UserError
from tests.effects.harness import STIFFNESS, Physics, assert_agrees

GOOD = '''
"""A stiffening by the fifth power."""
from ident.effects.effect import AbstractEffect, amplitude


class QuinticStiffness(AbstractEffect):
    """F = −k5 z⁵."""

    name = "fifth-power-spring"
    k5 = amplitude("N/m^5", "fifth-power spring")

    def force(self, state, drive, t):
        return -self.k5 * state.z**5
'''


def write(folder: Path, text: str) -> Path:
    file = folder / "my_effect.py"
    file.write_text(dedent(text), encoding="utf-8")
    return file


def answer(folder: Path, text: str) -> UserError:
    with pytest.raises(UserError) as caught:
        registry([write(folder, text)])
    return caught.value


def line_of(text: str, part: str) -> int:
    return next(i for i, line in enumerate(dedent(text).splitlines(), 1) if part in line)


def test_an_effect_outside_the_package_is_found_and_simulated(tmp_path):
    known = registry([write(tmp_path, GOOD)])
    assert set(known) == set(built_in()) | {"fifth-power-spring"}
    k5 = 0.2 * STIFFNESS / 625e-24
    effect = find("fifth-power-spring", known)(Oscillator(), k5=k5)
    assert_agrees(effect, Physics(lambda t, z, v, h: -k5 * z**5), 1e-5)


def test_the_library_is_not_changed_by_a_users_file(tmp_path):
    registry([write(tmp_path, GOOD)])
    assert "fifth-power-spring" not in built_in()


def test_a_wrong_unit_is_caught_with_the_formula_and_the_line(tmp_path):
    text = GOOD.replace('"N/m^5"', '"N/m^3"')
    error = answer(tmp_path, text)
    assert "force" in error.what and "k5 in N/m^3" in error.what
    assert error.where.endswith(f"my_effect.py, line {line_of(text, 'class Quintic')}")
    assert error.do


def test_a_unit_that_does_not_exist_is_caught(tmp_path):
    error = answer(tmp_path, GOOD.replace('"N/m^5"', '"N/furlongs_of_mine"'))
    assert "fifth-power-spring.k5" in error.what


def test_a_number_with_a_hidden_unit_is_caught(tmp_path):
    error = answer(tmp_path, GOOD.replace("state.z**5", "state.z**5 * (1 + state.z / 1e-6)"))
    assert "does not come out in N" in error.what


@pytest.mark.parametrize(
    ("part", "instead", "says"),
    [
        ("return -self.k5", "return -self.k6", "k6"),
        ("class Quintic", "class class Quintic", "not valid Python"),
        ("from ident.effects.effect", "from ident.nowhere", "nowhere"),
    ],
)
def test_a_mistake_in_the_file_is_answered_with_its_line(tmp_path, part, instead, says):
    text = GOOD.replace(part, instead)
    error = answer(tmp_path, text)
    assert says in error.what
    assert error.where.endswith(f"line {line_of(text, instead)}")


def test_a_taken_name_a_missing_file_and_an_empty_file(tmp_path):
    taken = answer(tmp_path, GOOD.replace("fifth-power-spring", "cubic-stiffness"))
    assert "taken" in taken.what and "line" in taken.where
    assert "no effect is defined" in answer(tmp_path, "x = 1\n").what
    with pytest.raises(UserError, match="does not exist"):
        registry([tmp_path / "absent.py"])


def test_an_effect_may_build_on_one_of_the_same_file_that_stands_above(tmp_path):
    builder = GOOD.replace("QuinticStiffness", "Builder").replace('= "fifth', '= "builder"\n    needs = "fifth')
    builder = builder.replace("-self.k5 * state.z", "-(self.partner.k5 + self.k5) * state.z")
    known = registry([write(tmp_path, GOOD + builder)])
    assert known["builder"].needs == "fifth-power-spring" in known
    for text in (builder, builder.replace("fifth-power-spring", "cubic"), builder + GOOD):
        error = answer(tmp_path, text)
        assert "builds on" in error.what and "defined above" in error.do
        assert error.where.endswith(f"line {line_of(text, 'class Builder')}")


def test_a_name_that_nobody_has_is_answered_with_the_nearest():
    with pytest.raises(UserError, match="cubic-stiffness"):
        find("cubic-stifness", built_in())


def test_hidden_states_must_match_their_units(tmp_path):
    text = GOOD + (
        "    def state0(self):\n        return (0.0, 0.0)\n\n"
        "    def rate(self, state, drive, t):\n        return (state.v,)\n"
    )
    assert "hidden" in answer(tmp_path, text).what


class _TwoLaws(AbstractEffect):
    """Right with its first choice, wrong with its second."""

    name = "two-laws"
    law = choice("right", "wrong")
    k = amplitude("N/m")

    def force(self, state, drive, t):
        return -self.k * (state.z if self.law == "right" else state.v)


class _FarAway(AbstractEffect):
    """Wrong where it acts, absent nearer to rest."""

    name = "far-away"
    k = amplitude("N/m")

    def force(self, state, drive, t):
        return -self.k * np.where(state.z < 0, state.z**2, 0.0)


@pytest.mark.parametrize("effect", [_TwoLaws, _FarAway])
def test_units_are_checked_for_every_choice_and_on_both_sides(effect):
    with pytest.raises(UserError, match="does not come out in N"):
        check_units(effect, built_in())
