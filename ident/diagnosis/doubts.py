"""What makes an answer doubtful: records that contradict it, and a law that says what a fault of theirs would."""

from __future__ import annotations

from dataclasses import replace

from ..campaign.quality.suspect import Suspect
from ..fit import Fit
from ..fit.start_score import mostly_starts
from .evidence.enough import MOST_OF_IT, adequate
from .faulty.suspects import BY_OTHERS
from .linearised.regression import prepare
from .linearised.shorten import working
from .search.once_more import with_other_starts
from .search.steps import Discovery
from .search.written import AS_WELL
from .unknown.find import Unknown


def in_doubt(found: Discovery, suspects: tuple[Suspect, ...]) -> Discovery:
    """What a walk has found, its verdict in doubt where records contradict one another, or what it leaves may be no
    physics at all."""
    if found.verdict == "identified" and any(one.kind in BY_OTHERS for one in suspects):
        return replace(found, verdict="ambiguous")
    if found.verdict == "not-in-library" and _starts_settle(found.final):
        return replace(found, verdict="ambiguous", lacking=0.0)
    return found


def _starts_settle(last: Fit) -> bool:
    """Whether a model reaches the noise with other starts than are claimed: what it leaves is then no physics."""
    freed = with_other_starts(last) if mostly_starts(last) else None
    return freed is not None and adequate(prepare(working(freed)))


def beside_law(suspects: tuple[Suspect, ...], unknown: Unknown | None) -> tuple[Suspect, ...]:
    """The suspects without those that come before any physics but leave something, where a law of the device's
    coordinates takes away most of that: of a rubber mount that softens as it is moved two records of seven passed for
    another device's, and left 67 of what the law left 4 of.

    Each was found beside those before it, and what the last one leaves all of them leave: they stand or fall together.
    """
    first = [one for one in suspects if one.first]
    if unknown is None or not first or any(one.settles for one in first):
        return suspects
    left, by_law = min(one.left for one in first), unknown.chi2_after
    if by_law < AS_WELL or by_law - 1 < MOST_OF_IT * (left - 1):
        return tuple(one for one in suspects if not one.first)
    return suspects
