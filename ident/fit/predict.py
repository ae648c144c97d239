"""What a fitted model says of a drive, and how well it can know that."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.special import ndtri

from ..campaign.campaign import Campaign
from ..campaign.drive_alone import drive_alone
from ..campaign.in_memory import table_of
from ..campaign.load import read_table
from ..campaign.record import Trace
from ..errors import UserError
from .change_values import changed_values
from .reading import read_with_slopes

if TYPE_CHECKING:
    from pandas import DataFrame

    from .result import Fit


class Prediction(NamedTuple):
    """A model's reading for one drive, (n,) SI.

    **Arguments:** `error`: (n,) standard deviation of the `reading` by the errors of the fitted parameters; `noise`: of
    a measurement beside it, NaN where curves alone were fitted; `unknown`: parameters whose error is not in it, because
    the records do not determine them.
    """

    name: str
    time: np.ndarray
    drive: np.ndarray
    reading: np.ndarray
    error: np.ndarray
    noise: float
    unknown: tuple[str, ...]

    def band(self, level: float = 0.9, *, noise: bool = True) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper end, (n,) each, between which a measurement (or without `noise` the model) lies with a
        probability of `level`, if the model is right.

        **Raises:** UserError if the noise of a measurement is not known.
        """
        if noise and not np.isfinite(self.noise):
            what = "curves alone were fitted, so that nobody knows the noise of a measurement in time"
            raise UserError(what, do="ask for the band of the model: band(noise=False)")
        half = ndtri(0.5 + level / 2) * np.sqrt(self.error**2 + (self.noise**2 if noise else 0.0))
        return self.reading - half, self.reading + half

    def to_dataframe(self) -> DataFrame:
        """Time, drive, reading and its error (SI), as a pandas table."""
        from pandas import DataFrame

        return DataFrame({"time": self.time, "drive": self.drive, "reading": self.reading, "error": self.error})

    def __repr__(self) -> str:
        unknown = f", without the error of {', '.join(self.unknown)}" if self.unknown else ""
        size = f"{np.std(self.reading):.3g} ± {np.sqrt(np.mean(self.error**2)):.2g} rms"
        return f"<Prediction of {self.name}: {len(self.time)} samples, {size}{unknown}>"


def predict(fit: Fit, data: Any, values: Mapping[str, float | str] | None = None) -> Prediction:
    """The reading of a fitted model for a record or a drive; see `Fit.predict`."""
    record = record_of(fit.campaign, data)
    model, at = fit.model, changed_values(fit.model, fit.values, values or {}, fit.campaign.order)
    reading, by_value, basis = read_with_slopes(model, at, record)
    kept = [k for k, i in enumerate(fit.free) if at[i] == fit.values[i]]
    covariance = fit.covariance[np.ix_(kept, kept)]
    slope = by_value[:, kept]
    variance = np.einsum("ni,ij,nj->n", slope, covariance, slope) + record.noise.sigma**2 * np.sum(basis**2, axis=1)
    floors = [r.noise.sigma for r in fit.campaign.fitted]
    usual = float(np.median(floors)) if floors else np.nan
    noise = record.noise.sigma if np.any(record.response) else usual
    names = [model.parameters[fit.free[k]].name for k in kept]
    unknown = tuple(name for name in names if "undetermined" in fit[name].flags)
    return Prediction(
        record.name, record.time, record.drive, reading, np.sqrt(np.maximum(variance, 0.0)), noise, unknown
    )  # fmt: skip


def record_of(campaign: Campaign, data: Any) -> Trace:
    """A record, by itself or by its name in the campaign; else a drive, from a file or from memory."""
    if isinstance(data, Trace):
        return data
    if isinstance(data, str) and data in (names := {record.name: record for record in campaign.traces}):
        return names[data]
    table = read_table(Path(data), Path(data).name) if isinstance(data, (str, os.PathLike)) else table_of(data, "drive")
    return drive_alone(table, campaign.device)
