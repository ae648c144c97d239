"""Records of a device that differs from one to the next, simulated with SciPy."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import ident
from ident.campaign.apart import TOLD, Kind, signal_of
from ident.campaign.campaign import Campaign
from ident.diagnosis.apart import apart_before
from ident.diagnosis.faulty.odd_one import odd_one
from ident.diagnosis.faulty.suspects import BY_OTHERS
from ident.diagnosis.ranking.look import first_look
from ident.diagnosis.records.between import KINDS, differing
from ident.diagnosis.records.differing import Differing
from ident.diagnosis.search.change import add
from ident.effects.registry import built_in
from ident.report.run_state import as_it_was, state

STEP, RESONANCE, QUALITY, NOISE = 1 / 4400, 146.0, 40.0, 4e-3
TONES = ((90.0,), (143.0,), (147.5,), (61.0, 118.0, 131.0, 149.0, 171.0, 203.0), (75.0, 110.0, 139.0, 152.0))
# Of each record; the last is held out.
TRUTH = {
    "stiffness": np.array([0.003, 0.002, -0.006, 0.001, 0.004]),
    "damping": np.array([0.05, 0.08, -0.12, -0.01, 0.06]),
    "sensitivity": np.array([0.00, 0.03, -0.02, 0.01, 0.02]),
    "delay": np.array([0.4, -0.7, 0.2, 1.6, -0.3]),  # samples
    "clock": np.array([2e-4, -3e-4, 0.0, 5e-4, 1e-4]),
    "level": np.array([0.05, -0.04, 0.1, -0.2, 0.02]),  # of its size
    "baseline": np.array([0.3, -0.2, 0.1, 0.0, 0.2]),  # of its size, along a line
}


def _records(kind: Kind | None, drag: float, start: str = "rest") -> Campaign:
    time, rng, records = STEP * np.arange(1500), np.random.default_rng(7), []
    w = 2 * np.pi * RESONANCE
    for k, tones in enumerate(TONES):
        phases = rng.uniform(0, 2 * np.pi, len(tones))
        push = lambda t, tones=tones, p=phases: sum(
            np.sin(2 * np.pi * f * t + a) for f, a in zip(tones, p, strict=True)
        )
        own = lambda name, k=k: TRUTH[name][k] if name == kind else 0.0
        law = lambda t, y, push=push, k=k, own=own: [
            y[1],
            w * w * (0.1 * push(t) - (1 + own("stiffness")) * y[0])
            - (1 + own("damping")) * w / QUALITY * y[1]
            - drag * y[1] * abs(y[1]),
        ]
        # A recorder that is late or fast looks at another moment of the motion; before its first sample there was none.
        read_at = np.maximum(time * (1 - own("clock")) - own("delay") * STEP, 0.0)
        moved = solve_ivp(law, (0, read_at[-1]), [0, 0], rtol=1e-9, atol=1e-10, max_step=2e-4, dense_output=True)
        z = moved.sol(read_at)[0]
        z = (1 + own("sensitivity")) * z + own("baseline") * np.std(z) * np.linspace(-1, 1, len(z))
        z = z + own("level") * np.std(z)
        z = z + NOISE * np.std(z) * rng.normal(size=len(time))
        table = {"time": time, "drive": push(time), "response": z}
        records.append({"data": table, "start": start, "holdout": k == len(TONES) - 1})
    return ident.read_campaign({"device": {"kind": "oscillator"}, "record": records})


@pytest.mark.parametrize("kind", KINDS)
def test_the_numbers_of_the_records_are_found_with_their_errors(kind: Kind):
    fitted = add(ident.fit(_records(kind, drag=0.05), effects=()), built_in()["quadratic-damping"])
    assert fitted.fitted.error_over_noise > 2.0
    found = differing(fitted)
    assert found is not None and found.kind == kind
    truth = TRUTH[kind]
    wanted = truth - np.mean(truth[:-1]) if kind in ("stiffness", "damping", "sensitivity") else truth
    column = 1 if kind == "baseline" else 0
    if TOLD[kind].of_zero:  # which is told in the unit of the reading
        unit = np.array([signal_of(trace) for trace in found.fit.campaign.traces])
        found = found._replace(sizes=found.sizes / unit[:, None], errors=found.errors / unit[:, None])
    assert np.all(np.abs(found.sizes[:, column] - wanted) < 4 * found.errors[:, column] + 0.01 * np.ptp(truth))
    assert found.fit.fitted.error_over_noise == pytest.approx(1.0, abs=0.05)
    assert found.fit.holdout is not None and found.fit.holdout.error_over_noise == pytest.approx(1.0, abs=0.1)
    assert found.fit.campaign.traces[1].name in found.words


def test_records_of_one_device_do_not_differ():
    assert differing(ident.fit(_records(None, drag=0.0), effects=())) is None


def test_a_walk_goes_on_beside_what_differs():
    found = ident.discover(_records("stiffness", drag=0.05))
    assert [step.added for step in found.discovery.steps] == ["quadratic-damping"]
    assert found.verdict == "ambiguous" and found.final.fitted.error_over_noise == pytest.approx(1.0, abs=0.05)
    assert any("a resonance of its own" in note for note in found.final.campaign.notes)
    kept = state(found.final)["traces"]
    assert kept == [[("stiffness", (trace.stiffer,)), None] for trace in found.final.campaign.traces]
    assert all(trace.differs for trace in found.final.campaign.traces)


@pytest.mark.parametrize(("kind", "off", "named", "size"), [
    ("stiffness", -0.006, "time-scale", 0.997), ("sensitivity", 0.06, "gain", 1.06), ("delay", 1.5, "delay", 1.5),
])  # fmt: skip
def test_one_that_differs_from_all_the_others_is_suspect(kind, off, named, size):
    """A time column that was 0.3 % off beside a squeezed film: "each has a resonance of its own"."""
    fitted = ident.fit(_records(None, drag=0.0), effects=())
    names = tuple(trace.name for trace in fitted.campaign.traces)
    sizes = off * np.array([0.02, -0.02, 1.0, 0.0, 0.0])[:, None]
    found = Differing(kind, names, sizes, np.full((5, 1), 1e-3), fitted, 4)
    one = odd_one(found)
    assert one is not None and (one.file, one.kind) == (names[2], named)
    assert one.size == pytest.approx(size, rel=2e-3) and not one.first and one.kind in BY_OTHERS
    assert odd_one(found._replace(sizes=TRUTH["stiffness"][:, None])) is None
    assert odd_one(found._replace(kind="level")) is None


def test_before_a_walk_the_effect_is_seen_beside_delays():
    fitted = ident.fit(_records("delay", drag=0.05), effects=())
    seen = apart_before(first_look(fitted, built_in(), lambda _: None), lambda _: None)
    assert seen is not None and seen.found.kind == "delay"
    assert seen.found.fit.model.names == ("quadratic-damping",)


def test_one_effect_in_one_device_makes_no_records_differ():
    fitted = ident.fit(_records(None, drag=0.05), effects=())
    assert apart_before(first_look(fitted, built_in(), lambda _: None), lambda _: None) is None


def test_a_memory_that_outlasts_its_records_is_a_number_of_each():
    """Begun freely in each record it was a constant force there, of which none was counted: sensors whose zeros differ
    had become a support that relaxes in seconds."""
    fitted = ident.fit(_records("level", drag=0.0, start="unknown"), effects=())
    look = first_look(fitted, built_in(), lambda _: None)
    seen = apart_before(look, lambda _: None)
    assert seen is not None and seen.found.kind == "level" and seen.found.fit.model.names == ()


@pytest.mark.parametrize("kind", ["sensitivity", "delay", "clock", "level", "baseline"])
def test_a_run_that_is_read_again_reads_its_records_so(kind: Kind):
    found = differing(add(ident.fit(_records(kind, drag=0.05), effects=()), built_in()["quadratic-damping"]), (kind,))
    assert found is not None
    kept = json.loads(json.dumps(state(found.fit)["traces"]))
    for record, told, there in zip(_records(kind, drag=0.05).traces, kept, found.fit.campaign.traces, strict=True):
        again = as_it_was(replace(record, noise=there.noise), told)
        assert again.noise == there.noise and again.edge == there.edge and again.own == (kind, tuple(told[0][1]))
        assert np.array_equal(again.response, there.response) and np.array_equal(again.drive, there.drive)
        assert np.array_equal(again.time, there.time)
