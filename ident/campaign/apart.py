"""A record that differs from the others in numbers of its own, read as if it did not."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from .campaign import Campaign
from .corners import drive_at
from .device import Device, response_unit
from .late import in_time
from .record import Kind, Trace, common_order


class Told(NamedTuple):
    """How a kind of numbers is told to people: `what` each record has, numbers times `times` in `unit`, or as they are
    in that of the reading if there is none, and `why`; how many `each` has, whether what all have is the device's own,
    and the `most` that a number can be, of a zero in signals: more says nothing of this device.

    `of_device`: the device itself is another one, of which a simulation takes account; `of_time`: it moves the samples
    of the drive beside those of the response; `of_zero`: the sensor has this zero, and no common one beside it."""

    what: str
    times: float
    unit: str
    why: str
    most: float
    each: int = 1
    shared: bool = False
    of_device: bool = False
    of_time: bool = False
    of_zero: bool = False


TOLD: dict[Kind, Told] = {
    # A resonance moves by half of what its spring does.
    "stiffness": Told("resonance", 50.0, "%", "was the device warmer or otherwise loaded in some?", 0.5, shared=True,
                      of_device=True),
    "damping": Told("damping", 100.0, "%", "was the pressure another, or a clamp less tight?", 0.9, shared=True,
                    of_device=True),
    "sensitivity": Told("sensitivity", 100.0, "%", "was the sensor moved?", 0.9, shared=True),
    "delay": Told("delay", 1.0, "samples", "did each have a trigger of its own?", 100.0, of_time=True),
    "clock": Told("clock", 1e6, "ppm", "do generator and recorder run by one clock?", 0.1, of_time=True),
    "level": Told("zero", 1.0, "", "was the sensor set anew, or is it AC coupled?", 100.0, of_zero=True),
    "baseline": Told("baseline", 100.0, "% of its signal", "does the sensor drift?", 100.0, each=3,
                     of_zero=True),
}  # fmt: skip


def curves(trace: Trace) -> np.ndarray:
    """The curves that the numbers of a baseline, in the unit of the reading, multiply, (3, n): a level, a line and a
    parabola; the first is that of a level alone."""
    t = np.linspace(-1.0, 1.0, len(trace.time))
    return np.stack([np.ones_like(t), t, 1.5 * t**2 - 0.5])


def signal_of(trace: Trace) -> float:
    """What a zero is compared with: the rms of the response about its mean."""
    return float(np.std(trace.response[trace.counted]))


def read_apart(trace: Trace, kind: Kind, sizes: Iterable[float]) -> Trace:
    """A trace that differs by numbers of its own, read as one of a device like the others, as far as it can be.

    Of its own stiffness or damping a simulation takes account; the response is taken back from its sensitivity, its
    delay in samples or the curves of its baseline, time and drive from the share by which the recorder's clock is fast.
    """
    told = (kind, tuple(float(size) for size in sizes))
    if TOLD[kind].of_device:
        return replace(trace, own=told)
    if kind == "delay":
        return replace(in_time(trace, told[1][0]), own=told)
    if kind == "clock":
        index, ran = np.arange(len(trace.time)), 1 - told[1][0]
        drive = drive_at(trace.drive, np.clip(index * ran, 0, index[-1]))
        return replace(trace, own=told, time=trace.time * ran, into=trace.into * ran, drive=drive)
    if TOLD[kind].of_zero:
        return replace(trace, own=told, response=trace.response - np.asarray(told[1]) @ _own_curves(trace, kind))
    times = 1 / (1 + told[1][0])
    noise = replace(trace.noise, sigma=trace.noise.sigma * times)
    return replace(trace, own=told, response=trace.response * times, noise=noise)


def as_it_came(trace: Trace) -> Trace:
    """A trace as it came, of one that was read by a zero of its own."""
    if trace.own is None or not TOLD[trace.own[0]].of_zero:
        return trace
    kind, sizes = trace.own
    return replace(
        trace, own=None, floats=False, response=trace.response + np.asarray(sizes) @ _own_curves(trace, kind)
    )


def _own_curves(trace: Trace, kind: Kind) -> np.ndarray:
    """Of what a zero of a record's own is a sum, (q, n)."""
    return curves(trace)[: TOLD[kind].each]


def zero_curves(trace: Trace) -> np.ndarray:
    """Of what a zero is a sum, (q, n), that is fitted with every model; q = 0 if there is none."""
    return (
        _own_curves(trace, trace.own[0]) if trace.floats and trace.own is not None else np.zeros((0, len(trace.time)))
    )


def read_on(trace: Trace, part: np.ndarray) -> Trace:
    """A trace read by a zero that is larger than before by some `part` (n,), a sum of its curves."""
    if trace.own is None or not trace.floats:
        return trace
    kind, sizes = trace.own
    more = np.linalg.lstsq(_own_curves(trace, kind).T, part, rcond=None)[0]
    own = (kind, tuple(float(a + b) for a, b in zip(sizes, more, strict=True)))
    return replace(trace, own=own, response=trace.response - part)


def floating(campaign: Campaign) -> Campaign:
    """The campaign with the zeros of its records' own, if they have such, fitted anew with every model."""
    of_zero = lambda r: isinstance(r, Trace) and r.own is not None and TOLD[r.own[0]].of_zero
    return replace(campaign, records=tuple(replace(r, floats=True) if of_zero(r) else r for r in campaign.records))


def size_of(trace: Trace) -> float:
    """How large the numbers of a trace that differs are, as they are told; of a baseline how far it moves."""
    if trace.own is None:
        return 0.0
    kind, sizes = trace.own
    t = np.linspace(-1.0, 1.0, 101)
    moved = sizes[0] if len(sizes) == 1 else float(np.ptp(sizes[1] * t + sizes[2] * 1.5 * t**2))
    return times_of(trace, kind) * moved


def times_of(trace: Trace, kind: Kind) -> float:
    """By what a number of a trace is multiplied to be told."""
    of_signal = TOLD[kind].of_zero and TOLD[kind].unit
    return TOLD[kind].times / ((signal_of(trace) or 1.0) if of_signal else 1.0)


def told_in(kind: Kind, traces: Sequence[Trace], device: Device) -> str:
    """The unit in which the numbers of some traces are told: the kind's own, or else that of their readings, SI."""
    return TOLD[kind].unit or response_unit(device) + ("", "/s", "/s^2")[common_order(traces)]
