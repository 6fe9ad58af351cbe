"""One script a public repository: where its copy lies, and the sets that it gives."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from benchmarks.measured.recorded import MeasuredSet
from benchmarks.measured.rigs import amh, cognifly, cone, jku, pads, pcb_beam, pcb_disc


@dataclass(frozen=True)
class Rig:
    """A public repository, the commit that was read, and the script that builds sets from its copy."""

    name: str
    repository: str  # owner/name on GitHub; its copy is a folder called name
    commit: str
    build: Callable[[Path], Iterator[MeasuredSet]]

    @property
    def folder(self) -> str:
        return self.repository.split("/")[1]


RIGS = (
    Rig("jku", "JKU-Linz-Institute-of-Robotics/ur10e_force_control_comparison", "3b9b1b2", jku.sets),
    Rig("cognifly", "thecognifly/CrashLandingExperiments", "e533d8a", cognifly.sets),
    Rig("pads", "cytronicoder/spongebobs-corpse", "6e3f124", pads.sets),
    Rig(
        "pcb_disc", "High-Rate-SHM-Working-Group/Dataset-5-Extended-Impact-Testing", "1bbfcf1", pcb_disc.sets
    ),
    Rig(
        "pcb_beam", "High-Rate-SHM-Working-Group/Dataset-5-Extended-Impact-Testing", "1bbfcf1", pcb_beam.sets
    ),
    Rig("cone", "Illimited-Lab/TwoBodyConeImpactData", "375a4ff", cone.sets),
    Rig("amh", "VanJim/AMH-ISMA", "74623dc", amh.sets),
)
