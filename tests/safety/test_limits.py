"""Limits: the shipped table, a user's own, and the standard's formula at its worked values."""

from pathlib import Path

import pytest

from acf_jax.errors import InputError
from acf_jax.safety import standard
from acf_jax.safety.limits import SHIPPED, read_limits


def test_shipped_table_holds_the_standards_29_areas() -> None:
    limits = read_limits()
    assert len(limits.areas) == 29
    (chest,) = limits.find("Sternum")
    assert (chest.force, chest.pressure, chest.stiffness, chest.mass) == (140, 120, 25e3, 40)
    assert {a.region for a in limits.areas if not a.is_permissible} == {"Skull and forehead", "Face"}


def test_a_name_means_every_area_that_it_can_mean_within_one_region() -> None:
    limits = read_limits()
    assert [a.name for a in limits.find("22")] == ["Palm (dominant side)"]
    assert {a.pressure for a in limits.find("palm")} == {260}
    hand = limits.find("hands and fingers")
    assert len(hand) == 9 and limits.find("hand") == hand
    assert {a.name for a in limits.find("thigh")} == {"Thigh muscle", "Kneecap"}
    with pytest.raises(InputError, match="did you mean 'Kneecap'"):
        limits.find("kneecup")
    for name in ("f", "t", ""):
        with pytest.raises(InputError, match="known are"):
            limits.find(name)
    for name, other in (("back", "Back of the hand"), ("arm", "Upper arms"), ("lower", "Lower legs")):
        with pytest.raises(InputError, match=f"can mean.*{other}"):
            limits.find(name)
    with pytest.raises(InputError, match="never permissible"):
        limits.find("head")


def test_speed_formula_at_the_standards_values() -> None:
    mass = standard.robot_mass(21.735, 6.86)
    assert mass == pytest.approx(17.73, abs=0.005)
    assert standard.highest_speed(280, 75e3, 0.6, mass) == pytest.approx(1.34, abs=0.005)
    assert standard.highest_speed(220, 10e3, 40, mass) == pytest.approx(0.63, abs=0.005)


HEADER = SHIPPED.read_text().splitlines()[0]


@pytest.mark.parametrize(
    "row",
    [
        "Face,Masticatory muscle,65,110,2,2,75,4.4,3,,,",
        "Chest,Masticatory muscle,65,110,2,2,75,4.4,,,,",
        "Face,Augapfel,600,110,2,2,75,4.4,,,,",
        "skull  and FOREHEAD,he ad,130,130,2,2,150,4.4,,,,",
        "Face,Sternum,130,130,2,2,150,4.4,,,,",
        "Chest,Anything,65,110,2,2,75,4.4,2,,,",  # the number of the standard's temple
        ",Temple,65,110,2,2,75,4.4,,,,",
    ],
)
def test_own_limits_never_free_the_head(tmp_path: Path, row: str) -> None:
    own = tmp_path / "own.csv"
    own.write_text(f"{HEADER}\n{row}\nHands and fingers,Glove,140,190,2,2,75,0.6,99,,,\n")
    areas = read_limits(own).areas
    assert [a.is_permissible for a in areas] == [False, True]


@pytest.mark.parametrize("region", ["Kopf", "Head", "Other", "", "he ad", "Hands"])
def test_an_own_area_has_to_name_a_region_of_the_standard(tmp_path: Path, region: str) -> None:
    own = tmp_path / "own.csv"
    own.write_text(f"{HEADER}\n{region},Augapfel,600,190,2,2,75,0.6,,,,\n")
    with pytest.raises(InputError, match=r"row 2.*no region of ISO/TS 15066:2016; name the one.*Face"):
        read_limits(own)


def test_own_limits_are_compared_with_the_standards(tmp_path: Path) -> None:
    own = tmp_path / "own.csv"
    own.write_text(
        f"{HEADER}\nThighs and knees,Kneecap,200,200,2,1.5,50,75,,,,\nLower legs,Shin pad,500,,2,,50,75,,,,\n"
        "Chest,Sternum,150,,2,,25,40,,,,\n"
    )
    lower, new, above = (a.caution for a in read_limits(own).areas)
    assert lower == "" and "no area of ISO/TS 15066" in new
    for part in ("150 for 140 N clamped", "300 for 280 N transient", "no limit for 120 N/cm^2 clamped"):
        assert part in above


def test_every_fault_of_own_limits_is_listed(tmp_path: Path) -> None:
    own = tmp_path / "own.csv"
    own.write_text(f"{HEADER}\nChest,Palm,strong,1,2,2,75,0.6,,,,\nChest,,140,1,2,2,-75,0.6,,,,\n")
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
    own.write_text(f"{HEADER}\nChest,Palm,140,1,2,2,75,0.6,,,,\nChest,palm,140,1,2,2,75,0.6,,,,\n")
    with pytest.raises(InputError, match="2 times"):
        read_limits(own)
    own.write_text(f"{HEADER}\nChest,Palm,140000,1900,20,200,75000,600,,,,\n")
    with pytest.raises(InputError) as caught:
        read_limits(own)
    assert len(caught.value.faults) == 6, "six values in another unit"
