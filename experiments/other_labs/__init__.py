"""Devices of other laboratories, by force laws and a solver of their own: `python -m experiments.other_labs`."""

from __future__ import annotations

from . import (
    devices,
    driven_far,
    held,
    in_machines,
    of_structures,
    on_base,
    on_benches,
    ringing,
    through_sensors,
    with_friction,
    with_play,
)
from .lab import DEVICES, Lab

__all__ = [
    "DEVICES",
    "Lab",
    "devices",
    "driven_far",
    "held",
    "in_machines",
    "judge",
    "of_structures",
    "on_base",
    "on_benches",
    "ringing",
    "through_sensors",
    "with_friction",
    "with_play",
]

OFFSETS = frozenset({"sensor-offset", "static-force"})
"""A level, which is in many records and no fault to name."""
DESCRIBED = 0.9  # of the misfit: what a law that the library lacks must be described to, as a function of coordinates


def judge(name: str, found: dict) -> str:
    """ "right", "right, with a doubt", "doubt" (a wrong name, not called sure) or "wrong"."""
    hidden, final = DEVICES[name].hidden, set(found["final"]["effects"]) - OFFSETS
    sure = found["verdict"] in ("identified", "adequate")
    if hidden is None:
        told = (found.get("unknown") or {}).get("explains", 0.0)
        return "wrong" if sure else "right" if told > DESCRIBED else "doubt"
    tied = [set(step["tie_set"]) | {step["added"]} for step in found["steps"]]
    named = all(names & (final | {*found["final"]["effects"]} | set().union(*tied)) for names in hidden)
    extra = final - frozenset().union(*hidden)
    if named and not extra:
        return "right" if sure or any(len(tie) > 1 for tie in tied) else "right, with a doubt"
    return "wrong" if sure else "doubt"
