"""Programs that are kept between runs: traced once, and again where anything that they are made from differs."""

from collections.abc import Iterator
from pathlib import Path

import jax
import numpy as np
import pytest

from acf_jax import kept as module
from acf_jax.kept import kept
from acf_jax.start import start_jax

NUMBER = (jax.ShapeDtypeStruct((), float),)


@pytest.fixture
def traced(tmp_path: Path) -> Iterator[Path]:
    """The folder of what was traced, beside a cache of compiled code of this test's own."""
    before = jax.config.jax_compilation_cache_dir  # type: ignore[attr-defined]
    jax.config.update("jax_compilation_cache_dir", str(tmp_path / "compiled"))
    yield tmp_path / "traced"
    jax.config.update("jax_compilation_cache_dir", before)


class Counted:
    """A program that counts how often it is traced."""

    def __init__(self) -> None:
        self.traces = 0

    def __call__(self, x: jax.Array) -> jax.Array:
        self.traces += 1
        return 2 * x


def _traces(name: str = "double") -> int:
    program = Counted()
    assert np.asarray(kept(program, name, NUMBER)(1.5)) == 3.0
    return program.traces


def test_a_program_is_traced_once(traced: Path) -> None:
    assert _traces() == 1
    assert _traces() == 0
    assert _traces("another") == 1
    assert len(list(traced.iterdir())) == 2


def test_other_source_is_traced_again(traced: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _traces()
    monkeypatch.setattr(module, "_origin", lambda: "another version")
    assert _traces() == 1


@pytest.mark.parametrize("content", [b"", b"damaged" * 100])
def test_a_damaged_file_is_replaced(traced: Path, content: bytes) -> None:
    _traces()
    (path,) = traced.iterdir()
    path.write_bytes(content)
    assert _traces() == 1
    assert _traces() == 0


def test_a_cache_that_cannot_be_written_costs_time_only(traced: Path) -> None:
    traced.write_text("a file where the folder should be")
    assert _traces() >= 1
    assert _traces() >= 1


def test_without_a_cache_nothing_is_kept(traced: Path) -> None:
    jax.config.update("jax_compilation_cache_dir", None)
    assert _traces() == _traces() == 1
    assert not traced.exists()


def test_a_user_without_a_home_computes_without_a_cache(
    traced: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_home() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", no_home)
    start_jax()
