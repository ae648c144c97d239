"""`ident sample` survives kill -9 at random moments."""

from __future__ import annotations

import pytest

from experiments.posterior import kill


@pytest.mark.slow
def test_a_killed_chain_goes_on_bit_by_bit():
    chains, refusals = kill.study(kills=2, seed=1)
    assert chains >= 1
    assert "cut short or damaged" in refusals[0] and "another run" in refusals[1]
