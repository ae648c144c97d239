"""What a caller in Python gives that no fit can use is said in a sentence, before anything is computed."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

import ident
from ident.campaign import read_campaign
from ident.errors import UserError
from tests.end_to_end.user import DATA

CLEAN = DATA / "platform_clean"
BIASED = 2e-7


def _sine(offset: float = 0.0):
    trace = next(r for r in read_campaign(CLEAN).traces if r.name == "sine_3V_500Hz.csv")
    return {"time (s)": trace.time, "U (V)": trace.drive, "z (m)": trace.response + offset}


@pytest.fixture(scope="module")
def found():
    return ident.fit(_sine(), (), start="rest")


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"sigma": "fited"}, "choose one of known, scaled, fitted"),
        ({"starts": -1}, "is no such number"),
        ({"initial": [1.0, 2.0]}, "give 3 finite numbers, SI: platform.frequency"),
        ({"starts": 1.5}, "is no such number"),
        ({"seed": -1}, "seed = -1 is no such number"),
        ({"initial": "none"}, "is no value of each parameter"),
        ({"initial": [np.nan] * 3}, "is no value of each parameter"),
        ({"effects": (3,)}, "3 is neither the name of an effect nor a class of one"),
        ({"effects": 3}, "3 is neither the name of an effect nor a class of one"),
        ({"effects": (int,)}, "is neither the name of an effect nor a class of one"),
    ],
)
def test_settings_that_cannot_be_used(given, says):
    with pytest.raises(UserError, match=says.replace("(", r"\(")):
        ident.fit(_sine(), **{"effects": (), **given}, start="rest")


def test_numbers_of_numpy_are_numbers():
    assert len(ident.fit(_sine(), (), start="rest", starts=np.int64(1), seed=np.int64(2)).starts) == 2


def test_a_complex_column_is_no_column_of_numbers():
    columns = _sine()
    columns["z (m)"] = columns["z (m)"] + 0j
    with pytest.raises(UserError, match=r'column 3 \("z \(m\)"\)'):
        ident.fit(columns)


def test_paths_may_be_strings_and_fits_have_names(found, tmp_path: Path):
    with pytest.raises(UserError, match="no effect"):
        ident.attribute(found, chain_file=str(tmp_path / "chain.h5"))
    law = tmp_path / "law.py"
    law.write_text("")
    with pytest.raises(UserError, match="this file exists already"):
        ident.diagnose(found, effect_file=str(law))
    with pytest.raises(UserError, match="are not those of a"):
        ident.compare({"a": found, "b": ident.fit(CLEAN, ())})
    with pytest.raises(UserError, match="neither the name"):
        ident.add(found, 3)  # type: ignore[arg-type]


def test_an_offset_that_the_model_lacks_counts_in_a_fitted_noise():
    """The noise is then what is left, root mean square: by that the error over noise is one."""
    biased = ident.fit(_sine(BIASED), (), sigma="fitted", start="rest")
    assert biased.fitted.error_over_noise == pytest.approx(1.0, abs=0.02)


def test_a_sentence_passes_between_processes():
    told = pickle.loads(pickle.dumps(UserError("it is wrong", where="a.csv", do="mend it")))
    assert str(told) == "a.csv: it is wrong — mend it"
