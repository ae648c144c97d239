"""A user at the command line, inside this process."""

from __future__ import annotations

import io
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import NamedTuple

from ident.cli.main import run

ROOT = Path(__file__).parent.parent.parent
DATA = ROOT / "data"


class Outcome(NamedTuple):
    """What a command left behind: its exit code, results and progress."""

    code: int
    out: str
    err: str


def ident(*arguments: object) -> Outcome:
    """`ident ARGUMENTS`, as typed."""
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        code = run([str(argument) for argument in arguments])
    return Outcome(code, out.getvalue(), err.getvalue())


def assert_one_line(outcome: Outcome, *words: str) -> None:
    """Unusable input: exit code 2, nothing on stdout, one line on stderr that holds the words."""
    assert outcome.code == 2, outcome
    assert outcome.out == ""
    assert len(outcome.err.splitlines()) == 1, outcome.err
    assert "Traceback" not in outcome.err
    for word in words:
        assert word in outcome.err, outcome.err
