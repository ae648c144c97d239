"""A law with a fitted power and the named laws among its members: when is the family that member?"""

from __future__ import annotations

from ...effects.dependence import depends_on
from ...effects.effect import AbstractEffect
from .enough import ANOTHER_LAW


def is_family_of(whole: type[AbstractEffect], part: AbstractEffect) -> bool:
    """Whether a law contains another, has one size as a whole, and depends on nothing that this one does not: they then
    differ in the shape of a curve, and not in what acts. A law with several sizes is a sum of several."""
    if part.name not in whole.contains or sum(p.kind == "amplitude" for p in whole().declared()) > 1:
        return False
    wide, narrow = depends_on(whole()), depends_on(part)
    return wide is not None and narrow is not None and wide[0] == narrow[0] and set(wide[1]) <= set(narrow[1])


def is_that_member(
    whole: type[AbstractEffect], part: AbstractEffect, left_by_whole: float, left_by_part: float, excess: float
) -> bool:
    """Whether a family is to be called by the name of one of its members: it leaves less than that, but by no more than
    puts a name in doubt.

    No device has a law of a whole power to the last digit: to say "quadratic" is not wrong because a fit finds 1.96.

    **Arguments:** χ² left by either, and the `excess` over noise of the fit without them.
    """
    return is_family_of(whole, part) and left_by_part - left_by_whole < ANOTHER_LAW * excess
