"""A refit that ends where its effect cannot be."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.campaign.device import Oscillator
from ident.diagnosis.ranking import confirm as confirming
from ident.diagnosis.ranking.starts import is_possible
from ident.effects.library.cubic_damping import CubicDamping
from ident.effects.library.squeeze_film_damping import SqueezeFilmDamping
from ident.model import Model

ONE = SimpleNamespace(displacement=1.0, one=1.0)
BESIDE = [100.0, 40.0, 4e5, 1.0, 1.0]  # the oscillator's numbers and those of the cubic damping


def test_where_a_driving_film_fits_best_the_starts_that_brake_run_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """To first order in z gas that drives below the stage is gas that brakes above it. Beside a damping that grows with
    z² the impossible one won the race, the possible one left it, and the film was given up (a device with drag and a
    film at 2.1 times its travel, NumPy's own Runge–Kutta)."""
    model = Model(Oscillator()) + CubicDamping() + SqueezeFilmDamping()
    values = lambda damping, gap: np.array([*BESIDE, damping, gap])
    scored = [{"damping": -3e-3, "gap": -3.0}, {"damping": 2e-3, "gap": 3.0}, {"damping": -1e-3, "gap": -8.0}]
    candidate: Any = SimpleNamespace(
        values=scored[0], near=tuple(scored[1:]), beside=None, errors={}, unseen=frozenset(), words={}
    )
    candidate._replace = lambda values: SimpleNamespace(values=values, errors={})
    races = []

    def weigh(regression: Any, model: Model, candidate: Any, starts: list[np.ndarray], most: int) -> Any:
        races.append([tuple(start[-2:]) for start in starts])
        wrong = any(gap < 0 for _, gap in races[-1])
        found = values(-3e-3, -3.0) if wrong else values(2e-3, 2.6)
        return SimpleNamespace(chi2=1.2 if wrong else 1.5, possible=not wrong, values=found, left=np.zeros(1))

    monkeypatch.setattr(confirming, "weigh", weigh)
    monkeypatch.setattr(confirming, "with_effect", lambda *_: model)
    monkeypatch.setattr(confirming, "base_of", lambda *_: np.array(BESIDE))
    monkeypatch.setattr(confirming, "shapes_of", lambda *_: [])
    regression: Any = SimpleNamespace(fit=SimpleNamespace(scales=ONE), plane=None, passes=None, n=1, best_chi2=9.0)
    found = confirming._refitted(regression, SqueezeFilmDamping, candidate, 60, None)
    assert races == [[(0.0, -3.0), (2e-3, 3.0), (0.0, -8.0)], [(2e-3, 3.0)]]
    assert found.possible and found.values[-1] > 0


def test_a_film_that_brakes_far_more_than_all_of_the_stage_is_another_law() -> None:
    """Sweeps of a resonator that softens, with z²ż: one film of 2250 times the stage's damping, in a gap of 56 times
    the travel, did for both, and was the name. Above or below the stage, and without a spring, the same is asked."""
    stage = 2 * np.pi * BESIDE[0] / BESIDE[1]
    for form, first, own in (("oscillator", BESIDE[:3], stage), ("no-spring", [1.0, 0.25, 1.0], 4.0)):
        model = Model(Oscillator(), form=form) + SqueezeFilmDamping()  # type: ignore[arg-type]
        for size, gap in ((3.0, 3.0), (3.0, -3.0), (2250.0, 56.0), (2250.0, -56.0)):
            film = SqueezeFilmDamping(damping=size * own, gap=gap)
            values = np.array([*first, size * own, gap])
            assert is_possible(model, values, film, ONE) == (size < 10)  # type: ignore[arg-type]
