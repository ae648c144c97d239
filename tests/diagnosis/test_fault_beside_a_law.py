"""A gain that is wrong in one record and a missing spring hide one another: neither alone brings the records far."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
from scipy.integrate import solve_ivp

import ident
from ident.campaign.quality.suspect import Suspect
from ident.diagnosis import diagnose
from ident.diagnosis.faulty.aside import left_out
from ident.effects.registry import registry


def _records(spoilt: int, gain: float) -> dict[str, dict]:
    """A resonator whose spring stiffens by the square of the displacement, under sweeps; each record has a zero."""
    rng, time, records = np.random.default_rng(11), np.arange(1500) / 8000.0, {}
    w, quality, end = 2 * np.pi * 430.0, 14.0, 380.0
    for k, (level, begin, finish) in enumerate(
        [(0.5, 250, 600), (0.8, 600, 280), (0.7, 300, 620), (1.0, 270, 650), (0.6, 620, 300), (0.9, 280, 610)]
    ):
        drive = level * np.sin(2 * np.pi * (begin + 0.5 * (finish - begin) * time / time[-1]) * time)

        def rate(t: float, y: np.ndarray, drive: np.ndarray = drive) -> list[float]:
            spring = y[0] * (1 + (y[0] / end) ** 2 / 3)
            return [y[1], 30.0 * w**2 * np.interp(t, time, drive) - w / quality * y[1] - w**2 * spring]

        z = solve_ivp(rate, (0, time[-1]), [0, 0], t_eval=time, rtol=1e-8, atol=1e-8, max_step=1 / 8000).y[0]
        response = (gain if k == spoilt else 1.0) * (z + 4.0 * rng.normal()) + 2.2 * rng.normal(size=len(time))
        records[f"sweep {k}"] = {"t": time, "u": drive, "y": response}
    return records


def test_the_others_tell_the_law_and_that_what_is_wrong_with_the_record():
    fitted = ident.fit(_records(2, 0.5), device={"kind": "oscillator"}, start="rest", holdout=["sweep 5"])
    library = {name: registry()[name] for name in ("cubic-stiffness", "sensor-nonlinearity")}
    asked = diagnose._Asked(library, lambda _: None, None, False, lambda _: None)
    told = Suspect("sweep 2", "gain", 0.6, "1", 0.9, "the response is 0.6 times what the others tell", first=True)
    seen = SimpleNamespace(fitted=fitted, suspects=(), where=None)
    said = diagnose._without_those_seen_now(asked, cast(Any, seen), (told,))
    assert said is not None and [step.added for step in said.discovery.steps] == ["cubic-stiffness"]
    assert said.final.fitted.error_over_noise < 1.1 and said.final.holdout.error_over_noise < 1.1
    (now,) = left_out(said.final)
    assert now.kind == "gain" and abs(now.size - 0.5) < 0.002 and "so read, it agrees with the others" in now.says
    assert diagnose._without_those_seen_now(asked, cast(Any, seen), ()) is None
    seen.suspects = (told,)  # at the first look it had been suspected, too, and something spoke against it
    assert diagnose._without_those_seen_now(asked, cast(Any, seen), (told,)) is None
