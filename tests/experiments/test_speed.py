"""The two sides of the speed study solve the same problem; times are left to the study itself."""

import numpy as np
import pytest

from experiments.benchmarks import peers, speed
from ident.fit import solve
from ident.fit.assemble import begin
from ident.response import respond


@pytest.fixture(scope="module")
def case() -> speed.Setting:
    return speed.Setting()


def test_one_simulation_is_the_same_on_both_sides(case) -> None:
    ours = respond(case.equation, case.tape, case.truth, np.zeros((1, 2))).readings
    theirs = peers.simulate(case.theta, *case.peer, np.empty(len(case.response)))
    assert np.max(np.abs(ours - theirs)) < 1e-3 * np.std(theirs)  # σ23 is rounded on one side


def test_both_searches_end_at_one_minimum(case) -> None:
    move = case.starts(3)[2]
    static, data = case.assembled(case.from_start(move))
    ours = solve.least_squares(static, data, begin(data, static), solve.How())[1]
    theirs = peers.fit_numba(case.theta * move, *case.peer, case.response, speed.SIGMA)
    assert ours.converged
    assert ours.cost == pytest.approx(2 * theirs.cost, rel=1e-3)


def test_the_fastest_of_several_turns_counts() -> None:
    calls: list[str] = []
    best = speed.fastest({"a": lambda: calls.append("a"), "b": lambda: calls.append("b")}, 3)
    assert set(best) == {"a", "b"} and calls == ["a", "b"] * 4


def test_a_bound_is_kept_from_its_own_side() -> None:
    assert speed.Line("", 0.2, "", 0.3).kept and not speed.Line("", 0.4, "", 0.3).kept
    assert speed.Line("", 2.0, "", 1.0, True).kept and not speed.Line("", 0.5, "", 1.0, True).kept
