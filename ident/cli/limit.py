"""A limit of time for a long command, which keeps what was found until then."""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

_ENDLESS = 1e8  # minutes, more than a timer can be set to: "inf" is no limit, too


class OutOfTime(Exception):
    """The minutes that were given are over."""


class Limit:
    """A clock that raises `OutOfTime` in the main thread; `waiting()` holds it back while something is written.

    Where the system has no timer signal, it is asked between the stages of the work (`ask`).
    """

    def __init__(self, minutes: float | None):
        limited = None if minutes is None or not minutes < _ENDLESS else minutes
        self._end = None if limited is None else time.monotonic() + 60.0 * limited
        self._held = False

    def ask(self) -> None:
        """Raise if the time is over."""
        if self._end is not None and not self._held and time.monotonic() > self._end:
            raise OutOfTime

    @contextmanager
    def running(self) -> Iterator[None]:
        """The clock ticks while this lasts."""
        if self._end is None or not hasattr(signal, "setitimer"):
            yield
            return

        def ring(*_: Any) -> None:
            self.ask()

        before = signal.signal(signal.SIGALRM, ring)
        # Again every second: it may ring while something is written.
        signal.setitimer(signal.ITIMER_REAL, max(self._end - time.monotonic(), 1e-3) + 1e-2, 1.0)
        try:
            yield
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, before)

    @contextmanager
    def waiting(self) -> Iterator[None]:
        """Nothing is interrupted while this lasts."""
        self._held = True
        try:
            yield
        finally:
            self._held = False
