"""Which laws could pass for one another, by the study's own simulator."""

import pytest

from experiments.hidden_effects.generator import draw
from experiments.hidden_effects.mimics import SEEN, left_by


def test_the_law_itself_leaves_nothing() -> None:
    case = draw(3, ("quadratic-damping",), size=0.02, noise=0.003, length=800, records=4)
    assert left_by(case, ["quadratic-damping"]) < 0.01


def test_another_law_leaves_what_can_be_seen() -> None:
    case = draw(3, ("power-law-stiffness",), size=0.02, noise=0.003, length=800, records=4)
    assert left_by(case, ["coulomb-friction"]) > 100 * SEEN


def test_noise_hides_the_difference_of_two_laws() -> None:
    cases = (draw(3, ("stribeck-friction",), noise=noise, length=800, records=4) for noise in (0.003, 0.03))
    quiet, loud = (left_by(case, ["coulomb-friction"]) for case in cases)
    assert quiet / loud == pytest.approx(100, rel=0.05)  # χ² is counted in units of the noise
