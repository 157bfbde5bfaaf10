//! Nonlinear least squares of functions of Python.

use dualbody::least_squares::{Iteration, Loss, Options, Residuals, Status, solve_with};

use crate::prelude::*;

/// Functions of Python as residuals.
struct Functions<'a, 'py> {
    residuals: &'a Bound<'py, PyAny>,
    jacobian: &'a Bound<'py, PyAny>,
    /// Number of directions, and (x, d) -> x ⊕ d, where variables are points of a curved space.
    manifold: Option<(usize, Bound<'py, PyAny>)>,
    n_residuals: usize,
    raised: Raised,
}

impl<'py> Functions<'_, 'py> {
    fn py(&self) -> Python<'py> {
        self.residuals.py()
    }

    /// Calls a function of variables.
    fn values(&self, x: &[f64], length: Option<usize>) -> PyResult<Vec<f64>> {
        let found = self.residuals.call1((vector(self.py(), x),))?;
        read_vector("residuals(x)", &found, length)
    }

    fn derivatives(&self, x: &[f64], shape: (usize, usize)) -> PyResult<DMatrix<f64>> {
        let found = self.jacobian.call1((vector(self.py(), x),))?;
        read_matrix_of("jacobian(x)", &found, shape)
    }
}

impl Residuals for Functions<'_, '_> {
    fn n_residuals(&self) -> usize {
        self.n_residuals
    }

    fn residuals(&mut self, x: &[f64], out: &mut [f64]) {
        let n = out.len();
        self.raised.fill(out, || self.values(x, Some(n)));
    }

    fn jacobian(&mut self, x: &[f64], out: &mut DMatrix<f64>) {
        match self.raised.attempt(|| self.derivatives(x, out.shape())) {
            Some(found) => out.copy_from(&found),
            None => out.fill(f64::NAN),
        }
    }

    fn n_directions(&self, x: &[f64]) -> usize {
        let own = self.manifold.as_ref();
        own.map_or(x.len(), |(directions, _)| *directions)
    }

    fn retract(&self, x: &[f64], d: &[f64], out: &mut [f64]) {
        let Some((_, retract)) = &self.manifold else {
            let sums = x.iter().zip(d).map(|(x, d)| x + d);
            return out.iter_mut().zip(sums).for_each(|(out, x)| *out = x);
        };
        let n = out.len();
        self.raised.fill(out, || {
            let [x, d] = [x, d].map(|x| vector(self.py(), x));
            read_vector("retract(x, d)", &retract.call1((x, d))?, Some(n))
        });
    }
}

fn loss_of((kind, delta): (String, f64)) -> PyResult<Loss> {
    match kind.as_str() {
        "square" => Ok(Loss::Square),
        "huber" => Ok(Loss::Huber(delta)),
        "soft_l1" => Ok(Loss::SoftL1(delta)),
        "cauchy" => Ok(Loss::Cauchy(delta)),
        _ => Err(invalid!("loss is of the unknown kind {kind:?}")),
    }
}

functions! {
    /// Cost ρ and weight ρ' of squares of residuals.
    fn _loss(loss: (String, f64), s) -> PyResult<[Bound<'py, PyAny>; 2]> {
        let (py, loss, s) = (s.py(), loss_of(loss)?, read_vector("s", s, None)?);
        let of_all = |of: fn(Loss, f64) -> f64| Vec::from_iter(s.iter().map(|&s| of(loss, s)));
        Ok([Loss::value, Loss::weight].map(|of| vector(py, &of_all(of))))
    }
}

fn options_of(
    loss: (String, f64),
    bounds: [Option<Bound<'_, PyAny>>; 2],
    given: &Bound<'_, PyDict>,
) -> PyResult<Options> {
    let mut options = read_options!(Options, "least_squares.solve", given;
        max_iterations, gradient_tolerance, cost_tolerance, step_tolerance, offset_tolerance, damping)?;
    let [lower, upper] = bounds;
    options.loss = loss_of(loss)?;
    options.lower = bound("the lower bounds", lower)?;
    options.upper = bound("the upper bounds", upper)?;
    Ok(options)
}

/// Bounds of all variables; none if they are left out.
fn bound(name: &'static str, given: Option<Bound<'_, PyAny>>) -> PyResult<Vec<f64>> {
    let Some(given) = given else {
        return Ok(Vec::new());
    };
    let all = read_vector(name, &given, None)?;
    match all.iter().position(|x| x.is_nan()) {
        Some(k) => Err(invalid!("{name}[{k}] is NaN")),
        None => Ok(all),
    }
}

functions! {
    /// Minimises: (x, residuals, cost, status, converged, iterations, history, held, normal matrix, variance, covariance).
    fn _least_squares(
        residuals, jacobian, start, manifold: Option<(usize, Bound<'py, PyAny>)>, loss: (String, f64), bounds: [Option<Bound<'py, PyAny>>; 2],
        report: Option<&Bound<'py, PyAny>>, options: &Bound<'py, PyDict>
    ) -> PyResult<Bound<'py, PyTuple>> {
        let options = options_of(loss, bounds, options)?;
        let start = read_vector("start", start, None)?;
        let raised = Raised::default();
        let mut functions = Functions {
            residuals,
            jacobian,
            manifold,
            n_residuals: 0,
            raised: raised.clone(),
        };
        functions.n_residuals = functions.values(&start, None)?.len();
        let report = report.map(|report| report.clone().unbind());
        let mut tell = |own: &Iteration| {
            raised.tell(report.as_ref(), (own.iteration, own.cost, own.gradient, own.damping));
        };
        let solve = || solve_with(&mut functions, &start, &options, &mut tell);
        let found = raised.stop.watch(solve);
        raised.check()?;
        let (py, s) = (residuals.py(), found);
        let covariance: Option<Array<'py>> = s.covariance().map(|own| matrix(py, &own));
        let (variance, normal) = (s.variance(), matrix(py, &s.normal_matrix));
        let [x, residuals, history] = [s.x, s.residuals, s.history].map(|x| vector(py, &x));
        let (status, is_converged) = (s.status.to_string(), s.status == Status::Converged);
        (x, residuals, s.cost, status, is_converged, s.iterations, history, s.held, normal, variance, covariance).into_pyobject(py)
    }
}
