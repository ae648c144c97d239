"""Every unusable campaign, at the command line: one line, exit code 2, nothing written."""

from __future__ import annotations

import pytest

from tests.broken import SAYS, broken
from tests.end_to_end.user import assert_one_line, ident


@pytest.mark.parametrize(("name", "write"), list(broken()), ids=[name for name, _ in broken()])
def test_a_broken_campaign_is_answered_in_one_line(name, write, tmp_path):
    folder = tmp_path / "campaign"
    folder.mkdir()
    path = write(folder)
    for command in (["fit", path, "-o", tmp_path / "run"], ["check", path]):
        assert_one_line(ident(*command), *SAYS[name])
    assert [p.name for p in tmp_path.iterdir()] == ["campaign"]


def test_a_sweep_alone_of_too_few_points_is_fitted_and_not_trusted(tmp_path):
    rows = "\n".join(f"{f},3,{1 + 0.1 * i}" for i, f in enumerate(range(400, 500, 10)))
    (tmp_path / "sweep.csv").write_text(f"frequency (Hz),level (V),amplitude (um)\n{rows}\n", encoding="utf-8")
    assert ident("check", tmp_path / "sweep.csv").code == 0
    outcome = ident("fit", tmp_path / "sweep.csv", "-o", tmp_path / "run")
    assert outcome.code == 0 and (tmp_path / "run" / "report.html").exists()
    assert "Do not trust the error bars" in outcome.out
