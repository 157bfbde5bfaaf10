"""How times are taken."""

from __future__ import annotations

import time
from collections.abc import Callable


def seconds(call: Callable[[], object]) -> float:
    """Seconds of a call."""
    begin = time.perf_counter()
    call()
    return time.perf_counter() - begin


def least(call: Callable[[], object], number: int, repeat: int = 2000) -> float:
    """Nanoseconds of a call: the least of many runs of so few calls that nothing else comes between."""

    def run() -> None:
        for _ in range(number):
            call()

    return min(seconds(run) for _ in range(repeat)) / number * 1e9
