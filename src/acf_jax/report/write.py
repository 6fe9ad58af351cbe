"""`report.html`: placeholder page until the report is built."""

import html
import json
from pathlib import Path
from typing import Any

from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.files import write_text


def write_report(path: Path, diagnosis: Diagnosis, content: dict[str, Any]) -> None:
    """Write the page."""
    write_text(path, f"<!doctype html><pre>{html.escape(json.dumps(content, indent=1))}</pre>")
