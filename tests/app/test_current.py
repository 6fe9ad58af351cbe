"""Whether results of a session belong together."""

from pathlib import Path

from acf_jax.app.current import surrogate_of
from acf_jax.gap_model import read_model, write_model

EXAMPLES = Path(__file__).parents[2] / "examples"
SURROGATE = EXAMPLES / "rig_surrogate.eqx"


def test_a_surrogate_stands_for_the_model_that_it_was_trained_on_and_no_other(tmp_path: Path) -> None:
    model = read_model(EXAMPLES / "rig_model.json")
    same, other = tmp_path / "same.json", tmp_path / "other.json"
    same.write_text(
        write_model(model)
    )  # which leaves out what is not there, and the surrogate writes as null
    other.write_text(write_model(model.model_copy(update={"description": "another flange"})))
    assert surrogate_of(same, SURROGATE)
    assert surrogate_of(other, SURROGATE) is None
    assert surrogate_of(same, tmp_path / "none.eqx") is None
