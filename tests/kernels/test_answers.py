"""numba's answers that are kept are those that it gives, and it has its own functions back afterwards."""

from __future__ import annotations

import operator
from typing import Any

import pytest
from numba.core import base, types
from numba.core.errors import TypingError
from numba.core.registry import cpu_target

from amorsim.kernels import answers
from amorsim.kernels.answers import kept_answers
from amorsim.kernels.compile import part

INT: Any = types.int64
FLOAT: Any = types.float64


def test_answers_are_numbas_and_asked_for_once(monkeypatch: pytest.MonkeyPatch) -> None:
    typing, target = cpu_target.typing_context, cpu_target.target_context
    typing.refresh()
    target.refresh()
    add: Any = typing.resolve_value_type(operator.add)
    before = types.Function.get_call_type, base._has_loc
    own = [add.get_call_type(typing, pair, {}) for pair in ((INT, INT), (INT, FLOAT), (FLOAT, FLOAT))]
    asked: list[tuple[Any, ...]] = []

    def ask(function: Any, context: Any, args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
        asked.append(args)
        return before[0](function, context, args, kws)

    monkeypatch.setattr(answers, "_get_call_type", ask)
    monkeypatch.setattr(answers, "_call_types", {})
    with kept_answers(target):
        for _ in range(3):
            kept = [add.get_call_type(typing, pair, {}) for pair in ((INT, INT), (INT, FLOAT), (FLOAT, FLOAT))]
            assert kept == own
        with pytest.raises(TypingError):
            add.get_call_type(typing, (types.none, FLOAT), {})
        with pytest.raises(TypingError):  # what has no answer may get one
            add.get_call_type(typing, (types.none, FLOAT), {})
    assert asked[:3] == [(INT, INT), (INT, FLOAT), (FLOAT, FLOAT)]
    assert len(asked) == 5
    assert (types.Function.get_call_type, base._has_loc) == before
    assert "get_abi_sizeof" not in vars(target)


@part
def _scaled(value: float, power: int) -> float:
    return value * 10.0**power


def test_a_part_is_compiled_once_for_a_constant_and_a_number() -> None:
    made = _scaled._part  # type: ignore[attr-defined]
    for power in (types.literal(2), INT, types.literal(3)):
        template, _, args, _ = made.get_call_template((FLOAT, power), {})
        assert args == (FLOAT, INT)
        assert [case.args for case in template.cases] == [(FLOAT, INT)]
    assert len(made.signatures) == 1
