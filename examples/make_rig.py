"""Writes examples/rig, the data set of the documentation: `python -m examples.make_rig`.

The files that lie here were made before 2026-11-25. Since then a delay of all triggers is drawn too, so that the
same seed makes another end stop and other traces.
"""

from pathlib import Path

from validation.worlds import make_case, write_case

if __name__ == "__main__":
    here = Path(__file__).parent
    case = make_case(6, ["end_stop"], size=0.1321629720564765, coloured=False)
    write_case(case, here / "rig", here / "rig_answer.yaml")
