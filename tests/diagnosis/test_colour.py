"""What a refit gains counts in the colour of what it leaves: slow noise is no room for a law that bends."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.evidence.coloured_noise import behind_in_colour
from ident.diagnosis.evidence.criterion import Left, behind

N = 4000
PUSH = np.random.default_rng(3).standard_normal((2, N))


def before(left: np.ndarray) -> Any:
    """What is read of a regression."""
    places = (slice(0, N // 2), slice(N // 2, N))
    return SimpleNamespace(
        left=left, numbers=3, plane=None, passes=None, places=places, whitenings=()
    )  # of no oscillator


def adrift(push: np.ndarray) -> np.ndarray:
    """A force that no law describes, added up twice by a mass without a spring."""
    return np.cumsum(np.cumsum(push)) * 1e-2


def test_a_law_that_takes_most_of_slow_noise_and_roughens_it_gains_nothing() -> None:
    left = adrift(PUSH[0])
    after = Left(0.3 * left + 2e-3 * np.std(left) * PUSH[1], 6)
    assert behind(after, before(left)) < 0
    assert behind_in_colour(after, before(left)) > 0


def test_a_law_of_the_device_gains_in_the_colour_of_slow_noise_too() -> None:
    left = adrift(PUSH[0])
    law = adrift(1.5 * np.sign(np.sin(0.01 * np.arange(N))))  # a friction that changes sides
    assert behind_in_colour(Left(left, 5), before(left + law)) < 0


def test_at_the_noise_floor_it_is_the_criterion_itself() -> None:
    after, law = Left(PUSH[0], 4), 0.3 * np.sin(0.08 * np.arange(N))
    was = before(PUSH[0] + law)
    assert behind_in_colour(after, was) == pytest.approx(behind(after, was), rel=0.1)
