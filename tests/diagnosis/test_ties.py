"""What an effect could be mistaken for: names stay together exactly where the records do not choose."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from typing import Literal

import numpy as np
import pytest

from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import draw
from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.diagnosis.diagnose import diagnose
from ident.diagnosis.evidence.equivalences import equivalence, exact_partners, mistaken, what_separates
from ident.diagnosis.evidence.family import is_family_of
from ident.diagnosis.linearised.regression import Regression, prepare
from ident.diagnosis.ranking.score import score
from ident.diagnosis.ranking.weigh import Candidate
from ident.diagnosis.search.ties import independent_of, reproduced, tie_set, unseen
from ident.effects import AbstractEffect, amplitude
from ident.effects.likeness import SAME_LOSS, Likeness
from ident.effects.registry import built_in
from ident.fit import fit
from ident.fit.reading import read
from ident.model import Model
from tests.fit.test_curves import sweep

LIBRARY = built_in()
N = 600


@pytest.fixture(scope="module")
def regression() -> Regression:
    time, channel, values = np.arange(N) / 4000.0, Channel("V", 1.0), np.array([100.0, 20.0, 4e5])
    drive = np.sin(2 * np.pi * 95.0 * time)
    blank = Trace("one.csv", time, drive, np.ones(N), channel, channel, NoiseFloor(0.003), "rest")
    model = Model(Oscillator())
    noise = 0.003 * np.random.default_rng(4).standard_normal(N)
    record = replace(blank, response=read(model, values, [blank])[0] + noise)
    return prepare(fit(model, Campaign("one", (record,), Oscillator()), initial=values))


def candidate(regression: Regression, name: str, direction: np.ndarray) -> Candidate:
    signature = regression.project(direction[None])
    signature /= np.linalg.norm(signature)
    drop = float((signature @ regression.residual)[0] ** 2)
    return Candidate(name, drop, 0.5, 1, 0.0, {}, {}, units={}, signature=signature)


@pytest.fixture(scope="module")
def lines() -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(8)
    return rng.standard_normal(N), rng.standard_normal(N)


def with_misfit(regression: Regression, misfit: np.ndarray) -> Regression:
    return replace(regression, residual=regression.residual + regression.project(misfit[None])[0])


def test_what_explains_as_well_is_tied_and_what_explains_less_is_not(
    regression: Regression, lines: tuple[np.ndarray, np.ndarray]
) -> None:
    a, b = lines
    disturbed = with_misfit(regression, 2.0 * a)
    best = candidate(disturbed, "cubic-stiffness", a)
    near = candidate(disturbed, "quadratic-damping", a + 0.02 * b)
    far = candidate(disturbed, "coulomb-friction", a + 0.7 * b)
    found = tie_set(disturbed, best, [best, near, far], LIBRARY)
    assert found.names == ("cubic-stiffness", "quadratic-damping")
    assert reproduced(disturbed, best, near) > 0.99


def test_a_misfit_of_the_laws_widens_the_set(regression: Regression, lines: tuple[np.ndarray, np.ndarray]) -> None:
    a, b = lines
    time = np.arange(N)
    unexplained = 20.0 * np.sin(0.9 * time)
    clean, spoilt = with_misfit(regression, 2.0 * a), with_misfit(regression, 2.0 * a + unexplained)
    for where, tied in ((clean, False), (spoilt, True)):
        best = candidate(where, "cubic-stiffness", a)
        other = candidate(where, "quadratic-damping", a + 0.3 * b)
        assert ("quadratic-damping" in tie_set(where, best, [best, other], LIBRARY).names) is tied
    assert independent_of(clean, candidate(clean, "cubic-stiffness", a)) > 0.8 * N
    assert independent_of(spoilt, candidate(spoilt, "cubic-stiffness", a)) < 0.2 * N


def test_lags_stay_together_on_a_linear_device(regression: Regression, lines: tuple[np.ndarray, np.ndarray]) -> None:
    a, b = lines
    disturbed = with_misfit(regression, 5.0 * a)
    best, other = candidate(disturbed, "drive-lag", a), candidate(disturbed, "sensor-lag", a + 0.25 * b)
    found = tie_set(disturbed, best, [best, other], LIBRARY)
    assert found.names == ("drive-lag", "sensor-lag")
    assert "second sensor" in found.reasons[0]


@pytest.mark.parametrize("hidden", ["electrostriction", "electrostatic-force"])
def test_a_law_that_contains_another_is_that_one_where_its_further_numbers_say_nothing(hidden: str) -> None:
    case = draw(9976, (hidden,), size=0.02, noise=0.01, length=1200)
    campaign = campaign_of(case)
    library = {name: LIBRARY[name] for name in ("electrostriction", "electrostatic-force", "coulomb-friction")}
    found = diagnose(fit(Model(campaign.device), campaign), library).discovery
    assert [step.tie_set for step in found.steps] == [(hidden,)] and found.verdict == "identified"


@pytest.mark.parametrize(("hidden", "law"), [("quadratic-damping", "own"), ("power-law-damping", "plain")])
def test_a_family_is_called_by_its_member_where_it_is_one(hidden: str, law: Literal["own", "plain"]) -> None:
    """A device's drag is quadratic but for its slowest motion; a fitted power of 2.1 then leaves less, and had become
    the name."""
    case = draw(7300, (hidden,), size=0.02, noise=0.01, detail=law)
    campaign = campaign_of(case)
    library = {name: LIBRARY[name] for name in ("quadratic-damping", "cubic-damping", "power-law-damping")}
    found = diagnose(fit(Model(campaign.device), campaign), library).discovery
    assert [step.tie_set for step in found.steps] == [(hidden,)] and found.verdict == "identified"
    if hidden == "power-law-damping":
        assert found.final["exponent"].value == pytest.approx(1.5, abs=4 * (found.final["exponent"].error or 0.0))


def test_beside_a_member_its_family_is_no_further_law(regression: Regression) -> None:
    member = LIBRARY["cubic-damping"]()
    beside = replace(regression, fit=replace(regression.fit, model=regression.fit.model + member), scored={})
    assert is_family_of(LIBRARY["power-law-damping"], member)
    assert not is_family_of(LIBRARY["residual-stress"], LIBRARY["cubic-stiffness"]())  # the drive acts there, too
    assert not is_family_of(LIBRARY["residual-stress"], LIBRARY["voltage-stiffness"]())  # and stress has several sizes
    assert score(beside, {"power-law-damping": LIBRARY["power-law-damping"]}) == []


def test_on_curves_a_law_that_contains_another_stays_beside_it(regression: Regression) -> None:
    """What would tell it, a mean and overtones, is in traces and not in curves."""
    sweeps = Campaign("", (sweep(0.2, 0.0, False),), Oscillator(output="m"))
    for where, tied in ((regression, False), (prepare(fit(Model(Oscillator(output="m")), sweeps)), True)):
        line = np.random.default_rng(8).standard_normal(where.n)
        disturbed = with_misfit(where, 2.0 * line)
        best = candidate(disturbed, "cubic-stiffness", line)
        other = candidate(disturbed, "residual-stress", line)._replace(dof=4)
        assert ("residual-stress" in tie_set(disturbed, best, [best, other], LIBRARY).names) is tied


def test_curves_of_settled_motion_are_not_asked_for_heat(regression: Regression) -> None:
    curves = prepare(
        fit(Model(Oscillator(output="m")), Campaign("", (sweep(0.2, 0.0, False),), Oscillator(output="m")))
    )
    warm = {name: effect for name, effect in built_in().items() if effect.settles_to_a_mean}
    assert len(warm) == 4 and score(curves, warm) == []
    assert {one.name for one in unseen(curves, [], built_in()) if one.settled} == set(warm)
    assert not any(one.settled for one in unseen(regression, [], built_in()))


def test_two_cubic_laws_share_no_heat() -> None:
    """A spring and a damper pass for what heat does to either, and not for one another."""
    spring, damper = built_in()["cubic-stiffness"], built_in()["cubic-damping"]
    assert equivalence(spring, damper) is None
    assert equivalence(spring, built_in()["stiffness-heating"]) and equivalence(damper, built_in()["damping-heating"])


def test_an_effect_without_a_score_is_reported_as_unseen(
    regression: Regression, lines: tuple[np.ndarray, np.ndarray]
) -> None:
    scored = [candidate(regression, name, lines[0]) for name in LIBRARY if name != "sensor-offset"]
    assert [u.name for u in unseen(regression, scored, LIBRARY)] == ["sensor-offset"]
    names = {u.name for u in unseen(regression, [], LIBRARY)}
    assert "residual-stress" not in names  # it has no meaning on an oscillator, rather than no trace


def test_two_effects_are_told_their_closest_likeness() -> None:
    for one, other in combinations(LIBRARY.values(), 2):
        assert equivalence(one, other) is equivalence(other, one), "both order their likenesses the same way"
    closest = equivalence(LIBRARY["drive-lag"], LIBRARY["sensor-lag"])
    assert closest is not None and closest.linear_exact
    assert "amplifies" in what_separates(LIBRARY["coulomb-friction"], LIBRARY["sensor-drift"])
    assert exact_partners(LIBRARY["static-force"], LIBRARY, True, True) == ["sensor-drift", "sensor-offset"]
    assert exact_partners(LIBRARY["static-force"], LIBRARY, False, False) == []


def test_no_likeness_is_one_effect_alone() -> None:
    shared = [likeness for effect in LIBRARY.values() for likeness in effect.alike]
    assert [likeness for likeness in shared if shared.count(likeness) < 2] == []


class Drag(AbstractEffect):
    """An effect of somebody's own, which has two likenesses with those of the library, one of them its own."""

    name = "drag"
    mistaken_for = ("quadratic-damping",)
    alike = (Likeness("both are drag", "other gas", in_motion=True), SAME_LOSS)
    c = amplitude("N s/m", "coefficient")


class OtherDrag(Drag):
    """A second one."""

    name = "other-drag"


def test_effects_of_ones_own_take_part(regression: Regression, lines: tuple[np.ndarray, np.ndarray]) -> None:
    known = {**LIBRARY, "drag": Drag, "other-drag": OtherDrag}
    assert what_separates(Drag, OtherDrag) == "other gas"
    assert exact_partners(Drag, known, True, True) == ["other-drag"] and not exact_partners(Drag, known, True, False)
    assert mistaken(LIBRARY["quadratic-damping"], known) >= {"drag", "cubic-damping"}
    disturbed = with_misfit(regression, 2.0 * lines[0])
    best = candidate(disturbed, "quadratic-damping", lines[0])
    other = candidate(disturbed, "drag", lines[0])
    (tie,) = tie_set(disturbed, best, [best, other], known).ties
    assert (tie.name, tie.why, tie.separate) == ("drag", SAME_LOSS.why, SAME_LOSS.separate)


def test_another_form_of_an_effect_is_scored_only_where_it_is_asked_for(regression: Regression) -> None:
    """It would stand in the place of that effect, also where the library has nothing else."""
    form = {"attached-mass": LIBRARY["attached-mass"]}
    beside = replace(regression, scored={})
    assert score(beside, form) == []
    assert [one.name for one in score(beside, form, forms=True)] == ["attached-mass"]
