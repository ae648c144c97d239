"""Which way a sweep went: what the campaign or a column says, the order of the rows, and whether the jumps agree."""

from __future__ import annotations

import numpy as np

from ...errors import UserError
from ..record import same_level
from ..spec import RecordSpec
from ..tables.table import Column
from .form import direction_in
from .jump import Jump, find_jump, loop_runs_backwards

_UP = ("up", "u", "forward", "fwd", "rising", "increasing", "1", "+1", "1.0", "true", "upward", "upwards")
_DOWN = ("down", "d", "backward", "bwd", "reverse", "falling", "decreasing", "-1", "0", "-1.0", "0.0", "false",
         "downward", "downwards")  # fmt: skip


def directions(
    spec: RecordSpec, column: Column | None, frequency: np.ndarray, level: np.ndarray, notes: list[str]
) -> np.ndarray:
    """(n,) whether the frequency was rising at each point; said in `notes` where nobody told.

    **Raises:** UserError for words that are no direction, and for rows in no order where nothing else tells.
    """
    if spec.direction in ("up", "down"):
        up = np.full(len(frequency), spec.direction == "up")
        return _unlike_rows(spec, up, frequency, level, notes)
    if column is not None:
        words = [_plain(cell) for cell in column.cells]
        for row, word in enumerate(words):
            if word not in _UP + _DOWN:
                raise UserError(
                    f'"{word}" is no direction', where=column.place(row), do='write "up" or "down", or 1 and -1'
                )
        return np.array([word in _UP for word in words])
    up = _by_order(spec, frequency, level)
    told = direction_in(spec.path.stem)
    both = bool(np.any(up) and not np.all(up))
    if told and not both and bool(up[0]) != (told == "up"):
        what = f"its name says {told}, its rows run {'up' if up[0] else 'down'}; the name is believed"
        notes.append(f'{spec.file}: direction is not given; {what} (direction = "{told}").')
        return ~up
    words = "in both directions" if both else ("upwards" if np.all(up) else "downwards")
    notes.append(f"{spec.file}: direction is not given; by the order of its rows the frequency was swept {words}.")
    return up


def _plain(cell: object) -> str:
    text = str(cell).strip().strip('"').lower()
    try:
        return f"{float(text):g}"
    except ValueError:
        return text


def _rising(frequency: np.ndarray) -> np.ndarray:
    """(n,) whether each point belongs to a rise: by the step to the next point, at an end by the last step."""
    step = np.diff(frequency)
    for k in range(1, len(step)):  # a frequency that is read twice goes on as before
        step[k] = step[k - 1] if step[k] == 0 else step[k]
    rising = step >= 0
    return np.append(rising, rising[-1:]) if len(step) else np.array([True])


def _by_order(spec: RecordSpec, frequency: np.ndarray, level: np.ndarray) -> np.ndarray:
    up = np.zeros(len(frequency), bool)
    for rows in same_level(level):
        rising = _rising(frequency[rows])
        turns = int(np.sum(rising[1:] != rising[:-1]))
        if turns > max(2, len(rows) // 8):
            what = f"the rows of one level run up and down {turns} times, so that they do not tell the direction"
            do = 'say it: direction = "up" or "down", or the name of the column that tells'
            raise UserError(what, where=spec.file, do=do)
        back = np.flatnonzero(rising[1:] != rising[:-1]) + 1
        for k in back[back < len(rows) - 1]:  # a pass that starts over, from the top or the bottom, is no turn
            alone = rising[k - 1] != rising[k] and rising[k + 1] != rising[k]
            if rising[k + 1] == rising[k - 1] or alone:
                rising[k] = rising[k - 1]
        up[rows] = rising
    return up


def _unlike_rows(
    spec: RecordSpec, up: np.ndarray, frequency: np.ndarray, level: np.ndarray, notes: list[str]
) -> np.ndarray:
    """The direction that is given, and a note where the rows run the other way."""
    runs = [np.all(np.diff(frequency[rows]) * (1 if up[0] else -1) <= 0) for rows in same_level(level)]
    if len(frequency) > 1 and all(runs):
        other = "fall" if up[0] else "rise"
        notes.append(
            f'{spec.file}: its frequencies {other} from row to row; direction = "{spec.direction}" is believed.'
        )
    return up


def jumps_of(
    frequency: np.ndarray, level: np.ndarray, amplitude: np.ndarray, phase: np.ndarray | None, up: np.ndarray
) -> list[tuple[float, Jump | None, Jump | None]]:
    """Per level (V): the jump of its upward and of its downward run."""
    found = []
    for rows in same_level(level):
        pair = []
        for way in (True, False):
            run = rows[up[rows] == way]
            pair.append(find_jump(frequency[run], amplitude[run], None if phase is None else phase[run]))
        found.append((float(np.median(level[rows])), *pair))
    return found


def turned_by_jumps(
    file: str,
    frequency: np.ndarray,
    level: np.ndarray,
    amplitude: np.ndarray,
    phase: np.ndarray | None,
    up: np.ndarray,
    notes: list[str],
) -> np.ndarray:
    """The directions, exchanged and said so if the jumps of every level that has two of them stand the wrong way."""
    found = jumps_of(frequency, level, amplitude, phase, up)
    told = [(volts, a, b, loop_runs_backwards(a, b)) for volts, a, b in found]
    wrong = [(volts, a, b) for volts, a, b, backwards in told if backwards]
    if not wrong or any(backwards is False for *_, backwards in told):
        return up
    volts, a, b = wrong[-1]
    assert a is not None and b is not None
    notes.append(
        f"{file}: up and down are exchanged: at level {volts:.4g} the curve called up jumps at {a.frequency:.6g} Hz, "
        f"below the one called down ({b.frequency:.6g} Hz), which no device does; they are read the other way round."
    )
    return ~up
