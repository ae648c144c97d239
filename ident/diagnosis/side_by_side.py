"""Two pieces of work at a time: what is not compiled code runs in one thread at a time, but that is the lesser part."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from ..pulse import Pulse, Report

A = TypeVar("A")
B = TypeVar("B")


def at_once(work: Callable[[A], B], items: Iterable[A], report: Report = lambda _: None, what: str = "") -> list[B]:
    """The work on each item, in their order; `report`ed under the name of `what` it is, if it takes long."""
    items = list(items)
    pulse = Pulse(report, what, len(items))

    def one(item: A) -> B:
        found = work(item)
        pulse.beat()
        return found

    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(one, items))
