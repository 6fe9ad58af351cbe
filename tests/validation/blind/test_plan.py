from validation.blind.plan import WEAK, draw_plan
from validation.worlds import find_world


def kind(order, library):
    if order.without:
        return "withheld"
    if not order.effects:
        return "none"
    if len(order.effects) == 2:
        return "pair"
    return "single" if order.effects[0] in library else "beyond"


def test_a_plan_holds_the_shares_and_every_effect():
    worlds = [find_world("scipy")]
    library = set(worlds[0].causes("library"))
    plan = draw_plan(5, 200, worlds)
    assert plan == draw_plan(5, 200, worlds) != draw_plan(6, 200, worlds)
    kinds = [kind(order, library) for order in plan]
    assert {k: kinds.count(k) for k in set(kinds)} == {
        "none": 50, "single": 80, "pair": 20, "beyond": 30, "withheld": 20,
    }  # fmt: skip
    single = [order for order, k in zip(plan, kinds, strict=True) if k == "single"]
    assert {order.effects[0] for order in single} == library
    assert 20 < sum(order.target < WEAK[1] for order in single) < 34
    assert all(order.without == order.effects[0] for order in plan if order.without)


def test_worlds_take_turns():
    plan = draw_plan(5, 9, [find_world("scipy"), find_world("scipy")])
    assert len(plan) == 9
    assert len({order.seed for order in plan}) == 9
