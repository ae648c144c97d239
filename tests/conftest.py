"""What every test relies on: double precision, no display, and examples that repeat in CI."""

from __future__ import annotations

import os

os.environ["MPLBACKEND"] = "Agg"  # before anything imports matplotlib: no test may open a window
# The threads of OpenBLAS wait by spinning, and several test processes would spin for the same cores. The workers of
# pytest-xdist read it when they import numpy.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from hypothesis import HealthCheck, settings

from ident import runtime

runtime.configure()

# JAX compiles on a test's first example, so neither a deadline nor "too slow" says anything about the code.
_common = {"deadline": None, "suppress_health_check": [HealthCheck.too_slow]}
settings.register_profile("explore", **_common)
settings.register_profile("repeat", derandomize=True, print_blob=True, **_common)
settings.load_profile("repeat" if os.environ.get("CI") else "explore")


@pytest.fixture(autouse=True)
def trusting(monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory) -> None:
    """Tests write effect files all the time and run their own; those about strangers' files say otherwise.

    Nothing goes to the settings of whoever runs the tests.
    """
    monkeypatch.setenv("IDENT_CONFIG", str(tmp_path_factory.getbasetemp() / "settings"))
    monkeypatch.setattr("ident.campaign.trust._known", lambda checksum: True)
