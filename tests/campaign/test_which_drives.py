"""Which column drives where no name tells: one answer for the files of one instrument, and the odd one is told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ident.campaign import read_campaign
from ident.campaign.propose import propose
from ident.campaign.quality.exchanged import exchanged

TIME = np.arange(600) / 6000
NOISE = (0.004, 0.006)  # of the first channel and of the second, V: what the instrument adds


def scope(folder: Path, drives: list[float], turned: tuple[int, ...] = (), noise=NOISE) -> list[Path]:
    """A file for each amplitude of the drive; those `turned` were recorded with the cables exchanged."""
    rng, files = np.random.default_rng(4), []
    for k, level in enumerate(drives):
        f = 90 + 6 * k
        signals = [level * np.sin(2 * np.pi * f * TIME), np.sin(2 * np.pi * f * TIME - 0.8)]
        signals, own = (signals[::-1], noise[::-1]) if k in turned else (signals, noise)
        one, two = (s + n * rng.standard_normal(len(TIME)) for s, n in zip(signals, own, strict=True))
        rows = "\n".join(f"{t:.6f},{a:.6f},{b:.6f}" for t, a, b in zip(TIME, one, two, strict=True))
        files.append(folder / f"run{k}.csv")
        files[-1].write_text(f"TIME (s),CH1 (V),CH2 (V)\n{rows}\n", encoding="utf-8")
    return files


def test_a_weak_drive_does_not_turn_its_file_against_the_others(tmp_path):
    text = propose(scope(tmp_path, [0.5, 4.0, 6.0, 5.0, 3.0]), tmp_path)  # the first is rougher than its response
    assert text.count('drive = "CH1 (V)"') == 5
    assert text.count("is not said; the smoother is taken") == 4
    doubt = 'but here "CH2 (V)" is the smoother: were the channels exchanged?'
    assert text.count(doubt) == 1 and text.index(doubt) < text.index("run1.csv")


def test_what_is_clear_in_one_file_outweighs_what_is_not_in_two(tmp_path):
    text = propose(scope(tmp_path, [0.6, 0.6, 9.0]), tmp_path)
    assert text.count('drive = "CH1 (V)"') == 3


def test_a_tie_is_told_of_all_and_accuses_none(tmp_path):
    text = propose(scope(tmp_path, [2.0, 2.0], turned=(1,)), tmp_path)
    told = (
        'the files contradict one another ("CH1 (V)" in run0.csv and "CH2 (V)" in run1.csv); "CH1 (V)" is taken in all'
    )
    assert text.count(told) == 2 and "exchanged?" not in text
    assert text.count('drive = "CH1 (V)"') == 2


def test_files_with_other_columns_are_decided_by_themselves(tmp_path):
    files = scope(tmp_path, [4.0, 4.0, 4.0], turned=(2,))
    files[2].write_text(files[2].read_text().replace("CH1", "A").replace("CH2", "B"), encoding="utf-8")
    text = propose(files, tmp_path)
    assert text.count('drive = "CH1 (V)"') == 2 and text.count('drive = "B (V)"') == 1
    assert "exchanged?" not in text


@pytest.mark.parametrize("drives", [[0.5, 4.0, 6.0, 5.0], [1.0, 4.0, 6.0, 5.0]])
def test_a_check_names_the_record_whose_columns_are_the_wrong_way_round(tmp_path, drives):
    text = propose(scope(tmp_path, drives), tmp_path)
    (tmp_path / "campaign.toml").write_text(text, encoding="utf-8")
    assert exchanged(read_campaign(tmp_path)) == ()
    wrong = text.replace('drive = "CH1 (V)", response = "CH2 (V)"', 'drive = "CH2 (V)", response = "CH1 (V)"', 1)
    (tmp_path / "campaign.toml").write_text(wrong, encoding="utf-8")
    [sentence] = exchanged(read_campaign(tmp_path))
    assert sentence.startswith("run0.csv") and sentence.endswith("were the two columns exchanged?")


def test_channels_that_are_alike_accuse_nobody(tmp_path):
    text = propose(scope(tmp_path, [4.0, 4.0, 5.0, 2.0], noise=(0.005, 0.005)), tmp_path)
    wrong = text.replace('drive = "CH1 (V)", response = "CH2 (V)"', 'drive = "CH2 (V)", response = "CH1 (V)"', 1)
    (tmp_path / "campaign.toml").write_text(wrong, encoding="utf-8")
    assert exchanged(read_campaign(tmp_path)) == ()
