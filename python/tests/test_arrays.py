"""Shapes, strides, types; wrong ones."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import SAME_ALGEBRA
from hypothesis import given, settings
from hypothesis import strategies as st

import dualbody as db

ARM = db.samples.arm()
TREE = db.samples.random_tree(9, 3)
NV, NQ = ARM.nv, ARM.nq

batches = st.lists(st.integers(0, 5), max_size=3).map(tuple) | st.sampled_from([(70,), (9, 11), (200,)])
dtypes = st.sampled_from([np.float64, np.float32, np.int64, np.int8, np.uint16, np.bool_, ">f8", np.float16])
layouts = st.sampled_from(["C", "F", "strided", "reversed", "unaligned", "read-only", "list"])


def laid_out(x: np.ndarray, layout: str) -> object:
    """The same numbers in memory in another way."""
    if layout == "F":
        return np.asfortranarray(x)
    if layout == "strided":
        wide = np.zeros((*x.shape[:-1], 2 * x.shape[-1]), x.dtype)
        wide[..., ::2] = x
        return wide[..., ::2]
    if layout == "reversed":
        return np.ascontiguousarray(x[..., ::-1])[..., ::-1]
    if layout == "unaligned":
        raw = np.zeros(x.nbytes + 1, np.uint8)[1:].view(np.uint8)
        out = np.frombuffer(raw.data, dtype=x.dtype).reshape(x.shape) if x.nbytes else x.copy()
        if x.nbytes:
            out[...] = x
        return out
    if layout == "read-only":
        x = x.copy()
        x.flags.writeable = False
        return x
    return x.tolist() if layout == "list" and x.size else x


def random(seed: int, batch: tuple[int, ...], n: int, dtype: object) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-2, 2, (*batch, n)).astype(dtype)


def one_by_one(f, *arrays: np.ndarray) -> np.ndarray:  # type: ignore[no-untyped-def]
    batch = arrays[0].shape[:-1]
    rows = [f(*(np.asarray(a[i], np.float64).copy() for a in arrays)) for i in np.ndindex(batch)]
    return np.array(rows).reshape((*batch, *np.shape(f(*(np.zeros(a.shape[-1]) for a in arrays)))))


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32), batches, dtypes, layouts)
def test_batches_in_any_layout_equal_single_states(seed: int, batch: tuple[int, ...], dtype: object, layout: str) -> None:
    q, v, a = (random(seed + k, batch, NV, dtype) for k in range(3))
    functions = {
        "inverse_dynamics": (q, v, a),
        "forward_dynamics": (q, v, a),
        "bias_forces": (q, v),
        "mass_matrix": (q,),
        "coriolis_matrix": (q, v),
        "kinetic_energy": (q, v),
        "center_of_mass": (q,),
    }
    for name, arrays in functions.items():
        function = getattr(db, name)
        actual = function(ARM, *(laid_out(x, layout) for x in arrays))
        expected = one_by_one(lambda *x: function(ARM, *x), *arrays)
        assert actual.shape == expected.shape, name
        assert actual.dtype == np.float64
        scale = max(1.0, np.abs(expected).max(initial=0.0))
        np.testing.assert_allclose(actual, expected, rtol=0, atol=1e3 * SAME_ALGEBRA * scale, err_msg=name)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32), st.sampled_from([(), (1,), (3,), (2, 5), (100,)]))
def test_arguments_without_a_batch_are_used_for_all(seed: int, batch: tuple[int, ...]) -> None:
    q, v, a = random(seed, batch, NV, float), random(seed + 1, (), NV, float), random(seed + 2, (), NV, float)
    together = db.inverse_dynamics(ARM, q, v, a)
    spread = db.inverse_dynamics(ARM, q, np.broadcast_to(v, q.shape), np.broadcast_to(a, q.shape))
    assert together.shape == q.shape
    np.testing.assert_array_equal(together, spread)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32), st.sampled_from([(), (1,), (4,), (3, 4), (80,)]))
def test_a_random_tree_in_batches_equals_single_states(seed: int, batch: tuple[int, ...]) -> None:
    count = int(np.prod(batch))
    q = np.array([TREE.random_configuration(seed % 2**31 + k) for k in range(count)]).reshape((*batch, TREE.nq))
    v, a = random(seed, batch, TREE.nv, float), random(seed + 1, batch, TREE.nv, float)
    tau = db.inverse_dynamics(TREE, q, v, a)
    back = db.forward_dynamics(TREE, q, v, tau)
    np.testing.assert_allclose(back, a, atol=1e-7)
    rows = (x.reshape(count, -1) for x in (q, v, a, tau))
    for qi, vi, ai, taui in zip(*rows, strict=True):
        np.testing.assert_allclose(db.inverse_dynamics(TREE, qi, vi, ai), taui, atol=1e-9 * max(1, np.abs(taui).max()))


def test_out_is_the_result() -> None:
    q, v, a = (random(k, (90,), NV, float) for k in range(3))
    out = np.empty((90, NV))
    assert db.inverse_dynamics(ARM, q, v, a, out=out) is out
    np.testing.assert_array_equal(out, db.inverse_dynamics(ARM, q, v, a))
    matrix = np.empty((NV, NV))
    assert db.mass_matrix(ARM, q[0], out=matrix) is matrix
    np.testing.assert_array_equal(matrix, db.mass_matrix(ARM, q[0]))


def test_arrays_go_in_and_out_by_dlpack() -> None:
    class Tensor:
        """An array of another library that offers DLPack only."""

        def __init__(self, x: np.ndarray) -> None:
            self.x = x

        def __dlpack__(self, **keywords: object) -> object:
            return self.x.__dlpack__(**keywords)  # type: ignore[arg-type]

        def __dlpack_device__(self) -> object:
            return self.x.__dlpack_device__()

    q = random(0, (3,), NV, float)
    expected = db.gravity_forces(ARM, q)
    np.testing.assert_array_equal(db.gravity_forces(ARM, Tensor(q)), expected)
    np.testing.assert_array_equal(np.from_dlpack(Tensor(db.gravity_forces(ARM, q))), expected)  # type: ignore[arg-type]


def test_results_are_new_arrays_that_own_their_numbers() -> None:
    tau = db.gravity_forces(ARM, np.zeros(NV))
    assert tau.flags.owndata and tau.flags.writeable
    before = tau.copy()
    db.gravity_forces(ARM, np.ones(NV))
    np.testing.assert_array_equal(tau, before)


zeros = np.zeros(NV)


@pytest.mark.parametrize(
    ("call", "error", "text"),
    [
        (lambda: db.inverse_dynamics(ARM, zeros[:-1], zeros, zeros), ValueError, r"q has the shape \[6\], expected \(…, 7\)"),
        (lambda: db.inverse_dynamics(ARM, zeros, zeros, 1.0), ValueError, r"a has the shape \[\]"),
        (lambda: db.inverse_dynamics(ARM, np.zeros((2, 7)), np.zeros((3, 7)), zeros), ValueError, r"v is a batch of shape \[3\], q one of shape \[2\]"),
        (lambda: db.inverse_dynamics(ARM, zeros, "seven", zeros), TypeError, "^v holds"),
        (lambda: db.inverse_dynamics(ARM, zeros, zeros, [None] * 7), TypeError, "^a holds object"),
        (lambda: db.inverse_dynamics(ARM, zeros + 1j, zeros, zeros), TypeError, "^q holds complex128"),
        (lambda: db.inverse_dynamics(ARM, [[1.0], [1.0, 2.0]], zeros, zeros), ValueError, "^q is not an array"),
        (lambda: db.inverse_dynamics("arm", zeros, zeros, zeros), TypeError, "model"),
        (lambda: db.inverse_dynamics(ARM, zeros, zeros), TypeError, "a"),
        (lambda: db.inverse_dynamics(ARM, zeros, zeros, zeros, external=np.zeros((3, 6))), ValueError, "^external has the shape"),
        (lambda: db.mass_matrix(ARM, zeros, out=np.zeros(7)), ValueError, r"^out has the shape \[7\], expected \[7, 7\]"),
        (lambda: db.mass_matrix(ARM, zeros, out=np.zeros((7, 7), np.float32)), TypeError, "^out is not an array of numpy.float64"),
        (lambda: db.mass_matrix(ARM, zeros, out=np.zeros((7, 7)).T[::-1]), ValueError, "^out is not a writeable array"),
        (lambda: db.gravity_forces(ARM, zeros, out=zeros), ValueError, "^out overlaps"),
        (lambda: db.frame_pose(ARM, zeros, "hand"), KeyError, "hand"),
        (lambda: db.frame_jacobian(ARM, zeros, ARM.frame_names[0], representation="world"), ValueError, "representation is \"world\""),
        (lambda: db.momentum(ARM, zeros, zeros, "center"), ValueError, "frame is \"center\""),
        (lambda: ARM.joint_q("elbow!"), KeyError, "elbow!"),
        (lambda: ARM.integrate(zeros, zeros[:3]), ValueError, "^dv has the shape"),
        (lambda: db.Model.from_urdf("<robot/>"), ValueError, "robot"),
        (lambda: db.Model.from_urdf("/nowhere/robot.urdf"), FileNotFoundError, "/nowhere/robot.urdf"),
        (lambda: db.Model.from_urdf("<robot", base="fixed"), ValueError, "XML"),
        (lambda: db.Model.from_urdf(7), TypeError, "description"),
        (lambda: db.Model.from_urdf("x.urdf", base="flying"), ValueError, "base is \"flying\""),
        (lambda: db.Model.from_urdf("x.urdf", bass="fixed"), TypeError, "bass"),
        (lambda: db.Model.from_urdf("x.urdf", gravity=3), TypeError, "gravity"),
    ],
)
def test_wrong_arguments_are_errors_that_name_them(call, error, text) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(error, match=text):
        call()


def test_a_singular_mass_matrix_is_an_error_that_names_the_joint() -> None:
    builder = db.ModelBuilder("light", base="fixed")
    builder.add_link(db.LinkSpec("world")).add_link(db.LinkSpec("arm"))
    builder.add_joint(db.JointSpec("hinge", "revolute", "world", "arm"))
    model = builder.build()
    with pytest.raises(ValueError, match="hinge"):
        db.forward_dynamics(model, [0.0], [0.0], [0.0])
    with pytest.raises(ValueError, match="hinge"):
        db.Simulator(model)
