"""The model for controllers that run no Python."""

from pathlib import Path


def peak_header() -> str:
    """The exact peak force as a C99 header that needs nothing but math.h."""
    return (Path(__file__).parent / "acf_peak.h").read_text("utf-8")
