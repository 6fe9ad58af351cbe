"""What is said of a file's content that does not fit its form."""

from typing import Annotated, Any

import pytest
from pydantic import Discriminator, Field, Tag

from acf_jax.errors import InputError
from acf_jax.forms import Part, check_form


class Ends(Part):
    low: float
    high: float = Field(gt=0)


def kind(value: Any) -> str:
    return "ends" if isinstance(value, dict) else "number"


class Form(Part):
    schema_: str = Field(default="x", alias="schema")
    speed: Annotated[Annotated[float, Tag("number")] | Annotated[Ends, Tag("ends")], Discriminator(kind)] = (
        1.0
    )
    free: dict[str, Ends] = Field(default={})
    rows: tuple[Ends, ...] = ()
    name: str = ""


@pytest.mark.parametrize(
    ("content", "fault"),
    [
        ({"speed": {"low": 1}}, "speed.high: is missing; add it"),
        ({"speed": "fast"}, "speed: must be a number, but is 'fast'; write digits, such as 3.4e5"),
        ({"speed": None}, "speed: must be a number, but is empty; write digits, such as 3.4e5"),
        ({"speed": {"low": 1, "high": -1}}, "speed.high: must be greater than 0, but is -1; correct the value"),
        ({"free": {"m": {"low": 1, "hihg": 2, "high": 3}}}, "free.m.hihg: is not a known key; did you mean 'high'?"),
        ({"rows": [{"low": 1, "high": 2}, {"low": 1}]}, "rows.1.high: is missing; add it"),
        ({"rows": [7]}, "rows.0: must hold `key: value` pairs, but is 7; write them below it"),
        ({"shcema": "x"}, "shcema: is not a known key; did you mean 'schema'?"),
        ({"high": 1}, "high: is not a known key; remove it"),
        ({"name": 3}, "name: must be text, but is 3; put it in quotes"),
        ({"speed": float("nan")}, "speed: must be a finite number, but is nan; correct the value"),
    ],
)  # fmt: skip
def test_a_fault_has_its_place_in_the_file_and_a_remedy(content: dict[str, Any], fault: str) -> None:
    with pytest.raises(InputError) as error:
        check_form(Form, content, "file.yaml")
    assert error.value.faults == [f"file.yaml: {fault}"]


def test_of_a_file_that_a_program_wrote_the_first_faults_are_told_with_one_remedy() -> None:
    with pytest.raises(InputError) as error:
        check_form(Form, {"rows": [{}] * 50}, "file.json", "write it again")
    assert error.value.faults[:2] == [
        "file.json: rows.0.low: is missing; write it again",
        "file.json: rows.0.high: is missing; write it again",
    ]
    assert len(error.value.faults) == 5


@pytest.mark.parametrize("value", [True, "1", "1_000", [1], {"a": 1}])
def test_only_a_number_is_one(value: Any) -> None:
    with pytest.raises(InputError, match=r"rows\.0\.low: must be a number, but is .*; write digits"):
        check_form(Form, {"rows": [{"low": value, "high": 1}]}, "file")


def test_a_list_stands_for_a_tuple_and_a_whole_number_for_a_number() -> None:
    assert check_form(Form, {"rows": [{"low": 1, "high": 2}]}, "").rows[0].high == 2.0


def test_faults_without_number_are_counted_not_listed() -> None:
    with pytest.raises(InputError) as error:
        check_form(Form, {"rows": [0] * 5000}, "file")
    assert error.value.faults == ["file: 5,000 values do not fit the file's form; write it anew"]


def test_no_one_is_shown_more_faults_than_can_be_read() -> None:
    faults = InputError([f"fault {k}; mend it" for k in range(1000)]).faults
    assert len(faults) == 101 and faults[99:] == [
        "fault 99; mend it", "900 more faults are not shown; correct these first"
    ]  # fmt: skip
    assert len(InputError(faults[:100]).faults) == 100
