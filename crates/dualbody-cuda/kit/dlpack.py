"""Arrays of the GPU from Rust to CuPy and PyTorch and back, where they are installed, without a way over the host.

    python3 dlpack.py libkit_bridge.so
"""

import ctypes
import sys

ROWS, COUNT = 7, 1003
NAME = b"dltensor_versioned"

new_capsule = ctypes.pythonapi.PyCapsule_New
new_capsule.restype = ctypes.py_object
new_capsule.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p]
pointer_of = ctypes.pythonapi.PyCapsule_GetPointer
pointer_of.restype = ctypes.c_void_p
pointer_of.argtypes = [ctypes.py_object, ctypes.c_char_p]
rename = ctypes.pythonapi.PyCapsule_SetName
rename.argtypes = [ctypes.py_object, ctypes.c_char_p]
USED = ctypes.create_string_buffer(b"used_dltensor_versioned")
OWN = ctypes.create_string_buffer(NAME)


class Array:
    """An array of Rust's, as the protocol of DLPack in Python hands it on."""

    def __init__(self, bridge, bits):
        self.bridge, self.bits = bridge, bits

    def __dlpack_device__(self):
        return (2, 0)

    def __dlpack__(self, **_):
        made = self.bridge.kit_give(ROWS, COUNT, self.bits)
        if not made:
            raise RuntimeError("Rust gave no array")
        return new_capsule(made, ctypes.cast(OWN, ctypes.c_char_p), None)


def number(row, column):
    """Number of Rust's array, as kit_give writes it."""
    return row * COUNT + column + 0.5


def taken(bridge, tensor, bits):
    """The sum of all entries of a tensor, which Rust computes from its copy."""
    capsule = tensor.__dlpack__(max_version=(1, 0))
    raw = pointer_of(capsule, NAME)
    rename(capsule, ctypes.cast(USED, ctypes.c_char_p))
    return bridge.kit_take(raw, ROWS, COUNT, bits)


def check(name, bridge, bits, from_dlpack, doubled, wait):
    found = from_dlpack(Array(bridge, bits))
    assert tuple(found.shape) == (ROWS, COUNT), found.shape
    for row, column in [(0, 0), (3, 500), (ROWS - 1, COUNT - 1)]:
        assert float(found[row, column]) == number(row, column), (row, column)
    back = doubled(found)
    wait()
    total = sum(2 * number(r, c) for r in range(ROWS) for c in range(COUNT))
    assert taken(bridge, back, bits) == total
    # The memory is Rust's until the last view of it is gone.
    del found, back
    print(f"DLPack to and from {name}, f{bits}: right")


def main():
    bridge = ctypes.CDLL(sys.argv[1])
    bridge.kit_give.restype = ctypes.c_void_p
    bridge.kit_give.argtypes = [ctypes.c_size_t, ctypes.c_size_t, ctypes.c_int]
    bridge.kit_take.restype = ctypes.c_double
    bridge.kit_take.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_size_t, ctypes.c_int]
    wrong = 0
    for name in ["cupy", "torch"]:
        try:
            module = __import__(name)
        except ImportError:
            print(f"DLPack: {name} is not installed")
            continue
        wait = module.cuda.synchronize if name == "torch" else module.cuda.Device().synchronize
        for bits in [64, 32]:
            try:
                check(name, bridge, bits, module.from_dlpack, lambda x: x + x, wait)
            except Exception as error:
                wrong += 1
                print(f"FAILED: DLPack to and from {name}, f{bits}: {type(error).__name__}: {error}")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
