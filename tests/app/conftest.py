"""One app for the tests of a file, over folders of its own."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.app.served import Served, served


@pytest.fixture(scope="module")
def app(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with served(tmp_path_factory.mktemp("sessions")) as running:
        yield running


@pytest.fixture(scope="session")
def wrong_sign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A table of eight contacts whose force is negative in contact."""
    from tests.recording.sessions import FEW, columns, made

    path = tmp_path_factory.mktemp("recordings") / "pressed.csv"
    values = columns(made(7, FEW, rate=4000.0))
    lines = ["time_s,force_n,velocity_m_per_s,pretension_n"]
    rows = zip(*values.values(), strict=True)
    lines += [f"{t:.6f},{-force:.4f},{v:.6f},{p:g}" for t, force, v, p in rows]
    path.write_text("\n".join([*lines, ""]))
    return path
