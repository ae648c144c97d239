"""A slice of the studies of broken inputs and of killed processes; both are run whole by hand."""

from __future__ import annotations

import sys

import pytest

from experiments.robust import fuzz, kill


def test_broken_inputs_end_in_advice(capsys):
    fuzz.warm()
    ends = fuzz.study(fuzz.api, 300, 4) + fuzz.study(fuzz.cli, 40, 4)
    assert {end: count for end, count in ends.items() if end not in ("fine", "advice")} == {}, capsys.readouterr().out
    assert ends["fine"] > 40 and ends["advice"] > 100  # neither everything nor nothing is refused


@pytest.mark.skipif(sys.platform == "win32", reason="there is no SIGKILL")
def test_a_run_survives_the_kill_of_whoever_writes_it():
    assert kill.study(2, 1) == (0, 0)
