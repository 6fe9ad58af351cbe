"""Limits: the shipped table, a user's own, and the standard's formula at its worked values."""

from pathlib import Path

import pytest

from acf_jax.errors import InputError
from acf_jax.safety import standard
from acf_jax.safety.limits import SHIPPED, read_limits


def test_shipped_table_holds_the_standards_29_areas() -> None:
    limits = read_limits()
    assert len(limits.areas) == 29
    chest = limits.find("Sternum")
    assert (chest.force, chest.pressure, chest.stiffness, chest.mass) == (140, 120, 25e3, 40)
    assert {a.region for a in limits.areas if not a.is_permissible} == {"Skull and forehead", "Face"}


def test_areas_are_found_by_number_name_and_region_and_the_strictest_is_meant() -> None:
    limits = read_limits()
    assert limits.find("22").name == "Palm (dominant side)"
    assert limits.find("palm").region == "Hands and fingers"
    assert limits.find("hands and fingers").pressure == 190  # back of the hand, non-dominant side
    assert limits.find("chest").pressure == 120
    with pytest.raises(InputError, match="did you mean 'Kneecap'"):
        limits.find("kneecup")


def test_speed_formula_at_the_standards_values() -> None:
    mass = standard.robot_mass(21.735, 6.86)
    assert mass == pytest.approx(17.73, abs=0.005)
    assert standard.highest_speed(280, 75e3, 0.6, mass) == pytest.approx(1.34, abs=0.005)
    assert standard.highest_speed(220, 10e3, 40, mass) == pytest.approx(0.63, abs=0.005)


def test_own_limits_replace_the_standards_but_never_free_the_head(tmp_path: Path) -> None:
    text = SHIPPED.read_text()
    own = tmp_path / "own.csv"
    own.write_text(text.replace("Face,Masticatory muscle,65,110,,,", "Face,Masticatory muscle,65,110,2,2,"))
    assert not read_limits(own).find("Masticatory muscle").is_permissible


def test_every_fault_of_own_limits_is_listed(tmp_path: Path) -> None:
    header = SHIPPED.read_text().splitlines()[0]
    own = tmp_path / "own.csv"
    own.write_text(f"{header}\nHand,Palm,strong,1,2,2,75,0.6,1,,,\nHand,,140,1,2,2,-75,0.6,1,,,\n")
    with pytest.raises(InputError) as caught:
        read_limits(own)
    faults = "\n".join(caught.value.faults)
    for part in (
        "row 2",
        "quasi_static_force_n",
        "row 3",
        "specific_location is empty",
        "spring_constant_n_mm",
    ):
        assert part in faults
    own.write_text(f"{header}\nHand,Palm,140,1,2,2,75,0.6,1,,,\nHand,palm,140,1,2,2,75,0.6,1,,,\n")
    with pytest.raises(InputError, match="2 times"):
        read_limits(own)
