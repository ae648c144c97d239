"""Two pieces of work at a time: most of each is tracing, which one thread does at a time, and compiling, which needs
no more than one core."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

A = TypeVar("A")
B = TypeVar("B")


def at_once(work: Callable[[A], B], items: Iterable[A]) -> list[B]:
    """The work on each item, in their order."""
    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(work, items))
