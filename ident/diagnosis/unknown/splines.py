"""Functions of what a record shows (where the stage was, how the drive went), as rows that a regression can weigh.

A missing force is looked for as a sum of B-splines of one coordinate or of a pair, with kinks and steps beside them
that no smooth spline has, or as a sum of what the displacement or the voltage leaves behind: plays and relaxations.

Source: C. de Boor, A Practical Guide to Splines, 1978, ch. IX (B-splines); P. Krejčí, Hysteresis, Convexity and
Dissipation, 1996, §II.2 (plays span the rate-independent memories).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy.interpolate import BSpline

from ...campaign.noise.recursive import recursive_filter
from ...effects.dependence import COORDINATES
from ...response.lane import Lane
from ..linearised.trajectory import Path

# dV is V̇/ω, so that records of any frequency compare.
UNITS = {"z": "m", "v": "m/s", "V": "V", "dV": "V", "t": "s", "rate": "V/s"}

_SINGLE, _PAIRED, _DEGREE = 18, 6, 3  # splines of one coordinate at first, of each of two; and their degree
_SELDOM = 0.002  # of the points of a record: on either side, as many are where its coordinate seldom was
_WIDTHS = (0.02, 0.05, 0.1, 0.18, 0.3, 0.45, 0.6, 0.8)  # of the plays, in parts of the largest value
_TIMES = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 40.0)  # of the relaxations, in periods of the resonance

_STEPS = (0.003, 0.006, 0.0125, 0.025, 0.05, 0.1)  # widths of the steps, in parts of the largest value

# SI. Each coordinate and "rate", V̇: (1, points); "z history", "V history", "z splines" …: (rows, 1, points);
# "step": (1,).
Places = dict[str, np.ndarray]


class Size(NamedTuple):
    """Range of one coordinate in the records, and its largest absolute value (SI); `pieces`: splines over it, of a
    function of this coordinate alone; `mostly`: the range without where no record was but seldom."""

    low: float
    high: float
    largest: float
    pieces: int = _SINGLE
    mostly: tuple[float, float] = (0.0, 0.0)


def places(
    lanes: Sequence[Lane], paths: Sequence[Path], strides: Sequence[int], period: float, largest: Sequence[float]
) -> tuple[Places, ...]:
    """The coordinates and memories along the motion of each record, SI.

    **Arguments:** `strides` thin the half-step grids; `period` of the resonance, s; `largest`: absolute values of z and
    V in all records.
    """
    found = [_coordinates(*record) for record in zip(lanes, paths, strides, strict=True)]
    for name, size in zip(("z", "V"), largest, strict=True):
        held = plays([place[name][0] for place in found], np.array(_WIDTHS) * size)
        for place, own in zip(found, held, strict=True):
            late = [lagging(place[name], place["step"], time * period, period) for time in _TIMES]
            place[f"{name} history"] = np.concatenate([own[:, None], np.stack(late)])
    return tuple(found)


def _coordinates(lane: Lane, path: Path, stride: int) -> Places:
    omega, half = lane.omega if lane.omega > 0 else np.inf, 0.5 * lane.step
    thin = lambda x: np.asarray(x)[None, ::stride]
    time = lane.into + half * np.arange(len(lane.voltage))
    found = {"z": thin(path.z), "v": thin(path.v), "V": thin(lane.voltage), "dV": thin(lane.rate / omega)}
    return found | {"t": thin(time), "rate": thin(lane.rate), "step": np.array([half * stride])}


def sizes(found: Sequence[Places]) -> dict[str, Size]:
    """Range of each coordinate over all records."""
    ranges = {}
    for name in COORDINATES:
        low = min(float(np.min(place[name])) for place in found)
        high = max(float(np.max(place[name])) for place in found)
        inner = np.array([np.quantile(place[name], (_SELDOM, 1 - _SELDOM)) for place in found])  # of each record
        mostly = float(inner[:, 0].min()), float(inner[:, 1].max())
        mostly = mostly if mostly[0] < mostly[1] else (low, high)
        ranges[name] = Size(low, high, max(abs(low), abs(high)) or 1.0, mostly=mostly)
    return ranges


def one(name: str, place: Places, size: Size) -> np.ndarray:
    """Functions of one coordinate: a cubic spline, and unless it is time a kink and steps at zero; (k, …)."""
    smooth = splines(place[name], size, size.pieces)
    if name == "t":
        return smooth
    x = place[name] / size.largest
    steps = [np.tanh(x / width) for width in _STEPS]
    return np.concatenate([smooth, np.stack([np.sqrt(x * x + 1e-4), sharp(x), *steps])])


def sharp(x: np.ndarray) -> np.ndarray:
    """The sign of x, averaged over the part of the half-step grid that each point stands for.

    The solver weighs whole and half steps as 1 to 2; a jump sampled at points alone would come early or late by up to
    half a step, which is what remains of a friction force after a fit.
    """
    part = np.where(np.arange(x.shape[-1]) % 2 == 0, 1 / 3, 2 / 3)
    return np.clip(x / np.maximum(part * np.abs(np.gradient(x, axis=-1)), 1e-6), -1.0, 1.0)


def pair(names: tuple[str, str], place: Places, ranges: Mapping[str, Size]) -> np.ndarray:
    """Products of splines of two coordinates, (k, …)."""
    for name in names:  # kept with the place: every coordinate is in several pairs
        if f"{name} splines" not in place:
            place[f"{name} splines"] = splines(place[name], ranges[name], _PAIRED)
    first, second = (place[f"{name} splines"] for name in names)
    return (first[:, None] * second[None]).reshape(-1, *first.shape[1:])


def splines(x: np.ndarray, size: Size, count: int) -> np.ndarray:
    """Cubic B-splines on evenly spaced knots over the range, constant beyond it; (count, *x.shape)."""
    low, high = size.low, size.high if size.high > size.low else size.low + 1.0
    knots = np.concatenate([[low] * _DEGREE, np.linspace(low, high, count - _DEGREE + 1), [high] * _DEGREE])
    each = BSpline(knots, np.eye(count), _DEGREE)  # twice as fast as its `design_matrix`, with the same numbers
    return each(np.clip(x.ravel(), low, high)).T.reshape(count, *x.shape)


def plays(signals: Sequence[np.ndarray], widths: np.ndarray) -> list[np.ndarray]:
    """Play operators of half widths (k,) along several signals (points,), all zero before; (k, points) each.

    A play limits what it was to where its signal now is, give or take its width; what a stretch of a signal makes of
    any state before it is a limit too, by what it makes of the lowest and of the highest one. So stretches are marched
    side by side.
    """
    longest = max(len(x) for x in signals)
    many = max(round(longest**0.5), 1)
    each = -(-longest // many)
    together = np.stack([np.pad(x, (0, many * each - len(x)), mode="edge") for x in signals])
    centre = together.reshape(len(signals), 1, many, each).transpose(3, 0, 1, 2)
    low, high = centre - widths[:, None], centre + widths[:, None]
    limits = np.empty((each, 2, *low.shape[1:]))
    state = np.stack([np.full(low.shape[1:], -np.inf), np.full(low.shape[1:], np.inf)])
    for k in range(each):
        state = np.minimum(np.maximum(state, low[k]), high[k], out=limits[k])
    before = np.zeros(low.shape[1:])
    for j in range(1, many):
        before[..., j] = np.clip(before[..., j - 1], limits[-1, 0, ..., j - 1], limits[-1, 1, ..., j - 1])
    found = np.clip(before, limits[:, 0], limits[:, 1]).transpose(1, 2, 3, 0).reshape(len(signals), len(widths), -1)
    return [own[:, : len(x)] for own, x in zip(found, signals, strict=True)]


def lagging(x: np.ndarray, step: np.ndarray, time: float, period: float) -> np.ndarray:
    """What a relaxation adds to a signal: what it holds back if it is quick, what is left of it if it is slow."""
    late = relaxed(x, step, time)
    return x - late if quick(time, period) else late


def quick(time: float, period: float) -> bool:
    """Whether a relaxation lets most of a motion of this period through."""
    return 2 * np.pi * time < period


def relaxed(x: np.ndarray, step: np.ndarray, time: float) -> np.ndarray:
    """First-order lag of (lanes, points) from zero, exact for straight lines between the points."""
    found = np.zeros_like(x)
    for lane, h in enumerate(step):
        decay = float(np.exp(-h / time))
        mean = time / h * (1 - decay)
        fed = (1 - mean) * x[lane, 1:] + (mean - decay) * x[lane, :-1]
        found[lane, 1:] = recursive_filter(np.ones(1), np.array([1.0, -decay]), fed)
    return found
