"""Programs that JAX has traced once, kept beside its cache of compiled code: tracing takes longer than running."""

import contextlib
import functools
from collections.abc import Callable
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Any

import jax
from jax import export

import acf_jax
from acf_jax.files import write_bytes

COMPILER = {"xla_backend_optimization_level": 1}  # compiling costs more than running; this runs as fast
MADE_WITH = ("jax", "jaxlib", "equinox", "numpy")
HASH = sha256().digest_size


def kept(
    function: Callable[..., Any], name: str, arguments: tuple[jax.ShapeDtypeStruct, ...]
) -> Callable[..., Any]:
    """The function, compiled; traced again only where this package's source, JAX or its device is another one.

    **Arguments:** `name`: tells it from every other function that is kept. `arguments`: shapes and types.

    Without a cache of compiled code, which `start_jax` makes, or where that cannot be written, nothing is kept.
    """
    traced = jax.jit(function, compiler_options=COMPILER)
    cache = jax.config.jax_compilation_cache_dir  # type: ignore[attr-defined]  # JAX makes it as it runs
    if not cache:
        return traced
    key = sha256(repr((_origin(), jax.default_backend(), name, arguments)).encode()).hexdigest()
    path = Path(cache).with_name("traced") / key
    content = _read(path)
    if content is None:
        content = bytes(export.export(traced)(*arguments).serialize())
        with contextlib.suppress(OSError):
            write_bytes(path, sha256(content).digest() + content)
    return jax.jit(export.deserialize(bytearray(content)).call, compiler_options=COMPILER)


def _read(path: Path) -> bytes | None:
    """What was kept; None where nothing was, or not whole."""
    try:
        stored = path.read_bytes()
    except OSError:
        return None
    content = stored[HASH:]
    return content if sha256(content).digest() == stored[:HASH] else None


@functools.cache
def _origin() -> str:
    """What a program is made from: the source of this package, JAX, and what it is written with."""
    folder = Path(acf_jax.__file__).parent
    digest = sha256()
    for path in sorted(folder.rglob("*.py")):
        digest.update(f"{path.relative_to(folder)}\n".encode())
        digest.update(sha256(path.read_bytes()).digest())
    return " ".join([digest.hexdigest(), *(version(name) for name in MADE_WITH)])
