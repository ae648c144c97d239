"""A slice of the convergence study: three starts at ±30 %, one campaign."""

from experiments.convergence import convergence
from experiments.recovery.campaigns import draw


def test_starts_at_thirty_per_cent_reach_one_minimum() -> None:
    convergence.check_starts(convergence.from_thirty_per_cent(3))


def test_a_guess_reaches_the_minimum_that_the_truth_leads_to() -> None:
    assert convergence.reaches(*convergence.from_guess_and_truth(draw(101)))
