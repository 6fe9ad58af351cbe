"""The seal: answers put away before the first diagnosis, and opened only after the last."""

import gzip
import hashlib
import json
import time
from pathlib import Path
from typing import Any

from acf_jax.errors import InputError
from acf_jax.files import read_text, read_yaml_mapping, write_text

ANSWERS, SEAL, OPENED = "answers.sealed", "seal.json", "opened.json"


def seal_answers(folder: Path, answers: dict[str, dict[str, Any]]) -> str:
    """Put the answers of a folder of data sets under a seal; returns its SHA-256.

    Writes `answers.sealed` (compressed, so that no one reads it by accident) and `seal.json` with its hash.
    """
    if not answers:
        raise InputError(f"{folder}: no answers to seal; each data set needs an answer.yaml")
    content = gzip.compress(json.dumps(answers, sort_keys=True).encode(), mtime=0)
    digest = hashlib.sha256(content).hexdigest()
    scratch = folder / f".{ANSWERS}"
    scratch.write_bytes(content)
    scratch.replace(folder / ANSWERS)
    record = {"sha256": digest, "data_sets": len(answers), "sealed_at": time.time()}
    write_text(folder / SEAL, json.dumps(record, indent=1) + "\n")
    return digest


def seal_folder(folder: Path) -> str:
    """Seal the `answer.yaml` beside each data set of a folder, and remove them; returns the SHA-256."""
    if (folder / SEAL).exists():
        raise InputError(f"{folder / SEAL}: these answers are sealed already")
    files = sorted(folder.glob("*/answer.yaml"))
    digest = seal_answers(folder, {file.parent.name: read_answer(file) for file in files})
    for file in files:
        file.unlink()
    return digest


def read_answer(path: Path) -> dict[str, Any]:
    """An `answer.yaml`; `InputError` where it does not name the effects."""
    answer = read_yaml_mapping(path)
    effects = answer.get("effects")
    if not isinstance(effects, list) or not all(isinstance(name, str) for name in effects):
        raise InputError(f"{path}: effects: must be a list of the causes' names, such as [sensor_lag], or []")
    return answer


def open_answers(folder: Path, results: Path, names: list[str]) -> dict[str, dict[str, Any]]:
    """The answers of a folder: from under its seal, or from the `answer.yaml` of each data set.

    Opening verifies the hash, and that every diagnosis in `results` was made after the sealing. It is recorded with the
    hash of each diagnosis, so that none can be made or changed afterwards without being noticed.

    Raises:
        InputError: where the seal is broken, or a diagnosis is not the one that the opening saw.
    """
    if not (folder / SEAL).exists():
        return {name: read_answer(folder / name / "answer.yaml") for name in names}
    seal = json.loads(read_text(folder / SEAL))
    content = (folder / ANSWERS).read_bytes()
    if hashlib.sha256(content).hexdigest() != seal["sha256"]:
        raise InputError(f"{folder / ANSWERS}: does not match the hash in {SEAL}: the answers were changed")
    hashes = {}
    for name in names:
        file = results / name / "diagnosis.json"
        if file.stat().st_mtime < seal["sealed_at"]:
            raise InputError(f"{file}: is older than the seal; diagnose this data set again")
        hashes[name] = hashlib.sha256(file.read_bytes()).hexdigest()
    record = results / OPENED
    if record.exists():
        before = json.loads(read_text(record))["diagnoses"]
        if changed := [name for name, digest in hashes.items() if before.get(name) != digest]:
            raise InputError(
                f"{record}: the answers were opened before {', '.join(changed)} was diagnosed;"
                " a blind run ends with the opening: start another one"
            )
    else:
        write_text(record, json.dumps({"opened_at": time.time(), "diagnoses": hashes}, indent=1) + "\n")
    answers: dict[str, dict[str, Any]] = json.loads(gzip.decompress(content))
    return answers
