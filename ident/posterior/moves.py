"""How the ensemble moves: independent proposals from a density like the posterior, and differential evolution.

No snooker move: that of emcee 3.1.6 draws a wrong posterior (unit Gaussian in eight dimensions: variance 0.63).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from emcee.moves import DEMove, RedBlueMove

from .bent import Bent
from .laplace import StudentT

# Of independent proposals and of differential evolution, which needs no proposal that fits. On the weak posterior of
# experiments/posterior/speed.py the slowest parameter took 8 to 10 steps with the first alone, 5 to 12 with a fifth of
# the second, 10 to 26 with half; on the sharp one 2, 3 and 4.
_SHARES = (0.7, 0.3)


class IndependenceMove(RedBlueMove):
    """Proposes from a fixed density q whatever the present position; accepts by p(new) q(old) / (p(old) q(new)).

    Source: L. Tierney, Markov chains for exploring posterior distributions, Ann. Stat. 22 (1994) 1701, §2.3.3.
    """

    def __init__(self, target: StudentT | Bent):
        self.target = target
        super().__init__()

    def get_proposal(self, sample: np.ndarray, complement: list[np.ndarray], random: Any) -> tuple[Any, Any]:
        """Proposals (k, p) for a half of the ensemble, and ln q(old) − ln q(new)."""
        new = self.target.draw(random, len(sample))
        return new, self.target.log_density(sample) - self.target.log_density(new)


def moves(target: StudentT | Bent) -> list[tuple[Any, float]]:
    """The moves of the sampler with their shares."""
    return [(IndependenceMove(target), _SHARES[0]), (DEMove(), _SHARES[1])]
