"""The process of a job: one command, its output, progress and exit code kept in a folder.

python -m acf_jax.app.work FOLDER COMMAND ...

It inherits the lock of its session, which the system frees when it ends in whatever way.
"""

import os
import runpy
import sys
from pathlib import Path

OUTPUT, PROGRESS, CODE = "output.txt", "progress.txt", "code.txt"


def main(folder: Path, command: list[str]) -> None:
    for stream, name in ((1, OUTPUT), (2, PROGRESS)):
        handle = os.open(folder / name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)
        os.dup2(handle, stream)
        os.close(handle)
    sys.argv[1:] = command
    code = 1
    try:
        runpy.run_module("acf_jax", run_name="__main__", alter_sys=True)
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
    finally:
        sys.stdout.flush()
        new = folder / f".{CODE}"
        new.write_text(f"{code}\n")
        new.replace(folder / CODE)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
