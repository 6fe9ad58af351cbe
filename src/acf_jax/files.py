"""Reading and writing files safely: reads that are bounded, writes that are whole or absent."""

import os
import tempfile
import zlib
from pathlib import Path
from typing import Any

from acf_jax.documents import MOST_BYTES, parse_json, parse_yaml
from acf_jax.errors import InputError, shown

MAX_BYTES = 200_000_000  # a trace of 200 MB is hours long; nothing else that is read comes near


def check_ordinary(path: Path, limit: int | None) -> None:
    """Refuse what is no ordinary file, or longer than `limit` bytes; a link is what it leads to, a missing file passes.

    A device or a pipe could be read without end.

    **Raises:** `InputError`.
    """
    if path.exists() and not path.is_file():
        raise InputError(f"{path}: is not an ordinary file; name a file")
    if limit is not None and path.is_file():
        _check_size(path, path.stat().st_size, limit)


def _check_size(path: Path, size: int, limit: int) -> None:
    if size > limit:
        raise InputError(f"{path}: is larger than {limit / 1e6:g} MB; cut it to what is needed")


def read_bytes(path: Path, most: int | None = None) -> bytes:
    """The file's content; `InputError` unless it is an ordinary file of `most` bytes at most, else of `MAX_BYTES`."""
    try:
        check_ordinary(path, None)
        with path.open("rb") as file:
            size = os.fstat(file.fileno()).st_size
            _check_size(path, size, most or MAX_BYTES)
            content = file.read(size + 1)
        if len(content) > size:  # as in /proc, where files need not tell how long they are
            raise InputError(f"{path}: is longer than its size says; name a file that is written to its end")
        return content
    except InputError:
        raise
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; check the path") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "no path of a file"
        raise InputError(f"{shown(str(path))}: cannot be read ({reason}); correct the path") from None


def read_text(path: Path, most: int | None = None) -> str:
    """The file's text; `InputError` when it is missing, is not UTF-8, or is larger than `read_bytes` allows."""
    return text_of(read_bytes(path, most), path)


def text_of(content: bytes, where: object) -> str:
    """The text of UTF-8 with any line ends; `InputError`, which begins with `where`, when it is none."""
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        raise InputError(f"{where}: is not UTF-8 text ({error.reason}); save it as UTF-8") from None


def unpacked(content: bytes, where: object, remedy: str, most: int) -> bytes:
    """What gzip packed; `InputError`, which begins with `where`, unless it is whole and has `most` bytes at most."""
    pack = zlib.decompressobj(wbits=zlib.MAX_WBITS | 16)
    try:
        found = pack.decompress(content, most + 1)
    except zlib.error as error:
        raise InputError(f"{where}: cannot be unpacked ({error}); {remedy}") from None
    if len(found) > most:
        raise InputError(f"{where}: unpacks to more than {most // 10**6} MB; {remedy}")
    if not pack.eof or pack.unused_data:
        raise InputError(f"{where}: {'more stands behind its end' if pack.eof else 'is cut off'}; {remedy}")
    return found


def read_json_mapping(path: Path, remedy: str) -> dict[str, Any]:
    """The object in a JSON file; `InputError`, which ends with `remedy`, when it is none."""
    value = parse_json(read_text(path, MOST_BYTES["JSON"]), path, remedy)
    if not isinstance(value, dict):
        raise InputError(f"{path}: must hold a JSON object, but holds {type(value).__name__}; {remedy}")
    return value


def read_yaml_mapping(path: Path) -> dict[str, Any]:
    """The mapping in a YAML file, read as acf_jax.documents says; `InputError` when it is not one."""
    value = parse_yaml(read_text(path, MOST_BYTES["YAML"]), path)
    if not isinstance(value, dict):
        what = "nothing" if value is None else f"a {type(value).__name__}"
        raise InputError(f"{path}: must hold `key: value` pairs, but holds {what}; write a pair a line")
    return value


def write_text(path: Path, text: str) -> None:
    """Write `text` so that the file is whole or absent; a name in it that is no text, as a path may be, is escaped."""
    write_bytes(path, text.encode(errors="backslashreplace"))


def write_bytes(path: Path, content: bytes) -> None:
    """Write `content` to a temporary name beside `path`, then rename: the file is whole or absent.

    A link stays one, and the file that it names is written; `InputError` for a folder, a device or a pipe.
    """
    path = Path(os.path.realpath(path))
    check_ordinary(path, None)
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(name, 0o644)
        os.replace(name, path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def inside(folder: Path, relative: str) -> Path:
    """The path `relative` within `folder`; `InputError` when it leaves the folder."""
    path = (folder / relative).resolve()
    if Path(relative).is_absolute() or not path.is_relative_to(folder.resolve()):
        raise InputError(f"'{relative}' leaves the folder {folder}; use a path inside it")
    return path
