import gzip
import hashlib
import json
import tracemalloc

import pytest
from click.testing import CliRunner

from acf_jax.cli.main import commands
from acf_jax.errors import InputError
from validation.blind.answer import Answer
from validation.blind.seal import check_answers, open_answers, seal_folder


@pytest.fixture
def sealed(tmp_path):
    sets, results = tmp_path / "sets", tmp_path / "results"
    for name, cause in (("a", "gravity"), ("b", "sensor_lag")):
        (sets / name).mkdir(parents=True)
        (sets / name / "answer.yaml").write_text(f"effects: [{cause}]\n")
    digest = seal_folder(sets)
    for name in ("a", "b"):
        (results / name).mkdir(parents=True)
        (results / name / "diagnosis.json").write_text("{}")
    return sets, results, digest


def test_answers_vanish_under_the_seal_and_come_back(sealed):
    sets, results, digest = sealed
    assert not list(sets.glob("*/answer.yaml"))
    assert b"gravity" not in (sets / "answers.sealed").read_bytes()
    assert json.loads((sets / "seal.json").read_text())["sha256"] == digest
    assert open_answers(sets, results, ["a", "b"]) == {
        "a": Answer(effects=("gravity",)),
        "b": Answer(effects=("sensor_lag",)),
    }
    assert open_answers(sets, results, ["a", "b"])["a"].effects == ("gravity",)


def test_changed_answers_are_refused(sealed):
    sets, results, _ = sealed
    (sets / "answers.sealed").write_bytes(b"other")
    with pytest.raises(InputError, match="answers were changed"):
        open_answers(sets, results, ["a", "b"])


@pytest.mark.parametrize("content", [b" " * 2**28, b"[" * 2**20, b'{"a": 1e999}', b"\xff", b"{", b"7"])
def test_answers_that_are_none_are_refused_under_a_right_seal(sealed, content):
    sets, results, _ = sealed
    packed = gzip.compress(content)
    (sets / "answers.sealed").write_bytes(packed)
    seal = json.loads((sets / "seal.json").read_text())
    digest = hashlib.sha256(packed).hexdigest()
    (sets / "seal.json").write_text(json.dumps({**seal, "sha256": digest}))
    tracemalloc.start()
    with pytest.raises(InputError, match=r"answers\.sealed: "):
        open_answers(sets, results, ["a", "b"])
    assert tracemalloc.get_traced_memory()[1] < 150e6
    tracemalloc.stop()


def test_answers_that_could_not_be_opened_are_not_sealed(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "answer.yaml").write_text("effects: [gravity]\nnote: .inf\n")
    with pytest.raises(InputError, match="the answers: holds Infinity, which is no number; correct them"):
        seal_folder(tmp_path)
    assert [path.name for path in tmp_path.rglob("*") if path.is_file()] == ["answer.yaml"]


def test_an_answer_given_after_the_opening_is_refused(sealed):
    sets, results, _ = sealed
    open_answers(sets, results, ["a", "b"])
    (results / "b" / "diagnosis.json").write_text('{"verdict": "identified"}')
    with pytest.raises(InputError, match="opened before b was diagnosed"):
        open_answers(sets, results, ["a", "b"])


def test_a_diagnosis_older_than_the_seal_is_refused(sealed):
    sets, results, _ = sealed
    seal = json.loads((sets / "seal.json").read_text())
    (sets / "seal.json").write_text(json.dumps({**seal, "sealed_at": seal["sealed_at"] + 3600}))
    with pytest.raises(InputError, match="is older than the seal"):
        open_answers(sets, results, ["a", "b"])


def test_a_folder_without_answers_or_sealed_twice_is_refused(sealed, tmp_path):
    with pytest.raises(InputError, match="no answers to seal"):
        seal_folder(tmp_path)
    with pytest.raises(InputError, match="sealed already"):
        seal_folder(sealed[0])


def test_a_sealing_that_was_killed_goes_on(sealed):
    sets, _, digest = sealed
    left = sets / "b" / "answer.yaml"
    left.write_text("effects: [gravity]\n")
    with pytest.raises(InputError, match="sealed already"):
        seal_folder(sets)
    left.write_text("effects: [sensor_lag]\n")
    assert seal_folder(sets) == digest and not left.exists()


def test_an_answer_with_a_misspelt_key_is_not_sealed(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "answer.yaml").write_text("effect: [gravity]\n")
    with pytest.raises(InputError, match=r"answer\.yaml: effects: is missing; write effects:"):
        seal_folder(tmp_path)
    assert (tmp_path / "a" / "answer.yaml").exists()


@pytest.mark.parametrize(
    "content",
    [
        "{",
        "[]",
        '{"sha256": 3, "data_sets": 2, "sealed_at": 1.0}',
        '{"sha256": "a", "data_sets": true, "sealed_at": 1.0}',
        '{"sha256": "a", "data_sets": 2, "sealed_at": false}',
        '{"sha256": "a", "data_sets": 2, "sealed_at": NaN}',
    ],
)
def test_a_damaged_seal_is_refused(sealed, content):
    sets, results, _ = sealed
    (sets / "seal.json").write_text(content)
    for read in (lambda: check_answers(sets, ["a", "b"]), lambda: open_answers(sets, results, ["a", "b"])):
        with pytest.raises(InputError, match=r"seal\.json: .*seal them again"):
            read()


def test_data_sets_without_an_answer_are_refused_before_they_are_diagnosed(sealed, tmp_path):
    with pytest.raises(InputError, match="remove those that came later"):
        check_answers(sealed[0], ["a", "b", "c"])
    for name in ("c", "d"):
        (tmp_path / "more" / name).mkdir(parents=True)
        (tmp_path / "more" / name / "dataset.yaml").write_text("")
    (tmp_path / "more/c/answer.yaml").write_text("effects: []\n")
    out = tmp_path / "out"
    result = CliRunner().invoke(commands, ["blind", "score", str(tmp_path / "more"), "--out", str(out)])
    assert isinstance(result.exception, InputError) and len(result.exception.faults) == 1
    assert "d/answer.yaml: no such file" in result.exception.faults[0] and not out.exists()
    with pytest.raises(InputError, match=r"d/answer\.yaml"):
        seal_folder(tmp_path / "more")


def test_notes_in_an_answer_are_sealed_whatever_they_are(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "answer.yaml").write_text("effects: [gravity]\nrecorded: 2026-11-20\n7: a number\n")
    seal_folder(tmp_path)
    assert open_answers(tmp_path, tmp_path, []) == {}
    sealed = json.loads(gzip.decompress((tmp_path / "answers.sealed").read_bytes()))
    assert sealed == {"a": {"effects": ["gravity"], "recorded": "2026-11-20", "7": "a number"}}


def test_an_effect_that_may_be_misspelt_needs_its_component(sealed):
    folder = sealed[0]
    (folder / "seal.json").unlink()
    (folder / "a/answer.yaml").write_text("effects: [gravty]\n")
    with pytest.raises(
        InputError, match=r"a/answer\.yaml: effects: 'gravty' is none of .*gravity.*components"
    ):
        seal_folder(folder)
    (folder / "a/answer.yaml").write_text("effects: [loose_screw]\ncomponents: [contact]\n")
    (folder / "b/answer.yaml").write_text("effects: []\n")
    seal_folder(folder)


@pytest.mark.parametrize(
    "content",
    [
        "effects: gravity",
        "effects: [1]",
        "effects: []\nceiling: high",
        "components: []",
        "effects: [screw]\ncomponents: [Sensor]",
    ],
)
def test_a_faulty_answer_is_named(sealed, content):
    folder = sealed[0]
    (folder / "seal.json").unlink()
    (folder / "a/answer.yaml").write_text(content)
    with pytest.raises(InputError, match=r"a/answer\.yaml: (effects|ceiling|components)"):
        seal_folder(folder)
