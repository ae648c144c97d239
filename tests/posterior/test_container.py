"""What `posterior.nc` holds of each record."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.fit.fit import fit
from ident.model import build_model
from ident.posterior.container import write_container
from ident.posterior.density import make_density
from tests.posterior.records import campaign, record

xarray = pytest.importorskip("xarray")
pytest.importorskip("arviz_base")
pytest.importorskip("h5netcdf")


def test_records_of_one_stem_are_all_there(tmp_path: Path) -> None:
    names = ("up/a.csv", "down/a.csv", "b.csv #1", "b.csv #2", "c.csv", "c.csv")
    data = campaign(*(replace(record(k, samples=120 + 10 * k), name=name) for k, name in enumerate(names)))
    density = make_density(fit(build_model(data, ()), data))
    draws = 0.01 * np.random.default_rng(0).standard_normal((2, 3, 4, density.size))
    sampled = SimpleNamespace(kept=draws, chain=SimpleNamespace(log_probability=np.zeros((2, 3, 4))),
                              convergence=SimpleNamespace(burned=0))  # fmt: skip
    posterior: Any = SimpleNamespace(density=density, sampled=sampled, trusted=True)
    write_container(posterior, tmp_path / "posterior.nc")
    with xarray.open_datatree(tmp_path / "posterior.nc", engine="h5netcdf") as tree:
        observed = tree["observed_data"].to_dataset()
        assert [len(observed[name]) for name in sorted(observed.data_vars)] == [140, 150, 160, 170, 130, 120]
        assert sorted(observed.data_vars) == ["b.csv_1", "b.csv_2", "c.csv_5", "c.csv_6", "down_a.csv", "up_a.csv"]
        assert len(tree["log_likelihood"].to_dataset().data_vars) == len(names)
