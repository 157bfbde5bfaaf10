"""Conversion of arguments that are not arrays of float64 in C order."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def given(arguments: dict[str, Any], *but: str) -> dict[str, Any]:
    """The options among the arguments of a function: all but some, and but None, for which the compiled module has its defaults."""
    return {name: value for name, value in arguments.items() if value is not None and name not in but}


def numbers(name: str, value: Any) -> NDArray[np.float64]:
    """An argument as an aligned array of float64 in C order; an error names it if it is not numeric, or is masked."""
    if hasattr(value, "__dlpack__") and not hasattr(value, "__array__"):
        value = np.from_dlpack(value)
    try:
        array = np.asarray(value)
    except ValueError as error:
        raise ValueError(f"{name} is not an array: {error}") from None
    if array.dtype.kind == "O" and array.ndim == 0:
        raise TypeError(f"{name} is of the type {type(value).__name__}, expected an array of numbers")
    if array.dtype.kind not in "biuf":
        raise TypeError(f"{name} holds {array.dtype}, expected numbers that float64 can hold")
    if np.ma.is_masked(value):
        raise ValueError(f"{name} has masked entries, expected numbers: `filled` replaces them")
    return np.require(array, dtype=np.float64, requirements=["C", "A"])
