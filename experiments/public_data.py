"""Public benchmark data, which are not shipped: where they are looked for, and a campaign made of them."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def data_folder(name: str) -> Path:
    """Where the files of a benchmark are looked for: `IDENT_BENCHMARKS` names the folder above it."""
    return Path(os.environ.get("IDENT_BENCHMARKS") or ROOT.parent / "shared" / "data") / name


def available(name: str, files: Sequence[str]) -> bool:
    """Whether all files of a benchmark are there."""
    return all((data_folder(name) / file).is_file() for file in files)


def campaign_text(page: Path) -> str:
    """The campaign that a page shows: what its reader would type."""
    fence = re.search(r"^```toml\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    if fence is None:
        raise ValueError(f"{page} shows no campaign")
    return fence[1]


def prepare(folder: Path, text: str, name: str, files: Sequence[str]) -> None:
    """Make a campaign folder: its campaign.toml, with the tables beside it."""
    folder.mkdir()
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    for file in files:
        (folder / file).symlink_to((data_folder(name) / file).resolve())


def ident(arguments: Sequence[str], work: Path) -> None:
    """Run one command in the folder `work`, its progress on stderr."""
    path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    subprocess.run(
        (sys.executable, "-m", "ident.cli.main", *arguments), cwd=work, check=True, stdout=subprocess.DEVNULL,
        env=os.environ | {"PYTHONPATH": path},
    )  # fmt: skip
