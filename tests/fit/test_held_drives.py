"""Linear models under drives that are held: filters, the choice, and what the solver makes of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.signal import lsim

from ident.campaign import Channel, NoiseFloor, Trace
from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.held_drive import Edges
from ident.fit import fit
from ident.fit.linear import choice
from ident.fit.linear.choice import choose_linear
from ident.fit.linear.forms import FORMS
from ident.fit.linear.start_model import start_model, with_drives
from ident.fit.linear.stretches import stretch_of

F, Q, STEP = 30.0, 8.0, 1 / 600.0
OMEGA = 2 * np.pi * F
SPRING = np.array([[0, 1, 0], [-(OMEGA**2), -OMEGA / Q, 1], [0, 0, 0]])
TAU = 0.02
DRIFT = np.array([[0, 1, 0], [0, -1 / TAU, 1], [0, 0, 0]])


def exact(matrix: np.ndarray, drive: np.ndarray, edge: float) -> np.ndarray:
    """(n, 2) displacement and velocity from rest, the drive of a sample beginning `edge` intervals after it."""
    late = int(np.ceil(edge)) if edge > 0 else 0
    earlier = np.concatenate([np.full(late, drive[0]), drive])[: len(drive)]
    share = edge - late  # of the interval before a sample, -1 to 0
    state, out = np.zeros(2), []
    for now, then in zip(earlier, [*earlier[1:], 0.0], strict=True):
        out.append(state)
        for part, value in ((1 + share, now), (-share, then)):
            state = (expm(matrix * part * STEP) @ np.append(state, value))[:2]
    return np.array(out)


def trace(drive: np.ndarray, response: np.ndarray, **told: object) -> Trace:
    time = STEP * np.arange(len(drive))
    return Trace("a", time, drive, response, Channel("V", 1.0), Channel("m", 1.0), NoiseFloor(0.002), "rest", **told)  # type: ignore[arg-type]


def switched(n: int = 1500) -> np.ndarray:
    """A square wave that begins after a while, one record of it."""
    k = np.arange(n)
    return np.where((k > 10) & ((k // 67) % 2 == 1), 1.0, 0.0)


@pytest.mark.parametrize("edge", [-1.0, -0.3, 0.0, 0.4, 1.0, 1.7])
@pytest.mark.parametrize(("name", "matrix", "point"), [("oscillator", SPRING, (F, Q)), ("no-spring", DRIFT, (TAU,))])
def test_filters_are_exact_for_a_drive_that_is_held(edge, name, matrix, point):
    drive = np.random.default_rng(2).standard_normal(200)
    drive[0] = 0.0
    states = exact(matrix, drive, edge)
    for order, measures in enumerate(("displacement", "velocity")):
        stretch = stretch_of(trace(drive, states[:, order] + 1e-9, measures=measures, edge=edge))
        answer = FORMS[name].answer(np.array(point), stretch, drive)
        np.testing.assert_allclose(answer, states[:, order], atol=1e-9 * np.max(np.abs(states[:, order])))


@pytest.mark.parametrize("edge", [-0.6, 0.0, 1.0])
def test_the_records_say_since_when_a_drive_is_held_and_the_fit_reaches_the_noise(edge):
    rng = np.random.default_rng(3)
    drive = switched()
    response = OMEGA**2 * exact(SPRING, drive, edge)[:, 0]
    record = trace(drive, response + 0.002 * rng.standard_normal(len(drive)))
    campaign = with_drives(Campaign("held", (record,), Oscillator("m", "V")))
    assert campaign.traces[0].edge == pytest.approx(edge, abs=0.01)
    found = fit(start_model(campaign), campaign)
    assert found.fitted.error_over_noise == pytest.approx(1.0, abs=0.06)
    assert found["frequency"].value == pytest.approx(F, rel=2e-3) and found["quality"].value == pytest.approx(
        Q, rel=0.02
    )


def sweep(at: np.ndarray) -> np.ndarray:
    return np.sin(2 * np.pi * (5 * at + 8 * at**2))


def swept(edge: float | None) -> Trace:
    """A record of the linear oscillator under a sweep that is held from so many samples on, or smooth."""
    fine, drive = STEP / 16 * np.arange(1500 * 16), sweep(STEP * np.arange(1500))
    whole = sweep(fine) if edge is None else np.repeat(drive, 16)
    response = lsim(([OMEGA**2], [1.0, OMEGA / Q, OMEGA**2]), whole, fine, interp=edge is None)[1][::16]
    return trace(drive, response + 0.002 * np.random.default_rng(4).standard_normal(1500))


def switch() -> Trace:
    drive = switched()
    response = OMEGA**2 * exact(SPRING, drive, 0.0)[:, 0]
    return trace(drive, response + 0.002 * np.random.default_rng(5).standard_normal(len(drive)))


@pytest.mark.parametrize("everywhere", [False, True])
def test_a_drive_may_be_held_only_where_it_jumps(everywhere):
    """A generator's sweep beside its switch, and both of a converter."""
    records = (swept(0.0 if everywhere else None), switch())
    campaign = with_drives(Campaign("both", records, Oscillator("m", "V")))
    chirp, jumping = (record.edge for record in campaign.traces)
    assert jumping == pytest.approx(0.0, abs=0.05) and (chirp is not None) == everywhere
    assert fit(start_model(campaign), campaign).fitted.error_over_noise == pytest.approx(1.0, abs=0.06)


def test_beside_a_switch_a_sweep_is_held_only_if_that_explains_the_greater_part(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A dead band in the drive is late, as one that is held: a sweep was taken for held, by next to nothing."""
    told = lambda stretches, one, free, jumping: [
        one._replace(left=(0.018 if all(free) else 0.02) * one.left, edges=Edges(0.0))
    ]
    monkeypatch.setattr(choice, "held", told)
    chosen = choose_linear([swept(None), switch()]).chosen
    assert chosen.edges == Edges(0.0, everywhere=False)


def test_what_a_campaign_says_of_its_drive_stays():
    drive = switched()
    record = trace(drive, OMEGA**2 * exact(SPRING, drive, 0.0)[:, 0], between="smooth")
    campaign = Campaign("told", (record,), Oscillator("m", "V"))
    assert with_drives(campaign) is campaign
    assert choose_linear([record]).chosen.edges.first is None
    held = replace(record, between="hold", edge=0.0)
    assert choose_linear([held]).chosen.left < 1e-3 < choose_linear([record]).chosen.left


def test_a_smooth_drive_stays_smooth():
    assert choose_linear([swept(None)]).chosen.edges.first is None
