"""Where a model fails, in words: only what a statistic backs, and nothing where nothing stands out."""

from __future__ import annotations

from math import fsum
from typing import Literal, NamedTuple

import numpy as np

from ...units import ratio_text
from .locate import ALARMS, RecordView, Where
from .views import View

Axis = Literal["record", "level", "time", "phase", "displacement", "velocity", "harmonic", "frequency"]


class Statement(NamedTuple):
    """One thing that stands out: the axis it is seen on, the words, the share of the misfit, and its probability."""

    axis: Axis
    words: str
    share: float
    p_value: float


_MOST = 0.5  # share of the misfit below which a single place is not worth naming
_PLACED = 0.3  # share of the misfit from which a place in the motion, in time or in the drive's phase is worth naming
_OF_A_LEVEL = 0.8  # share of the misfit in the records of a level, from which that is worth naming
_SAME_LEVEL = 0.02  # relative difference below which records have one level
_OUTER, _INNER = 0.55, 0.45  # of the largest value: beyond the one a place is outer, within the other inner
_IN_A_HARMONIC = 0.2  # share of the misfit from which a harmonic is worth naming
_CLEAR, _CLEAR_LINE = 1.5, 3.0  # times the noise: what stands out in a bin of the motion, and of the many of a spectrum
_ANOTHER_SIZE = 0.02  # relative difference from which two numbers for the error are explained
_ORDINALS = (
    "in the constant part",
    "at the drive frequency itself",
    *(f"at the {n} harmonic of the drive" for n in ("second", "third", "fourth", "fifth", "sixth", "seventh")),
)


def hertz(value: float) -> str:
    """A frequency in four digits, without a power of ten."""
    return np.format_float_positional(value, 4, fractional=False, trim="-")


def statements(where: Where) -> list[Statement]:
    """What stands out, each backed by its probability; empty if the model is adequate or the misfit is even."""
    if not where.fails:
        return []
    found = [_record(where), _level(where), _motion(where), _time(where), _phase(where), *_tones(where)]
    return [s for s in found if s is not None]


def summary(where: Where) -> str:
    """One paragraph."""
    if not where.fails:
        unrelated = "" if where.drive is None else " and unrelated to the drive"
        return f"No part of the records stands out: what is left is noise, white{unrelated}."
    found = statements(where)
    first = (
        f"The error is {ratio_text(where.error)} times the noise floor{_counted(where)}; what is left {_nature(where)}."
    )
    if not found:
        return f"{first} No part of the records stands out."
    places = sorted((s for s in found if s.axis not in ("record", "level")), key=lambda s: -s.share)
    amounts = [s.words for s in found if s.axis in ("record", "level")]
    middle = f" The misfit sits {_listed([s.words for s in places])}." if places else ""
    last = f" Of the misfit, {_listed(amounts)}." if amounts else ""
    return f"{first}{middle}{last}"


def _counted(where: Where) -> str:
    """What the places below are counted on, where that is another size than the error itself."""
    if not abs(where.white_error / where.error - 1) > _ANOTHER_SIZE:
        return ""
    of = " of excerpts" if where.excerpts else ""
    return (
        f" ({ratio_text(where.white_error)} in what follows{of}, where mains hum and the noise's colour are taken out)"
    )


def _nature(where: Where) -> str:
    """What is left: its colour, and whether it has to do with the drive, if there is one."""
    driven = None if where.drive is None else where.drive.p_value < ALARMS
    if where.whiteness.p_value < ALARMS:
        drive = {None: "", True: " and follows the drive", False: " but does not follow the drive"}[driven]
        return f"has a colour of its own{drive}"
    if driven:
        return "follows the drive"
    unrelated = "" if driven is None else " and unrelated to the drive"
    return f"is white{unrelated}, as a noise floor stated too low would be"


def _listed(words: list[str]) -> str:
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + " and " + words[-1]


def _percent(share: float) -> str:
    return "nearly all" if share > 0.985 else f"{100 * share:.0f} %"


def _record(where: Where) -> Statement | None:
    fitted = [r for r in where.records if not r.holdout]
    worst = max(fitted, key=lambda r: r.excess)
    share = _share([worst], fitted)
    if len(fitted) < 2 or worst.p_value * len(fitted) > ALARMS or share < max(_MOST, 1.5 / len(fitted)):
        return None
    return Statement("record", f"{_percent(share)} is in {worst.name}", share, worst.p_value)


def _share(chosen: list[RecordView], every: list[RecordView]) -> float:
    # Exact sums: the same records in another order have the same share, and of two ways to say it the first is taken.
    inside, total = (fsum(max(r.excess, 0.0) for r in some) for some in (chosen, every))
    return inside / max(total, 1e-300)


def _level(where: Where) -> Statement | None:
    """Whether the records above a drive level, a travel, or near the resonance hold most of the misfit."""
    fitted = [r for r in where.records if not r.holdout]
    if len(fitted) < 3:
        return None
    f0 = where.resonance
    nearness = lambda r: -abs(np.log(max(r.frequency, 1e-9) / f0))
    questions = [
        (lambda r: r.level, lambda r: f"in records driven at {r.level:.3g} {where.drive_unit} or more"),
        (nearness, lambda r: f"in records within {100 * (np.exp(-nearness(r)) - 1):.0f} % of the resonance"),
        (lambda r: -r.frequency / f0, lambda r: f"in records driven at or below {hertz(r.frequency)} Hz"),
        (lambda r: r.frequency / f0, lambda r: f"in records driven at or above {hertz(r.frequency)} Hz"),
    ]
    best: tuple[float, Statement] | None = None
    for key, words in questions:
        ranked = sorted(fitted, key=key, reverse=True)
        for count in range(2, len(ranked)):
            inside, outside = ranked[:count], ranked[count:]
            if key(ranked[count - 1]) - key(ranked[count]) < _SAME_LEVEL * abs(key(ranked[count - 1])):
                continue  # records of the same level belong together
            clear = min(r.ratio**2 - 1 for r in inside) > 2 * max(max(r.ratio**2 - 1 for r in outside), 0.0)
            p = max(r.p_value for r in inside) * len(fitted)
            share = _share(inside, fitted)
            gain = share - count / len(fitted)
            if clear and p < ALARMS and share > _OF_A_LEVEL and (best is None or gain > best[0]):
                best = gain, Statement("level", f"{_percent(share)} is {words(inside[-1])}", share, p)
    return None if best is None else best[1]


def _chosen(view: View | None, factor: float = _CLEAR) -> tuple[np.ndarray, float, float]:
    """Bins that stand out, the share of the misfit in them, and the largest of their probabilities."""
    if view is None:
        return np.zeros(0, bool), 0.0, 1.0
    chosen = view.stands_out(ALARMS, factor)
    if not np.any(chosen):
        return chosen, 0.0, 1.0
    worst = float(np.max(np.maximum(view.p_value, view.distinct)[chosen])) * int(np.isfinite(view.ratio).sum())
    return chosen, view.share(chosen), worst


def _motion(where: Where) -> Statement | None:
    """Where in the motion: turning points, the middle, one side; whichever of displacement and velocity says more."""
    found = []
    of_traces, of_curves = (_DISPLACEMENT, _VELOCITY), (_AMPLITUDE, _FROM_PEAK)
    both = zip((where.displacement, where.velocity), of_curves if where.of_curves else of_traces, strict=True)
    for view, names in both:
        chosen, share, p = _chosen(view)
        places = np.abs(view.centres[chosen]) / np.max(np.abs(view.edges))
        if share < _PLACED or not len(places):
            continue
        signs = np.sign(view.centres[chosen])
        side = 0 if len(set(signs)) > 1 else int(signs[0])
        zone = "outer" if places.min() > _OUTER else "inner" if places.max() < _INNER else "one side" if side else ""
        if zone and (zone, 0 if zone == "inner" else side) in names:
            axis: Axis = "displacement" if view is where.displacement else "velocity"
            found.append(Statement(axis, names[zone, 0 if zone == "inner" else side], share, p))
    return max(found, key=lambda s: s.share, default=None)


_DISPLACEMENT = {
    ("outer", 0): "at the turning points of the motion",
    ("outer", 1): "at the upper turning point of the motion",
    ("outer", -1): "at the lower turning point of the motion",
    ("inner", 0): "where the stage passes its middle",
    ("one side", 1): "on the upper side of the motion",
    ("one side", -1): "on the lower side of the motion",
}
_VELOCITY = {
    ("outer", 0): "where the stage is fastest",
    ("outer", 1): "where the stage is fastest upwards",
    ("outer", -1): "where the stage is fastest downwards",
    ("inner", 0): "at the zero crossings of velocity",
    ("one side", 1): "while the stage moves upwards",
    ("one side", -1): "while the stage moves downwards",
}


_AMPLITUDE = {
    ("outer", 1): "at the largest amplitudes",
    ("inner", 0): "at small amplitudes",
}
_FROM_PEAK = {
    ("outer", 0): "far from the peaks",
    ("outer", 1): "far above the peaks",
    ("outer", -1): "far below the peaks",
    ("inner", 0): "at the peaks",
    ("one side", 1): "above the peaks",
    ("one side", -1): "below the peaks",
}


def _time(where: Where) -> Statement | None:
    chosen, share, p = _chosen(where.time)
    if share < _PLACED or not np.any(chosen):
        return None
    bins = np.flatnonzero(chosen)
    if bins[-1] - bins[0] + 1 > len(bins) + 1 or len(bins) > len(chosen) // 2:
        return None
    low, high = where.time.edges[bins[0]], where.time.edges[bins[-1] + 1]
    if where.of_curves:
        return Statement("frequency", f"between {hertz(float(low))} and {hertz(float(high))} Hz", share, p)
    place = f"the first {100 * high:.0f} %" if low == 0 else f"the last {100 * (1 - low):.0f} %" if high == 1 else None
    words = f"in {place} of the records" if place else f"between {100 * low:.0f} and {100 * high:.0f} % of the records"
    return Statement("time", words, share, p)


def _phase(where: Where) -> Statement | None:
    view = where.phase
    chosen, share, p = _chosen(view)
    if view is None or share < _PLACED or not np.any(chosen) or chosen.sum() > len(chosen) // 3:
        return None
    runs = int(np.sum(chosen & ~np.roll(chosen, 1)))
    if runs > 2:
        return None
    starts = np.flatnonzero(chosen & ~np.roll(chosen, 1))
    spans = []
    for first in starts:
        length = int(np.argmin(np.roll(chosen, -first)))
        last = view.edges[first] + length * (view.edges[1] - view.edges[0])
        spans.append(f"{view.edges[first]:.0f}–{last if last <= 360 else last - 360:.0f}°")  # 330–30°, across the zero
    return Statement("phase", f"at {' and '.join(spans)} of the drive's phase", share, p)


def _tones(where: Where) -> list[Statement]:
    """Which harmonics of the drive; failing that, which band of frequency."""
    found = []
    view = where.harmonics
    if view is not None:
        for k in np.argsort(-view.excess)[:2]:
            share = float(max(view.excess[k], 0.0) / max(where.misfit, view.excess[view.excess > 0].sum(), 1e-300))
            if view.p_value[k] * len(view.excess) < ALARMS and share > _IN_A_HARMONIC:
                found.append(Statement("harmonic", _ORDINALS[k], share, float(view.p_value[k])))
    if found or where.of_curves:
        return found
    chosen, share, p = _chosen(where.spectrum, _CLEAR_LINE)
    bins = np.flatnonzero(chosen)
    if share < _MOST or not len(bins) or bins[-1] - bins[0] >= len(bins) + 1:
        return []
    low, high = (where.spectrum.edges[i] * where.resonance for i in (bins[0], bins[-1] + 1))
    return [Statement("frequency", f"between {hertz(float(low))} and {hertz(float(high))} Hz", share, p)]
