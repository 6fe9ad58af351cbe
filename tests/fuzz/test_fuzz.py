"""Whatever stands in its files, every reader ends in a result or in an `InputError` with a remedy.

A few files of every reader, and more of them with the longer checks; `python -m tests.fuzz --minutes 10` goes on where
these stop.
"""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from acf_jax.errors import InputError
from acf_jax.recording.readers import readers
from tests.fuzz import attempt as module
from tests.fuzz.attempt import attempt, no_numbers
from tests.fuzz.hostile import built
from tests.fuzz.mutate import mutated
from tests.fuzz.readers import READERS, Reader, kinds

EVERY = pytest.mark.parametrize("reader", READERS, ids=[reader.name for reader in READERS])
SAME = settings(deadline=None, derandomize=True, database=None, suppress_health_check=list(HealthCheck))


def files(few: int, many: int) -> pytest.MarkDecorator:
    """How many files are made of a reader's whole one."""
    return pytest.mark.parametrize("count", [few, pytest.param(many, marks=pytest.mark.long)])


def try_out(reader: Reader, make: Callable[[str, bytes], st.SearchStrategy[bytes]], count: int) -> None:
    """`count` times what `make` makes of one of the reader's files, beside the others."""
    whole = reader.files()

    @settings(SAME, max_examples=count)
    @given(data=st.data())
    def one(data: st.DataObject) -> None:
        wrong = data.draw(st.sampled_from(reader.wrong))
        attempt(reader, {**whole, wrong: data.draw(make(wrong, whole[wrong]))})

    one()


@EVERY
def test_whole_files_are_understood(reader):
    assert attempt(reader, reader.files()).faults == []


@EVERY
@files(6, 40)
def test_mutated_files_are_understood_or_refused(reader, count):
    try_out(reader, mutated, count)


@EVERY
@files(3, 15)
def test_hostile_files_are_understood_or_refused(reader, count):
    try_out(reader, built, count)


def test_every_reader_of_recordings_is_tried():
    assert len({others for _, others in kinds()}) == len(readers())


def refuse(*faults):
    raise InputError(faults)


def leave(folder):
    (folder / "half").touch()
    refuse("half; try again")


@pytest.mark.parametrize(
    ("read", "wrong"),
    [
        (lambda folder: {"a": [1.0, (2.0, float("nan"))]}, r"not a number: result\.a\.1\.1"),
        (lambda folder: np.full(3, np.nan), "not a number: result"),
        (lambda folder: np.ones(10**7).sum(), "bytes of memory"),
        (lambda folder: np.empty(10**9), "allocate"),
        (lambda folder: refuse("a\nb"), "no remedy"),
        (lambda folder: refuse(), "without a reason"),
        (leave, r"a refusal leaves \['half'\]"),
        (lambda folder: [None for _ in iter(lambda: 0, 1) if False], "not read within 1 s"),
        (lambda folder: 1 // 0, "zero"),
    ],
)  # fmt: skip
def test_what_must_not_be_is_noticed(read, wrong, monkeypatch):
    monkeypatch.setattr(module, "MOST", 50_000_000)
    with pytest.raises((AssertionError, ArithmeticError, MemoryError), match=wrong):
        attempt(Reader("made up", dict, (), read), {"a": b""}, longest=1)


def test_infinity_and_words_are_no_numbers_that_are_none():
    assert list(no_numbers([1.0, float("inf"), "nan", None])) == []
