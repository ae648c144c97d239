"""Everything that a file can say can be said of arrays, and a prediction knows how well it is known."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

import ident
from ident.campaign import read_campaign
from ident.fit.reading import read
from tests.end_to_end.user import DATA

CLEAN = DATA / "platform_clean"


@pytest.fixture(scope="module")
def found():
    return ident.fit(CLEAN)


def columns(name: str) -> dict[str, np.ndarray]:
    trace = next(r for r in read_campaign(CLEAN).traces if r.name == name)
    return {"time (ms)": 1e3 * trace.time, "U [mV]": 1e3 * trace.drive, "z (um)": 1e6 * trace.response}


def test_arrays_tables_and_files_are_one_campaign():
    told = columns("sine_3V_500Hz.csv")
    (of_file,) = read_campaign(CLEAN / "sine_3V_500Hz.csv", start="rest").traces
    plain = np.column_stack([of_file.time, of_file.drive, of_file.response])
    shuffled = pd.DataFrame({"x": told["time (ms)"], "b": told["z (um)"], "a": told["U [mV]"]})
    named = {"time": "x", "drive": "a", "response": "b"}
    units = {"time": "ms", "drive": "mV", "response": "um"}
    for data, said in (
        (told, {}),
        (pd.DataFrame(told), {}),
        (plain, {}),
        (shuffled, {"columns": named, "units": units}),
    ):
        (trace,) = read_campaign(data, start="rest", **said).traces
        np.testing.assert_allclose(trace.response, of_file.response, rtol=1e-9)
        np.testing.assert_allclose(trace.drive, of_file.drive, rtol=1e-9)
        assert trace.start == of_file.start == "rest"
        assert trace.noise.sigma == pytest.approx(of_file.noise.sigma, rel=1e-6)


def test_a_document_says_what_a_campaign_file_says():
    document = {
        "title": "mine",
        "model": {"effects": ["cubic-stiffness"]},
        "priors": {"cubic-stiffness.k3": {"normal": [0.0, 1e9], "unit": "N/m^3"}},
        "record": [
            {"data": columns("sine_3V_500Hz.csv"), "file": "a", "start": "rest"},
            {"data": columns("sine_5V_450Hz.csv"), "holdout": True, "noise": "25 nm"},
        ],
    }
    campaign = read_campaign(document)
    assert campaign.effects == ("cubic-stiffness",) and campaign.priors["cubic-stiffness.k3"].deviation == 1e9
    assert [(r.name, r.holdout, r.start) for r in campaign.traces] == [
        ("a", False, "rest"),
        ("record 2", True, "unknown"),
    ]
    assert campaign.traces[1].noise.sigma == pytest.approx(25e-9)


@pytest.mark.parametrize(
    ("data", "told", "words"),
    [
        ([1, 2], {}, "no record"),
        ({"t": [1, 2], "u": [1]}, {}, "one length"),
        ({"t": ["a"]}, {}, "no column of numbers"),
        (columns("sine_3V_500Hz.csv"), {"strat": "rest"}, "did you mean 'start'"),
        (columns("sine_3V_500Hz.csv"), {"holdout": "recrd"}, "did you mean 'record'"),
        (CLEAN, {"start": "rest"}, "campaign file says itself"),
        ({**columns("sine_3V_500Hz.csv"), "z (um)": np.full(2000, np.nan)}, {}, "row 1"),
    ],
)
def test_what_is_no_record_is_answered(data, told, words):
    with pytest.raises(ident.UserError, match=words):
        read_campaign(data, **told)


def test_the_fit_of_arrays_is_the_fit_of_files(found):
    campaign = read_campaign(CLEAN)
    tables = {trace.name: columns(trace.name) for trace in campaign.traces}
    held = [trace.name for trace in campaign.heldout]
    again = ident.fit(tables, start="rest", holdout=held)
    for one, other in zip(found.estimates, again.estimates, strict=True):
        assert other.value == pytest.approx(one.value, abs=0.05 * one.error)
    assert again.holdout.error_over_noise == pytest.approx(found.holdout.error_over_noise, rel=1e-3)


def test_the_station_is_called_by_its_name(found):
    import ident.fit
    from ident.fit import Fit

    assert isinstance(found, Fit) and callable(ident.fit)
    with pytest.raises(AttributeError, match="'diagnose'"):
        _ = ident.diagnos


def test_the_error_of_a_prediction_is_the_spread_of_the_readings(found):
    trace = found.campaign.traces[0]
    rng = np.random.default_rng(3)
    draws = rng.multivariate_normal(found.values[list(found.free)], found.covariance, size=200)
    spread = np.std([read(found.model, _with(found, one), [trace])[0] for one in draws], axis=0)
    said = found.predict(trace.name)
    assert np.sqrt(np.mean(said.error**2)) == pytest.approx(np.sqrt(np.mean(spread**2)), rel=0.12)
    low, high = said.band(0.9)
    inside = np.mean((trace.response > low) & (trace.response < high))
    assert inside == pytest.approx(0.9, abs=0.03)


def _with(found, free):
    values = found.values.copy()
    values[list(found.free)] = free
    return values


def test_a_new_drive_begins_at_rest_and_parameters_can_be_set(found):
    held = next(r for r in found.campaign.traces if r.name == "sine_5V_450Hz.csv")
    said = found.predict({"t": held.time, "u": held.drive})
    np.testing.assert_allclose(said.reading, found.predict(held).reading, atol=1e-10)
    sharper = found.predict({"t": held.time, "u": held.drive}, {"quality": 60, "frequency": "0.45 kHz"})
    assert np.max(np.abs(sharper.reading)) > 2 * np.max(np.abs(said.reading))
    for name, told in (("qualty", 40), ("quality", -1), ("quality", "40 mm"), ("quality", None), ("quality", 0),
                       ("frequency", "0 Hz")):  # fmt: skip
        with pytest.raises(ident.UserError):
            found.predict(held, {name: told})


def test_a_new_drive_that_was_sampled_unevenly_is_put_on_a_grid(found):
    time = (np.arange(600) + np.random.default_rng(1).uniform(-0.05, 0.05, 600)) * 2.5e-5
    said = found.predict({"t": time, "u": 5.0 * np.sin(2 * np.pi * 450.0 * time)})
    np.testing.assert_allclose(said.drive, 5.0 * np.sin(2 * np.pi * 450.0 * said.time), atol=0.02)


def test_of_curves_alone_nobody_knows_the_noise_of_a_measurement_in_time():
    found = ident.fit(DATA / "platform_sweeps", (), seconds=1e-3)  # wherever the search is by then
    time = np.arange(200) * 2.5e-5
    said = found.predict({"t": time, "u": np.sin(2 * np.pi * 300.0 * time)})
    with pytest.raises(ident.UserError, match="noise=False"):
        said.band()
    low, high = said.band(noise=False)
    assert np.isnan(said.noise) and np.all(low <= high)


def test_simulate_says_what_the_fit_says(found):
    said = ident.simulate(found, records=["sine_5V_450Hz.csv"])
    index = [r.name for r in found.campaign.traces].index("sine_5V_450Hz.csv")
    np.testing.assert_array_equal(said.reading("sine_5V_450Hz.csv"), found.readings[index])
    assert list(said.to_dataframe().columns) == ["record", "time", "drive", "reading"]
    with pytest.raises(ident.UserError, match="did you mean 'sine_5V_450Hz.csv'"):
        said.reading("sine_5V_45Hz.csv")


def test_a_run_of_arrays_has_a_report_but_says_that_it_cannot_be_read_again(found, tmp_path):
    run = ident.write_run(ident.fit(columns("sine_3V_500Hz.csv"), start="rest"), tmp_path / "run")
    assert (run / "report.html").is_file()
    with pytest.raises(ident.UserError, match="in memory"):
        ident.load_run(run)
