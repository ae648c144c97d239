"""A record whose response lost samples may bend the choice of the drive, beside which the others then disagree, too."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.signal import lsim

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.held_drive import Edges
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.diagnosis.faulty.suspects import find_suspects
from ident.diagnosis.ranking.look import first_look
from ident.diagnosis.search.drive import with_edges
from ident.fit import Fit, fit
from ident.model import Model

F, Q, STEP, HELD, FINE, NOISE, LOST = 30.0, 60.0, 1e-3, 4, 10, 0.02, 17
ONE = Channel("V", 1.0)


def record(name: str, seed: int, n: int = 2000, lost: int = 0) -> Trace:
    """Noise that a converter holds for four samples drives an oscillator; in the middle so many samples are lost."""
    rng, w = np.random.default_rng(seed), 2 * np.pi * F
    commanded = np.repeat(rng.standard_normal((n + lost) // HELD + 1), HELD)[: n + lost]
    fine = STEP / FINE * np.arange(FINE * (n + lost))
    z = lsim(([w * w], [1.0, w / Q, w * w]), np.repeat(commanded, FINE), fine, interp=False)[1][::FINE]
    read = np.delete(z, np.arange(n // 2, n // 2 + lost)) + NOISE * rng.standard_normal(n)
    return Trace(name, STEP * np.arange(n), commanded[:n], read, ONE, ONE, NoiseFloor(NOISE), "rest")


def led_astray(*records: Trace) -> Fit:
    """The fit as a choice would leave it that the faulty record has bent: edges nearly two samples late."""
    device = Oscillator("V", "V")
    return fit(Model(device), with_edges(Campaign("steps", records, device), Edges(1.7)))


def test_it_is_told_and_the_others_are_sound() -> None:
    heldout = replace(record("judge", 5), holdout=True)
    fitted = led_astray(record("a", 1), record("b", 2), record("c", 3), record("odd", 4, lost=LOST), heldout)
    assert all(score.error_over_noise > 3 for score in fitted.trace_scores)
    (suspect,) = find_suspects(fitted, lambda one: first_look(one, {}, lambda _: None))
    assert (suspect.file, suspect.kind, suspect.size) == ("odd", "delay", -LOST) and suspect.settles


def test_where_all_agree_nothing_is_asked_again() -> None:
    records = tuple(record(name, seed) for seed, name in enumerate("abcd"))
    device = Oscillator("V", "V")
    sound = fit(Model(device), with_edges(Campaign("steps", records, device), Edges(0.0)))
    assert find_suspects(sound, lambda one: first_look(one, {}, lambda _: None)) == ()
