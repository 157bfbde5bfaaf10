"""Conversion of arguments that are not arrays of float64 in C order."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def given(**options: Any) -> dict[str, Any]:
    """The options that are not None; the compiled module has defaults for the others."""
    return {name: value for name, value in options.items() if value is not None}


def numbers(name: str, value: Any) -> NDArray[np.float64]:
    """An argument as an aligned array of float64 in C order; raises a TypeError that names it if it is not numeric."""
    if hasattr(value, "__dlpack__") and not hasattr(value, "__array__"):
        value = np.from_dlpack(value)
    try:
        array = np.asarray(value)
    except ValueError as error:
        raise ValueError(f"{name} is not an array: {error}") from None
    if array.dtype.kind not in "biuf":
        raise TypeError(f"{name} holds {array.dtype}, expected numbers that float64 can hold")
    return np.require(array, dtype=np.float64, requirements=["C", "A"])
