"""Which linear model the records start from: the candidates of linear physics, and one criterion between them.

Gain, level and the free motion of every start enter linearly and are eliminated; the one or two numbers of a form are
searched. What a candidate leaves of the signal and the numbers that it needs give

    n ln(left) + k ln n,

the least of which wins (G. Schwarz, Ann. Statist. 6 (1978) 461). What a linear model leaves is no white noise where an
effect is missing, so n counts its independent samples: (Σ P)²/Σ P² of its power spectrum, and not the samples of the
record; a constant or a spring is then not bought with what a missing effect leaves. Further modes are bought with the
samples that are there (`_priced`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from ...campaign.campaign import MOST_MODES
from ...campaign.held_drive import jumps
from ...campaign.quality.rest_level import level_before, zero_of
from ...campaign.record import Trace
from ...errors import UserError
from ...model import ABOVE_THE_DRIVE
from .candidate import Candidate
from .drives import held, is_acceleration, is_length, with_edge
from .forms import FORMS, Form
from .guess import guess_linear
from .independent import independent_samples
from .modes import find_modes, solved
from .rows import Kind, fitted, rows_of, searched
from .stretches import Stretch, highest_content, stretch_of

FormName = Literal["oscillator", "overdamped", "base", "shaken", "no-spring", "quasi-static"]
_ON_BASE = ("base", "shaken")
Told = Literal["auto", "oscillator", "no-spring", "quasi-static"]
_FEWEST = 20.0  # independent samples in what is left: a single line has four, which buy nothing
_GREATER_PART = math.sqrt(2.0)  # half of the power
_SURE = 5.0  # standard deviations: one of two million samples of noise lies that far off


def side_of_constant(form: str) -> Literal["force", "sensor"]:
    """Where the constant of a form acts: without a spring it is a force, for a level is where it starts."""
    return "force" if form == "no-spring" else "sensor"


@dataclass(frozen=True)
class LinearChoice:
    """The candidates, best first, and the one that was chosen; `told`: what the campaign asked for."""

    candidates: tuple[Candidate, ...]
    chosen: Candidate
    told: str = "auto"

    @property
    def simplest(self) -> Candidate | None:
        """Gain and offset alone, where a drive was measured."""
        return next((c for c in self.candidates if c.form == "quasi-static"), None)


def choose_linear(
    records: Sequence[Trace], told: str = "auto", *, modes: int | None = None, base: bool = True
) -> LinearChoice:
    """The linear model with which to start on these records.

    Where a record starts from rest the first sample says where the zero is. If that is zero a constant is looked for
    only if gain and offset, or an offset alone, leave less than every form without one: what moves the mean is then a
    force. Decays alone need none: their displacements are counted from where they come to rest. Without a spring a
    constant is a force itself, of which no first sample says anything.

    **Arguments:** `told`: "auto", or the form that the campaign asks for; `modes`: how many an oscillator has, None if
    the records decide; `base`: whether it may stand on what the drive moves.
    """
    stretches = with_edge([stretch_of(record) for record in records], _free(records), None)
    driven = any(stretch.driven for stretch in stretches)
    level = driven and all(record.start != "rest" for record in records)
    off = driven and not level and begin_off_zero(records)
    guess = guess_linear(records) if told not in ("no-spring", "quasi-static") else None
    names = [
        name
        for name in get_args(FormName)
        if told == "auto" or told in (name, FORMS[name].family if name in FORMS else name)
    ]
    forms = [
        FORMS[name] for name in names if name in FORMS and name not in _ON_BASE and (driven or name != "no-spring")
    ]
    starts = {} if guess is None else {"oscillator": (guess.frequency, guess.quality)}

    def compared(stretches: Sequence[Stretch]) -> tuple[list[Candidate], float]:
        def every(constant: bool, among: Sequence[Form]) -> list[Candidate]:
            return [searched(stretches, Kind(form.name, constant, form), starts.get(form.name)) for form in among]

        forced = [form for form in forms if side_of_constant(form.name) == "force"]
        found = [fitted(stretches, Kind("constant", True))]
        found += [_static(records, stretches)] if driven else []
        found += every(False, forms)
        if level or off or (driven and min(found, key=lambda c: c.left).level):
            found += every(True, [form for form in forms if form not in forced])
        return _weighed(stretches, [*found, *every(True, forced)])

    found, n = compared(stretches)
    other = _held(records, stretches, found, n)
    if other is not None:
        edges = other.edges
        stretches = with_edge(stretches, _free(records, edges.everywhere), edges.first)
        starts = {"oscillator": (other.first, other.second)} if other.form == "oscillator" else {}
        own, n = compared(stretches)
        own = [c._replace(edges=edges, numbers=c.numbers + edges.numbers) for c in own if c.form in FORMS]
        found = sorted((c._replace(criterion=_plain(c, n)) for c in [*own, *found]), key=lambda c: c.criterion)
    if base and other is None and "base" in names:
        found = sorted([*found, *_on_base(records, stretches, found, n)], key=lambda c: c.criterion)
    moved = all(record.order == 0 for record in records)  # a rate has no gain to a steady drive
    allowed = [c for c in found if c.form in names and (moved or c.form != "quasi-static")]
    if modes is not None and modes > 1:
        allowed = [c for c in allowed if c.form == "oscillator"]
        if not allowed:
            raise UserError(f"modes = {modes} needs time records of an oscillator", do="remove it")
    if not allowed:
        what = 'linear = "quasi-static" needs a drive that was measured, and a displacement that answers it'
        raise UserError(what, do="remove it, and let the records choose")
    chosen, more = _chosen(records, stretches, allowed, modes, n)
    return LinearChoice(tuple(sorted([*found, *more], key=lambda c: c.criterion)), chosen, told)


def begin_off_zero(records: Sequence[Trace]) -> bool:
    """Whether most records that start from rest begin on one level that is not zero: that is the sensor's, though one
    of them may be read with another gain."""
    shown = lambda record: zero_of(record) if record.start == "rest" else level_before(record)
    rest = [(zero, r.noise.sigma) for r in records if r.driven and (zero := shown(r)) is not None]
    if not rest:
        return False
    first, sigma = (np.array(x) for x in zip(*rest, strict=True))
    said, order = sigma**-2.0, np.argsort(first)  # a quiet record says more than a noisy one
    middle = first[order][np.searchsorted(np.cumsum(said[order]), 0.5 * np.sum(said))]
    alike = np.abs(first - middle) < _SURE * sigma
    most = 2 * np.count_nonzero(alike) > len(rest)
    return bool(most and abs(np.sum((said * first)[alike])) > _SURE * np.sqrt(np.sum(said[alike])))


def _chosen(
    records: Sequence[Trace], stretches: Sequence[Stretch], allowed: Sequence[Candidate], modes: int | None, n: float
) -> tuple[Candidate, list[Candidate]]:
    """The best of the candidates, and those with further modes, of which it may be one.

    Two modes together may resemble no single one: whichever form has won, more are looked for.
    """
    chosen = min(allowed, key=lambda c: c.criterion)
    alone = [c for c in allowed if c.form == "oscillator"]
    one = min(alone, key=lambda c: c.criterion) if alone else None
    most = modes or next((m - 1 for m in range(2, MOST_MODES + 1) if not _room(one, m, n)), MOST_MODES) if one else 0
    more = [] if one is None or most < 2 else _with_modes(records, stretches, one, modes, most)
    rise = lambda c: _priced(c, n) - _priced(chosen, n) if modes is None else _plain(c, n) - _plain(chosen, n)
    more = [c._replace(criterion=chosen.criterion + rise(c)) for c in more]
    if modes is not None and modes > 1 and more:
        chosen = more[-1]
    elif more:
        chosen = min([chosen, *more], key=lambda c: c.criterion)
    return chosen, more


def _free(records: Sequence[Trace], everywhere: bool = True) -> list[bool]:
    """Which records do not say what their drive is between its samples; not `everywhere`: where it jumps."""
    return [r.between == "auto" and r.driven and (everywhere or jumps(r.drive)) for r in records]


def _held(
    records: Sequence[Trace], stretches: Sequence[Stretch], found: Sequence[Candidate], n: float
) -> Candidate | None:
    """The best candidate with drives that are held, if the records choose one."""
    one, free = next((c for c in found if c.form in FORMS), None), _free(records)
    if one is None or not any(free) or one.left < _GREATER_PART * _least(records, stretches):
        return None
    jumping = _free(records, everywhere=False)
    modest = one  # drives that do not jump are smooth
    if any(jumping) and jumping != free:
        modest = min([one, *map(_only_jumps, held(stretches, one, jumping, True))], key=lambda c: _plain(c, n))
    best = min([modest, *held(stretches, one, free, any(jumping))], key=lambda c: _plain(c, n))
    clear = jumping == free or best.left < modest.left / _GREATER_PART
    best = best if clear else modest
    return best if best.edges.first is not None else None


def _only_jumps(one: Candidate) -> Candidate:
    return one._replace(edges=one.edges._replace(everywhere=False))


def _on_base(
    records: Sequence[Trace], stretches: Sequence[Stretch], found: Sequence[Candidate], n: float
) -> list[Candidate]:
    """The oscillator on a base that the drive moves, if it may be chosen."""
    springs, driven = [c for c in found if c.form in ("oscillator", "overdamped")], [r for r in records if r.driven]
    smooth = all(stretch.edge is None for stretch in stretches)
    if not (springs and driven and smooth) or found[0].left < _GREATER_PART * _least(records, stretches):
        return []
    told = all(is_length(record.drive_channel.unit) for record in driven)
    riding = all(record.order == 2 and is_acceleration(record.drive_channel.unit) for record in records)
    form = FORMS["shaken" if riding else "base"]
    best = searched(stretches, Kind(form.name, springs[0].level, form), None)
    clear = told or riding or best.left < found[0].left / _GREATER_PART
    return [best._replace(criterion=_plain(best, n))] if clear else []


def _numbers(one: Candidate, modes: int) -> int:
    return one.numbers + 3 * (modes - 1)


def _room(one: Candidate, modes: int, n: float) -> bool:
    """Whether there are samples for so many modes in what one form leaves."""
    return n > _numbers(one, modes) + 2


def _priced(c: Candidate, n: float) -> float:
    """The criterion for few samples: n ln(left) + k ln n · n/(n − k − 2), and no model with more numbers than samples.

    A motion that repeats itself is a few lines, which any filter with as many numbers meets, and it predicts from one
    half of such a record what is in the other. So modes are bought with the samples that are there, and no fewest.

    Source: A. D. R. McQuarrie, Statist. Probab. Lett. 44 (1999) 79.
    """
    free = n - c.numbers - 2
    return math.inf if free <= 0 else 2 * n * math.log(max(c.left, 1e-12)) + c.numbers * math.log(n) * n / free


def _with_modes(
    records: Sequence[Trace], stretches: Sequence[Stretch], one: Candidate, told: int | None, most: int
) -> list[Candidate]:
    """The oscillator with two modes, with three, … up to `most`, if the campaign asks for them or records show them:
    what they predict of records that were left out must be the greater part of what one mode leaves, noise included."""
    driven = any(stretch.driven for stretch in stretches)
    # Of a decay a further line is among what its noise floor is read off.
    if told == 1 or (told is None and driven and _least(records, stretches) > one.left / _GREATER_PART):
        return []
    found = find_modes(stretches, (one.first, one.second), one.level, told, most)
    before = min(found[0].predicted, found[-1].alone) if driven else found[0].predicted
    if told is None and found[-1].predicted > before / _GREATER_PART:
        return []
    return [
        one._replace(left=m.left, numbers=_numbers(one, len(m.modes)), first=m.modes[0].frequency,
                     second=m.modes[0].quality, gain=m.modes[0].gain, constant=m.constant, further=m.modes[1:])
        for m in found[1:]
    ]  # fmt: skip


def _least(records: Sequence[Trace], stretches: Sequence[Stretch]) -> float:
    """rms of the noise over that of the signal."""
    noise = sum((r.noise.sigma / p.size) ** 2 * len(p.response) for r, p in zip(records, stretches, strict=True))
    return math.sqrt(noise / sum(stretch.power for stretch in stretches))


def _static(records: Sequence[Trace], stretches: Sequence[Stretch]) -> Candidate:
    """Gain and offset, as an oscillator far above the band of the drives."""
    found = fitted(stretches, Kind("quasi-static", True))
    frequency = ABOVE_THE_DRIVE * max(highest_content(record.drive, record.step) for record in records if record.driven)
    gain = found.gain * (2 * math.pi * frequency) ** 2
    return found._replace(first=frequency, second=ABOVE_THE_DRIVE, gain=gain)


def _weighed(stretches: Sequence[Stretch], found: Sequence[Candidate]) -> tuple[list[Candidate], float]:
    """The candidates with their criterion, best first; and the independent samples in what the best one leaves."""
    best = min(found, key=lambda c: c.left)
    form = FORMS.get(best.form)
    point = None if form is None else form.point(best.first, best.second)
    rows, targets = rows_of(stretches, Kind(best.form, best.level, form), point)
    n = independent_samples(solved(rows, targets)[1])
    return sorted((c._replace(criterion=_plain(c, n)) for c in found), key=lambda c: c.criterion), n


def _plain(c: Candidate, n: float) -> float:
    n = max(n, _FEWEST)
    return 2 * n * math.log(max(c.left, 1e-12)) + c.numbers * math.log(n)
