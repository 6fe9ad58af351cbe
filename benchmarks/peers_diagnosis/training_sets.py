"""Features of drawn sets, kept in one file that grows: drawing takes minutes and can be stopped at any time."""

from pathlib import Path

import numpy as np

from acf_jax.errors import InputError
from benchmarks.peers_diagnosis.draws import draw
from benchmarks.peers_diagnosis.features import features

KEEP = 10  # rigs after which the file is written anew


def keep(path: Path, seed: int, rigs: int) -> int:
    """Draw sets of so many rigs, and write their features; returns how many sets there are.

    **Raises:** `InputError` where the file cannot be written as asked.
    """
    if path.suffix != ".npz" or not path.parent.is_dir():
        raise InputError(f"{path}: name a file that ends with .npz, in a folder that exists")
    rows, told, of_rig = [], [], []
    for first in range(0, rigs, KEEP):
        for k in range(first, min(first + KEEP, rigs)):
            for one in draw(seed + k, 1):
                x = features(one.traces)
                if np.isfinite(x).all():
                    rows.append(x)
                    told.append("+".join(one.explanation))
                    of_rig.append(k)
        if rows:
            scratch = path.with_name(f"{path.stem}.part.npz")
            np.savez(scratch, features=np.array(rows), explanations=np.array(told), rig=np.array(of_rig))
            scratch.replace(path)
        print(f"{min(first + KEEP, rigs)} of {rigs} rigs, {len(rows)} sets", flush=True)
    return len(rows)
