"""Batches on a GPU beside the library's own; without a GPU, or without the feature, what the errors say."""

from __future__ import annotations

import importlib
import sys

import numpy as np
import pytest

import dualbody as db
from dualbody import _dualbody

POLE = db.Simulator(db.samples.cartpole(), time_step=0.01)
COUNT = 5
#: Roundings of 20 steps, which single precision and the GPU's own functions have besides.
DOUBLE, SINGLE = 1e-11, 1e-3

built = pytest.mark.skipif(not hasattr(_dualbody, "CudaSimulator"), reason="built without the feature `cuda`")


def states() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    x = np.random.default_rng(0).normal(size=(COUNT, 6))
    return x[:, :2], x[:, 2:4], x[:, 4:]


def on_gpu(**options):  # type: ignore[no-untyped-def]
    """A simulator on the GPU, where there is one."""
    from dualbody import cuda

    try:
        return cuda.Simulator(POLE, COUNT, **options)
    except OSError as error:
        pytest.skip(str(error))


def test_a_package_without_it_says_how_to_build_one_with_it(monkeypatch) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.delattr(_dualbody, "CudaSimulator", raising=False)
    monkeypatch.delitem(sys.modules, "dualbody.cuda", raising=False)
    with pytest.raises(ImportError, match="--features cuda"):
        importlib.import_module("dualbody.cuda")


@built
def test_what_is_missing_is_named() -> None:
    from dualbody import cuda

    try:
        made = cuda.Simulator(POLE, COUNT)
    except OSError as error:
        text = str(error)
        assert ("libcuda.so" in text or "libnvrtc.so" in text) and "none of" in text or "device" in text
    else:
        assert len(made) == COUNT


@built
@pytest.mark.parametrize(
    ("options", "error", "text"),
    [
        ({"precision": "half"}, ValueError, 'precision is "half", not "double" or "single"'),
        ({"derivatives": ["hessians"]}, ValueError, 'derivatives is "hessians", not "jacobians" or "gradients"'),
        ({"parameters": {"pivot: damping": [0.0]}}, ValueError, r"parameters has the shape \[1\], expected \(5,\)"),
        ({"parameters": [0.0]}, TypeError, "parameters"),
    ],
)
def test_wrong_arguments_are_named(options, error, text) -> None:  # type: ignore[no-untyped-def]
    from dualbody import cuda

    with pytest.raises(error, match=text):
        cuda.Simulator(POLE, COUNT, **options)


@built
@pytest.mark.parametrize(("precision", "tolerance"), [("double", DOUBLE), ("single", SINGLE)])
def test_steps_and_rollouts_are_those_of_the_simulator(precision, tolerance) -> None:  # type: ignore[no-untyped-def]
    gpu, (q, v, u) = on_gpu(precision=precision), states()
    for own, expected in zip(gpu.step(q, v, u), POLE.step(q, v, u), strict=True):
        np.testing.assert_allclose(own, expected, atol=tolerance)
    inputs = np.random.default_rng(1).normal(size=(COUNT, 20, 2))
    expected = POLE.rollout(q, v, inputs=inputs)
    found = gpu.rollout(q, v, inputs=inputs, every=10)
    assert found.is_completed and len(found) == COUNT and found.q.shape == (COUNT, 3, 2)
    np.testing.assert_allclose(found.times, [0.0, 0.1, 0.2])
    np.testing.assert_allclose(found.q, expected.q[:, ::10], atol=tolerance)
    np.testing.assert_allclose(found.last[1], expected.v[:, -1], atol=tolerance)
    with pytest.raises(ValueError, match=r"expected \(5,\)"):
        gpu.step(q[:2], v[:2])


@built
def test_derivatives_are_those_of_the_simulator() -> None:
    gpu, (q, v, u) = on_gpu(derivatives=["jacobians", "gradients"]), states()
    for own, expected in zip(gpu.linearize(q, v, u), POLE.linearize(q, v, u), strict=True):
        np.testing.assert_allclose(own, expected, atol=DOUBLE)
    adjoint = np.random.default_rng(2).normal(size=(COUNT, 4))
    found, expected = gpu.vjp(q, v, u, adjoint), POLE.vjp(q, v, u, adjoint)
    np.testing.assert_allclose(found.state, expected.state, atol=DOUBLE)
    np.testing.assert_allclose(found.input, expected.input, atol=DOUBLE)
    assert found.parameters.shape == (COUNT, 0)


@built
def test_variants_have_their_own_numbers() -> None:
    damping = np.linspace(0.0, 0.5, COUNT)
    gpu, (q, v, u) = on_gpu(parameters={"pivot: damping": damping}), states()
    assert gpu.parameter_names == ["pivot: damping"]
    models = [POLE.model.with_damping(1, float(d)) for d in damping]
    expected = POLE.rollout(q, v, inputs=u[:, None, :], models=models)
    np.testing.assert_allclose(gpu.step(q, v, u)[1], expected.v[:, 1], atol=DOUBLE)


@built
@pytest.mark.parametrize(("precision", "tolerance"), [("double", DOUBLE), ("single", SINGLE)])
def test_states_stay_on_the_gpu(precision, tolerance) -> None:  # type: ignore[no-untyped-def]
    gpu, (q, v, u) = on_gpu(precision=precision), states()
    torch = pytest.importorskip("torch")
    held = gpu.states(q, v)
    np.testing.assert_allclose(held.numbers(), np.hstack([q, v]), atol=tolerance)
    inputs = torch.tensor(u.T, dtype=torch.float64 if precision == "double" else torch.float32, device="cuda").contiguous()
    held.advance(inputs, steps=3)
    expected = POLE.rollout(q, v, inputs=np.repeat(u[:, None, :], 3, axis=1))
    own = np.hstack([expected.q[:, -1], expected.v[:, -1]])
    np.testing.assert_allclose(held.numbers(), own, atol=tolerance)
    # a copy, which later steps do not change; work that is under way when it is asked for comes first
    x = torch.from_dlpack(held)
    assert x.shape == (4, COUNT) and x.dtype == inputs.dtype and x.is_cuda
    held.advance()
    np.testing.assert_allclose(x.cpu().numpy().T, own, atol=tolerance)
    done = torch.arange(COUNT, device="cuda") % 2 == 0
    held.copy_from(torch.where(done, torch.zeros_like(x), x))
    np.testing.assert_allclose(held.numbers(), np.where(np.arange(COUNT)[:, None] % 2 == 0, 0.0, own), atol=tolerance)
    assert all(status.is_completed for status in held.status)


@built
def test_arrays_that_do_not_fit_on_the_gpu_are_refused() -> None:
    gpu, (q, v, u) = on_gpu(), states()
    torch = pytest.importorskip("torch")
    held = gpu.states(q, v)
    for wrong, error, text in [
        (u.T, ValueError, "u is not on a GPU"),
        ([0.0], TypeError, "__dlpack__"),
        (torch.zeros((COUNT, 2), dtype=torch.float64, device="cuda"), ValueError, r"the shape \[5, 2\], not \[2, 5\]"),
        (torch.zeros((2, COUNT), dtype=torch.float32, device="cuda"), ValueError, "numbers"),
        (torch.zeros((COUNT, 2), dtype=torch.float64, device="cuda").T, ValueError, "gaps"),
    ]:
        with pytest.raises(error, match=text):
            held.advance(wrong)
    with pytest.raises(ValueError, match=r"expected \(5,\)"):
        gpu.states(q[:2], v[:2])
    np.testing.assert_allclose(held.numbers(), np.hstack([q, v]))


@built
def test_a_motion_that_diverges_stops_until_it_begins_anew() -> None:
    gpu, (q, v, _) = on_gpu(), states()
    torch = pytest.importorskip("torch")
    held = gpu.states(q, v)
    bad = torch.zeros((2, COUNT), dtype=torch.float64, device="cuda")
    bad[0, 1] = float("nan")
    held.advance(bad, steps=2)
    assert [k for k, status in enumerate(held.status) if not status.is_completed] == [1]
    assert np.isfinite(held.numbers()).all()
    held.copy_from(torch.from_dlpack(held))
    held.advance()
    assert all(status.is_completed for status in held.status)
