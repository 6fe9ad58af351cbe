"""Programs that JAX has traced once, kept beside its cache of compiled code: tracing takes longer than running."""

import contextlib
import functools
from collections.abc import Callable
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar

import equinox as eqx
import jax
from jax import export

import acf_jax
from acf_jax.files import write_bytes

# compiling costs more than running; this runs as fast
COMPILER: dict[str, Any] = {"xla_backend_optimization_level": 1}
# XLA keeps to 256 bits even where a processor has 512, with which batches take 0.6 of the time, and fits of many laws
# three quarters; the numbers are the same
VECTORS: dict[str, Any] = {"xla_cpu_prefer_vector_width": 512}
QUICKER: dict[str, Any] = {
    **VECTORS,
    "xla_cpu_use_fusion_emitters": False,  # compiles faster
    # without this pass an `optimization_barrier` still stands when the compiler chooses what to compute twice
    "xla_disable_hlo_passes": "cse_barrier_expander",
}
MADE_WITH = ("jax", "jaxlib", "equinox", "numpy")
HASH = sha256().digest_size

Result = TypeVar("Result")


def kept(
    function: Callable[..., Any],
    name: str,
    arguments: tuple[jax.ShapeDtypeStruct | None, ...],
    sources: tuple[str, ...],
) -> Callable[..., Any]:
    """The function, compiled; traced again only where its source, JAX or its device is another one.

    **Arguments:** `name`: tells it from every other function that is kept. `arguments`: shapes and types. `sources`:
    folders and files of this package that hold all that the function calls.

    Without a cache of compiled code, which `start_jax` makes, or where that cannot be written, nothing is kept.
    """
    options = quick_options()
    traced = jax.jit(function, compiler_options=options)
    folder = _folder(sources)
    if not folder:
        return traced.lower(*arguments).compile()
    path = folder / _digest(name, arguments)
    content = _read(path)
    if content is None:
        content = bytes(export.export(traced)(*arguments).serialize())
        with contextlib.suppress(OSError):
            write_bytes(path, sha256(content).digest() + content)
    again = jax.jit(export.deserialize(bytearray(content)).call, compiler_options=options)
    return again.lower(*arguments).compile()


def is_first(sources: tuple[str, ...]) -> bool:
    """Whether nothing made from these sources is kept yet, though it could be: compiling will take a while, once."""
    folder = _folder(sources)
    return folder is not None and not folder.exists()


def _folder(sources: tuple[str, ...]) -> Path | None:
    """Where programs made from some sources are kept; None without a cache of compiled code."""
    cache = jax.config.jax_compilation_cache_dir  # type: ignore[attr-defined]  # JAX makes it as it runs
    if not cache:
        return None
    return Path(cache).with_name("traced") / _digest(origin(sources), jax.default_backend())


def _digest(*parts: object) -> str:
    return sha256(repr(parts).encode()).hexdigest()


def compiled_quickly(function: Callable[..., Result]) -> Callable[..., Result]:
    """`equinox.filter_jit` of a function that takes longer to compile than to run; not for use within another one."""

    @functools.wraps(function)
    def call(*arguments: Any) -> Result:
        found: Result = _quick(function)(*arguments)
        return found

    return call


@functools.cache
def _quick(function: Callable[..., Any]) -> Callable[..., Any]:
    of_jit: Any = {"compiler_options": quick_options()}  # which Equinox' types do not name
    compiled: Callable[..., Any] = eqx.filter_jit(function, **of_jit)
    return compiled


@functools.cache
def quick_options() -> dict[str, Any]:
    """What compiles and runs quickly, of what this version of the compiler knows."""
    return COMPILER | QUICKER if knows(COMPILER | QUICKER) else COMPILER


def knows(options: dict[str, Any]) -> bool:
    """Whether this version of the compiler knows all of some options."""
    try:
        jax.jit(jax.lax.optimization_barrier, compiler_options=options)(0.0)
    except jax.errors.JaxRuntimeError:
        return False
    return True


def _read(path: Path) -> bytes | None:
    """What was kept; None where nothing was, or not whole."""
    try:
        stored = path.read_bytes()
    except OSError:
        return None
    content = stored[HASH:]
    return content if sha256(content).digest() == stored[:HASH] else None


@functools.cache
def origin(sources: tuple[str, ...]) -> str:
    """What a program is made from: some source of this package, JAX, and what it is written with."""
    folder = Path(acf_jax.__file__).parent
    digest = sha256(Path(__file__).read_bytes())
    for path in files_of(folder, sources):
        digest.update(f"{path.relative_to(folder)}\n".encode())
        digest.update(sha256(path.read_bytes()).digest())
    return " ".join([digest.hexdigest(), *(version(name) for name in MADE_WITH)])


def files_of(folder: Path, sources: tuple[str, ...]) -> list[Path]:
    """All Python files among some files and folders."""
    named = [folder / source for source in sources]
    return sorted(path for one in named for path in ([one] if one.is_file() else one.rglob("*.py")))
