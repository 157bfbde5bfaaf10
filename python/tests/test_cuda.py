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
