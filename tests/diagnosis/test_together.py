"""Two effects of which each hides what the other does."""

from __future__ import annotations

import itertools
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import ident
from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import draw
from ident.diagnosis.diagnose import diagnose
from ident.diagnosis.ranking.pairs import best_pair
from ident.diagnosis.ranking.weigh import Candidate
from ident.diagnosis.search import together
from ident.diagnosis.search.together import hidden_by_each_other
from ident.effects.registry import built_in
from ident.fit import fit
from ident.model import Model


def test_the_best_pair_is_that_of_all_regressions() -> None:
    random = np.random.default_rng(7)
    residual = random.normal(size=400)
    columns = [random.normal(size=(1 + k % 3, 400)) + 0.3 * residual for k in range(6)]
    columns[4] = columns[3] + 0.05 * random.normal(size=columns[3].shape)  # nearly the same direction
    columns[3][0] += 0.2 * residual
    regression = SimpleNamespace(n=400, residual=residual, numbers=3)
    candidates = [_candidate(str(k), rows, residual) for k, rows in enumerate(columns)]
    left = {}
    for i, j in itertools.combinations(range(6), 2):
        both = np.concatenate([columns[i], columns[j]])
        fitted = both.T @ np.linalg.lstsq(both.T, residual, rcond=None)[0]
        left[i, j] = float(np.sum((residual - fitted) ** 2)) + len(both) * np.log(400)
    found = best_pair(regression, candidates)  # pyright: ignore[reportArgumentType]  (only what it reads)
    assert found is not None
    names = tuple(sorted(int(name) for name in found.names))
    assert names == min(left, key=lambda pair: left[pair])
    numbers = found.numbers - 3
    assert float(found.left @ found.left) + numbers * np.log(400) == pytest.approx(left[names])
    with_five = best_pair(regression, candidates, "5")  # pyright: ignore[reportArgumentType]
    assert with_five is not None and "5" in with_five.names


def test_in_a_pair_a_law_takes_the_place_of_a_part_of_it() -> None:
    """Stress beside a loop is never worse than the cubic spring in it; at the shapes of a grid its score may be."""
    random = np.random.default_rng(11)
    spring, loop, bent = np.linalg.qr(random.normal(size=(400, 3)))[0].T
    residual = 100 * spring + 60 * loop + random.normal(size=400)
    stress = np.stack([spring + 0.3 * bent])
    candidates = [
        _candidate(name, rows, residual)
        for name, rows in (
            ("residual-stress", stress),
            ("cubic-stiffness", spring[None]),
            ("pzt-hysteresis", loop[None]),
        )
    ]
    noise = SimpleNamespace(fitted=[SimpleNamespace(noise=SimpleNamespace(relative_error=0.0))], fitted_sweeps=[])
    told = lambda left: SimpleNamespace(
        whitenings=(),
        n=400, residual=left, numbers=3, chi2=float(left @ left), to_explain=float(left @ left) - 400, credible=True,
        fit=SimpleNamespace(campaign=noise), instead_of=None, best_chi2=float(left @ left), fit_chi2=float(left @ left),
        above_noise=float(left @ left) - 400,
    )  # fmt: skip
    regression, with_stress = told(residual), told(residual - 100 * spring)
    names = lambda single: hidden_by_each_other(regression, candidates, single, regression, built_in())  # pyright: ignore
    assert sorted(names(None) or ()) == ["cubic-stiffness", "pzt-hysteresis"]
    assert names(("residual-stress", with_stress)) == ("residual-stress", "pzt-hysteresis")
    nearly = told(residual - 100 * spring - 56 * loop)  # what a loop would add is 0.1 % of it all: a shape, not a name
    assert names(("residual-stress", nearly)) is None


def _candidate(name: str, rows: np.ndarray, residual: np.ndarray) -> Candidate:
    signature = np.linalg.qr(rows.T)[0].T
    drop = float(np.sum((signature @ residual) ** 2))
    return Candidate(name, drop, 0.0, len(rows), 0.0, {}, {}, {}, signature)


@pytest.mark.parametrize(("kept", "named"), [(0.05, False), (0.5, True)])
def test_a_pair_whose_refits_keep_little_of_what_is_left_is_no_pair(
    monkeypatch: pytest.MonkeyPatch, kept: float, named: bool
) -> None:
    """On an oscillator that no effect described, pairs that took 1 % of the misfit, by scores that promised all of it,
    were named one after the other."""
    noise = SimpleNamespace(fitted=[SimpleNamespace(noise=SimpleNamespace(relative_error=0.0))], fitted_sweeps=[])
    far = 100 * np.random.default_rng(3).normal(size=400)
    told = lambda left: SimpleNamespace(
        whitenings=(),
        n=400, residual=left, numbers=3, chi2=float(left @ left), to_explain=float(left @ left) - 400, instead_of=None,
        fit=SimpleNamespace(campaign=noise, holdout=None), best_chi2=float(left @ left), fit_chi2=float(left @ left),
        above_noise=float(left @ left) - 400,
    )  # fmt: skip
    before, after = told(far), told(np.sqrt(1 - kept) * far)
    monkeypatch.setattr(together, "score", lambda *_: [_candidate("one", far[None], far)])
    tried = SimpleNamespace(chi2=1.0, possible=True, gain=kept, left=np.ones(400), numbers=4)
    monkeypatch.setattr(together, "confirm", lambda *asked: SimpleNamespace(candidate=asked[2], **vars(tried)))
    monkeypatch.setattr(together, "accept", lambda *_: after.fit)
    monkeypatch.setattr(together, "working", lambda fit: fit)
    monkeypatch.setattr(together, "prepare", lambda _: after)
    monkeypatch.setattr(together, "behind_in_colour", lambda *_: -1.0)
    library = {name: SimpleNamespace(name=name, needs="") for name in ("one", "two")}
    found = together.both(before.fit, before, ("one", "two"), library, None, before)  # pyright: ignore
    assert (found is not None) is named
    monkeypatch.setattr(together, "score", lambda *_: [])  # the first absorbs all that the second does
    assert together.both(before.fit, before, ("one", "two"), library, None, before) is None  # pyright: ignore


@pytest.mark.parametrize(
    ("seed", "hidden", "records", "length"),
    [
        # Alone they explain 2 % and 1 % of what they explain together; quadratic stiffness 27 %.
        (9402, ("voltage-stiffness", "electrostriction"), 6, 1224),
        # A Bouc-Wen loop explains more than either, and both together all.
        (9304, ("squeeze-film-damping", "cubic-stiffness"), 7, 1200),
    ],
)
def test_effects_that_hide_each_other_are_found(seed: int, hidden: tuple[str, ...], records: int, length: int) -> None:
    case = draw(seed, hidden, size=0.03, noise=0.003, records=records, length=length, starts="mixed")
    campaign = campaign_of(case)
    found = diagnose(fit(Model(campaign.device), campaign)).discovery
    assert {step.added for step in found.steps if step.role == "effect"} == set(hidden)
    assert found.final.fitted.error_over_noise < 1.1


def test_what_builds_on_the_first_of_a_pair_may_be_the_second() -> None:
    """A drag was named beside a stop that loses energy, for before that was there the loss could not be asked."""
    rng, t, w = np.random.default_rng(3), np.arange(1500) / 100, 2 * np.pi * 2.5
    found = []
    for k, size in enumerate((1.0, 1.6, 2.2, 1.9)):
        drive = lambda at, a=size: a * np.sin(2 * np.pi * (1.2 * at + 0.12 * at**2))

        def rates(at: float, y: np.ndarray, drive=drive) -> list[float]:
            depth = max(y[0] - 2.0, 0.0)
            return [
                y[1],
                w * w * (0.4 * drive(at) - y[0] - 2.0 * depth**1.5 * max(1 + 0.02 * y[1], 0.0)) - w / 15 * y[1],
            ]

        z = solve_ivp(rates, (0.0, t[-1]), [0.0, 0.0], "LSODA", t, rtol=1e-9, atol=1e-12, max_step=2e-3).y[0]
        table = {"time": t, "drive": drive(t), "response": z + 0.01 * np.std(z) * rng.normal(size=len(t))}
        found.append({"data": table, "start": "rest", "holdout": k == 3})
    campaign = ident.read_campaign({"device": {"kind": "oscillator"}, "record": found})
    said = ident.discover(campaign)
    assert [step.added for step in said.discovery.steps] == ["end-stop", "contact-loss"]
    assert [step.tie_set for step in said.discovery.steps] == [("end-stop",), ("contact-loss",)]
    assert said.final.fitted.error_over_noise < 1.05 and said.verdict == "identified"
