"""How much may come out of a packed file: checked before it is read, so that a small file cannot fill the memory."""

from pathlib import Path

from acf_jax.errors import InputError

_ROWS = 1_000_000  # however small the file is
_BYTES, _RATIO = 64_000_000, 100  # tables of many constant columns are packed 50 to 1
_REMEDY = "it is damaged or no recording; save it again, not compressed"


def check_rows(path: Path, rows: int) -> None:
    """`InputError` when a file holds more rows than bytes: time and noise take more than a byte a row."""
    size = path.stat().st_size
    if rows > _ROWS + size:
        raise InputError(f"{path}: says to hold {rows:.3g} values of a signal in {size:,} bytes; {_REMEDY}")


def check_unpacked(path: Path, unpacked: int) -> None:
    """`InputError` when so many bytes come out of a file that it holds next to nothing."""
    size = path.stat().st_size
    if unpacked > _BYTES + _RATIO * size:
        raise InputError(f"{path}: {size:,} bytes unpack to {unpacked:.3g} or more; {_REMEDY}")
