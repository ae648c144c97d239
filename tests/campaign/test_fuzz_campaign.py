"""Random bytes and random values are read as finite records, or answered with advice in one line."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from ident.campaign import read_campaign
from ident.errors import UserError
from ident.units import find_unit, parse_quantity
from tests.broken import HEADER, campaign_text, csv_text

KEYS = (
    "kind",
    "start",
    "holdout",
    "load",
    "noise",
    "skip",
    "columns",
    "units",
    "direction",
    "quantity",
    "rate",
    "level",
)
SUFFIXES = (".csv", ".txt", ".mat", ".h5", ".nc", ".parquet", ".tdms")

_words = st.sampled_from(
    ("rest", "up", "um", "12 nm", "40 mg", "20 ms", "3 V", "t", "drive", "z (um)", "1e400 V", "-1 s", "")
)
_plain = st.one_of(st.booleans(), st.integers(), st.floats(), st.text(max_size=12), _words)


def _toml(value: object) -> str:
    """A TOML value (tomllib has no writer)."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        escaped = "".join(c if c.isprintable() and c not in '"\\' else f"\\U{ord(c):08X}" for c in value)
        return f'"{escaped}"'
    if isinstance(value, list):
        return "[" + ", ".join(_toml(one) for one in value) + "]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_toml(key)} = {_toml(one)}" for key, one in value.items()) + "}"
    return repr(value)


_text = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
_values = st.recursive(
    st.one_of(st.booleans(), st.integers(), st.floats(), _text, _words),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.one_of(_text, _words), inner, max_size=3)),
    max_leaves=6,
)


def _reads_or_advises(path: Path | list[Path]) -> None:
    try:
        campaign = read_campaign(path)
    except UserError as error:
        assert "\n" not in str(error)
        return
    for record in campaign.traces:  # what is read can be fitted
        assert np.all(np.diff(record.time) > 0)
        assert np.all(np.isfinite([record.time, record.drive, record.response]))
        assert record.noise.sigma > 0


def _in_folder(content: bytes, name: str = "a.csv", campaign: str | None = None) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_bytes(content)
        if campaign is None:
            _reads_or_advises(path)
        else:
            (Path(folder) / "campaign.toml").write_bytes(campaign.encode("utf-8", "replace"))
            _reads_or_advises(Path(folder))


@given(st.binary(max_size=400), st.sampled_from(SUFFIXES))
def test_random_bytes(content, suffix):
    _in_folder(content, "a" + suffix)


@given(st.binary(max_size=200))
def test_random_bytes_as_a_campaign(content):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "c.toml"
        path.write_bytes(content)
        _reads_or_advises(path)


@given(st.text(st.characters(exclude_categories=["Cs"]), max_size=60), st.sampled_from(",;\t "), st.booleans())
def test_random_header_over_good_numbers(header, separator, comma):
    text = csv_text(header, separator=separator if not comma else ";")
    _in_folder((text.replace(".", ",") if comma else text).encode())


@given(
    st.lists(
        st.lists(st.one_of(st.floats().map(repr), st.text(max_size=4), st.just("")), max_size=5).map(",".join),
        max_size=40,
    )
)
@example(["0.0", "0.0,,,", "inf,0.0,,0.0", "0.0,,0.0,0.0"])  # infinite steps have no median
def test_random_rows(rows):
    _in_folder("\n".join([HEADER, *rows]).encode("utf-8", "replace"))


@given(st.integers(0, 400), st.integers(0, 30), st.text(st.characters(exclude_categories=["Cs"]), max_size=6))
def test_a_good_file_with_random_text_somewhere(row, column, insert):
    rows = csv_text().split("\n")
    line = rows[row]
    rows[row] = line[:column] + insert + line[column:]
    _in_folder("\n".join(rows).encode())


@given(st.dictionaries(st.sampled_from(KEYS), _values, min_size=1, max_size=3))
def test_random_values_in_a_record(values):
    lines = "\n".join(f"{key} = {_toml(value)}" for key, value in values.items() if key != "kind")
    _in_folder(csv_text().encode(), campaign=campaign_text(lines))


@given(st.sampled_from(("model", "effect", "priors", "device", "title", "record", "x")), _values)
def test_random_values_at_the_top(key, value):
    _in_folder(
        csv_text().encode(), campaign=f"{key} = {_toml(value)}\n" + ("" if key == "record" else campaign_text()[12:])
    )


@given(
    st.dictionaries(_text, st.dictionaries(_text, _values, max_size=3), max_size=3),
    st.sampled_from(("effect", "priors")),
)
def test_random_effects_and_priors(tables, name):
    _in_folder(csv_text().encode(), campaign=f"{name} = {_toml(tables)}\n" + campaign_text())


@given(st.dictionaries(st.sampled_from(("kind", "width", "beam_end", "output", "max_voltage", "in_plane")), _values))
def test_random_devices(values):
    _in_folder(csv_text().encode(), campaign=f"device = {_toml(values)}\n" + campaign_text())


@given(st.text(max_size=30))
def test_random_units(text):
    found = find_unit(text)
    assert found is None or found.factor > 0
    try:
        parse_quantity(text)
    except UserError as error:
        assert error.do


@pytest.mark.parametrize(
    "text", ["9" * 400 + " V", "1e999 m", "1 " + "m" * 1000, "1 m^9^9", "1 (m", "1 m//s", "１ V", "٣ V"]
)
def test_hostile_quantities(text):
    with pytest.raises(UserError):
        parse_quantity(text)
