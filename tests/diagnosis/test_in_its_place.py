"""What was written from a misfit stands in the place of named effects only if it is better than they are."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

import ident
from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import draw
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.search.steps import Discovery, Step
from ident.diagnosis.search.written import _by_itself, beyond_library, outdoes
from ident.effects.registry import built_in
from ident.fit import fit
from ident.model import Model


def test_more_numbers_that_tell_no_more_replace_no_name() -> None:
    """A loudspeaker's stiffening suspension and losses had left 5.79 noise floors, and a formula of thirteen numbers
    that left 5.77 took their place: "no effect of the library helps"."""
    case = draw(41, ("cubic-stiffness",), size=0.05, noise=0.004, records=4, length=700, detail="plain")
    campaign, library = campaign_of(case), built_in()
    start = Model(campaign.device)
    named = fit(start + library["cubic-stiffness"](), campaign)
    bent = fit(start + library["cubic-stiffness"]() + library["residual-stress"](), campaign)
    assert bent.fitted.chi2 <= named.fitted.chi2 * 1.001
    assert not outdoes(named, bent)
    assert not outdoes(named, fit(start, campaign))
    assert outdoes(fit(start, campaign), named)


def test_what_was_written_stands_alone_where_the_names_before_it_do_no_more() -> None:
    """|z| of a beam with a crack had two names before it, of which nothing remained beside it."""
    case = draw(42, ("cubic-stiffness",), size=0.05, noise=0.004, records=4, length=700)
    campaign, library = campaign_of(case), built_in()
    start = fit(Model(campaign.device), campaign)
    first = prepare(start)
    for hidden, superfluous in (("quadratic-stiffness", True), ("cubic-stiffness", False)):
        last = ({"quadratic-stiffness", "cubic-stiffness"} - {hidden}).pop()
        one = fit(start.model + library[hidden](), campaign)
        both = fit(one.model + library[last](), campaign)
        steps = tuple(Step(n, 1.0, 1.0, (n,), "effect", f) for n, f in ((hidden, one), (last, both)))
        alone = _by_itself(Discovery("not-in-library", start, steps, (), {}, (), first), first, lambda _: None)
        assert (alone is not None) is superfluous
        if alone is not None:
            assert alone.model.names == (last,)


def _one_way() -> list[dict]:
    """An oscillator of 150 Hz whose damper is stronger one way, F = −4 |v|; the last record is held out."""
    w, time, rng, records = 2 * np.pi * 150.0, np.arange(1500) / 4500, np.random.default_rng(3), []
    for k, tones in enumerate(((93.0,), (148.0,), (60.0, 113.0, 139.0, 151.0, 188.0), (75.0, 110.0, 146.0, 163.0))):
        phases = rng.uniform(0, 2 * np.pi, len(tones))
        push = lambda t, f=tones, p=phases: np.sum(np.sin(2 * np.pi * np.multiply.outer(t, f) + p), axis=-1)
        law = lambda t, y, u=push: [y[1], w * w * (u(t) - y[0]) - w / 40 * y[1] - 4.0 * abs(y[1])]
        z = solve_ivp(law, (0, time[-1]), [0, 0], t_eval=time, rtol=1e-8, atol=1e-9, max_step=3e-4).y[0]
        z = z + 4e-3 * np.std(z) * rng.normal(size=len(time))
        records.append({"data": {"time": time, "drive": push(time), "response": z}, "start": "rest", "holdout": k == 3})
    return records


def test_one_law_of_a_coordinate_takes_the_place_of_several_names_that_come_near(tmp_path: Path) -> None:
    start = ident.fit({"device": {"kind": "oscillator"}, "record": _one_way()}, effects=())
    library = built_in()
    one = fit(start.model + library["quadratic-stiffness"](), start.campaign)
    two = fit(one.model + library["electrostriction"](), start.campaign, initial=np.append(one.values, 0.0))
    steps = tuple(Step(f.model.names[-1], 1.0, 1.0, (f.model.names[-1],), "effect", f) for f in (one, two))
    regression = prepare(start)
    named = Discovery("ambiguous", start, steps, (), {}, (), prepare(two), lacking=0.04)
    said = beyond_library(named, regression, tmp_path / "law.py", keeps_walk=True)
    assert said.discovery.verdict == "not-in-library" and said.path is not None and said.path.exists()
    assert said.unknown is not None and said.unknown.coordinates == ("v",)
    assert said.discovery.final.fitted.error_over_noise < 1.05 < two.fitted.error_over_noise
    family = replace(named, confirmed={"power-law-damping": 1.0})  # tried by itself, and called by its member
    assert beyond_library(family, regression, tmp_path / "law2.py", keeps_walk=True).discovery is family
    alone = Discovery("ambiguous", start, steps[:1], (), {}, (), prepare(one), lacking=0.04)
    kept = beyond_library(alone, regression, tmp_path / "other.py", keeps_walk=True)
    assert kept.discovery is alone and not (tmp_path / "other.py").exists()


def test_sure_names_are_in_doubt_beside_one_law_that_says_more_with_fewer_numbers(tmp_path: Path) -> None:
    """A sine of less than a turn was a bent spring with a stop at its end, for sure."""
    start = ident.fit({"device": {"kind": "oscillator"}, "record": _one_way()}, effects=())
    two = ident.fit(start.campaign, effects=("power-law-damping", "electrostriction"))
    names = two.model.names
    steps = tuple(Step(name, 1.0, 1.0, (name,), "effect", two) for name in names)
    sure = Discovery("identified", start, steps, (), {}, (), prepare(two))
    said = beyond_library(sure, prepare(start), tmp_path / "law.py", keeps_walk=True)
    assert said.discovery.verdict == "ambiguous" and "|v|" in said.discovery.shorter
    assert said.discovery.final is two and said.path is not None and said.path.exists()

    case = draw(43, ("quadratic-stiffness", "cubic-stiffness"), size=0.05, noise=0.004, records=4, length=700)
    campaign, library = campaign_of(case), built_in()
    start = fit(Model(campaign.device), campaign)
    both = fit(start.model + library["quadratic-stiffness"]() + library["cubic-stiffness"](), campaign)
    steps = tuple(Step(name, 1.0, 1.0, (name,), "effect", both) for name in both.model.names)
    sure = Discovery("identified", start, steps, (), {}, (), prepare(both))
    assert beyond_library(sure, prepare(start), tmp_path / "other.py", keeps_walk=True).discovery is sure
    assert not (tmp_path / "other.py").exists()
