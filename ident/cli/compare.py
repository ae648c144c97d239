"""`ident compare`: models of the same records, weighed."""

from __future__ import annotations

import click

from .options import figures_option, force_option, json_option, trust_option


@click.command("compare", short_help="Weigh the models of several runs by evidence and held-out prediction.")
@click.argument("runs", nargs=-1, required=True, metavar="RUN RUN…")
@click.option("-o", "--output", metavar="FOLDER", help="Write compare.json and compare.png there.")
@force_option
@json_option
@figures_option
@trust_option
def command(runs: tuple[str, ...], output: str | None, force: bool, as_json: bool) -> None:
    """Weigh the models of runs that were fitted to the same records: log evidence with its error, probability, how well
    each predicts left-out stretches and held-out records, and in words whether the records can tell them apart.

    \b
    Example:
      ident compare runs/stress runs/hysteresis runs/both -o runs/compared
    """
    from pathlib import Path

    from ..errors import UserError
    from ..report.run_folder import load_run, read_run, write_json
    from .output import progress, say, say_json, say_sheet

    if len(runs) < 2:
        raise UserError("one run has nothing to be compared with", do="name two runs or more")
    folder = None if output is None else Path(output)
    if folder is not None and (folder / "compare.json").exists() and not force:
        raise UserError("this exists already", where=str(folder / "compare.json"), do="another folder, or --force")
    for run in runs:
        read_run(run)
    fits = []
    for run in runs:
        progress(f"reading {run}")
        fits.append((run, load_run(run)))

    from ..diagnosis.judged import compare
    from ..report.compare_view import compare_dict, compare_figure, compare_sheet, headline
    from ..report.figures.picture import draw

    progress("evidence, left-out and held-out scores")
    document = compare_dict(compare(fits))
    figures = []
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        write_json(folder / "compare.json", document)
        figures = draw("", compare_figure(document)).write(folder, "compare")
    if as_json:
        say_json(document)
        return
    say_sheet(compare_sheet(document))
    say(f"verdict: {headline(document)}")
    say(document["words"])
    if folder is not None:
        say(f"figure: {', '.join(map(str, figures))}")
