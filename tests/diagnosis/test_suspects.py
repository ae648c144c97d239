"""A faulty record is named before any physics; faults of the records of `data/`, one at a time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ident.campaign import Campaign, Trace, read_campaign
from ident.campaign.suspect import suspects_by_data
from ident.diagnosis.diagnose import diagnose
from ident.diagnosis.document import diagnosis_dict
from ident.diagnosis.nuisance import nuisances
from ident.diagnosis.suspects import find_suspects
from ident.effects.registry import registry
from ident.fit import fit
from ident.model import build_model
from ident.report.diagnosis_view import advice, verdict_words
from tests.end_to_end.user import DATA


def spoiled(campaign: Campaign, name: str, **changes) -> Campaign:
    """The campaign with one record changed, by functions of the record."""
    return replace(
        campaign,
        records=tuple(
            replace(r, **{key: change(r) for key, change in changes.items()}) if r.name == name else r
            for r in campaign.traces
        ),
    )


@pytest.fixture(scope="module")
def clean() -> Campaign:
    return read_campaign(DATA / "platform_clean")


def late(record: Trace) -> np.ndarray:
    return np.concatenate([record.response[:3] * 0.0, record.response[:-3]])


CASES = {
    "gain": ("sine_3V_500Hz.csv", {"drive": lambda r: 1.1 * r.drive}, 1 / 1.1),
    "sign": ("sine_9V_505Hz.csv", {"response": lambda r: -r.response}, -1.0),
    "delay": ("sine_8V_317Hz.csv", {"response": late}, 3.0),
}


@pytest.mark.parametrize("kind", CASES)
def test_a_fault_is_named_with_its_size_and_no_physics_is(kind, clean):
    name, changes, size = CASES[kind]
    campaign = spoiled(clean, name, **changes)
    found = diagnose(fit(build_model(campaign), campaign), registry())
    (suspect,) = found.suspects
    assert (suspect.file, suspect.kind) == (name, kind) and suspect.first
    assert abs(suspect.size / size - 1) < 0.02
    assert found.discovery.steps == () and found.discovery.verdict != "identified"
    assert name in verdict_words(found) and name in advice(found)[0]
    (told,) = diagnosis_dict(found)["records"]
    assert (told["file"], told["suspect"]) == (name, kind) and told["probability"] > 0.9


def test_the_response_of_a_held_out_record_from_another_is_named(clean):
    other = next(r for r in clean.traces if r.name == "sine_9V_505Hz.csv")
    noise = other.noise.sigma * np.random.default_rng(3).standard_normal(len(other.time))  # else it is a duplicate
    campaign = spoiled(clean, "sine_5V_450Hz.csv", response=lambda _: other.response + noise)
    (suspect,) = find_suspects(fit(build_model(campaign), campaign))
    assert (suspect.file, suspect.kind) == ("sine_5V_450Hz.csv", "wrong-record")
    assert "sine_9V_505Hz.csv" in suspect.says


@pytest.mark.parametrize("name", ["platform_clean", "mystery_platform", "platform_fe"])
def test_sound_records_are_not_suspected_whatever_the_model_lacks(name):
    campaign = read_campaign(DATA / name)
    assert find_suspects(fit(build_model(campaign, ()), campaign)) == ()


def test_what_the_data_alone_tell(clean):
    first = clean.traces[0]
    twice = replace(clean, records=(*clean.records, replace(first, name="again.csv")))
    assert [(s.file, s.kind) for s in suspects_by_data(twice)] == [("again.csv", "duplicate")]
    limit = 0.6 * np.max(np.abs(first.response))
    clipped = spoiled(clean, first.name, response=lambda r: np.clip(r.response, -limit, limit))
    assert [(s.file, s.kind) for s in suspects_by_data(clipped)] == [(first.name, "clipping")]
    assert suspects_by_data(clean) == ()


def test_the_number_that_brings_a_record_back():
    time = np.arange(1500)
    curve = np.sin(time / 9) * (1 - np.exp(-time / 200))
    noise = 0.01 * np.random.default_rng(4).standard_normal(1500)
    moved = np.interp(time - 4.5, time, curve)
    for measured, kind, size in (
        (1.25 * curve, "gain", 1.25),
        (-curve, "sign", -1.0),
        (moved, "delay", 4.5),
        (curve + time / 700, "drift", None),
    ):
        best = nuisances(measured + noise, curve, 0.01)[0]
        assert best.kind == kind and best.error < 1.2
        assert size is None or abs(best.size - size) < 0.02 * abs(size)


def test_a_level_is_no_drift():
    # Seen of a device whose sensor has an offset: "the response drifts by 0.13 noise floors".
    predicted = np.sin(np.linspace(0.0, 40.0, 700))
    measured = predicted + 0.3 + 0.01 * np.random.default_rng(0).standard_normal(700)
    assert next(one for one in nuisances(measured, predicted, 0.01) if one.kind == "drift").error == np.inf
