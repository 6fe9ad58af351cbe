"""What a diagnosis leaves for other programs: `diagnosis.json` and `model.json`."""

import json
from pathlib import Path
from typing import Any

from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.diagnosis.document import document
from acf_jax.diagnosis.model_file import gap_model, write_model
from acf_jax.files import write_text


def write_results(folder: Path, diagnosis: Diagnosis) -> dict[str, Any]:
    """Write both files into `folder`; returns the content of `diagnosis.json`."""
    content = document(diagnosis)
    write_text(folder / "model.json", write_model(gap_model(diagnosis)))
    write_text(folder / "diagnosis.json", json.dumps(content, indent=1) + "\n")
    return content
