"""The seal: answers put away before the first diagnosis, and opened only after the last."""

import gzip
import hashlib
import json
import time
from pathlib import Path
from typing import Any

from pydantic import BaseModel, FiniteFloat

from acf_jax.documents import MOST_BYTES, parse_json
from acf_jax.errors import InputError, merged
from acf_jax.files import (
    read_bytes,
    read_json_mapping,
    read_yaml_mapping,
    text_of,
    unpacked,
    write_bytes,
    write_text,
)
from acf_jax.forms import check_form
from validation.blind.answer import ANSWER, DIAGNOSIS, Answer, check_answer, read_answer

ANSWERS, SEAL, OPENED = "answers.sealed", "seal.json", "opened.json"
ENDED = "a blind run ends with the opening of its answers: start another one"


class Seal(BaseModel):
    """What is known of the answers under a seal."""

    sha256: str  # of the answers as packed
    data_sets: int
    sealed_at: FiniteFloat  # s since 1970


def seal_answers(folder: Path, answers: dict[str, dict[str, Any]]) -> str:
    """Put the answers of a folder of data sets under a seal; returns its SHA-256.

    Writes `answers.sealed` (compressed, so that no one reads it by accident) and `seal.json` with its hash.
    """
    if not answers:
        raise InputError(f"{folder}: no answers to seal; each data set needs an answer.yaml")
    text = json.dumps(answers, sort_keys=True)
    parse_json(text, f"{folder}: the answers", "correct them")  # as they are to be read again
    content = gzip.compress(text.encode(), mtime=0)
    digest = hashlib.sha256(content).hexdigest()
    write_bytes(folder / ANSWERS, content)
    record = Seal(sha256=digest, data_sets=len(answers), sealed_at=time.time())
    write_text(folder / SEAL, record.model_dump_json(indent=1) + "\n")
    return digest


def seal_folder(folder: Path) -> str:
    """Seal the `answer.yaml` beside each data set of a folder, and remove them; returns the SHA-256.

    A sealing that was killed before it had removed them all goes on.

    **Raises:** `InputError` where there are no answers, one is missing or wrong, or others are sealed already.
    """
    files = sorted(folder.glob(f"*/{ANSWER}"))
    beside = {file.parent.name: read_answer(file.parent) for file in files}
    if (folder / SEAL).exists():
        seal, content = _read_seal(folder)
        if not beside or _unpack(folder / ANSWERS, content, list(beside)) != beside:
            raise InputError(f"{folder / SEAL}: these answers are sealed already")
        digest = seal.sha256
    else:
        _check_beside(folder, [p.parent.name for p in folder.glob("*/dataset.yaml")] if files else [])
        digest = seal_answers(folder, {file.parent.name: read_yaml_mapping(file) for file in files})
    for file in files:
        file.unlink()
    return digest


def check_answers(folder: Path, names: list[str]) -> str | None:
    """The hash of the sealed answers, None without a seal; `InputError` unless each data set has an answer.

    No answer is opened: this is what can be known before the first diagnosis.
    """
    if not (folder / SEAL).exists():
        _check_beside(folder, names)
        return None
    seal, _ = _read_seal(folder)
    if seal.data_sets < len(names):
        raise InputError(
            f"{folder / SEAL}: {seal.data_sets} answers are under the seal, but there are {len(names)} data sets;"
            " remove those that came later"
        )
    return seal.sha256


def is_opened(folder: Path, results: Path) -> bool:
    """Whether the sealed answers were opened after these results: none of them can be changed then."""
    return (folder / SEAL).exists() and (results / OPENED).exists()


def open_answers(folder: Path, results: Path, names: list[str]) -> dict[str, Answer]:
    """The answers of a folder: from under its seal, or from the `answer.yaml` of each data set.

    Opening verifies the hash, and that every diagnosis in `results` was made after the sealing. It is recorded with the
    hash of each diagnosis, so that none can be made or changed afterwards without being noticed.

    **Raises:** `InputError` where the seal is broken, or a diagnosis is not the one that the opening saw.
    """
    if not (folder / SEAL).exists():
        return {name: read_answer(folder / name) for name in names}
    seal, content = _read_seal(folder)
    answers, hashes = _unpack(folder / ANSWERS, content, names), {}
    for name in names:
        file = results / name / DIAGNOSIS
        if file.stat().st_mtime < seal.sealed_at:
            raise InputError(f"{file}: is older than the seal; diagnose this data set again")
        hashes[name] = hashlib.sha256(read_bytes(file)).hexdigest()
    record = results / OPENED
    if record.exists():
        before = read_json_mapping(record, "name another --out").get("diagnoses")
        if not isinstance(before, dict):
            raise InputError(f"{record}: does not list the diagnoses; name another --out")
        if changed := [name for name, digest in hashes.items() if before.get(name) != digest]:
            raise InputError(
                f"{record}: the answers were opened before {', '.join(changed)} was diagnosed; {ENDED}"
            )
    else:
        write_text(record, json.dumps({"opened_at": time.time(), "diagnoses": hashes}, indent=1) + "\n")
    return answers


def _read_seal(folder: Path) -> tuple[Seal, bytes]:
    """The record of the sealing, and the answers still packed, which match its hash."""
    path, remedy = folder / SEAL, "the answers can no longer be trusted; make and seal them again"
    seal = check_form(Seal, read_json_mapping(path, remedy), path, remedy)
    content = read_bytes(folder / ANSWERS)
    if hashlib.sha256(content).hexdigest() != seal.sha256:
        raise InputError(
            f"{folder / ANSWERS}: does not match the hash in {SEAL}: the answers were changed; {remedy}"
        )
    return seal, content


def _unpack(path: Path, content: bytes, names: list[str]) -> dict[str, Answer]:
    again = "make and seal the answers again"
    text = text_of(unpacked(content, path, again, MOST_BYTES["JSON"]), path)
    answers = parse_json(text, path, again)
    if not isinstance(answers, dict) or (missing := [name for name in names if name not in answers]):
        which = f"for {', '.join(missing)}" if isinstance(answers, dict) else "at all"
        raise InputError(f"{path}: holds no answer {which}; remove data sets that came after the sealing")
    return {name: check_answer(f"{path} {name}", answers[name]) for name in names}


def _check_beside(folder: Path, names: list[str]) -> None:
    missing = [folder / name / ANSWER for name in sorted(names) if not (folder / name / ANSWER).is_file()]
    if missing:
        what = "no such file; write effects: [...] in it"
        raise InputError(merged((str(file), [f"{file}: {what}"]) for file in missing))
