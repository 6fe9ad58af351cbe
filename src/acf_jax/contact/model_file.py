"""The model that `peak`, `design`, `speed` and `check` work with: a rig, a diagnosis, or a surrogate of one."""

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from acf_jax.documents import parse_json
from acf_jax.errors import InputError
from acf_jax.files import read_bytes, read_json_mapping, text_of

if TYPE_CHECKING:
    from acf_jax.contact.model import ContactModel
    from acf_jax.gap_model import GapModel
    from acf_jax.surrogate import CorrectedSurrogate

RIG = ("m", "d", "k_f", "k_c")
IMPACT = ("v_e", "f_p")
HELP = "A rig's YAML file, a diagnosis' folder or model.json, or a model.eqx trained on one."
TRAINED = "acf-jax corrected surrogate 1"


def model_path(path: Path) -> Path:
    """The model.json of a diagnosis' folder; any other path as it is.

    **Raises:** `InputError` for the folder of a data set, which is not diagnosed yet.
    """
    if not path.is_dir():
        return path
    found = path / "model.json"
    if not found.exists() and (path / "dataset.yaml").exists():
        raise InputError(
            f"{path}: is a data set without a diagnosis; `diagnose` it, and name the folder of --out"
        )
    return found


class ModelFile:
    """A model file whose form has been checked; `load` needs JAX, this does not."""

    def __init__(
        self, path: Path, relative_std: Mapping[str, float] | None = None, surrogate: Path | None = None
    ):
        self.path, self.surrogate = model_path(path), surrogate
        self.rig: dict[str, float] = {}
        self.stds: dict[str, float] = {}  # of the rig's values
        self.relative_std = dict(relative_std or {})
        self.tried: tuple[tuple[float, float], tuple[float, float]] | None = None  # of v_e and of f_p
        faults: list[str] = []
        if self.is_diagnosis:
            faults += self._check_trained() if self.is_trained else self._check_json()
            faults += [
                f"relative_std.{name}: of a diagnosis only v_e and f_p are free to give; its fit tells the rest"
                for name in self.relative_std
                if name not in IMPACT
            ]
            if surrogate is not None:
                faults.append(
                    f"{surrogate}: a surrogate stands for the paper's model; name a rig's YAML file as model"
                )
        else:
            faults += self._read_rig()
        if surrogate is not None and str(surrogate) != "shipped" and not surrogate.is_file():
            faults.append(f"{surrogate}: no such file; name a model.eqx that train.fit wrote, or `shipped`")
        if faults:
            raise InputError(faults)

    @property
    def is_diagnosis(self) -> bool:
        """Whether the file holds a diagnosis' model rather than a rig's four values."""
        return self.path.suffix.lower() in (".json", ".eqx")

    @property
    def is_trained(self) -> bool:
        """Whether the file is a surrogate, which carries the diagnosis' model that it stands for."""
        return self.path.suffix.lower() == ".eqx"

    def load(self) -> "ContactModel":
        """The model, a surrogate in place of the simulation where the file is one; JAX must have been started."""
        from acf_jax.contact.read import by_surrogate

        model, trained = self.load_exact()
        return model if trained is None else by_surrogate(model, trained)

    def load_exact(self) -> "tuple[ContactModel, CorrectedSurrogate | None]":
        """The model without its surrogate, and the surrogate beside it."""
        from acf_jax.contact.read import of_diagnosis, of_rig

        gap, trained = self.load_gap()
        if gap is not None:
            return of_diagnosis(gap, self.relative_std, str(self.path)), trained
        from acf_jax.dataset.tried import Tried

        surrogate, tried = None, Tried(*self.tried) if self.tried else None
        if self.surrogate is not None:
            from acf_jax.surrogate import load_surrogate

            surrogate = load_surrogate(None if str(self.surrogate) == "shipped" else self.surrogate)
        return of_rig(self.rig, self.relative_std, surrogate, tried, str(self.path), self.stds), None

    def load_gap(self) -> "tuple[GapModel | None, CorrectedSurrogate | None]":
        """What a diagnosis left, and the surrogate that was trained on it; of a rig's file neither."""
        from acf_jax.gap_model import check_model, read_model

        if self.is_trained:
            from acf_jax.surrogate import load_corrected

            trained, content = load_corrected(self.path)
            return check_model(self.path, content), trained
        return (read_model(self.path) if self.is_diagnosis else None), None

    def _check_trained(self) -> list[str]:
        """Of the header only; `load` reads the rest."""
        header: Any = None
        try:
            line = read_bytes(self.path).partition(b"\n")[0]
        except InputError as error:
            return error.faults
        with suppress(InputError):
            header = parse_json(text_of(line, self.path), self.path, "")
        if not isinstance(header, dict) or header.get("format") != TRAINED:
            return [
                f"{self.path}: is no surrogate of a corrected model; use a model.eqx that train.fit wrote with"
                " `labels`, or for the paper's model a rig's YAML file"
            ]
        if header.get("which") != "contact":
            return [f"{self.path}: has learnt the sensor's reading; train it with labels.force: contact"]
        return []

    def _check_json(self) -> list[str]:
        try:
            content = read_json_mapping(self.path, "use the model.json that `diagnose` wrote")
        except InputError as error:
            return error.faults
        if content.get("schema") != "acf-gap-model/1":
            return [
                f"{self.path}: its schema is not acf-gap-model/1; use the model.json that `diagnose` wrote"
            ]
        return []

    def _read_rig(self) -> list[str]:
        asked = [
            f"relative_std.{name}: is not a quantity of the model; known are {', '.join((*RIG, *IMPACT))}"
            for name in self.relative_std
            if name not in (*RIG, *IMPACT)
        ]
        from acf_jax.dataset.rig_file import read_whole_rig

        rig, faults = read_whole_rig(self.path)
        self.rig, self.stds, self.tried = rig.values, rig.stds, rig.tried
        self.relative_std = rig.relative_std | self.relative_std
        return faults + asked
