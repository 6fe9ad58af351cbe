"""What trials of one condition do not share: no model can predict it."""

import numpy as np

from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.diagnosis.spectrum import spectrum
from acf_jax.inference.ring import Ring
from acf_jax.report.markup import Html, element
from acf_jax.report.plot import LINES, Variant, axis, plot, series
from acf_jax.report.words import listed, si

MODELS = ("recalibrated", "corrected")


def in_words(diagnosis: Diagnosis) -> Html | None:
    """The rings; None where there are none."""
    rings = diagnosis.observations.rings
    if not rings:
        return None
    return element(
        "p",
        f"Each trial rings with a size and a phase of its own: {listed([said(ring) for ring in rings])}. No model of"
        " the contact predicts that; it counts as noise. A stiffer fixture under the sensor, or a sensor nearer to the"
        " contact, makes it smaller.",
    )


def said(ring: Ring) -> str:
    """A ring in words."""
    size = f"about {si(ring.size, 2, 'N')} at first contact"
    grows = ", the more the harder the impact" if ring.power else ""
    return f"{size} at {ring.frequency:.3g} Hz, gone after {si(1e3 * 3 * ring.decay, 2, 'ms')}{grows}"


def by_frequency(diagnosis: Diagnosis) -> Html | None:
    """The gap by frequency, and what repeats of a condition do not share; None without traces."""
    d = diagnosis
    found = spectrum(d.observations, {name: d.held[name].residual for name in MODELS})
    if found is None:
        return None
    x = series(np.repeat(found.edges, 2)[1:-1], 4)

    def steps(values: np.ndarray, name: str, **line: object) -> dict[str, object]:
        return {
            "type": "scatter", "mode": "lines", "x": x, "y": series(np.repeat(values, 2), 3), "name": name,
            "line": line, "hovertemplate": "%{x:.3g} Hz: %{y:.3g} N<extra>" + name + "</extra>",
        }  # fmt: skip

    data = [steps(found.gap[name], name, **LINES[name]) for name in MODELS]
    if found.scatter is not None:
        data.append(steps(found.scatter, "scatter of repeats", color="--measured", dash="dash", width=2))
    layout = {
        "xaxis": axis("frequency / Hz", type="log"),
        "yaxis": axis("RMS force in a third of an octave / N", rangemode="tozero"),
        "showlegend": True,
    }
    what = "What the models miss on conditions that the fit did not see"
    floor = (
        ", and what trials of one condition do not share: where the two meet, no model can do better."
        if found.scatter is not None
        else ". No condition has repeats; repeats would show what no model can predict."
    )
    return plot("spectrum", "By frequency", what + floor, [Variant("", data)], layout, 300)
