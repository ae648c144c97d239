"""What is said beside a document of records in memory."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ident.campaign import Oscillator, read_campaign
from ident.errors import UserError

TIME = np.arange(200) * 1e-4
DATA: dict[str, Any] = {"time (s)": TIME, "drive (V)": np.sin(3e3 * TIME), "response (V)": np.cos(3e3 * TIME)}
DOCUMENT = {"title": "bench", "record": [{"data": DATA, "file": "a"}, {"data": DATA, "file": "b"}]}


def test_a_document_takes_a_device_a_title_and_who_is_held_out() -> None:
    found = read_campaign(DOCUMENT, device={"kind": "oscillator"}, title="again", holdout=["b"], start="unknown")
    assert found.title == "again" and isinstance(found.device, Oscillator)
    assert [record.holdout for record in found.records] == [False, True]
    assert all(record.holdout for record in read_campaign(DOCUMENT, holdout=True).records)
    with pytest.raises(UserError, match="'c' to hold out"):
        read_campaign(DOCUMENT, holdout="c")
