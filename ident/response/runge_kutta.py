"""One step of the classical Runge–Kutta method of order 4, on a tuple of scalars.

Source: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 1993, §II.1.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from jax import Array

from .lane import Numbers

Slope = Callable[[tuple[Array, ...], tuple[Any, ...]], tuple[Array, ...]]


def runge_kutta(f: Slope, y: tuple[Array, ...], at: list[tuple[Any, ...]], h: Numbers) -> tuple[Array, ...]:
    """The state after a step `h` of y' = f(y, u); `at`: the inputs u at the beginning, the middle and the end."""
    return with_stages(f, y, at, h)[0]


def with_stages(
    f: Slope, y: tuple[Array, ...], at: list[tuple[Any, ...]], h: Numbers
) -> tuple[tuple[Array, ...], tuple[tuple[Array, ...], ...]]:
    """The same, and the four states at which the slope was asked for."""
    move = lambda k, step: tuple(a + step * b for a, b in zip(y, k, strict=True))
    k1 = f(y, at[0])
    k2 = f(second := move(k1, h / 2), at[1])
    k3 = f(third := move(k2, h / 2), at[1])
    k4 = f(last := move(k3, h), at[2])
    after = tuple(a + h / 6 * (p + 2 * q + 2 * r + s) for a, p, q, r, s in zip(y, k1, k2, k3, k4, strict=True))
    return after, (y, second, third, last)


def by_steps(grids: tuple[Numbers, ...]) -> Any:
    """Inputs on the half-step grid, (2 n + 1,) each, as a scan takes them: at beginning, middle and end of n steps."""
    return tuple((grid[:-1:2], grid[1::2], grid[2::2]) for grid in grids)


def stages(x: tuple[tuple[Any, ...], ...]) -> list[tuple[Any, ...]]:
    """One step of `by_steps`, as `runge_kutta` takes it."""
    return [tuple(grid[i] for grid in x) for i in range(3)]
