"""Reading and writing files safely: YAML without surprises, writes that are whole or absent."""

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import yaml

from acf_jax.errors import InputError


def read_text(path: Path) -> str:
    """The file's text; `InputError` when it is missing or is not UTF-8."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; check the path") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder; name a file") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is not UTF-8 text ({error.reason}); save it as UTF-8") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None


class _UniqueKeyLoader(yaml.SafeLoader):
    """YAML's safe loader that refuses a key given twice (the last one would win in silence)."""

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
    except RecursionError:
        raise InputError(f"{path}: nested too deeply; correct the YAML") from None
    except (ValueError, TypeError, OverflowError) as error:  # a date or number that does not exist
        raise InputError(f"{path}: is not valid YAML ({error}); correct the YAML") from None
    if not isinstance(value, dict):
        raise InputError(f"{path}: must hold `key: value` pairs, but holds {type(value).__name__}")
    return value


def write_text(path: Path, text: str) -> None:
    """Write `text` to a temporary name beside `path`, then rename: the file is whole or absent."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(name, 0o644)
        os.replace(name, path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


@contextmanager
def whole_folder(target: Path) -> Iterator[Path]:
    """A scratch folder whose files move into `target` when the block ends well, and vanish otherwise."""
    target.parent.mkdir(parents=True, exist_ok=True)
    scratch = Path(tempfile.mkdtemp(dir=target.parent, prefix=f".{target.name}."))
    try:
        yield scratch
        for source in sorted(scratch.rglob("*")):
            if source.is_file():
                destination = target / source.relative_to(scratch)
                destination.parent.mkdir(parents=True, exist_ok=True)
                os.replace(source, destination)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def inside(folder: Path, relative: str) -> Path:
    """The path `relative` within `folder`; `InputError` when it leaves the folder."""
    path = (folder / relative).resolve()
    if Path(relative).is_absolute() or not path.is_relative_to(folder.resolve()):
        raise InputError(f"'{relative}' leaves the folder {folder}; use a path inside it")
    return path
