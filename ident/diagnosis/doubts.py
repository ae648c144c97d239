"""What makes an answer doubtful: records that contradict it, and a law that says what a fault of theirs would."""

from __future__ import annotations

from dataclasses import replace

from ..campaign.quality.suspect import Suspect
from ..fit import Fit
from ..fit.start_score import mostly_starts
from .evidence.enough import adequate
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
    coordinates leaves less, or nothing: of a rubber mount that softens as it is moved two records of seven passed for
    another device's, and left 67 of what the law left 4 of."""
    if unknown is None:
        return suspects
    less = lambda one: unknown.chi2_after < max(AS_WELL, one.left)
    return tuple(one for one in suspects if one.settles or not (one.first and less(one)))
