"""A linear model that records may start from."""

from __future__ import annotations

import math
from typing import NamedTuple

from ...campaign.held_drive import Edges
from .modes import Mode


class Candidate(NamedTuple):
    """One linear model.

    **Arguments:** `form`: its name, also "constant" and "quasi-static"; `level`: whether with a constant; `left`: rms
    of what it leaves over that of the signal; `numbers`: how many are fitted beside the initial states; `criterion`;
    `first`, `second`: frequency (Hz) and quality, or a time scale (Hz) and the decay time (s) without a spring; `gain`
    ((m/s²)/V) and `constant` (N, or m in the reading); `further` modes of an oscillator; `edges` of the
    drives between their samples.
    """

    form: str
    level: bool
    left: float
    numbers: int
    criterion: float = math.inf
    first: float = math.nan
    second: float = math.nan
    gain: float = 0.0
    constant: float = 0.0
    further: tuple[Mode, ...] = ()
    edges: Edges = Edges()

    @property
    def words(self) -> str:
        """What it is, for a table."""
        names = {"constant": "a constant", "quasi-static": "gain and offset, no inertia", "overdamped":
                 "oscillator, overdamped", "no-spring": "mass and damper, no spring",
                 "base": "oscillator on a base that the drive moves",
                 "shaken": "oscillator shaken by its base"}  # fmt: skip
        level = {"constant": "", "quasi-static": "", "no-spring": ", constant force"}.get(self.form, ", offset")
        modes = f", {1 + len(self.further)} modes" if self.further else ""
        held = "" if self.edges.first is None else ", drive held"
        held += "" if self.edges.everywhere else " where it jumps"
        return names.get(self.form, self.form) + modes + (level if self.level else "") + held
