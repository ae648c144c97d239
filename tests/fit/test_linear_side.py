"""What a linear model is completed with is asked of the effects: one of the user's own counts as the library's do."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from textwrap import dedent

import numpy as np
import pytest

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.effects.linear_side import constant_on, further_modes
from ident.effects.registry import built_in, registry
from ident.fit.linear.choice import side_of_constant
from ident.fit.linear.one_tone import hold_gain
from ident.fit.linear.start_model import modes_of, start_model
from ident.model import build_model
from tests.fit.test_linear_choice import SYSTEMS, record

OWN = '''
"""A zero of the sensor, and two modes."""
from ident.effects import AbstractEffect, amplitude
from ident.effects.library.second_mode import SecondMode


class MyZero(AbstractEffect):
    """reading = z + z_0."""

    name = "my-zero"
    is_constant = True
    zero = amplitude("m", "zero")

    def sensor(self, state, drive, t):
        return self.zero


class SeventhMode(SecondMode):
    """Another mode."""

    name = "seventh-mode"
    needs = "sixth-mode"
    further_mode = 7


class MySecondMode(SecondMode):
    """As the library's, of which it inherits its number."""

    name = "my-second-mode"
'''
LIBRARY = ("second-mode", "third-mode", "fourth-mode", "fifth-mode", "sixth-mode")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "my_effect.py"
    path.write_text(dedent(OWN), encoding="utf-8")
    return path


def test_the_library_says_what_belongs_to_a_linear_device() -> None:
    assert further_modes(built_in()) == LIBRARY
    wanted = {"oscillator": "sensor-offset", "no-spring": "static-force"}
    for form, name in wanted.items():
        constant = constant_on(side_of_constant(form), built_in())
        assert constant is not None and constant.name == name
    assert constant_on("sensor", {"static-force": built_in()["static-force"]}) is None


def test_modes_of_ones_own_come_after_the_librarys(file: Path) -> None:
    assert modes_of(Campaign("", (), Oscillator(), effect_files=(file,))) == (*LIBRARY, "seventh-mode")


def test_a_constant_of_ones_own_is_not_doubled(file: Path) -> None:
    records = (record(SYSTEMS["oscillator"], 5.0),)
    assert start_model(Campaign("", records, Oscillator())).names == ("sensor-offset",)
    campaign = Campaign("", records, Oscillator(), effects=("my-zero",), effect_files=(file,))
    assert start_model(campaign).names == ("my-zero",)
    constant = constant_on("sensor", {"my-zero": registry([file])["my-zero"]})
    assert constant is not None and constant.name == "my-zero"


def test_a_mode_of_ones_own_is_another_mode(file: Path) -> None:
    records = (record(SYSTEMS["oscillator"]),)
    campaign = Campaign("", records, Oscillator(), effects=("my-second-mode",), effect_files=(file,))
    assert start_model(campaign).names == ("my-second-mode",)
    still = replace(records[0], drive=np.zeros(3000))
    gains = {"oscillator.gain", "my-second-mode.travel"}
    assert hold_gain(build_model(campaign), [still]).undetermined == gains
    assert not hold_gain(build_model(campaign), records).undetermined
