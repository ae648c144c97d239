"""How far a long stage has come, told now and then."""

from __future__ import annotations

import time
from collections.abc import Callable

Report = Callable[[str], None]
_SILENT = 2.0  # s: a shorter stage, and the time between two lines of a longer one


class Pulse:
    """Counts what a stage has done and reports it at most every two seconds, with the time left where that is known.

    **Arguments:** `what` the stage does; `total`, how many parts it has, 0 if nobody knows.
    """

    def __init__(self, report: Report, what: str, total: int = 0):
        self._report, self._what, self._total = report, what, total
        self._begun = self._told = time.monotonic()
        self._done = 0

    def beat(self, more: str = "") -> None:
        """One part is done; `more` to say about it."""
        self._done += 1
        now = time.monotonic()
        if now - self._told < _SILENT:
            return
        self._told = now
        left = (now - self._begun) / self._done * (self._total - self._done)
        count = f"{self._done} of {self._total}, about {left:.0f} s left" if self._total else f"step {self._done}"
        self._report(f"{self._what}: {count}{more and ', '}{more}")
