//! Dynamics and residuals that are functions of Python.
//!
//! Solvers call them with the interpreter lock, one thread at a time. An exception ends the solver, by numbers that are not finite, and is raised again.

use dualbody::trajopt::{Node, Residual, ResidualJacobian, Scratch, System};
use dualbody::{Linearization, Scalar};

use crate::prelude::*;

/// Two functions of (x, u): values, and their Jacobians in state and input.
struct Functions {
    value: Py<PyAny>,
    jacobians: Py<PyAny>,
    /// Number of values, of states and of inputs.
    sizes: [usize; 3],
    raised: Raised,
}

impl Functions {
    /// The functions of an object: that of a name, and `jacobians`.
    fn read(
        of: &Bound<'_, PyAny>,
        value: &str,
        sizes: [usize; 3],
        raised: &Raised,
    ) -> PyResult<Self> {
        Ok(Self {
            value: of.getattr(value)?.unbind(),
            jacobians: of.getattr("jacobians")?.unbind(),
            sizes,
            raised: raised.clone(),
        })
    }

    /// Calls one of both functions with arrays of a state and an input.
    fn call<'py>(
        py: Python<'py>,
        function: &Py<PyAny>,
        x: &[f64],
        u: &[f64],
    ) -> PyResult<Bound<'py, PyAny>> {
        let arguments = (PyArray1::from_slice(py, x), PyArray1::from_slice(py, u));
        function.bind(py).call1(arguments)
    }

    fn value(&self, name: &'static str, x: &[f64], u: &[f64], out: &mut [f64]) {
        let call = |py: Python<'_>| {
            let found = Self::call(py, &self.value, x, u)?;
            read_vector(name, &found, Some(self.sizes[0]))
        };
        self.raised.fill(out, || Python::attach(call));
    }

    /// The Jacobians; what is not finite after an exception.
    fn jacobians(&self, x: &[f64], u: &[f64]) -> [DMatrix<f64>; 2] {
        let [rows, nx, nu] = self.sizes;
        let call = |py: Python<'_>| {
            let found = Self::call(py, &self.jacobians, x, u)?;
            let of = |k: usize, name, columns| {
                read_matrix_of(name, &found.get_item(k)?, (rows, columns))
            };
            let of_state = of(0, "the Jacobian in x", nx)?;
            // At the end of the horizon there is no input, and its Jacobian does not count.
            let of_input = match u.is_empty() {
                true => DMatrix::zeros(rows, 0),
                false => of(1, "the Jacobian in u", nu)?,
            };
            Ok([of_state, of_input])
        };
        let nothing =
            || [nx, u.len()].map(|columns| DMatrix::from_element(rows, columns, f64::NAN));
        let found = self.raised.attempt(|| Python::attach(call));
        found.unwrap_or_else(nothing)
    }
}

/// Numbers without what a scalar has besides.
fn values<T: Scalar>(x: &[T]) -> Vec<f64> {
    x.iter().map(|x| x.value(0)).collect()
}

/// A system whose step is a function of Python.
pub(super) struct UserSystem {
    step: Functions,
    time_step: f64,
}

impl UserSystem {
    pub(super) fn read(value: &Bound<'_, PyAny>, raised: &Raised) -> PyResult<Self> {
        let (nx, nu): (usize, usize) = (attribute(value, "nx")?, attribute(value, "nu")?);
        if nx == 0 {
            refuse!("nx is 0: dynamics have a state");
        }
        Ok(Self {
            step: Functions::read(value, "step", [nx, nx, nu], raised)?,
            time_step: attribute(value, "time_step")?,
        })
    }
}

impl System for UserSystem {
    fn nx(&self) -> usize {
        self.step.sizes[1]
    }

    fn nu(&self) -> usize {
        self.step.sizes[2]
    }

    fn time_step(&self) -> f64 {
        self.time_step
    }

    fn is_vector_space(&self) -> bool {
        true
    }

    /// Solvers step on plain numbers; derivatives are those of [`Self::linearize`].
    fn step<T: Scalar>(&self, x: &[T], u: &[T], _: &mut Scratch, next: &mut [T]) {
        let mut found = vec![0.0; next.len()];
        let name = "the next state";
        self.step.value(name, &values(x), &values(u), &mut found);
        next.iter_mut()
            .zip(found)
            .for_each(|(out, x)| *out = x.into());
    }

    fn linearize(&self, x: &[f64], u: &[f64], _: &mut Scratch, out: &mut Linearization) {
        [out.a, out.b] = self.step.jacobians(x, u);
    }

    fn prepare(&self, _: &mut Scratch) {}
}

/// A residual that is a function of Python.
pub(super) struct UserResidual(Functions);

impl UserResidual {
    /// * `sizes` – directions of the state, inputs
    pub(super) fn read(
        value: &Bound<'_, PyAny>,
        sizes: [usize; 2],
        raised: &Raised,
    ) -> PyResult<Self> {
        let (dim, [ndx, nu]) = (attribute(value, "dim")?, sizes);
        check_array("Jacobians of a residual", &[dim, ndx + nu])?;
        Functions::read(value, "value", [dim, ndx, nu], raised).map(Self)
    }
}

impl Residual for UserResidual {
    fn dim(&self, _: &Node<'_>) -> usize {
        self.0.sizes[0]
    }

    fn eval<T: Scalar>(&self, _: &Node<'_, T>, x: &[T], u: &[T], r: &mut [T]) {
        let mut found = vec![0.0; r.len()];
        let name = "the residual";
        self.0.value(name, &values(x), &values(u), &mut found);
        r.iter_mut().zip(found).for_each(|(out, x)| *out = x.into());
    }

    fn value(&self, _: &Node<'_>, x: &[f64], u: &[f64], r: &mut [f64]) {
        self.0.value("the residual", x, u, r);
    }

    fn linearize(&self, _: &Node<'_>, x: &[f64], u: &[f64], out: &mut ResidualJacobian) {
        let mut found = vec![0.0; self.0.sizes[0]];
        self.0.value("the residual", x, u, &mut found);
        out.values.copy_from_slice(&found);
        let [of_state, of_input] = self.0.jacobians(x, u);
        let ndx = out.ndx();
        for i in 0..found.len() {
            let (state, input) = out.row_mut(i).split_at_mut(ndx);
            let (own_state, own_input) = (of_state.row(i), of_input.row(i));
            let rows = state.iter_mut().zip(own_state.iter());
            let rows = rows.chain(input.iter_mut().zip(own_input.iter()));
            rows.for_each(|(out, &x)| *out = x);
        }
    }
}
