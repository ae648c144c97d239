"""The forms that a linear model with one degree of freedom can take, as filters exact for a drive linear between
samples."""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from .stretches import Stretch, answered, free_motion, oscillator_filter, sampled_filter

_POINTS_PER_OCTAVE = 5  # Nelder and Mead find the rest


class Form(ABC):
    """One form: its trial `point`s are (frequency Hz, quality), or (decay time s,) without a spring.

    `family`: what a campaign calls it; `least` and `most`: where the trial values keep the form.
    """

    name: ClassVar[str]
    family: ClassVar[str]
    least: ClassVar[tuple[float, ...]]
    most: ClassVar[tuple[float, ...]]

    @abstractmethod
    def grid(self, stretches: Sequence[Stretch]) -> list[tuple[float, ...]]:
        """Points worth trying on these records."""

    @abstractmethod
    def answer(self, point: np.ndarray, stretch: Stretch, push: np.ndarray) -> np.ndarray:
        """Displacement (n,) under a push (n,), m/s², from rest."""

    @abstractmethod
    def free(self, point: np.ndarray, stretch: Stretch) -> np.ndarray:
        """What a start in motion adds, (n, 2)."""

    @abstractmethod
    def parameters(self, point: np.ndarray, stretches: Sequence[Stretch]) -> tuple[float, float]:
        """The model's first two parameters."""

    @abstractmethod
    def point(self, first: float, second: float) -> np.ndarray:
        """The trial point of those parameters."""

    def told(self, point: np.ndarray, stretches: Sequence[Stretch]) -> np.ndarray:
        """The point that samples tell from others: where they do not, the one nearest to what they can."""
        return point


class _WithSpring(Form):
    qualities: ClassVar[tuple[float, ...]]
    family = "oscillator"

    def grid(self, stretches: Sequence[Stretch]) -> list[tuple[float, ...]]:
        lowest = min(1.0 / (stretch.step * len(stretch.response)) for stretch in stretches)
        highest = max(0.3 / stretch.step for stretch in stretches)
        count = max(int(_POINTS_PER_OCTAVE * math.log2(highest / lowest)), 8)
        return list(itertools.product(np.geomspace(lowest, highest, count), self.qualities))

    def answer(self, point: np.ndarray, stretch: Stretch, push: np.ndarray) -> np.ndarray:
        filter_of = lambda step: oscillator_filter(point[0], point[1], step, stretch.order, stretch.edge)
        return answered(stretch, filter_of, push)

    def free(self, point: np.ndarray, stretch: Stretch) -> np.ndarray:
        return free_motion(stretch, float(point[0]), float(point[1]))

    def parameters(self, point: np.ndarray, stretches: Sequence[Stretch]) -> tuple[float, float]:
        return float(point[0]), float(point[1])

    def point(self, first: float, second: float) -> np.ndarray:
        return np.array([first, second])


class Underdamped(_WithSpring):
    """z̈ + (ω0/Q) ż + ω0² z = g u with Q > ½: it rings."""

    name = "oscillator"
    qualities = (0.7, 2.0, 8.0, 40.0)
    least, most = (0.0, 0.5), (math.inf, 1e4)


class Overdamped(_WithSpring):
    """The same with Q < ½: it creeps back."""

    name = "overdamped"
    qualities = (0.05, 0.15, 0.4)
    least, most = (0.0, 1e-3), (math.inf, 0.5)

    def told(self, point: np.ndarray, stretches: Sequence[Stretch]) -> np.ndarray:
        """A decay that is over within a sample might be of any rate: it is taken as falling to 5 % in one."""
        omega, quality = 2 * math.pi * float(point[0]), float(point[1])
        fast = omega / (2 * quality) * (1 + math.sqrt(max(1 - 4 * quality**2, 0.0)))
        seen = 3.0 / min(stretch.step for stretch in stretches)
        if fast <= seen:
            return point
        slow = omega**2 / fast
        omega = math.sqrt(seen * slow)
        return np.array([omega / (2 * math.pi), omega / (seen + slow)])


class OnBase(_WithSpring):
    """z̈ + (ω0/Q) (ż − g u̇) + ω0² (z − g u) = 0: spring and damper stand on a base, which is what the drive moves."""

    name = "base"
    qualities = (0.15, 0.4, 1.0, 3.0, 12.0, 40.0)
    least, most = (0.0, 1e-2), (math.inf, 1e4)

    def answer(self, point: np.ndarray, stretch: Stretch, push: np.ndarray) -> np.ndarray:
        """To the drive of the stretch, the only thing that moves its base."""
        omega = 2 * math.pi * float(point[0])
        return super().answer(point, stretch, omega**2 * push + omega / float(point[1]) * stretch.push_rate)


class Shaken(OnBase):
    """The same where accelerations were measured, of the base as the drive and of the body as the response: they are
    to one another as the displacements are."""

    name = "shaken"

    def answer(self, point: np.ndarray, stretch: Stretch, push: np.ndarray) -> np.ndarray:
        return super().answer(point, stretch._replace(order=0), push)


class NoSpring(Form):
    """z̈ + ż/τ = g u + F0: a mass and a damper, which stay where they are left."""

    name = "no-spring"
    family = "no-spring"
    least, most = (0.0,), (math.inf,)

    def grid(self, stretches: Sequence[Stretch]) -> list[tuple[float, ...]]:
        longest = max(stretch.step * len(stretch.response) for stretch in stretches)
        shortest = min(stretch.step for stretch in stretches)
        return [(tau,) for tau in np.geomspace(shortest, 10 * longest, 40)]

    def answer(self, point: np.ndarray, stretch: Stretch, push: np.ndarray) -> np.ndarray:
        filter_of = lambda step: _drifting_filter(float(point[0]), step, stretch.order, stretch.edge)
        return answered(stretch, filter_of, push)

    def free(self, point: np.ndarray, stretch: Stretch) -> np.ndarray:
        t = stretch.step * np.arange(len(stretch.response))
        fading = np.expm1(-t / point[0])[:, None]
        return 1.0 + fading if stretch.order else np.hstack([np.ones_like(fading), fading])

    def parameters(self, point: np.ndarray, stretches: Sequence[Stretch]) -> tuple[float, float]:
        """A time scale of the motion, rms(ż)/rms(z)/2π Hz, in the place of a frequency; the decay time."""
        rates = [np.std(np.diff(p.response)) / np.std(p.response) / p.step / (2 * np.pi) for p in stretches]
        return float(np.median(rates)), float(point[0])

    def point(self, first: float, second: float) -> np.ndarray:
        return np.array([second])


def _drifting_filter(tau: float, step: float, order: int, edge: float | None) -> tuple[np.ndarray, np.ndarray]:
    """Digital filter (b, a) of z̈ + ż/τ = u, as `oscillator_filter`."""

    def ramp(t: np.ndarray, order: int) -> np.ndarray:
        x = t / tau
        if order == 0:
            series = x**3 / 6 - x**4 / 24 + x**5 / 120 - x**6 / 720
            return tau**3 * np.where(x < 0.05, series, x**2 / 2 - x - np.expm1(-x))
        if order == 1:
            return tau**2 * np.where(x < 0.05, x**2 / 2 - x**3 / 6 + x**4 / 24 - x**5 / 120, x + np.expm1(-x))
        return -tau * np.expm1(-x) if order == 2 else np.exp(-x)

    decay = math.exp(-step / tau)
    return sampled_filter(ramp, np.array([1.0, -1.0 - decay, decay]), step, order, edge)


FORMS: dict[str, Form] = {form.name: form for form in (Underdamped(), Overdamped(), OnBase(), Shaken(), NoSpring())}
