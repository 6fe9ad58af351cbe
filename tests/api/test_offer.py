"""`import acf_jax as acf`: what is offered, that it is quick to import, and where JAX's float64 comes from."""

import doctest
import importlib
import inspect
import re
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

import acf_jax as acf

ROOT = Path(__file__).resolve().parents[2]
OFFERED = {
    "Rig", "Impact", "Prior", "find_peak", "find_peaks", "read_recording", "read_dataset", "diagnose", "read_model",
    "speed", "design", "check", "train", "load_surrogate", "export_c",
}  # fmt: skip
MODULES = sorted({module.__name__ for name in OFFERED if (module := inspect.getmodule(getattr(acf, name)))})


def answer(code: str) -> str:
    """What a fresh Python prints."""
    finished = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert finished.returncode == 0, finished.stderr
    return finished.stdout.strip()


def test_importing_it_loads_nothing_that_is_slow_and_shows_all_that_is_offered():
    code = "import sys, acf_jax as acf; print({'jax', 'numpy', 'plotly'} & set(sys.modules), *dir(acf))"
    loaded, *names = answer(code).split(" ")
    assert loaded == "set()" and "__version__" in names
    assert {name for name in names if not name.startswith("__")} == OFFERED  # no helper of the module itself


def test_type_checkers_see_what_is_offered():
    """The block for them names what `__getattr__` brings, from the same modules."""
    source = (ROOT / "src/acf_jax/__init__.py").read_text("utf-8")
    seen = re.findall(r"from acf_jax\.api\.(\w+) import (\w+) as \2", source)
    assert {(module, name) for name, module in acf._MODULES.items()} == set(seen)


def test_a_name_that_is_not_offered_is_told():
    with pytest.raises(AttributeError, match="no attribute 'find_peek'"):
        acf.find_peek  # noqa: B018


def test_no_package_has_the_name_of_a_function():
    """Importing it would put the package in the function's place."""
    assert not {path.stem for path in (ROOT / "src/acf_jax").iterdir()} & OFFERED


def test_float64_is_switched_on_by_the_first_value():
    code = (
        "import acf_jax as acf, jax; before = jax.config.jax_enable_x64; r = acf.Rig(4, 0, 0, 175561);"
        "print(before, r.m.dtype, acf.find_peak(r, acf.Impact(0.2, 100)).f_max.dtype)"
    )
    assert answer(code) == "False float64 float64"


def test_a_cache_of_the_user_stays():
    code = (
        "import jax; jax.config.update('jax_compilation_cache_dir', '/tmp/own-cache'); import acf_jax as acf;"
        "acf.Impact(0.2, 100); print(jax.config.jax_compilation_cache_dir)"
    )
    assert answer(code) == "/tmp/own-cache"


@pytest.mark.parametrize("name", MODULES)
def test_examples_in_docstrings_print_what_they_show(name, monkeypatch):
    monkeypatch.chdir(ROOT)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        failed, tried = doctest.testmod(
            importlib.import_module(name), optionflags=doctest.NORMALIZE_WHITESPACE
        )
    assert tried and not failed


@pytest.mark.parametrize("name", sorted(OFFERED))
def test_every_docstring_says_what_a_caller_has_to_know(name):
    text = inspect.getdoc(getattr(acf, name)) or ""
    is_class = inspect.isclass(getattr(acf, name))
    for part in ("**Arguments:**", "**Raises:**", ">>> import acf_jax as acf"):
        assert part in text, part
    assert is_class or "**Returns:**" in text
    named = set(inspect.signature(getattr(acf, name)).parameters) - {"self"}
    assert all(f"`{parameter}`" in text for parameter in named), named
