"""Files that are dropped onto a page: streamed to the disk piece by piece, whole or absent."""

import os
import re
import tempfile
from collections.abc import AsyncIterator
from pathlib import Path

from acf_jax.errors import InputError, shown

LARGEST = 4_000_000_000  # bytes of one file; a larger one is opened in place
MOST = 200  # files of one recording
_NAME = re.compile(r"[^\W_][\w.+ ()-]{0,199}")


def file_name(text: str) -> str:
    """The name of an uploaded file, if it is a plain one; `InputError` where it is none."""
    if not _NAME.fullmatch(text) or text != text.strip() or text.endswith("."):
        raise InputError(
            f"file name {shown(text)}: use letters, digits, spaces and .+-_() only, and begin with a letter"
        )
    return text


async def receive(pieces: AsyncIterator[bytes], target: Path, most: int = LARGEST) -> int:
    """Write the pieces to `target`; how many bytes they were.

    **Raises:** `InputError` beyond `most` bytes and for a folder that is full of files; nothing is left then.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    if len(list(target.parent.iterdir())) >= MOST:
        raise InputError(f"{target.parent.name}: holds {MOST} files already; open the recording in place")
    handle, name = tempfile.mkstemp(dir=target.parent, prefix=".upload.")
    size = 0
    try:
        with os.fdopen(handle, "wb") as file:
            async for piece in pieces:
                size += len(piece)
                if size > most:
                    raise InputError(
                        f"{target.name}: is larger than {most / 1e9:g} GB; start the app with its folder, and open"
                        " it in place"
                    )
                file.write(piece)
        os.chmod(name, 0o644)
        os.replace(name, target)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
    return size
