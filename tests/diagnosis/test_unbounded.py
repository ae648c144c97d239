"""A refit whose motion has no bound is no answer, and never a traceback: a walk goes on from where it was."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.diagnosis.search import fewer_modes, once_more
from ident.effects.registry import built_in
from ident.fit import Fit, fit
from ident.model import Model

VALUES = np.array([100.0, 20.0, 4e4])  # frequency, quality, gain


@pytest.fixture(scope="module")
def bounded() -> Fit:
    """A linear oscillator at its resonance."""
    time = np.linspace(0, 0.3, 1500)
    rise = 1 - np.exp(-np.pi * 100 * time / 20)
    response = -VALUES[2] * 20 / (2 * np.pi * 100) ** 2 * rise * np.cos(2 * np.pi * 100 * time)
    response += np.random.default_rng(0).normal(0, 0.02, len(time))
    drive, channel = np.sin(2 * np.pi * 100 * time), Channel("V", 1.0)
    campaign = Campaign(
        "escape", (Trace("a.csv", time, drive, response, channel, channel, NoiseFloor(0.02), "rest"),), Oscillator()
    )
    return fit(Model(campaign.device), campaign, initial=VALUES)


@pytest.fixture(scope="module")
def lost(bounded: Fit) -> Fit:
    """The same with a spring that lets go."""
    softening = bounded.model + built_in()["cubic-stiffness"]()
    found = fit(softening, bounded.campaign, initial=np.append(VALUES, [-1e9, 0.0]), most=5)
    assert not np.isfinite(found.fitted.error_over_noise)
    return found


def test_other_starts_from_which_the_motion_has_no_bound_are_none(
    bounded: Fit, lost: Fit, monkeypatch: pytest.MonkeyPatch
) -> None:
    one = cast(Fit, SimpleNamespace(
        begun_otherwise=[("a.csv", 1.0)], model=bounded.model, campaign=bounded.campaign, values=bounded.values
    ))  # fmt: skip
    monkeypatch.setattr(once_more, "fit", lambda *_, **__: bounded)
    assert once_more.with_other_starts(one) is bounded
    monkeypatch.setattr(once_more, "fit", lambda *_, **__: lost)
    assert once_more.with_other_starts(one) is None


def test_a_mode_without_which_the_motion_has_no_bound_stays(
    bounded: Fit, lost: Fit, monkeypatch: pytest.MonkeyPatch
) -> None:
    start = cast(Fit, SimpleNamespace(model=SimpleNamespace(names=("second-mode",)), campaign=bounded.campaign))
    chosen = SimpleNamespace(chosen=SimpleNamespace(further=("second-mode",)))
    monkeypatch.setattr(fewer_modes, "linear_choice", lambda _: chosen)
    monkeypatch.setattr(fewer_modes, "without_one", lambda *_: (bounded, None, "second-mode"))
    monkeypatch.setattr(fewer_modes, "_does_as_well", lambda *_: True)
    asked = (start, bounded, {}, cast(Any, None), lambda _: None)
    monkeypatch.setattr(fewer_modes, "without", lambda *_: bounded)
    assert fewer_modes.without_a_mode(*asked) is bounded
    monkeypatch.setattr(fewer_modes, "without", lambda *_: lost)
    assert fewer_modes.without_a_mode(*asked) is None
