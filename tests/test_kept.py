"""Programs that are kept between runs: traced once, and again where anything that they are made from differs."""

import re
from collections.abc import Iterator
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import acf_jax
from acf_jax import kept as module
from acf_jax.inference.forward import MADE_OF
from acf_jax.kept import kept
from acf_jax.start import start_jax

SOURCES = ("model",)
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
    assert np.asarray(kept(program, name, NUMBER, SOURCES)(1.5)) == 3.0
    return program.traces


def test_a_program_is_traced_once(traced: Path) -> None:
    assert _traces() == 1
    assert _traces() == 0
    assert _traces("another") == 1
    assert len(list(traced.glob("*/*"))) == 2


def test_the_first_time_is_told(traced: Path) -> None:
    assert module.is_first(SOURCES)
    _traces()
    assert not module.is_first(SOURCES) and module.is_first(("effects",))
    jax.config.update("jax_compilation_cache_dir", None)
    assert not module.is_first(SOURCES), "nothing is kept: each time is like the first"


def test_other_source_is_traced_again(traced: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the folders that the program is made of; what stands elsewhere does not matter."""
    package = tmp_path / "package"
    for folder in ("model", "report"):
        (package / folder).mkdir(parents=True)
        (package / folder / "a.py").write_text("one")
    monkeypatch.setattr(acf_jax, "__file__", str(package / "__init__.py"))

    def change(folder: str) -> int:
        (package / folder / "a.py").write_text("another")
        module.origin.cache_clear()
        return _traces()

    try:
        module.origin.cache_clear()
        assert _traces() == 1
        assert change("report") == 0
        assert change("model") == 1
    finally:
        module.origin.cache_clear()


def test_a_forward_program_is_made_of_the_folders_it_names() -> None:
    """No folder that it names imports another one that computes."""
    root = Path(acf_jax.__file__).parent
    allowed = {*(source.partition("/")[0] for source in MADE_OF), "dataset", "errors", "kept"}
    files = module.files_of(root, MADE_OF)
    assert root / "inference" / "forward.py" in files and root / "effects" / "gravity.py" in files
    for path in files:  # data come in as arguments
        text = path.read_text("utf-8")
        assert set(re.findall(r"^\s*(?:from|import) acf_jax\.(\w+)", text, re.M)) <= allowed, path
        beside = re.findall(r"^from acf_jax\.inference\.(\w+)", text, re.M)
        assert {f"inference/{name}" for name in beside} <= {s.removesuffix(".py") for s in MADE_OF}, path


@pytest.mark.parametrize("content", [b"", b"damaged" * 100])
def test_a_damaged_file_is_replaced(traced: Path, content: bytes) -> None:
    _traces()
    (path,) = traced.glob("*/*")
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


def test_an_option_that_the_compiler_does_not_know_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    module.quick_options.cache_clear()
    assert module.quick_options() == module.COMPILER | module.QUICKER
    monkeypatch.setattr(module, "QUICKER", {"xla_no_such_option": True})
    module.quick_options.cache_clear()
    try:
        assert module.quick_options() == module.COMPILER
    finally:
        module.quick_options.cache_clear()


def test_the_compiler_keeps_apart_what_a_barrier_separates() -> None:
    once = jax.jit(lambda x: jax.lax.optimization_barrier(2 * x) + 1, compiler_options=module.quick_options())
    assert "opt-barrier" in str(once.lower(jnp.zeros(99)).compile().as_text())
