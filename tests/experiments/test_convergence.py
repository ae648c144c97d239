"""A slice of the convergence study: three starts at ±30 %, two campaigns."""

from experiments.convergence import convergence
from experiments.recovery.campaigns import draw


def test_starts_at_thirty_per_cent_reach_one_minimum() -> None:
    convergence.check_starts(convergence.from_thirty_per_cent(3))


def test_a_guess_reaches_the_minimum_that_the_truth_leads_to() -> None:
    convergence.check_campaigns([convergence.from_guess_and_truth(draw(seed)) for seed in (101, 102)])
