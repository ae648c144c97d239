"""The chain on disk: ensembles as emcee's own HDF backend writes them, and everything needed to go on bit by bit.

The file is written whole beside the old one and put in its place, so that a process killed at any moment leaves the
last complete one. `emcee.backends.HDFBackend("chain.h5", name="ensemble_0")` reads each ensemble.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import UserError, need

FORMAT = 2
_AGAIN = "sample again without --resume, with --force"


class Chain(NamedTuple):
    """What has been drawn so far.

    **Arguments:** per ensemble `positions` (E, steps, walkers, p), `log_probability` (E, steps, walkers), `accepted`
    (E, walkers), `generators`, the state of each generator; `taus`, largest τ at each check; `frame`: the coordinates
    (`Density.frame`) and `covariance` of the proposals; `key`, what the chain belongs to.
    """

    positions: np.ndarray
    log_probability: np.ndarray
    accepted: np.ndarray
    generators: tuple[Any, ...]
    taus: tuple[float, ...]
    frame: dict[str, np.ndarray]
    key: str


def need_h5py() -> Any:
    """The h5py module. **Raises:** UserError with the command that installs it."""
    return need("h5py", "a chain, which is kept in HDF5,", "posterior")


def write_chain(path: Path, chain: Chain) -> None:
    """Write the file whole, or leave the old one."""
    h5py = need_h5py()
    beside = path.with_name(path.name + ".part")
    with h5py.File(beside, "w") as file:
        file.attrs["format"], file.attrs["key"] = FORMAT, chain.key
        file.attrs["taus"] = np.asarray(chain.taus, float)
        frame = file.create_group("frame")
        for name, values in chain.frame.items():
            frame[name] = values
        for e, state in enumerate(chain.generators):
            group = file.create_group(f"ensemble_{e}")
            steps, walkers, size = chain.positions[e].shape
            group.attrs.update(version="3.1", nwalkers=walkers, ndim=size, has_blobs=False, iteration=steps)
            for name, values in (("chain", chain.positions[e]), ("log_prob", chain.log_probability[e])):
                # A checksum per chunk, so that damage is noticed wherever it is.
                group.create_dataset(name, data=values, fletcher32=True, maxshape=(None, *values.shape[1:]))
            group["accepted"] = chain.accepted[e]
            for i, part in enumerate(state):
                group.attrs[f"random_state_{i}"] = part
        file.flush()
    with open(beside, "rb") as written:
        os.fsync(written.fileno())
    beside.replace(path)


def read_chain(path: Path, key: str | None = None) -> Chain:
    """The chain of a file, of whatever run if no `key` is given. **Raises:** UserError if it is missing, damaged, or
    belongs to another run."""
    if not path.is_file():
        raise UserError("there is no chain to go on with", where=str(path), do="sample without --resume")
    h5py = need_h5py()
    try:
        with h5py.File(path, "r") as file:
            if int(file.attrs["format"]) != FORMAT:
                raise UserError("the chain is of another version of ident", where=str(path), do=_AGAIN)
            if key is not None and file.attrs["key"] != key:
                what = "the chain belongs to another run: its model, data, noise or seed are not those of this folder"
                raise UserError(what, where=str(path), do=_AGAIN)
            groups = [file[f"ensemble_{e}"] for e in range(sum(name.startswith("ensemble_") for name in file))]
            return Chain(
                np.stack([g["chain"][:] for g in groups]),
                np.stack([g["log_prob"][:] for g in groups]),
                np.stack([g["accepted"][:] for g in groups]),
                tuple(_generator(g.attrs) for g in groups),
                tuple(float(t) for t in file.attrs["taus"]),
                {name: file["frame"][name][()] for name in file["frame"]},
                str(file.attrs["key"]),
            )
    except (OSError, KeyError, ValueError, RuntimeError):
        raise UserError("the chain file is cut short or damaged", where=str(path), do=_AGAIN) from None


def _generator(attributes: Any) -> tuple[Any, ...]:
    state = [attributes[f"random_state_{i}"] for i in range(5)]
    return (str(state[0]), np.asarray(state[1]), int(state[2]), int(state[3]), float(state[4]))
