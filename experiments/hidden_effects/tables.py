"""The tables of the hidden-effect study, and the targets that they must meet."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from .laws import LAWS
from .mimics import SEEN

Row = dict[str, Any]

CLASS = {law.name: {law.name, *law.alike} for law in LAWS}
LETTER = {"e": "V", "de": "dV"}  # the tool's names of the laws' coordinates
NONE = "(nothing)"
FAILS = 1.1  # error over noise


def show(part: str, rows: Sequence[Row]) -> None:
    """Print the tables of a part."""
    if rows:
        print(f"\n{part}: {len(rows)} cases")
        _SHOWN[part](rows)
        print(f"processor time per case: {_quantiles([r['cpu_seconds'] for r in rows], '.1f')} s")


def check(part: str, rows: Sequence[Row]) -> None:
    """Assert that a part meets its targets."""
    missed = [f"{what}: {value:.4f}, target {sign} {bound}" for what, value, sign, bound in _TARGETS[part](rows)
              if not (value >= bound if sign == ">=" else value <= bound)]  # fmt: skip
    assert not missed, f"{part}: " + "; ".join(missed)


def named(row: Row) -> list[str]:
    """The effects that the tool names; what only refines a shape is none."""
    return [step["added"] for step in row["steps"] if step["role"] == "effect"]


def first_name(row: Row) -> str:
    return row["steps"][0]["added"] if row["steps"] else NONE


def top(row: Row, count: int) -> bool:
    """Whether the hidden effect, or one that no such record tells from it, is among the first names."""
    refitted = sorted(row["confirmed"], key=lambda name: -row["confirmed"][name])
    order = dict.fromkeys([first_name(row), *refitted, *(name for name, _, _ in row["ranking"])])
    return bool(CLASS[row["effects"][0]] & set(list(order)[:count]))


def visible(rows: Iterable[Row]) -> list[Row]:
    """Cases whose effect reaches the noise; some effects cannot be made as large as asked."""
    return [row for row in rows if row["true_size"] >= row["noise"]]


def both_found(row: Row) -> bool:
    """Whether every hidden effect was added, be it called a refinement: beside the other it may explain under 1 %."""
    added = {step["added"] for step in row["steps"]}
    return all(CLASS[name] & added for name in row["effects"])


def exact_set(row: Row) -> bool:
    """Whether the hidden effects, and no others, are named as effects."""
    return all(CLASS[name] & set(named(row)) for name in row["effects"]) and len(named(row)) == len(row["effects"])


def in_tie_set(row: Row) -> bool:
    first = row["steps"][0] if row["steps"] else {"added": NONE, "ties": []}
    return bool(CLASS[row["effects"][0]] & {first["added"], *first["ties"]})


def coordinates_right(row: Row) -> bool:
    law = row["laws"][row["effects"][0]]
    return {LETTER.get(c, c) for c in law["coordinates"]} == set(row["unknown"]["coordinates"])


def side_right(row: Row) -> bool:
    return row["laws"][row["effects"][0]]["side"] == row["unknown"]["side"]


def share(rows: Sequence[Row], holds: Callable[[Row], bool]) -> float:
    return float(np.mean([holds(row) for row in rows])) if rows else float("nan")


def _quantiles(values: Iterable[float | None], form: str = ".3f") -> str:
    known = np.array([v for v in values if v is not None], float)
    if not len(known):
        return "none"
    return f"median {np.median(known):{form}}, p90 {np.quantile(known, 0.9):{form}}, most {np.max(known):{form}}"


def _errors(rows: Sequence[Row]) -> None:
    for i, records in enumerate(("fitted", "held-out")):
        before, after = (_quantiles(row[when][i] for row in rows) for when in ("before", "after"))
        print(f"error over noise, {records} records: {before} -> {after}")
    print(f"estimated over true noise floor: {_quantiles(x for row in rows for x in row['sigma_ratio'])}, "
          f"least {min(x for row in rows for x in row['sigma_ratio']):.3f}")  # fmt: skip


def _single(rows: Sequence[Row]) -> None:
    print(f"{'size':>6} {'noise':>6} {'n':>4} {'top-1':>6} {'top-3':>6} {'exact':>6}  after, fitted / held-out (p90)")
    seen = visible(rows)
    for size, noise in sorted({(row["size"], row["noise"]) for row in seen}):
        part = [row for row in seen if (row["size"], row["noise"]) == (size, noise)]
        print(f"{size:6.1%} {noise:6.1%} " + _score_line(part))
    print(f"{'all':>13} " + _score_line(seen))
    print(f"below the noise and left out: {len(rows) - len(seen)}")
    _errors(seen)
    print("verdicts: " + ", ".join(f"{verdict} {n}" for verdict, n in Counter(r["verdict"] for r in seen).items()))
    confusion(seen)


def _score_line(rows: Sequence[Row]) -> str:
    cells = [share(rows, lambda row: top(row, 1)), share(rows, lambda row: top(row, 3)), share(rows, exact_set)]
    after = [np.array([row["after"][i] for row in rows]) for i in (0, 1)]
    errors = " / ".join(f"{np.median(a):.3f} ({np.quantile(a, 0.9):.3f})" for a in after)
    return f"{len(rows):4d} " + " ".join(f"{cell:6.3f}" for cell in cells) + f"  {errors}"


def confusion(rows: Sequence[Row]) -> None:
    """Print which effect (down) was named as which (across, by number), and the list of what went wrong."""
    names = [law.name for law in LAWS if any(law.name == row["effects"][0] for row in rows)]
    across = [*dict.fromkeys([*names, *sorted({first_name(row) for row in rows} - set(names))])]
    print("named first (across) for what was hidden (down); '.' is none")
    print(" " * 28 + "".join(f"{i:4d}" for i in range(1, len(across) + 1)))
    for i, hidden in enumerate(across, 1):
        found = Counter(first_name(row) for row in rows if row["effects"][0] == hidden)
        print(f"{i:3d} {hidden:24}" + "".join(f"{found[name] or '.':>4}" for name in across))
    for row in rows:
        if not top(row, 1):
            print(f"  missed: {told(row)}")


def told(row: Row) -> str:
    """A case and what was said of it, in one line."""
    hidden = " + ".join(row["effects"]) or "nothing hidden"
    steps = " > ".join(
        f"{'/'.join([s['added'], *s['ties']])}({s['role'][0]} {s['confirmed']:.3f})" for s in row["steps"]
    )
    errors = " ".join(f"{b}->{a}" for b, a in zip(row["before"], row["after"], strict=True))
    return (f"seed {row['seed']}, {hidden}, size {row['true_size']:.2%}, noise {row['noise']:.1%} {row['noise_kind']}, "
            f"{row['starts']}: {row['verdict']}, {steps or 'nothing'}; error over noise {errors}; "
            f"noise floors {min(row['sigma_ratio']):.2f}-{max(row['sigma_ratio']):.2f} of the true ones")  # fmt: skip


def _circumstances(rows: Sequence[Row]) -> None:
    for where in dict.fromkeys(row["circumstance"] for row in rows):
        print(f"{where:14} " + _score_line([row for row in visible(rows) if row["circumstance"] == where]))
    _errors(visible(rows))
    _list(visible(rows), lambda row: top(row, 1))


def _pairs(rows: Sequence[Row]) -> None:
    print(f"both found {share(rows, both_found):.3f}, exact set {share(rows, exact_set):.3f}")
    _errors(rows)
    _list(rows, exact_set)


def _nulls(rows: Sequence[Row]) -> None:
    print(f"{'noise':>8} {'starts':>6} {'n':>4} {'named':>6} {'doubted':>8}   before, fitted / held-out (p90)")
    groups = sorted({(row["noise_kind"], row["starts"]) for row in rows})
    for kind, starts in groups:
        part = [row for row in rows if (row["noise_kind"], row["starts"]) == (kind, starts)]
        before = [np.array([row["before"][i] for row in part]) for i in (0, 1)]
        errors = " / ".join(f"{np.median(a):.3f} ({np.quantile(a, 0.9):.3f})" for a in before)
        alarms, doubts = sum(map(_alarm, part)), sum(map(_doubted, part))
        print(f"{kind:>8} {starts:>6} {len(part):4d} {alarms:6d} {doubts:8d}   {errors}")
    print(f"false alarms {share(rows, _alarm):.4f}; called inadequate without a name {share(rows, _doubted):.4f}")
    _errors(rows)
    _list(rows, lambda row: row["verdict"] == "adequate")


def _alarm(row: Row) -> bool:
    return bool(row["steps"])


def _doubted(row: Row) -> bool:
    return not row["steps"] and row["verdict"] != "adequate"


def _outside(rows: Sequence[Row]) -> None:
    for name in dict.fromkeys(row["effects"][0] for row in rows):
        part = [row for row in rows if row["effects"][0] == name]
        verdicts = ", ".join(f"{v} {n}" for v, n in Counter(r["verdict"] for r in part).items())
        formulas = Counter(row["unknown"]["formula"] for row in part).most_common(2)
        print(f"{name:26} coordinates {share(part, coordinates_right):.2f}, side {share(part, side_right):.2f}; "
              f"{verdicts}; {' | '.join(f for f, _ in formulas)}")  # fmt: skip
    right = share(rows, lambda row: coordinates_right(row) and side_right(row))
    for i, records in enumerate(("fitted", "held-out")):
        print(f"with the written effect, {records} records: {_quantiles(r['unknown']['written'][i] for r in rows)}")
    print(f"coordinates and side {right:.3f}, confident wrong name {share(rows, _confident):.3f}, "
          f"with those whose law nobody could tell from the named one {share(rows, _named):.3f}")  # fmt: skip
    _errors(rows)
    _list(rows, lambda row: coordinates_right(row) and side_right(row) and not _confident(row))


def _named(row: Row) -> bool:
    return row["verdict"] == "identified"


def _confident(row: Row) -> bool:
    """A wrong name for sure, where an observer who knew both laws would have seen the difference."""
    return _named(row) and row["unknown"].get("left_by_name", np.inf) >= SEEN


def _fails_there(rows: Sequence[Row]) -> list[Row]:
    """Cases in which the linear model fails on the one record: it absorbs what shifts amplitude and phase only."""
    return [row for row in rows if row["before"][0] > FAILS]


def _poor(rows: Sequence[Row]) -> None:
    print(f"the linear model describes the record in {len(rows) - len(_fails_there(rows))} cases, which are left out")
    rows = _fails_there(rows)
    if not rows:
        return
    print(f"hidden effect in the tie set {share(rows, in_tie_set):.3f}, "
          f"named first {share(rows, lambda row: top(row, 1)):.3f}")  # fmt: skip
    tied = _tied(rows)
    print(f"tie sets wider than the effect's class: {len(tied)}; resolved by the proposed record "
          f"{share(tied, _resolved):.3f}")  # fmt: skip
    for row in tied:
        if not _resolved(row):
            print(f"  not resolved: {row['effects'][0]}, seed {row['seed']}: after {row['next']['record']} "
                  f"{', '.join(row['next']['named'])}")  # fmt: skip
    _errors(rows)
    _list(rows, in_tie_set)


def _tied(rows: Sequence[Row]) -> list[Row]:
    """Cases in which names tie that other records could tell apart."""
    beyond = lambda row: {row["steps"][0]["added"], *row["steps"][0]["ties"]} - CLASS[row["effects"][0]]
    return [row for row in rows if row.get("next") and row["steps"] and beyond(row)]


def _resolved(row: Row) -> bool:
    """Whether only the hidden effect, or its likes, is named once the proposed record is there."""
    return bool(row["next"]["named"]) and set(row["next"]["named"]) <= CLASS[row["effects"][0]]


def _list(rows: Sequence[Row], fine: Callable[[Row], bool]) -> None:
    for row in rows:
        if not fine(row):
            said = row.get("unknown")
            beside = f"; {said['side']} of {', '.join(said['coordinates'])}" if said else ""
            print(f"  missed: {told(row)}{beside}")


_SHOWN: dict[str, Callable[[Sequence[Row]], None]] = {
    "single": _single, "pairs": _pairs, "nulls": _nulls, "outside": _outside, "poor": _poor,
    "cut": _single,
    "steady": _single, "circumstances": _circumstances, "long": _single,
}  # fmt: skip

Target = tuple[str, float, str, float]


def _median_and_p90(rows: Sequence[Row]) -> list[Target]:
    fitted, held = (np.array([row["after"][i] for row in rows]) for i in (0, 1))
    return [
        ("error over noise after, median", float(np.median(fitted)), "<=", 1.02),
        ("error over noise after, p90", float(np.quantile(fitted, 0.9)), "<=", 1.1),
        ("held-out error over noise after, median", float(np.median(held)), "<=", 1.03),
        ("held-out error over noise after, p90", float(np.quantile(held, 0.9)), "<=", 1.2),
    ]


_TARGETS: dict[str, Callable[[Sequence[Row]], list[Target]]] = {
    "single": lambda rows: [
        ("class top-1", share(visible(rows), lambda row: top(row, 1)), ">=", 0.97),
        ("class top-3", share(visible(rows), lambda row: top(row, 3)), ">=", 0.99),
        *_median_and_p90(visible(rows)),
    ],
    "circumstances": lambda rows: [("class top-1", share(visible(rows), lambda row: top(row, 1)), ">=", 0.95)],
    "long": lambda rows: [("class top-1", share(visible(rows), lambda row: top(row, 1)), ">=", 0.95)],
    "cut": lambda rows: [
        ("class top-1", share(visible(rows), lambda row: top(row, 1)), ">=", 0.95),
        *_median_and_p90(visible(rows)),
    ],
    "pairs": lambda rows: [
        ("both found", share(rows, both_found), ">=", 0.97),
        ("exact set", share(rows, exact_set), ">=", 0.90),
    ],
    "nulls": lambda rows: [("false alarms", share(rows, _alarm), "<=", 0.01)],
    "outside": lambda rows: [
        ("coordinates and side", share(rows, lambda r: coordinates_right(r) and side_right(r)), ">=", 0.95),
        ("confident wrong name", share(rows, _confident), "<=", 0.02),
        (
            "error over noise with the written effect, median",
            float(np.median([row["unknown"]["written"][0] for row in rows])),
            "<=",
            1.1,
        ),
    ],
    "poor": lambda rows: [
        ("hidden effect in the tie set", share(_fails_there(rows), in_tie_set), ">=", 0.98),
        ("tie resolved by the proposed record", share(_tied(_fails_there(rows)), _resolved), ">=", 0.90),
    ],
}
