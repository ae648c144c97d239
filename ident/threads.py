"""Linear algebra in one thread, as long as a function of ident runs.

Our matrices are tall and thin. OpenBLAS, with which NumPy and SciPy come, shares even these among its threads, and
those wait by spinning: on a busy machine of two cores a campaign of seven records took twelve times the CPU to read,
and its diagnosis three times. JAX has threads of its own, which stay.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")


class _OneThread:
    """Entered by the first function of ident that runs and left by the last one, whichever thread each is in: the whole
    process has one number of threads, so what the user had is noted once and restored once."""

    def __init__(self) -> None:
        self._lock, self._inside = threading.Lock(), 0
        self._before: Any = None

    def __enter__(self) -> None:
        with self._lock:
            if not self._inside:
                from threadpoolctl import threadpool_limits

                self._before = threadpool_limits(1, "blas")
            self._inside += 1

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._inside -= 1
            if not self._inside:
                self._before.restore_original_limits()


_ONE = _OneThread()


def one_thread(function: Callable[P, T]) -> Callable[P, T]:
    """Decorator of what users call: BLAS works in one thread until it returns, and then as the user had it."""

    @wraps(function)
    def alone(*args: P.args, **kwargs: P.kwargs) -> T:
        with _ONE:
            return function(*args, **kwargs)

    return alone
