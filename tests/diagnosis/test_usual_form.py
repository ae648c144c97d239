"""A shape that is as its textbook has it is no number that records had to tell."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.campaign.device import Oscillator
from ident.diagnosis.ranking.usual_form import numbers_told
from ident.effects.library.bouc_wen_drive import BoucWenDrive
from ident.model import Model

N = 600
ROWS = np.random.default_rng(5).standard_normal((7, N))
PRICE = np.log(N)


def told(sharpness: float, fullness: float, errors: tuple[float, float]) -> float:
    """Numbers of a loop in the drive whose two shapes without a unit have these standard errors."""
    model = Model(Oscillator(), (BoucWenDrive(),))
    names = [p.name.rpartition(".")[2] for p in model.parameters]
    values = np.ones(len(names))
    values[[names.index("sharpness"), names.index("fullness")]] = sharpness, fullness
    rows = np.linalg.qr(ROWS.T)[0].T
    rows[names.index("sharpness")] /= errors[0]
    rows[names.index("fullness")] /= errors[1]
    evaluation = SimpleNamespace(values=values, by_x=rows, response=SimpleNamespace(slopes=rows[:, :0]))
    data = SimpleNamespace(
        tape=SimpleNamespace(slices=(), samples=0),
        scale=np.ones(7),
        lower=np.full(7, -np.inf),
        upper=np.full(7, np.inf),
    )
    found: Any = SimpleNamespace(
        static=SimpleNamespace(free=tuple(range(7))), best=SimpleNamespace(found=evaluation), data=data, values=values
    )
    left = np.random.default_rng(6).standard_normal(N)
    regression: Any = SimpleNamespace(whitenings=())
    return numbers_told(regression, model, found, left / np.sqrt(np.mean(left**2)))


def test_shapes_at_their_usual_values_are_none() -> None:
    """One of the two has two usual values, and to say which costs 2 ln 2."""
    assert told(2.0, 0.5, (0.1, 0.01)) == pytest.approx(5 + 2 * np.log(2) / PRICE)


def test_a_shape_near_its_usual_value_counts_as_far_as_the_records_tell_it() -> None:
    assert told(2.1, 0.5, (0.1, 0.01)) == pytest.approx(5 + (1 + 2 * np.log(2)) / PRICE, rel=1e-2)


def test_shapes_that_the_records_tell_from_their_usual_values_are_numbers() -> None:
    assert told(2.8, 0.5, (0.1, 0.01)) == 6
    assert told(2.8, 0.7, (0.1, 0.01)) == 7
