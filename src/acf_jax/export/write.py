"""C headers as files; the name of the file of a surrogate's header is that of its function."""

import re
from pathlib import Path
from typing import TYPE_CHECKING

from acf_jax.errors import InputError
from acf_jax.export import peak_header
from acf_jax.export.c_names import is_taken
from acf_jax.files import write_text

if TYPE_CHECKING:
    from acf_jax.export.formula import Formula

EXACT = "ACF_PEAK"  # with _H the include guard of the exact peak's header
FUNCTION = "acf_find_peak(m, d, k_f, k_c, v_e, f_p)"


def write_c(path: Path, formula: "Formula | None" = None, origin: str = "") -> str:
    """Write the header of a surrogate's formula, or without one that of the exact peak of the paper's model.

    **Arguments:** `path`: ends in `.h`. `origin`: where the surrogate comes from, for the header's comment.

    **Returns:** the function and its arguments, as C calls it.

    **Raises:** `InputError` for a path that cannot be.
    """
    if faults := c_faults(path, names_function=formula is not None):
        raise InputError(faults)
    if formula is None:
        write_text(path, peak_header())
        return FUNCTION
    from acf_jax.export.c_header import c_header, identifier

    write_text(path, c_header(formula, path.stem, origin))
    return f"{path.stem}({', '.join(identifier(q.name) for q in formula.inputs)})"


def c_faults(path: Path, names_function: bool, called: str = "") -> list[str]:
    """What is wrong with the path of a header.

    **Arguments:** `names_function`: the file's name names its function. `called`: the option that gave it, if one did.
    """
    where = f"{called} {path}".strip()
    faults = file_faults(path, ".h", where)
    if names_function and (fault := _name_fault(path.stem)):
        faults.append(f"{where}: the file's name names the function; {fault}")
    return faults


def file_faults(path: Path, suffix: str, where: str) -> list[str]:
    """What is wrong with the path of a file that ends in `suffix`."""
    if path.suffix != suffix:
        return [f"{where}: must end in {suffix}; rename it"]
    return [f"{where}: is a folder; name a file in it"] if path.is_dir() else []


def _name_fault(name: str) -> str | None:
    """Why a function of a surrogate's header cannot have a name."""
    if not re.fullmatch(r"[A-Za-z]\w*", name, re.ASCII):
        return "use letters, digits and _ only"
    if is_taken(name):
        return f"`{name}` is a name of C, C++ or math.h; use another, such as {name}_force.h"
    if name.upper() == EXACT:
        return f"`{EXACT}_H` is the include guard of the exact peak's header; use another, such as {name}_surrogate.h"
    return None
