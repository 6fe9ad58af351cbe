"""Every reader of the project, with a whole example of what it reads."""

import functools
import gzip
import hashlib
import io
import json
import re
import tempfile
from collections.abc import Callable, Iterator
from contextlib import chdir, redirect_stdout, suppress
from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np

from acf_jax.cli import design, identify
from acf_jax.cli.main import commands
from acf_jax.contact.model_file import ModelFile
from acf_jax.contact.peak import Simulated
from acf_jax.contact.read import of_diagnosis
from acf_jax.dataset import read_conditions, read_dataset
from acf_jax.diagnosis.document import SCHEMA
from acf_jax.errors import InputError
from acf_jax.files import read_bytes
from acf_jax.fleet.changes import find_changes
from acf_jax.fleet.page import fleet_page
from acf_jax.fleet.record import Fleet, read_fleet
from acf_jax.gap_model import read_model, write_model
from acf_jax.predict import predict
from acf_jax.recording import Mapping, Session, read_mapping, read_session
from acf_jax.recording.readers import readers
from acf_jax.recording.review import read_review
from acf_jax.recording.rig import read_rig_file
from acf_jax.safety.check import Checker
from acf_jax.safety.limits import SHIPPED, read_limits
from acf_jax.safety.situation import read_situations
from acf_jax.surrogate import load_surrogate
from acf_jax.surrogate.load import Shape, new_network
from acf_jax.surrogate.saved import signed
from acf_jax.training import labels
from acf_jax.training.checkpoint import State, load_state, save_state
from acf_jax.training.config import CorrectedConfig, read_config
from acf_jax.training.domain import make_domain
from tests.corrected import gap_model
from tests.dataset.impacts import write
from tests.recording.sessions import FEW, RIG, made, small, write_csv
from validation.blind import campaign, score, seal
from validation.blind.answer import read_answer, read_said

CONFIGS = Path(__file__).resolve().parents[2] / "configs"
Files = dict[str, bytes]


class Reader(NamedTuple):
    """What is read, the whole files, those of them that go wrong, and the reader of their folder."""

    name: str
    files: Callable[[], Files]
    wrong: tuple[str, ...]
    read: Callable[[Path], Any]
    makes: tuple[str, ...] = ()  # files that it leaves although it refuses


def beside(*names: str) -> Callable[[], Files]:
    """Files of configs/, each by its own name."""
    return lambda: {name: (CONFIGS / name).read_bytes() for name in names}


def content_of(make: Callable[[Path], Any]) -> Files:
    """The files that `make` leaves in a folder."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name, "made")
        make(folder)
        return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def corrected() -> Files:
    return {"model.json": write_model(gap_model()).encode()}


def peaks(folder: Path) -> None:
    *_, faults = identify._read(folder / "table1.csv")
    if faults:
        raise InputError(faults)


def training() -> tuple[dict[str, int], State]:
    network = new_network(3, Shape(width=4, depth=1), np.float32, jax.random.key(0))
    arrays = jax.tree.map(np.asarray, jax.tree.leaves(network.layers))
    return {"seed": 1}, State(arrays, arrays, 20, [0.1])


def checkpoint() -> Files:
    identity, state = training()
    return content_of(lambda folder: save_state(folder / "fold.eqx", state, identity))


def resume(folder: Path) -> State:
    identity, state = training()
    return load_state(folder / "fold.eqx", state, identity)


def learnt() -> Files:
    text = (CONFIGS / "closed_loop.yaml").read_bytes()
    return {"closed_loop.yaml": text.replace(b"low: 1.12e5", b"low: 6.0e4")}  # with the k_c of `corrected`


def domain(folder: Path) -> None:
    gap = gap_model()
    config = read_config(folder / "closed_loop.yaml")
    if isinstance(config, CorrectedConfig):
        make_domain(config, of_diagnosis(gap), Simulated(gap.corrected.effects, gap.step_s))


def block() -> Files:
    values = labels.Block(np.ones(4), np.ones(4), np.ones(4, bool))
    return content_of(lambda folder: labels.write_tree(folder / "test_0000.eqx", {"of": {"seed": 1}}, values))


def fleet(label: str, friction: float) -> Fleet:
    """One rig with dry friction."""
    estimate = {"value": friction, "std": 0.3, "unit": "N", "at_bound": False}
    rig = {
        "rig": "a", "data": label, "verdict": "identified", "first": ["coulomb_friction"], "probability": 0.9,
        "credible": [["coulomb_friction"]], "component": "actuator", "corrected_rms_n": 0.5,
        "parameters": {"coulomb_friction.force_n": estimate},
    }  # fmt: skip
    return Fleet.model_validate(
        {"schema": "acf-gap-fleet/1", "label": label, "finished": "today", "rigs": [rig]}
    )


def compared(folder: Path) -> None:
    """What a later run makes of an earlier one."""
    changes, trends = find_changes([read_fleet(folder), now := fleet("june", 4.0)])
    assert all(np.isfinite(trend.sigmas) for trend in trends)
    fleet_page(now.model_copy(update={"since": ("may",), "changes": tuple(changes)}), trends)


def sealed() -> Files:
    def make(folder: Path) -> None:
        for name in "ab":
            (folder / name).mkdir(parents=True)
            (folder / name / "answer.yaml").write_text("effects: [gravity]\nceiling: 0.7\n")
        seal.seal_folder(folder)
        for name in "ab":
            (folder / name / "diagnosis.json").write_text("{}")
        seal.open_answers(folder, folder, ["a", "b"])

    return content_of(make)


def unseal(folder: Path) -> None:
    seal.check_answers(folder, ["a", "b"])
    seal.open_answers(folder, folder, ["a", "b"])


def resealed(folder: Path) -> None:
    """Answers that are wrong under a seal that is right."""
    packed = gzip.compress(read_bytes(folder / "answers.json"))
    (folder / "answers.sealed").write_bytes(packed)
    record = {"sha256": hashlib.sha256(packed).hexdigest(), "data_sets": 2, "sealed_at": 0.0}
    (folder / "seal.json").write_text(json.dumps(record))
    for name in "ab":
        (folder / name).mkdir()
        (folder / name / "diagnosis.json").write_text("{}")
    unseal(folder)


def resigned(read: Callable[[Path], Any], folder: Path) -> Any:
    """What is read of a header that is wrong under a checksum that is right."""
    line, _, body = read_bytes(folder / "model.eqx").partition(b"\n")
    try:
        whole = signed(json.loads(line), body)
    except (ValueError, RecursionError, AttributeError):
        return None
    (folder / "model.eqx").write_bytes(whole)
    return read(folder / "model.eqx")


SAID = {
    "schema": SCHEMA,
    "verdict": "identified",
    "explanations": [{"effects": ["gravity"], "probability": 0.9}, {"effects": [], "probability": 0.1}],
    "credible_set": [["gravity"]],
    "indistinguishable": [{"effects": ["coulomb_friction", "gravity"], "bayes_error": 0.3}],
    "where": {"component": {"actuator": 0.9, "contact": 0.1}},
    "shrinkage": {"force": {"value": 0.9, "ci95": [0.8, 0.95]}, "peak": None},
    "parameters": {"moving_mass_kg": {"value": 2.1, "std": 0.1, "unit": "kg"}},
    "excluded_trials": [{"trial": "t001", "reason": "dead"}],
}


MAPPING = b"force: -1*/ft:z\nvelocity: {name: /v, scale: 0.001}\npretension: 60\ncontacts: {tare: true}\n"
CUTS = (
    b"schema: acf-import-cuts/1\nrecording: log.mcap\ncuts:\n  - {trial: t000, contact_s: 1.5, keep: true}\n"
)


def surrogate() -> Files:
    from acf_jax.surrogate.load import DEFAULT

    return {"model.eqx": DEFAULT.read_bytes()}


def learnt_model() -> Files:
    return {"model.eqx": (CONFIGS.parent / "examples/rig_surrogate.eqx").read_bytes()}


def run_folder(folder: Path) -> None:
    campaign._describe(folder, {"seed": 1})
    (folder / "a").mkdir()
    (folder / "a/dataset.yaml").write_text("")
    (folder / "results/a").mkdir(parents=True)
    (folder / "results/a/diagnosis.json").write_text("")
    campaign.diagnose_all(folder, folder / "results", 1, lambda *counted: None)


def recording(name: str, folder: Path) -> Session:
    return read_session(folder / name, Mapping(pretension=60.0))


@functools.cache
def sample(kind: str, others: tuple[str, ...]) -> Files:
    """A sound recording of a kind: made as such, packed, or one of the other kinds of its reader by another name."""
    if kind.endswith(".gz"):
        inner = kind.removesuffix(".gz")
        return {f"log.{kind}": gzip.compress(sample(inner, others)[f"log.{inner}"])}
    for other in (kind, *others):
        files = {
            name.replace(f"log.{other}", f"log.{kind}"): content for name, content in small(other).items()
        }
        with tempfile.TemporaryDirectory() as folder, suppress(InputError):
            Path(folder, f"log.{kind}").write_bytes(files[f"log.{kind}"])
            recording(f"log.{kind}", Path(folder))
            return files
    raise AssertionError(f"tests.recording.sessions.small makes no recording that is read as .{kind}")


def kinds() -> Iterator[tuple[str, tuple[str, ...]]]:
    """The suffixes of which the readers of recordings speak, each with the others of its reader."""
    for reader in readers():
        spoken = [suffix.removeprefix(".") for suffix in re.findall(r"\.\w+", reader.KIND)]
        plain = tuple(suffix for suffix in spoken if suffix != "gz")
        yield from ((kind, plain) for kind in (*plain, *(f"{plain[0]}.gz" for _ in range("gz" in spoken))))


def recordings() -> Iterator[Reader]:
    """A recording of each kind; `metadata.yaml` is that of a folder with a bag."""
    for kind, others in kinds():
        read = functools.partial(recording, f"log.{kind}")
        yield Reader(f"recording, {kind}", functools.partial(sample, kind, others), (f"log.{kind}",), read)
    files = functools.partial(small, "mcap")
    yield Reader("recording, metadata", files, ("metadata.yaml",), functools.partial(recording, ""))


READERS = (
    *recordings(),
    Reader("mapping", lambda: {"mapping.yaml": MAPPING}, ("mapping.yaml",),
           lambda folder: read_mapping(folder / "mapping.yaml", {})),
    Reader("review", lambda: {"cuts.yaml": CUTS}, ("cuts.yaml",),
           lambda folder: read_review(folder / "cuts.yaml", "log.mcap", 10.0)),
    Reader("rig of a recording", lambda: {"rig.yaml": RIG.encode()}, ("rig.yaml",),
           lambda folder: read_rig_file(folder / "rig.yaml")),
    Reader("data set", functools.cache(lambda: content_of(write)),
           ("dataset.yaml", "trials.csv", "traces/t001.csv"), read_dataset),
    Reader("conditions", beside("conditions_example.csv"), ("conditions_example.csv",),
           lambda folder: read_conditions(folder / "conditions_example.csv")),
    Reader("peaks", beside("table1.csv"), ("table1.csv",), peaks),
    Reader("rig", beside("check_rig.yaml"), ("check_rig.yaml",), lambda f: ModelFile(f / "check_rig.yaml")),
    Reader("design", beside("design.yaml", "table1_rig.yaml"), ("design.yaml", "table1_rig.yaml"),
           lambda folder: design._read(folder / "design.yaml", [])),
    Reader("training", beside("table1.yaml", "table1_rig.yaml"), ("table1.yaml", "table1_rig.yaml"),
           lambda folder: read_config(folder / "table1.yaml")),
    Reader("training, corrected", learnt, ("closed_loop.yaml",), domain),
    Reader("labels", functools.cache(block), ("test_0000.eqx",),
           lambda folder: labels._read(folder / "test_0000.eqx", 4, {"seed": 1})),
    Reader("checkpoint", functools.cache(checkpoint), ("fold.eqx",), resume),
    Reader("model.json", corrected, ("model.json",), lambda folder: read_model(folder / "model.json")),
    Reader("model.eqx", surrogate, ("model.eqx",), lambda folder: load_surrogate(folder / "model.eqx")),
    Reader("model.eqx, checksum right", surrogate, ("model.eqx",), functools.partial(resigned, load_surrogate)),
    Reader("model.eqx of a corrected model", learnt_model, ("model.eqx",),
           functools.partial(resigned, lambda path: ModelFile(path).load())),
    Reader("limits", lambda: {"limits.csv": SHIPPED.read_bytes()}, ("limits.csv",),
           lambda folder: read_limits(folder / "limits.csv")),
    Reader("situations", beside("situations.csv"), ("situations.csv",),
           lambda folder: read_situations(folder / "situations.csv", read_limits())),
    Reader("answer.yaml", lambda: {"answer.yaml": b"effects: [gravity]\nceiling: 0.7\n"}, ("answer.yaml",),
           read_answer),
    Reader("seal", functools.cache(sealed), ("seal.json", "answers.sealed", "opened.json"), unseal),
    Reader("sealed answers, hash right",
           lambda: {"answers.json": b'{"a": {"effects": []}, "b": {"effects": ["x"], "components": ["robot"]}}'},
           ("answers.json",), resealed, ("answers.sealed", "seal.json", "a/diagnosis.json", "b/diagnosis.json")),
    Reader("blind run", lambda: {"run.json": b'{"seed": 1}', "withheld.json": b'{"a": "gravity"}'},
           ("run.json", "withheld.json"), run_folder, ("a/dataset.yaml", "results/a/diagnosis.json")),
    Reader("diagnosis.json", lambda: {"diagnosis.json": json.dumps(SAID).encode()}, ("diagnosis.json",), read_said),
    Reader("fleet.json", lambda: {"fleet.json": fleet("may", 2.0).model_dump_json(by_alias=True).encode()},
           ("fleet.json",), compared),
    Reader("held-out trace", lambda: {"trace.csv": b"time_s,force_n\n0,80\n0.001,90\n0.002,70\n"}, ("trace.csv",),
           lambda folder: score._true_force(folder / "trace.csv")),
)  # fmt: skip


def predicted(folder: Path) -> None:
    """What the prediction makes of a model that was read."""
    found = predict(read_model(folder / "model.json"), np.array([0.2]), np.array([80.0]))[0]
    assert np.isfinite([found.peak_force, found.peak_force_std, found.contact_peak_force]).all(), found
    assert len(found.time) < 10**6


def judged(folder: Path) -> None:
    """What the check makes of a rig and of situations that were read."""
    with chdir(folder):  # a model knows where it is from: another path would compile anew
        checker = Checker(ModelFile(Path("check_rig.yaml")).load(), load_surrogate())
    for situation in read_situations(folder / "situations.csv", read_limits()):
        answer = checker(situation)
        assert answer.verdict != "allowed" or np.isfinite([answer.force, answer.upper]).all(), answer


def logged() -> Files:
    """A recording of contacts that make a data set."""
    files = content_of(
        lambda folder: (folder.mkdir(), write_csv(folder / "log.csv", made(1, FEW, rate=2000.0)))
    )
    return {**files, "rig.yaml": RIG.encode()}


def ran(*arguments: str) -> Callable[[Path], None]:
    """A command, run in the folder; its JSON says nothing of a peak that it does not give."""

    def run(folder: Path) -> None:
        out = io.StringIO()
        with chdir(folder), redirect_stdout(out), suppress(SystemExit):
            commands.main([*arguments, "--json"], standalone_mode=False)
        for row in json.loads(out.getvalue()).get("peaks", ()):
            assert row["has_peak"] == (row["f_max"] is not None) == (row["t_max"] is not None), row

    return run


# These compile: too slow for the tests.
USERS = (
    Reader("peak", beside("check_rig.yaml"), ("check_rig.yaml",),
           ran("peak", "--rig", "check_rig.yaml", "--f-p", "60", "--v-e", "0.2")),
    Reader("speed", beside("check_rig.yaml"), ("check_rig.yaml",),
           ran("speed", "--model", "check_rig.yaml", "--f-p", "60", "--limit", "150", "--draws", "256")),
    Reader("identify", beside("table1.csv", "table1_rig.yaml"), ("table1.csv", "table1_rig.yaml"),
           ran("identify", "table1.csv", "--rig", "table1_rig.yaml")),
    Reader("import", functools.cache(logged), ("log.csv", "rig.yaml"),
           ran("import", "log.csv", "--rig", "rig.yaml", "--out", "out")),
    Reader("model.json, predicted", corrected, ("model.json",), predicted),
    Reader("rig and situations, checked", beside("check_rig.yaml", "situations.csv"),
           ("check_rig.yaml", "situations.csv"), judged),
)  # fmt: skip
