"""`ident diagnose`: where a fit fails, which effect is missing, what to measure next."""

from __future__ import annotations

import click

from .options import figures_option, json_option, run_argument, trust_option


@click.command("diagnose", short_help="Where a fit fails, which effect is missing, what to measure next.")
@run_argument
@click.option("--write-effect", "target", metavar="FILE", help="Write what the library lacks as an effect of your own.")
@json_option
@figures_option
@trust_option
def command(run: str, target: str | None, as_json: bool) -> None:
    """Ask of RUN: is its model adequate; if not, where does it fail, which effect is missing and how sure is that,
    what could be mistaken for it, and which record would settle it. RUN gets a diagnosis.json and a
    new report; its fit stays.

    \b
    Example:
      ident diagnose runs/a
      ident diagnose runs/a --write-effect my_effect.py
    """
    from pathlib import Path

    from ..report.run_folder import load_run, read_run, renew_report, write_json
    from .output import progress, say, say_json

    read_run(run)
    progress("reading the run")
    fitted = load_run(run)

    from ..diagnosis.diagnose import diagnose
    from ..diagnosis.document import diagnosis_dict
    from ..report.diagnosis_view import advice, sections, why_not_written
    from .walk import tell

    found = diagnose(fitted, None, progress, None if target is None else Path(target))
    document = diagnosis_dict(found) | {"advice": advice(found)}
    write_json(Path(run) / "diagnosis.json", document)
    progress("writing the report")
    renew_report(fitted, run, diagnosis=sections(found))
    if as_json:
        say_json(document)
        return
    tell(found)
    if found.effect_file is not None:
        say(f"next: ident add {run} {found.effect_file}")
    elif target is not None:
        say(f"{target} was not written: {why_not_written(found)}")
    if found.effect_file is None and found.discovery.steps:
        say(f"next: ident add {run} {found.discovery.steps[0].added}")
    elif target is None and found.unknown is not None and found.unknown.written is not None:
        say(f"next: ident diagnose {run} --write-effect my_effect.py")
