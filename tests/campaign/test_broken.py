"""Whatever is wrong with a campaign, the user gets one sentence that says where and what to do; never anything else."""

from __future__ import annotations

import pytest

from ident.campaign import read_campaign
from ident.errors import UserError
from tests.broken import SAYS, broken


def test_there_are_enough_broken_campaigns():
    names = [name for name, _ in broken()]
    assert len(names) == len(set(names)) >= 40


@pytest.mark.parametrize(("name", "write"), list(broken()), ids=[name for name, _ in broken()])
def test_a_broken_campaign_gives_one_clear_line(name, write, tmp_path):
    path = write(tmp_path)
    with pytest.raises(UserError) as caught:
        read_campaign(path)
    message = str(caught.value)
    assert "\n" not in message
    for words in SAYS[name]:
        assert words in message, message
    assert caught.value.what and caught.value.do, message
    assert caught.value.where, message
