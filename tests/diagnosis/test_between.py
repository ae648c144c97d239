"""Records of a device that differs from one to the next, simulated with SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import ident
from ident.campaign.campaign import Campaign
from ident.diagnosis.faulty.between import differing
from ident.diagnosis.search.change import add
from ident.effects.registry import built_in
from ident.report.run_state import state

STEP, RESONANCE, QUALITY, NOISE = 1 / 4400, 146.0, 40.0, 4e-3
TONES = ((90.0,), (143.0,), (147.5,), (61.0, 118.0, 131.0, 149.0, 171.0, 203.0), (75.0, 110.0, 139.0, 152.0))
WARMER = np.array([0.003, 0.002, -0.006, 0.001, 0.004])  # of the stiffness; the last record is held out
LOUDER = np.array([0.00, 0.03, -0.02, 0.01, 0.02])


def _records(warmer: np.ndarray, louder: np.ndarray, drag: float) -> Campaign:
    time, rng, records = STEP * np.arange(1500), np.random.default_rng(7), []
    w = 2 * np.pi * RESONANCE
    for k, tones in enumerate(TONES):
        phases = rng.uniform(0, 2 * np.pi, len(tones))
        push = lambda t, tones=tones, p=phases: sum(
            np.sin(2 * np.pi * f * t + a) for f, a in zip(tones, p, strict=True)
        )
        law = lambda t, y, push=push, k=k: [
            y[1], w * w * (0.1 * push(t) - (1 + warmer[k]) * y[0]) - w / QUALITY * y[1] - drag * y[1] * abs(y[1])
        ]  # fmt: skip
        z, _ = solve_ivp(law, (0, time[-1]), [0, 0], t_eval=time, rtol=1e-9, atol=1e-10, max_step=4e-4).y
        z = (1 + louder[k]) * z + NOISE * np.std(z) * rng.normal(size=len(time))
        table = {"time": time, "drive": push(time), "response": z}
        records.append({"data": table, "start": "rest", "holdout": k == len(TONES) - 1})
    return ident.read_campaign({"device": {"kind": "oscillator"}, "record": records})


@pytest.mark.parametrize("kind", ["stiffness", "sensitivity"])
def test_the_numbers_of_the_records_are_found_with_their_errors(kind):
    truth = WARMER if kind == "stiffness" else LOUDER
    nothing = np.zeros(len(TONES))
    campaign = _records(*((truth, nothing) if kind == "stiffness" else (nothing, truth)), drag=0.05)
    fitted = add(ident.fit(campaign, effects=()), built_in()["quadratic-damping"])
    assert fitted.fitted.error_over_noise > 2.0
    found = differing(fitted)
    assert found is not None and found.kind == kind
    wanted = truth - np.mean(truth[:-1])
    assert np.all(np.abs(found.sizes[:, 0] - wanted) < 4 * found.errors[:, 0] + 0.01 * np.ptp(truth))
    assert found.fit.fitted.error_over_noise == pytest.approx(1.0, abs=0.05)
    assert found.fit.holdout is not None and found.fit.holdout.error_over_noise == pytest.approx(1.0, abs=0.1)
    assert found.fit.campaign.traces[1].name in found.words


def test_records_of_one_device_do_not_differ():
    nothing = np.zeros(len(TONES))
    assert differing(ident.fit(_records(nothing, nothing, drag=0.0), effects=())) is None


def test_a_walk_goes_on_beside_what_differs():
    found = ident.discover(_records(WARMER, np.zeros(len(TONES)), drag=0.05))
    assert [step.added for step in found.discovery.steps] == ["quadratic-damping"]
    assert found.verdict == "ambiguous" and found.final.fitted.error_over_noise == pytest.approx(1.0, abs=0.05)
    assert any("a resonance of its own" in note for note in found.final.campaign.notes)
    kept = state(found.final)["traces"]
    assert kept == [[("stiffness", (trace.stiffer,)), None] for trace in found.final.campaign.traces]
    assert all(trace.differs for trace in found.final.campaign.traces)
