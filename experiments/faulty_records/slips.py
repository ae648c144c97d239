"""Is a sensor that slips told from a device that jumps?  `python -m experiments.faulty_records.slips`

The devices of `study`, with nothing, one effect or two hidden, and those of `experiments.other_labs`, on fresh seeds:
every record as it is, and those of `study` with two slips of 2 to 8 samples, in which the reading is zero, stays, or
is wild. A slip counts as found where it takes the reading farther than a twentieth of its range.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from experiments.hidden_effects.campaigns import campaign_of
from experiments.other_labs import DEVICES, Lab
from ident import runtime
from ident.campaign.quality.slips import find_slips
from ident.campaign.record import Trace

from .study import hide

SEEDS, LABS = range(7620, 7640), (3,)


def with_slips(record: Trace, rng: np.random.Generator) -> tuple[np.ndarray, list[slice]]:
    """The reading with two slips, and those of them that take it far."""
    reading, far = record.response.copy(), list[slice]()
    for first in (0, 1):
        size = int(rng.integers(2, 9))
        k = int(rng.integers(60, len(reading) // 2 - 70)) + first * len(reading) // 2
        there = slice(k, k + size)
        wild = 0.3 * float(np.ptp(record.response)) * rng.standard_normal(size)
        reading[there] = (0.0, reading[k - 1], reading[there] + wild)[int(rng.integers(3))]
        if np.max(np.abs(reading[there] - record.response[there])) > 0.05 * float(np.ptp(record.response)):
            far.append(there)
    return reading, far


def of_labs(seed: int) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Name, reading and drive of records of other laboratories that read no acceleration or velocity."""
    for place, (name, device) in enumerate(DEVICES.items()):
        with tempfile.TemporaryDirectory() as folder:
            rng = np.random.default_rng([seed, place])
            device.write(Lab(Path(folder), rng), rng)
            for path in sorted(Path(folder).glob("*.csv")):
                head = path.read_text().splitlines()[0]
                columns = np.genfromtxt(path, delimiter=",", skip_header=1).T
                if len(columns) > 1 and not any(word in head for word in ("acc", "/s", "vel")):
                    reading = columns[-1]
                    drive = columns[1] if len(columns) > 2 else np.zeros(len(reading))
                    there = np.isfinite(reading) & np.isfinite(drive)
                    yield f"{name} {path.name}", reading[there], drive[there]


def main() -> None:
    """Run the study."""
    runtime.configure()
    sound, suspected, made, told = 0, list[str](), 0, 0
    for seed in SEEDS:
        for hidden in (0, 1, 2):
            case, effects = hide(seed, hidden)
            rng = np.random.default_rng([seed, hidden])
            for record in campaign_of(case).traces:
                sound += 1
                if find_slips(record.response, record.drive) is not None:
                    suspected.append(f"{seed} {'+'.join(effects)} {record.name}")
                reading, far = with_slips(record, rng)
                found = find_slips(reading, record.drive)
                made += len(far)
                told += sum(bool(np.any(found[there])) for there in far) if found is not None else 0
    print(f"study: {len(suspected)} of {sound} sound records suspected {suspected}; {told} of {made} slips told")
    labs = [(name, find_slips(reading, drive)) for seed in LABS for name, reading, drive in of_labs(seed)]
    wrong = [name for name, slips in labs if slips is not None]
    print(f"other labs: {len(wrong)} of {len(labs)} sound records suspected {wrong}")
    assert not suspected and not wrong and told >= 0.9 * made, (suspected, wrong, told, made)


if __name__ == "__main__":
    main()
