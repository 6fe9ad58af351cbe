"""A file without pickle: one line of JSON, then the leaves of a pytree.

**Source:** the layout is that of equinox's serialisation example; a checksum makes a damaged file a
fault of the file instead of a wrong force.
"""

import hashlib
import io
import json
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

import equinox as eqx

from acf_jax.documents import parse_json
from acf_jax.errors import InputError
from acf_jax.files import read_bytes, text_of, write_bytes

Tree = TypeVar("Tree")


def write_tree(path: Path, header: dict[str, Any], tree: Any) -> None:
    """Write `header` and the arrays of `tree`; the file is whole, or the one before it, at any moment."""
    body = io.BytesIO()
    eqx.tree_serialise_leaves(body, tree)
    write_bytes(path, signed(header, body.getvalue()))


def signed(header: dict[str, Any], body: bytes) -> bytes:
    """The content of a file: `header` with a checksum of itself and of `body`, then `body`."""
    line = json.dumps({name: value for name, value in header.items() if name != "sha256"}, allow_nan=False)
    checksum = hashlib.sha256(line.encode() + b"\n" + body).hexdigest()
    return json.dumps({**json.loads(line), "sha256": checksum}).encode() + b"\n" + body


def read_header(path: Path) -> tuple[dict[str, Any], bytes]:
    """Header and body of a file; `InputError` when it is none, or not whole."""
    line, _, body = read_bytes(path).partition(b"\n")
    header: Any = None
    with suppress(InputError):
        header = parse_json(text_of(line, path), path, "")
    if not isinstance(header, dict) or "sha256" not in header:
        raise InputError(f"{path}: does not start with a JSON header; name a file that train.fit wrote")
    if signed(header, body) != line + b"\n" + body:
        raise InputError(f"{path}: is cut off or damaged (its checksum differs); copy or train it again")
    return header, body


def read_leaves(path: Path, body: bytes, like: Tree) -> Tree:
    """The pytree `like` with the leaves in `body`; `InputError` when they do not fit it."""
    stream = io.BytesIO(body)
    try:
        tree: Tree = eqx.tree_deserialise_leaves(stream, like)
    except (RuntimeError, ValueError, EOFError, OSError, TypeError):
        raise InputError(f"{path}: its leaves do not fit its header; train it again") from None
    if stream.read(1):
        raise InputError(f"{path}: has more leaves than its header says; train it again")
    return tree
