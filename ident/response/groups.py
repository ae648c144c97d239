"""Records of similar length and step are padded to one shape and solved together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..campaign.drive import drive_frequency, half_step_drive
from ..campaign.record import Trace
from .lane import Lane


class Group(NamedTuple):
    """Records solved in one batch, as arrays for the compiled code.

    **Arguments:**

    - `lanes`: the records' drive; `response`: (lanes, n) measured, m.
    - `weight`: (lanes, n) 1/σ, zero where a sample is padding or is not counted.
    - `free`: (lanes, 2) 1 where the initial state is fitted, 0 where the record starts at rest.
    - `start_scale`: (2,) typical displacement and velocity, the unit of the fitted initial states.
    """

    lanes: Lane
    response: np.ndarray
    weight: np.ndarray
    free: np.ndarray
    start_scale: np.ndarray


class Layout(NamedTuple):
    """Where each record went: `substeps` per group; `places`, (group, lane, samples) per record."""

    substeps: tuple[int, ...]
    places: tuple[tuple[int, int, int], ...]

    @property
    def per_record(self) -> list[int]:
        """Substeps of each record."""
        return [self.substeps[group] for group, _, _ in self.places]


_LONGEST_PADDING = 1.5  # a record is padded to at most this multiple of its own length


def make_groups(
    records: Sequence[Trace], frequency: float, quality: float, finest: int = 0, substeps: Sequence[int] | None = None
) -> tuple[tuple[Group, ...], Layout]:
    """Pack records into batches with a solver step small enough for their noise floors.

    **Arguments:** `frequency` (Hz) and `quality` of the resonance, roughly; `finest`, steps per period of the
    resonance that the sharpest effect of the model needs; `substeps`, solver steps per sample of
    each record, if they are to be other than that.
    """
    substeps = substeps or [_substeps(record, frequency, quality, finest) for record in records]
    order = sorted(range(len(records)), key=lambda i: (substeps[i], len(records[i].time)))
    bins: list[list[int]] = []
    for i in order:
        first = bins[-1][0] if bins else None
        fits = first is not None and substeps[first] == substeps[i]
        if fits and len(records[i].time) <= _LONGEST_PADDING * len(records[first].time):  # type: ignore[index]
            bins[-1].append(i)
        else:
            bins.append([i])
    places: list[tuple[int, int, int]] = [(0, 0, 0)] * len(records)
    for g, members in enumerate(bins):
        for lane, i in enumerate(members):
            places[i] = (g, lane, len(records[i].time))
    groups = tuple(_pack([records[i] for i in members], substeps[members[0]], frequency) for members in bins)
    return groups, Layout(tuple(substeps[members[0]] for members in bins), tuple(places))


def _substeps(record: Trace, frequency: float, quality: float, finest: int) -> int:
    """Steps per sample for which the method's error moves the natural frequency by less than a tenth of its error bar.

    The phase error of Runge–Kutta steps is (ωh)⁴/120 per radian. It always has the same sign, so that samples do not
    average it as they do the noise: near resonance ln ω is known to σ/(2Q √n rms); a tenth of that is allowed.
    (With σ/10 instead of σ/(10 √n) 400 simulated campaigns returned frequencies 0.18 error bars too high.)
    In an excerpt no frequency is reported: σ/10 is fine, and so is half of the steps that sharp effects need.
    """
    signal = float(np.std(record.response)) or 1.0
    share = 0.1 / (1.0 if record.excerpt else math.sqrt(len(record.time)))
    allowed = share * min(max(record.noise.sigma / signal, 1e-4), 0.1)
    largest = (120 * allowed / max(2 * quality, 2.0)) ** 0.25
    if finest:
        largest = min(largest, 2 * math.pi / finest * (2 if record.excerpt else 1))
    omega = 2 * math.pi * frequency
    return int(np.clip(math.ceil(omega * record.step / largest - 0.05), 1, 32))


def _pack(records: Sequence[Trace], substeps: int, frequency: float) -> Group:
    n = max(len(record.time) for record in records)
    drives = [half_step_drive(record, substeps) for record in records]
    fill = lambda a, size, mode: np.pad(a, (0, size - len(a)), mode=mode)
    voltage = np.stack([fill(v, 2 * (n - 1) * substeps + 1, "edge") for v, _ in drives])
    rate = np.stack([fill(r, 2 * (n - 1) * substeps + 1, "constant") for _, r in drives])
    weight = np.stack([fill(_weight(record, frequency), n, "constant") for record in records])
    amplitude = max(float(np.max(np.abs(record.response))) for record in records) or 1.0
    return Group(
        Lane(
            np.array([record.step / substeps for record in records]),
            voltage,
            rate,
            np.array([drive_frequency(record) for record in records]),
            np.array([record.load for record in records]),
            np.array([float(record.begins_in_motion) for record in records]),
        ),
        np.stack([fill(record.response, n, "constant") for record in records]),
        weight,
        np.array([[float(record.start != "rest")] * 2 for record in records]),
        amplitude * np.array([1.0, 2 * math.pi * frequency]),
    )


_TIED_FOR = 0.25  # of a period of the resonance: two numbers, displacement and velocity, need no more


def _weight(record: Trace, frequency: float) -> np.ndarray:
    """1/σ of the samples that count, (n,).

    Of skipped ones the first hold the initial state: without them nothing does, and a start that is free runs away to
    where it mimics a little of what the model lacks. They weigh as much as any sample, for what a wrong model gains by
    such a start grows with its misfit in noise floors too.
    """
    index = np.arange(len(record.time))
    first = index < max(round(_TIED_FOR / (frequency * record.step)), 5)
    counted = (index >= record.skip) | (first if record.start != "rest" else False)
    return counted / record.noise.sigma
