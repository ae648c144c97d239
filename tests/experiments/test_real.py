"""The measured devices of `docs/real-devices.md`."""

from __future__ import annotations

import importlib
import tomllib
from pathlib import Path

import pytest

from experiments import public_data

ROOT = Path(__file__).parents[2]
SETS = sorted(p.stem for p in (ROOT / "experiments" / "real").glob("*.py") if p.stem not in ("__init__", "device"))


@pytest.mark.parametrize("name", SETS)
def test_every_set_has_its_row_and_a_campaign_that_holds_records_out(name):
    device = importlib.import_module(f"experiments.real.{name}").DEVICE
    assert f"| `{name}` |" in (ROOT / "docs" / "real-devices.md").read_text(encoding="utf-8")
    records = tomllib.loads(device.campaign)["record"]
    assert {r["file"] for r in records} == set(device.files)
    assert any(r.get("holdout") for r in records) and not all(r.get("holdout") for r in records)


@pytest.mark.slow
@pytest.mark.parametrize("name", SETS)
def test_the_limits_hold(name):
    device = importlib.import_module(f"experiments.real.{name}").DEVICE
    if not public_data.available(device.folder, device.files):
        pytest.skip(f"{public_data.data_folder(device.folder)} lacks the files; IDENT_BENCHMARKS names another folder")
    device.main()
