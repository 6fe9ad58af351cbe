from collections import Counter

from validation.blind.plan import WEAK, draw_plan
from validation.worlds import find_world


def test_a_plan_holds_the_shares_and_every_effect():
    worlds = [find_world("scipy")]
    library = set(worlds[0].causes("library"))
    plan = draw_plan(5, 200, worlds)
    assert plan == draw_plan(5, 200, worlds) != draw_plan(6, 200, worlds)
    assert Counter(order.kind for order in plan) == {
        "lifelike": 67, "none": 33, "single": 54, "pair": 13, "beyond": 20, "withheld": 13,
    }  # fmt: skip
    effects = {kind: [o.effects for o in plan if o.kind == kind] for kind in ("none", "pair", "beyond")}
    assert set(effects["none"]) == {()} and {len(names) for names in effects["pair"]} == {2}
    assert all(len(names) == 1 and not {*names} & library for names in effects["beyond"])
    single = [order for order in plan if order.kind == "single"]
    assert {order.effects[0] for order in single} == library
    assert 13 < sum(order.target < WEAK[1] for order in single) < 23
    assert all(order.without == (order.effects[0] if order.kind == "withheld" else "") for order in plan)


def test_lifelike_rigs_have_up_to_three_large_effects_or_a_foreign_one():
    (world,) = worlds = [find_world("scipy")]
    library = set(world.causes("library"))
    large = [o.effects for o in draw_plan(5, 200, worlds) if o.kind == "lifelike"]
    inside = [names for names in large if {*names} <= library]
    assert Counter(map(len, inside)) == {0: 13, 1: 21, 2: 13, 3: 7}
    assert [len(names) for names in large if names not in inside] == [1] * 13
    alone = Counter(names[0] for names in inside if len(names) == 1)
    assert set(alone) == library and max(alone.values()) - min(alone.values()) <= 1


def test_worlds_take_turns():
    plan = draw_plan(5, 9, [find_world("scipy"), find_world("scipy")])
    assert len(plan) == 9
    assert len({order.seed for order in plan}) == 9
