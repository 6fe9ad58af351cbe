"""What a recording offers, told by a process of its own: the server's memory does not grow with recordings.

python -m acf_jax.app.look list RECORDING [MAPPING]
python -m acf_jax.app.look signal RECORDING MAPPING NAME [FIELD]

Prints JSON: `faults`, and beside them what was found.
"""

import json
import subprocess
import sys
import threading
from contextlib import closing
from pathlib import Path
from typing import Any

from acf_jax.errors import InputError

BUSY = threading.Semaphore(2)  # recordings that are read at once
FIELDS = 64  # numbers of a message that are told
FOUND_S = 600.0  # in which a signal is read


def look(folder: Path, *arguments: str) -> dict[str, Any]:
    """The answer of this module's command, paths from `folder`; `faults` tells why there is none."""
    command = [sys.executable, "-P", "-m", "acf_jax.app.look", *arguments]
    with BUSY:
        try:
            done = subprocess.run(
                command, cwd=folder, capture_output=True, text=True, timeout=FOUND_S, stdin=subprocess.DEVNULL
            )
            answer: dict[str, Any] = json.loads(done.stdout)
        except subprocess.TimeoutExpired:
            return {"faults": [f"reading takes longer than {FOUND_S:g} s; go on without a preview"]}
        except ValueError:
            return {
                "faults": [
                    "the recording cannot be read: " + (done.stderr.strip().splitlines() or ["no answer"])[-1]
                ]
            }
    return answer


def listed(recording: Path, mapping: Path | None) -> dict[str, Any]:
    """The channels with their fields, and the candidates for each role."""
    from acf_jax.recording import read_mapping
    from acf_jax.recording.readers import open_recording

    stated = read_mapping(mapping, {})
    with closing(open_recording(recording, stated)) as opened:
        channels = [
            {"name": c.name, "type": c.type, "count": c.count, "fields": opened.numbers(c.name)[:FIELDS]}
            for c in opened.channels()
        ]
        candidates = {
            role: [
                {
                    "name": s.name,
                    "field": field_of(opened.described(s), s.name),
                    "is_position": opened.is_position(s),
                }
                for s in opened.candidates(role)
            ]
            for role in ("force", "velocity", "pretension")
        }
        return {"channels": channels, "candidates": candidates, "obstacles": opened.obstacles()}


def field_of(described: str, name: str) -> str | None:
    """The field that a signal without one stands for, as `described` tells it behind the topic."""
    return described.removeprefix(f"{name}:") if described.startswith(f"{name}:") else None


def signal(recording: Path, mapping: Path | None, name: str, field: str | None) -> dict[str, Any]:
    """One signal as a line through its least and largest samples."""
    import numpy as np

    from acf_jax.recording import Source, read_mapping
    from acf_jax.recording.clock import settle
    from acf_jax.recording.page import envelope
    from acf_jax.recording.readers import open_recording
    from acf_jax.recording.series import in_order
    from acf_jax.report.plot import series

    with closing(open_recording(recording, read_mapping(mapping, {}))) as opened:
        source = Source(name=name, field=field)
        read = opened.read({"it": source}, lambda done, total: None)["it"]
        found = in_order(settle(read, name), f"{recording} {opened.described(source)}")
    time, value = envelope(found, int(found.time[0]))
    return {
        "time": series(time, 9),
        "value": series(value, 6),
        "count": found.time.size,
        "seconds": float(found.time[-1] - found.time[0]) * 1e-9,
        "least": float(np.min(found.value)),
        "largest": float(np.max(found.value)),
        "median": float(np.median(found.value)),
        "notes": list(found.notes),
    }


def main(arguments: list[str]) -> None:
    what, recording, *rest = arguments
    mapping = Path(rest[0]) if rest and rest[0] else None
    try:
        if what == "list":
            found = listed(Path(recording), mapping)
        else:
            found = signal(Path(recording), mapping, rest[1], (rest[2] or None) if len(rest) > 2 else None)
        answer = {"faults": []} | found
    except InputError as error:
        answer = {"faults": error.faults}
    print(json.dumps(answer))


if __name__ == "__main__":
    main(sys.argv[1:])
