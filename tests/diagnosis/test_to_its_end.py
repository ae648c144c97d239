"""A last fit that stops at a kink begins again with other shapes, and the better end counts."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.campaign.device import Oscillator
from ident.diagnosis.search import change
from ident.effects.library.coulomb_friction import CoulombFriction
from ident.effects.library.cubic_stiffness import CubicStiffness
from ident.model import Model


def ended(model: Model, values: list[float], chi2: float, converged: bool) -> Any:
    """What is asked of a fit."""
    solved = SimpleNamespace(found=SimpleNamespace(starts=np.zeros((1, 2))))
    scales = SimpleNamespace(velocity=2.0, displacement=1.0, voltage=1.0, squared_nearness=1.0)
    fitted = SimpleNamespace(chi2=chi2)
    return SimpleNamespace(model=model, values=np.array(values), campaign=None, solved=solved, scales=scales,
                           fitted=fitted, converged=converged)  # fmt: skip


@pytest.mark.parametrize(("again", "best"), [(60.0, 60.0), (120.0, 100.0)])
def test_other_shapes_are_tried_where_a_kink_stopped_the_search(
    monkeypatch: pytest.MonkeyPatch, again: float, best: float
) -> None:
    model = Model(Oscillator(), (CoulombFriction(),))
    start = ended(model, [1.0, 10.0, 1.0, 0.2, 1e-4], 101.0, False)
    tried: list[np.ndarray] = []

    def race(_: Any, __: Any, initial: list[np.ndarray], *___: Any) -> Any:
        tried.extend(initial)
        return SimpleNamespace(values=initial[1])

    fits = iter([ended(model, [1.0, 10.0, 1.0, 0.2, 1e-4], 100.0, False), ended(model, [1.0] * 5, again, False)])
    monkeypatch.setattr(change, "fit", lambda *_, **__: next(fits))
    monkeypatch.setattr(change, "refit", race)
    assert change.to_its_end(start).fitted.chi2 == best
    grid = 2.0 * np.array(model.parameters[-1].grid)
    np.testing.assert_allclose([one[-1] for one in tried], [1e-4, *grid])
    assert all(np.array_equal(one[:-1], start.values[:-1]) for one in tried)


def test_smooth_laws_and_ends_that_were_reached_are_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    for effect, converged in ((CubicStiffness(), False), (CoulombFriction(), True)):
        model = Model(Oscillator(), (effect,))
        last = ended(model, [1.0] * len(model.parameters), 100.0, converged)
        monkeypatch.setattr(change, "fit", lambda *_, last=last, **__: last)
        monkeypatch.setattr(change, "refit", None)
        assert change.to_its_end(last) is last


def test_without_an_effect_the_others_stay_what_they_can_be(monkeypatch: pytest.MonkeyPatch) -> None:
    """For want of a drag, friction was refitted to one that drives, and nothing could be asked beside that: a damper of
    square law kept the name of the family."""
    model = Model(Oscillator(), (CubicStiffness(), CoulombFriction()))
    parent = ended(model, [1.0, 10.0, 1.0, 5.0, 0.0, 0.2, 1e-4], 100.0, True)
    for friction, kept in ((-0.2, 0.2), (0.3, 0.3)):
        best = SimpleNamespace(found=SimpleNamespace(starts=None))
        found = SimpleNamespace(values=np.array([1.0, 10.0, 1.0, friction, 1e-4]), best=best)
        monkeypatch.setattr(change, "refit", lambda *_, found=found, **__: found)
        monkeypatch.setattr(change, "fit_at", lambda model, _, values, **__: ended(model, list(values), 200.0, False))
        without = change.try_without.__wrapped__(parent, "cubic-stiffness", parent)
        assert without.model.names == ("coulomb-friction",) and without.values[3] == kept
