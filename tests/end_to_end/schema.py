"""What outside programs may rely on in `run.json`, format 1."""

from __future__ import annotations

from typing import Any

SCORE = {
    "n": int, "rmse": float, "unit": str, "noise_rmse": float, "error_over_noise": float, "error_over_signal": float,
}  # fmt: skip
PARAMETER = {"name": str, "value": float, "unit": str, "flags": list}
RUN = {
    "format": int,
    "effects": list,
    "converged": bool,
    "sigma": str,
    "parameters": list,
    "undetermined": list,
    "fitted": dict,
    "records": list,
}


def _assert_fields(found: dict[str, Any], expected: dict[str, type], where: str) -> None:
    for key, kind in expected.items():
        assert isinstance(found.get(key), kind), f"{where}: {key} is {found.get(key)!r}, not {kind.__name__}"


def assert_run(document: dict[str, Any]) -> None:
    """Every field of the interface is there, with its type."""
    _assert_fields(document, RUN, "run.json")
    assert document["format"] == 1
    assert document["sigma"] in ("known", "scaled", "fitted")
    for parameter in document["parameters"]:
        _assert_fields(parameter, PARAMETER, parameter["name"])
        assert parameter["standard_error"] is None or parameter["standard_error"] > 0
    _assert_fields(document["fitted"], SCORE, "fitted")
    if document["holdout"] is not None:
        _assert_fields(document["holdout"], SCORE, "holdout")
    for record in document["records"]:
        _assert_fields(record, {"file": str, "holdout": bool, **SCORE}, record["file"])
