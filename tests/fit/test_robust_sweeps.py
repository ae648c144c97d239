"""A robust fit of curves beside traces: what starts move are the traces alone."""

from __future__ import annotations

from dataclasses import replace

import ident
from tests.end_to_end.user import DATA


def test_a_campaign_of_sweeps_and_a_trace_is_fitted_robustly():
    sweeps = ident.read_campaign(DATA / "platform_sweeps")
    (trace, *_) = ident.read_campaign(DATA / "platform_317hz").traces
    both = replace(sweeps, records=(*sweeps.records, replace(trace, start="unknown")))
    found = ident.fit(both, (), robust=True)
    assert found.fitted.error_over_noise > 1 and found.converged
