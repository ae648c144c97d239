"""What stands in the figure of a sweep."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

from ident.campaign.record import Channel
from ident.report.figures.curves import _jump_words


def test_a_level_is_told_in_the_unit_of_its_column():
    run = SimpleNamespace(run=SimpleNamespace(level=0.25, up=True), jump=SimpleNamespace(measured=40.0, model=None))
    curve = SimpleNamespace(runs=[run], sweep=SimpleNamespace(drive_channel=Channel("mN", 1e-3)))
    assert _jump_words(cast(Any, curve), cast(Any, None)) == "jumps:  250 mN up: measured 40.00 Hz, model none"
