"""Fits that several tests look at, each made once per process."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.end_to_end.user import DATA, Outcome, ident


@pytest.fixture(scope="session")
def clean(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Outcome]:
    """A folder with `campaign/` (a copy of the linear platform) and `run/`, and what `ident fit` said."""
    home = tmp_path_factory.mktemp("clean")
    shutil.copytree(DATA / "platform_clean", home / "campaign")
    return home, ident("fit", home / "campaign", "-o", home / "run", "--profile", "platform.quality")


@pytest.fixture(scope="session")
def oscillator(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Outcome]:
    """The run folder of the oscillator in volts with its cubic spring, and the printed JSON."""
    run = tmp_path_factory.mktemp("oscillator") / "run"
    return run, ident("fit", DATA / "oscillator", "--effects", "cubic-stiffness", "-o", run, "--json")


@pytest.fixture(scope="session")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign of one short record, for mistakes that are found before anything is fitted."""
    folder = tmp_path_factory.mktemp("small")
    lines = (DATA / "platform_clean" / "sine_3V_500Hz.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    (folder / "a.csv").write_text("".join(lines[:402]), encoding="utf-8")
    (folder / "campaign.toml").write_text('[model]\neffects = []\n\n[[record]]\nfile = "a.csv"\nstart = "rest"\n')
    return folder
