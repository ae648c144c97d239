"""Is a mean that drifts told from one that the vibration itself moves?  `python -m experiments.faulty_records.drifts`

The devices of `study`, with nothing, one effect or two hidden, on fresh seeds: every record as it is, and one of each
campaign with a ramp of 0.3 of its range. A quadratic spring or sensor moves the mean with the square of the vibration,
which is no drift; creep moves it with time, which the data alone cannot tell from one.
"""

from __future__ import annotations

from dataclasses import replace

from experiments.hidden_effects.campaigns import campaign_of
from ident.campaign.quality.judge import judge
from ident.campaign.record import Trace

from .faults import spoil
from .study import hide

SEEDS = range(740, 770)


def drifts(record: Trace) -> bool:
    """Whether the record is said to drift."""
    return any("drifts" in remark for remark in judge(record).remarks)


def main() -> None:
    """Run the study."""
    sound, suspected, ramps, told = 0, list[str](), 0, 0
    for seed in SEEDS:
        for hidden in (0, 1, 2):
            case, effects = hide(seed, hidden)
            records = campaign_of(case).traces
            sound += len(records)
            suspected += [f"{seed} {'+'.join(effects)} {record.name}" for record in records if drifts(record)]
            spoiled, faulty = spoil(case, "drift", seed)
            ramp = next(r for r in campaign_of(replace(case, records=spoiled)).traces if r.name == f"{faulty}.csv")
            ramps += 1
            told += drifts(ramp)
    others = [words for words in suspected if "creep" not in words]
    print(f"{len(suspected)} of {sound} sound records suspected {suspected}; {told} of {ramps} ramps told")
    assert len(others) <= 0.01 * sound and told >= 0.95 * ramps


if __name__ == "__main__":
    main()
