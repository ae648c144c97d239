"""What is wrong with a record, in words."""

from __future__ import annotations

from collections.abc import Sequence

from ...campaign.record import Trace
from .nuisance import DROPPED, OWN_CLOCK, Nuisance


def words_of(one: Nuisance, traces: Sequence[Trace]) -> str:
    """What is wrong with a record."""
    size = f"{one.size:.4g}" if one.kind == "time-scale" else f"{one.size:.3g}"
    if one.unit == OWN_CLOCK:
        return f"by the clock of its drive the times of its response are {one.size:.6g} times what they say"
    if one.unit == DROPPED:
        return f"samples are missing: towards its end the response comes {abs(one.size):.3g} samples too early"
    if one.kind == "wrong-record":
        known = any(trace.name == one.unit for trace in traces)
        return (
            f"the response is that of {one.unit}" if known
            else f"it belongs to another device or load, with a resonance {one.size:+.2g} % off, or its time runs "
            f"{1 + one.size / 100:.3g} times as fast as it says"
        )  # fmt: skip
    return {
        "delay": f"the response comes {abs(one.size):.3g} samples {'late' if one.size > 0 else 'early'}",
        "gain": f"the response is {size} times what the others tell",
        "sign": f"the response is inverted ({size} times what the others tell)",
        "time-scale": f"its time runs {size} times as fast as it says, or its device is another or otherwise loaded",
        "drift": f"the response drifts by {size} noise floors",
    }[one.kind]
