"""Reading and writing files safely: YAML without surprises, writes that are whole or absent."""

import json
import os
import re
import tempfile
from pathlib import Path
from typing import Any

import yaml

from acf_jax.errors import InputError, shown

MAX_BYTES = 200_000_000  # a trace of 200 MB is hours long; nothing else that is read comes near


def check_ordinary(path: Path, limit: int | None) -> None:
    """Refuse what is no ordinary file, or longer than `limit` bytes; a link is what it leads to, a missing file passes.

    A device or a pipe could be read without end.

    **Raises:** `InputError`.
    """
    if path.exists() and not path.is_file():
        raise InputError(f"{path}: is not an ordinary file; name a file")
    if limit is not None and path.is_file() and path.stat().st_size > limit:
        raise InputError(f"{path}: is larger than {limit / 1e6:g} MB; cut it to what is needed")


def read_bytes(path: Path) -> bytes:
    """The file's content; `InputError` unless it is an ordinary file of bearable size."""
    try:
        check_ordinary(path, MAX_BYTES)
        return path.read_bytes()
    except InputError:
        raise
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; check the path") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "no path of a file"
        raise InputError(f"{shown(str(path))}: cannot be read ({reason}); correct the path") from None


def read_text(path: Path) -> str:
    """The file's text; `InputError` when it is missing or is not UTF-8."""
    try:
        return read_bytes(path).decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is not UTF-8 text ({error.reason}); save it as UTF-8") from None


def read_json_mapping(path: Path, remedy: str) -> dict[str, Any]:
    """The object in a JSON file; `InputError`, which ends with `remedy`, when it is none."""
    try:
        value = json.loads(read_text(path))
    except InputError:
        raise
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: is not JSON ({error}); {remedy}") from None
    if not isinstance(value, dict):
        raise InputError(f"{path}: must hold a JSON object, but holds {type(value).__name__}; {remedy}")
    return value


class _UniqueKeyLoader(yaml.SafeLoader):
    """YAML's safe loader without a key given twice (the last one would win in silence) and without aliases.

    A few lines of aliases of aliases stand for more values than any memory holds.
    """

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.AliasEvent):
            mark = self.peek_event().start_mark
            raise yaml.composer.ComposerError(
                None, None, "aliases (*name) are not known; write values out", mark
            )
        return super().compose_node(parent, index)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if isinstance(key, str) and key in seen:
                raise yaml.constructor.ConstructorError(
                    None, None, f"key '{key}' is given twice", key_node.start_mark
                )
            seen.add(key if isinstance(key, str) else None)
        return super().construct_mapping(node, deep)


# YAML 1.1 takes 3.4e5 and 1e-3 for text: it asks for a point and for the exponent's sign.
_UniqueKeyLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+"), list("-+.0123456789")
)


def read_yaml_mapping(path: Path) -> dict[str, Any]:
    """The mapping in a YAML file; `InputError` when it is not one."""
    text = read_text(path)
    try:
        value = yaml.load(text, Loader=_UniqueKeyLoader)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = f" line {mark.line + 1}" if mark else ""
        what = getattr(error, "problem", None) or "not valid YAML"
        raise InputError(f"{path}{where}: {what}; correct the YAML") from None
    except InputError:
        raise
    except RecursionError:
        raise InputError(f"{path}: nested too deeply; correct the YAML") from None
    except (ValueError, TypeError, LookupError, AttributeError, ArithmeticError) as error:
        # PyYAML's constructors on a date, a number or a tag that does not exist
        raise InputError(f"{path}: is not valid YAML ({error}); correct the YAML") from None
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
