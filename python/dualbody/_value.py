"""Values with arrays among their fields."""

from __future__ import annotations

from dataclasses import fields
from typing import Any


class Value:
    """Equality of dataclasses (those with eq=False) that may hold arrays, in fields or in their lists. Numbers that are not numbers are equal to each other."""

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and _same(*map(_fields, (self, other)))

    def __hash__(self) -> int:
        return hash(_fields(self))


def _fields(of: Any) -> tuple[Any, ...]:
    return tuple(getattr(of, own.name) for own in fields(of))


def _same(a: Any, b: Any) -> bool:
    if hasattr(a, "__array__") or hasattr(b, "__array__"):
        import numpy as np

        a, b = np.asarray(a), np.asarray(b)
        return np.array_equal(a, b, equal_nan=a.dtype.kind in "fc" and b.dtype.kind in "fc")
    if isinstance(a, (list, tuple)) and type(a) is type(b):
        return len(a) == len(b) and all(map(_same, a, b))
    return bool(a == b)
