"""The posterior as an ArviZ container: `posterior.nc`, which ArviZ 0.23 and 1.x read alike.

Groups: posterior, log_likelihood (by blocks of time), posterior_predictive, observed_data, constant_data, sample_stats.
A chain of ArviZ is an ensemble; its draws are those of all walkers, step by step. Each record's samples have their
times beside them, s: `<record>_time` along `<record>_sample`.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import need
from .block_likelihood import block_likelihood
from .result import Posterior

_DRAWS = 500  # per ensemble: the file stays small, and any figure or summary is as good
_PREDICTED = 10  # per ensemble, of whole records


def need_arviz_base() -> Any:
    """The arviz_base module. **Raises:** UserError with the command that installs it."""
    what = "a posterior, which is kept as NetCDF,"
    need("h5netcdf", what, "posterior")
    return need("arviz_base", what, "posterior")


def write_container(posterior: Posterior, path: Path) -> None:
    """Write `posterior.nc`, whole or not at all."""
    arviz_base = need_arviz_base()
    density, random = posterior.density, np.random.default_rng(0)
    kept = posterior.sampled.kept
    ensembles = len(kept)
    flat = kept.reshape(ensembles, -1, density.size)
    index = np.linspace(0, flat.shape[1] - 1, min(_DRAWS, flat.shape[1])).astype(int)
    chosen = flat[:, index]
    probability = posterior.sampled.chain.log_probability[:, posterior.sampled.convergence.burned :]
    shape = chosen.shape[:2]
    together = chosen.reshape(-1, density.size)
    values = density.values(together)[:, list(density.static.free)].reshape(*shape, -1)
    blocks = block_likelihood(density, together)
    few = np.linspace(0, shape[1] - 1, min(_PREDICTED, shape[1])).astype(int)
    at = (np.arange(ensembles)[:, None] * shape[1] + few).reshape(-1)
    readings = density.readings(density.values(together[at]))
    predictive, observed, drive, times, likelihood = {}, {}, {}, {}, {}
    dims: dict[str, list[str]] = {}
    names = _names([record.name for record in density.records])
    for i, (name, record, reading) in enumerate(zip(names, density.records, readings, strict=True)):
        noise = random.standard_normal(reading.shape) * record.noise.sigma * blocks.sigma[at, i][:, None]
        predictive[name] = (reading + noise).reshape(ensembles, len(few), -1)
        observed[name], drive[name], times[name] = record.response, record.drive, record.time
        likelihood[name] = blocks.log_likelihood[:, blocks.record == i].reshape(*shape, -1)
        dims[name] = [f"{name}_sample"]
    data = {
        "posterior": {n: values[..., k] for k, n in enumerate(density.names)},
        "log_likelihood": {f"{n}_blocks": v for n, v in likelihood.items()},
        "posterior_predictive": predictive,
        "observed_data": observed,
        "constant_data": {f"{n}_drive": v for n, v in drive.items()},
        "sample_stats": {"lp": probability.reshape(ensembles, -1)[:, index]},
    }
    dims |= {f"{n}_blocks": [f"{n}_block"] for n in likelihood} | {f"{n}_drive": [f"{n}_sample"] for n in drive}
    attributes = {"inference_library": "emcee", "trusted": str(posterior.trusted), "units": "SI"}
    tree = arviz_base.from_dict(data, dims=dims, attrs={"/": attributes})
    for n, prior in zip(density.names, density.priors, strict=True):
        tree["posterior"][n].attrs["units"] = prior.unit
    for group in ("posterior_predictive", "observed_data", "constant_data"):
        beside_samples = {f"{n}_time": ([f"{n}_sample"], time, {"units": "s"}) for n, time in times.items()}
        tree[group].dataset = tree[group].to_dataset().assign_coords(beside_samples)
    beside = path.with_name(path.name + ".part")
    tree.to_netcdf(beside, engine="h5netcdf")
    beside.replace(path)


def _names(files: Sequence[str]) -> list[str]:
    """What records are called, by their files, in words that NetCDF allows: each by its stem; where several would be
    called the same (files of two folders, recordings of one file) those by all of their names, or by their numbers."""
    plain = lambda text: re.sub(r"[^\w.]+", "_", text)
    names = [plain(Path(file).stem) for file in files]
    names = [plain(file) if names.count(name) > 1 else name for file, name in zip(files, names, strict=True)]
    return [f"{name}_{k}" if names.count(name) > 1 else name for k, name in enumerate(names, 1)]
