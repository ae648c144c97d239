"""What `ident add` and `ident remove` share: parent in, changed fit out, errors before and after."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from ..errors import UserError
from .fit import command_line
from .output import progress, say_fit, say_folder, say_json, say_sheet


def change(run: str, effect: str, output: str | None, *, adding: bool, force: bool, as_json: bool) -> None:
    """Load the run, change its model, refit, write the new run and print what it brought."""
    from ..campaign.trust import trust
    from ..report.run_folder import check_target, load_run, read_lineage, read_run, write_run

    name = Path(effect).stem.replace("_", "-") if effect.endswith(".py") else effect
    folder = Path(output) if output else beside(Path(run), f"{'+' if adding else '-'}{name}")
    check_target(folder, force)
    read_run(run)  # a wrong folder is answered before anything is compiled
    progress("reading the parent run")
    parent = load_run(run)

    from ..diagnosis.document import lineage_entry
    from ..diagnosis.search.change import add, remove
    from ..effects.registry import registry
    from ..report.story import change_sheet

    if adding and effect.endswith(".py"):
        trust(effect)  # named at the command line: that is to ask for it
        files = parent.campaign.effect_files  # which the campaign may have it among
        others = tuple(file for file in files if file.resolve() != Path(effect).resolve())
        files = files if len(others) < len(files) else (*files, Path(effect))
        own = set(registry(files)) - set(registry(others))
        parent = replace(parent, campaign=replace(parent.campaign, effect_files=files))
        name = _only(sorted(own - {*parent.model.names} or own), effect)
    elif adding:
        name = effect
    if adding:
        after = add(parent, name, progress)
        entry = lineage_entry(parent, after, str(run), added=name)
    else:
        after = remove(parent, effect, progress)
        entry = lineage_entry(parent, after, str(run), removed=effect)
    lineage = [*read_lineage(run), entry]
    write_run(after, folder, force=force, command=command_line(), lineage=lineage, report=progress)
    if as_json:
        say_json(read_run(folder))
        return
    say_fit(after)
    say_sheet(change_sheet(lineage[-1:]))
    say_folder(folder)


def _only(effects: list[str], file: str) -> str:
    """The one effect that a file can mean. **Raises:** UserError if there are several."""
    if len(effects) > 1:
        what = f"{file} defines several effects: {', '.join(effects)}"
        instead = "name it in effect_files of the campaign, fit that again and add an effect by its name"
        raise UserError(what, do=f"give each a file of its own, or {instead}")
    return effects[0]


def beside(run: Path, ending: str) -> Path:
    """A folder beside a run, with its name and an ending."""
    run = run if run.name not in ("", "..") else run.resolve()
    return run.parent / f"{run.name}{ending}"
