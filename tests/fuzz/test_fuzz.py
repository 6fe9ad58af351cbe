"""Whatever stands in its files, every reader ends in a result or in an `InputError` with a remedy.

`python -m tests.fuzz --minutes 10` goes on where this stops.
"""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.fuzz.attempt import attempt
from tests.fuzz.mutate import mutated
from tests.fuzz.readers import READERS


@pytest.mark.parametrize("reader", READERS, ids=[reader.name for reader in READERS])
def test_whole_files_are_understood(reader):
    assert attempt(reader, reader.files())[0] == []


@pytest.mark.parametrize("reader", READERS, ids=[reader.name for reader in READERS])
@settings(
    max_examples=40, deadline=None, derandomize=True, database=None, suppress_health_check=list(HealthCheck)
)
@given(data=st.data())
def test_mutated_files_are_understood_or_refused(reader, data):
    files = reader.files()
    wrong = data.draw(st.sampled_from(reader.wrong))
    attempt(reader, {**files, wrong: data.draw(mutated(wrong, files[wrong]))})
