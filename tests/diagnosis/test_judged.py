"""What `ident.sample` and `ident.attribute` refuse they refuse at once, before the library is asked."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from ident.diagnosis import judged
from ident.errors import UserError


def test_what_is_refused_is_refused_before_the_library_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(judged, "missing", lambda *_: pytest.fail("the library was asked"))
    campaign = SimpleNamespace(fitted=(), fitted_sweeps=(object(),), effect_files=())
    of_sweeps: Any = SimpleNamespace(campaign=campaign, model=SimpleNamespace(names=()))
    with pytest.raises(UserError, match="rests on sweeps"):
        judged.sample(of_sweeps)
    with pytest.raises(UserError, match="no effect"):
        judged.attribute(of_sweeps)
