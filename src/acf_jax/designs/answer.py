"""The answer to a design's question by a model, and what of the question that model cannot answer."""

from acf_jax.contact.ended import ended
from acf_jax.contact.model import ContactModel
from acf_jax.contact.peak import RIG, Learned
from acf_jax.contact.read import learnt_range, possible_fault, zeta_span
from acf_jax.contact.stop import ending_conflict
from acf_jax.designs.chance import draws_fault
from acf_jax.designs.config import IMPACT, Config, Question, Span
from acf_jax.designs.remedy import Infeasible
from acf_jax.designs.solve import Design, design
from acf_jax.designs.task import make_task


def answer(config: Config, model: ContactModel) -> Design | Infeasible:
    """What `design` finds within the configuration's ranges.

    **Raises:** `TooLittleData` where the diagnosis behind the model could not answer.
    """
    model.check_carried()
    ranges = {name: (r.low, r.high) for name, r in config.ranges().items()}
    fixed = {name: value for name in IMPACT if isinstance(value := getattr(config, name), float)}
    if (ending := config.ending.ending()).is_known:
        model = ended(model, ending)
    task = make_task(model, ranges, fixed, config.goal, config.limit, config.probability)
    return design(task, config.starts, config.draws, config.seed)


def model_faults(where: object, question: Question, model: ContactModel) -> list[str]:
    """Ranges, numbers of draws and endings that the model does not allow; each fault begins with `where`."""
    return _range_faults(where, question, model) + _config_faults(where, question.config, model)


def _config_faults(where: object, config: Config | None, model: ContactModel) -> list[str]:
    """What is wrong with the number of draws and the ending, once all else is sound."""
    if config is None:
        return []
    found = {
        "draws": draws_fault(model, config.probability, config.draws),
        "ending": ending_conflict(model, config.ending.ending(), 0.0),  # too far a travel has remedies
    }
    return [f"{where}: {name}: {fault}" for name, fault in found.items() if fault]


def _range_faults(where: object, question: Question, model: ContactModel) -> list[str]:
    """Names that the model does not know, and ranges that its effects or a surrogate do not allow."""
    faults = [
        f"{where}: free.{name}: is not a parameter of the model; known are {', '.join(model.names[:-2])}"
        for name in question.names("free")
        if name not in model.names
    ]
    spans = {name: span for name, span in question.spans().items() if name in model.names}
    for name, (low, high) in spans.items():
        if fault := possible_fault(model, name, (low, high)):
            faults.append(f"{where}: free.{name}: {low:g} to {high:g} {fault}")
    return faults + _unlearnt(where, spans, model)


def _unlearnt(where: object, spans: dict[str, Span], model: ContactModel) -> list[str]:
    """Ranges and values that a surrogate was not trained for."""
    remedy = "name the diagnosis' model.json as model"
    asked = dict(spans)
    if isinstance(model.main.peak, Learned):
        remedy = "leave out `surrogate`"
        values = dict(zip(RIG, model.main.theta.tolist(), strict=True))
        asked = {name: (x, x) for name, x in values.items()} | asked | {"zeta": zeta_span(model, spans)}
    faults = []
    for name, (low, high) in asked.items():
        known = learnt_range(model, name)
        if known is None or (known[0] <= low and high <= known[1]):
            continue
        learnt = f"the surrogate's {known[0]:g} to {known[1]:g}"
        faults.append(
            f"{where}: {name}: {low:g} to {high:g} leaves {learnt}; narrow it, or {remedy}"
            if low < high
            else f"{where}: {name}: {low:g} lies outside {learnt}; {remedy}"
        )
    return faults
