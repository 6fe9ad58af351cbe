"""`python -m acf_jax import`: a gap data set from one long recording."""

from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from acf_jax.cli._json import echo_json
from acf_jax.cli._origin import OVERWRITE, origin
from acf_jax.cli._progress import counts
from acf_jax.cli._signals import signal_options
from acf_jax.cli._stale import foreign, foreign_traces, of_import

if TYPE_CHECKING:
    from acf_jax.recording import Impacts

EXAMPLES = """
\b
Examples:
  python -m acf_jax import session.mcap --list
  python -m acf_jax import session.mcap --out my_rig --rig rig.yaml --pretension 60 --review cuts.yaml
  python -m acf_jax import log.csv --out my_rig --force "-1*Fz" --velocity "0.001*v_mm_s" --pretension preload
"""


@click.command(epilog=EXAMPLES)
@click.argument("recording", type=click.Path(path_type=Path))
@click.option(
    "--out", type=click.Path(path_type=Path), help="Folder for the data set; needed but with --list."
)
@click.option("--rig", type=click.Path(path_type=Path), help="YAML file: what is known of the rig.")
@signal_options
@click.option(
    "--review", type=click.Path(path_type=Path), help="YAML file of the cuts: written, then honoured."
)
@OVERWRITE
@click.option("--list", "listed", is_flag=True, help="Only list what the recording offers.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(
    recording: Path,
    out: Path | None,
    other: Path | None,
    rig: Path | None,
    mapping: Path | None,
    review: Path | None,
    overwrite: bool,
    listed: bool,
    as_json: bool,
    **signals: str | float | None,
) -> None:
    """Cut a gap data set from RECORDING: a ROS bag, text, or a file of MATLAB, HDF5, LabVIEW, Excel, Parquet or NumPy.

    Finds the contacts, measures their velocity, takes off the force's zero, and writes OUT/dataset.yaml,
    OUT/trials.csv, OUT/traces, OUT/provenance.json and a page of every cut, OUT/import.html. The signals of the robot
    may be in another recording, --with ROBOT. `--list` shows what it holds.
    """
    from acf_jax.errors import InputError

    if listed:
        _list([recording, *([other] if other else [])], as_json)
        return
    if out is None:
        raise InputError("--out: is missing; name a folder for the data set")
    if out.exists() and not out.is_dir():
        raise InputError(f"--out {out}: is a file; name a folder")
    from acf_jax.recording.write import CUTS

    impacts, described = _import(recording, out, other, rig, mapping, review, overwrite, signals)
    page = out / CUTS
    if impacts.faults:
        page, impacts = _leave(impacts, out, review)
    if as_json:
        echo_json(_document(impacts))
    else:
        click.echo(_text(impacts, out, page, review, described))
    if impacts.faults:
        raise InputError(impacts.faults)


def _list(recordings: list[Path], as_json: bool) -> None:
    """Print what the recordings offer."""
    from acf_jax.recording.choose import listing
    from acf_jax.recording.readers import open_recording

    shown: list[dict[str, Any]] = []
    for path in recordings:
        with closing(open_recording(path)) as opened:
            channels = opened.channels()
        if not as_json:
            click.echo("\n".join([*([f"{path}:"] if len(recordings) > 1 else []), listing(channels)]))
        where = {"recording": str(path)} if len(recordings) > 1 else {}
        shown += [{"name": c.name, "type": c.type, "count": c.count} | where for c in channels]
    if as_json:
        echo_json(shown)


def _import(
    recording: Path,
    out: Path,
    other: Path | None,
    rig: Path | None,
    mapping: Path | None,
    review: Path | None,
    overwrite: bool,
    signals: dict[str, Any],
) -> tuple["Impacts", bool]:
    """Read, cut, write unless the impacts have faults; the impacts, and whether the rig is described."""
    from acf_jax.errors import InputError, collected
    from acf_jax.files import write_text
    from acf_jax.folders import recover, whole_folder
    from acf_jax.recording import Refused, find_impacts, read_mapping, read_session
    from acf_jax.recording.page import import_page
    from acf_jax.recording.review import kept_faults, read_review
    from acf_jax.recording.rig import earlier_rig, read_rig_file
    from acf_jax.recording.write import CUTS, review_of, write_impacts

    recover(out)
    faults = foreign(out, out, overwrite)
    known = None
    earlier = out / "dataset.yaml"
    if rig is not None:
        known = collected(faults, lambda: read_rig_file(rig))
    elif not faults and earlier.exists():
        known = collected(faults, lambda: earlier_rig(earlier))
    chosen = collected(faults, lambda: read_mapping(mapping, signals))
    if faults or chosen is None:
        raise InputError(faults)
    with counts() as count:
        session = read_session(recording, chosen, partial(count, "reading"), other)
    decided = None
    if review is not None and review.exists():
        decided = read_review(review, recording.name, session.duration).cuts
        kept = [entry.trial for entry in decided if entry.keep is not False]
        if faults := foreign_traces(out, kept, overwrite):  # a review may call trials anything
            raise InputError(faults)
    try:
        impacts = find_impacts(session, chosen.contacts, known.prior if known else None, decided)
        if review is not None and decided is not None and (wrong := kept_faults(review, impacts.kept)):
            raise Refused(replace(impacts, faults=tuple(wrong)))
        made = origin(session.digests())
        with whole_folder(out, of_import(out)) as folder:
            write_impacts(folder, impacts, known)
            page = import_page(impacts, str(review) if review else None, str(out), str(made))
            write_text(folder / CUTS, page)
            made.write(folder)
            if review is not None and decided is None:
                write_text(review, review_of(impacts))  # where that fails no data set is written
    except Refused as refusal:
        impacts = refusal.impacts
    return impacts, known is not None


def _leave(impacts: "Impacts", out: Path, review: Path | None) -> tuple[Path, "Impacts"]:
    """Write the page and the cuts of a recording of which no data set came; where the page is, and what failed."""
    from acf_jax.errors import InputError
    from acf_jax.files import write_text
    from acf_jax.recording.page import import_page
    from acf_jax.recording.write import CUTS, REFUSED, review_of

    page = out / (REFUSED if (out / "trials.csv").exists() else CUTS)  # an earlier data set keeps its own
    try:
        write_text(page, import_page(impacts, str(review) if review else None, str(out)))
        if review is not None and not review.exists() and impacts.cuts:
            write_text(review, review_of(impacts))
    except (OSError, InputError) as error:
        impacts = replace(impacts, faults=(*impacts.faults, f"{page}: cannot be written ({error})"))
    return page, impacts


def _text(impacts: "Impacts", out: Path, page: Path, review: Path | None, described: bool) -> str:
    from acf_jax.recording.words import found

    lines = found(impacts)
    if impacts.faults:
        if page.exists():
            lines.append(f"{page}: look at what was found in a browser")
        if review is not None and review.exists():
            lines.append(f"{review}: keep, drop or move a contact here, then import again")
        return "\n".join(lines)
    lines.append(f"{page}: look at every cut in a browser")
    if review is not None:
        lines.append(f"{review}: drop or move a cut here, then import again")
    if described:
        lines.append(f"next: python -m acf_jax diagnose {out} --out diagnosis")
    else:
        lines.append(
            f"{out / 'dataset.yaml'}: fill in the rig, or import again with --rig FILE, before `diagnose`"
        )
    return "\n".join(lines)


def _document(impacts: "Impacts") -> dict[str, Any]:
    begin = int(impacts.session.force.time[0])
    return {
        "recording": str(impacts.session.path),
        "signals": impacts.session.labels,
        "cuts": [
            {
                "trial": cut.trial,
                "keep": cut.keep,
                "contact_s": 1e-9 * (cut.contact.begin - begin),
                "contact_velocity_m_per_s": cut.velocity.value,
                "contact_velocity_std_m_per_s": cut.velocity.std,
                "pretension_n": cut.pretension.value,
                "peak_force_n": cut.peak,
                "remarks": list(cut.remarks),
            }
            for cut in impacts.cuts
        ],
        "trust": None if impacts.faults else impacts.trust.headline,
        "limits": [] if impacts.faults else list(impacts.trust.lines),
        "notes": list(impacts.notes),
        "faults": list(impacts.faults),
    }
