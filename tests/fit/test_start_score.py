"""A record that is said to begin at rest and does not is told; one whose device is pushed off its place is not."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import ident
from ident.fit.start_score import mostly_starts
from ident.report.words.sentences import sentences

W = 2 * np.pi * 180.0


def _record(volts: float, before: float, push: float, seed: int) -> dict[str, np.ndarray]:
    """A chirp on an oscillator that it has driven for `before` seconds ahead of the record; `push`, a further force."""
    time = np.arange(3000) / 5000
    drive = lambda t: volts * np.sin(2 * np.pi * (60 + 350 * t) * t)
    law = lambda t, y: [y[1], W * W * (0.7 * drive(t) + push - y[0]) - W / 22 * y[1]]
    z = solve_ivp(law, (-before, time[-1]), [0, 0], t_eval=time, rtol=1e-9, atol=1e-12).y[0]
    noise = np.random.default_rng(seed).normal(0, 0.05, len(time))
    return {"time": time, "drive": drive(time), "response": z + noise}


@pytest.mark.parametrize("before, push, told", [(0.013, 0.0, True), (0.0, 0.0, False), (0.0, 1.0, False)])
def test_a_start_in_motion_is_told(before, push, told):
    records = {f"{volts:g}": _record(volts, before, push, k) for k, volts in enumerate((1.0, 3.0))}
    effects = ["static-force"] if push else []
    found = ident.fit(records, effects, device={"kind": "oscillator"}, start="rest", noise="0.05 V")
    assert bool(found.begun_otherwise) is told
    assert any('write start = "unknown"' in sentence.text for sentence in sentences(found)) is told
    assert mostly_starts(found) is told


def test_the_start_of_one_weak_record_is_not_most_of_what_a_model_lacks() -> None:
    records = {"weak": _record(1.0, 0.013, 0.0, 0), "strong": _record(9.0, 0.0, 0.0, 1)}
    records["strong"]["response"] = np.tanh(records["strong"]["response"] / 9.0) * 9.0  # its sensor bends
    found = ident.fit(records, device={"kind": "oscillator"}, start="rest", noise="0.05 V")
    assert not mostly_starts(found)
