//! Derivatives of the step of many states.

use dualbody::linearize::Linearization;
use dualbody::{Simulator, State};

use crate::error::{CudaError, check_length};
use crate::function::{CudaFunction, Outputs};
use crate::real::Real;
use crate::simulator::CudaSimulator;

/// Gradients of λᵀ x⁺ of the steps of a batch, those of one state after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradients {
    /// In the state, in tangent coordinates: `n_tangent` numbers each.
    pub state: Vec<f64>,
    /// In the input: `nu` numbers each.
    pub input: Vec<f64>,
    /// In the parameters of the variants, in the order of their names.
    pub parameters: Vec<f64>,
    /// Status of each state: 0, the index k, from 1, of the first violated condition, or −1 if a number is not finite.
    pub status: Vec<i32>,
}

impl<R: Real> CudaSimulator<R> {
    /// Computes A and B of the step from each state; each variant has its own. If a condition of the graph is violated, the library computes them on the CPU.
    ///
    /// * `inputs` – the input of one state after the other
    ///
    /// # Errors
    /// If [Jacobians](Self::with_jacobians) were not compiled, the number of states or inputs is wrong, the device has too little memory, or the driver fails.
    pub fn linearize(
        &self,
        states: &[State],
        inputs: &[f64],
    ) -> Result<Vec<Linearization>, CudaError> {
        let function = compiled(self.jacobians.as_ref(), "Jacobians", "with_jacobians")?;
        let found = self.call(function, states, inputs, &[])?;
        let n = function.sizes().outputs;
        let parameters = self.parameters.download_states()?;
        let one = |i: usize| {
            if found.status[i] != 0 {
                let u = &inputs[self.nu() * i..self.nu() * (i + 1)];
                let n = self.parameters.rows();
                let own = self.variant(&parameters[n * i..n * (i + 1)])?;
                return Ok(own.linearize(&states[i], u));
            }
            let numbers = found.numbers[n * i..n * (i + 1)].iter();
            let mut out = Linearization::zeros(&self.own);
            let all = out.a.iter_mut().chain(&mut out.b);
            all.zip(numbers).for_each(|(to, x)| *to = x.to_f64());
            Ok(out)
        };
        (0..states.len()).map(one).collect()
    }

    /// The simulator of the variant of these parameters.
    fn variant(&self, parameters: &[R]) -> Result<Simulator, CudaError> {
        let (layout, mut all) = (self.own.parameter_layout(), self.own.parameters());
        for (name, p) in self.parameter_names().into_iter().zip(parameters) {
            all[layout.find(name)?] = p.to_f64();
        }
        Ok(self.own.with_parameters(all.as_slice()))
    }

    /// Computes the gradients of λᵀ x⁺ of the steps in state, input and the parameters of the variants, by one backward pass through each step.
    ///
    /// * `inputs` – the input of one state after the other
    /// * `adjoints` – λ of one state after the other, `n_tangent` numbers each
    ///
    /// # Errors
    /// If [gradients](Self::with_gradients) were not compiled, the number of states, inputs or adjoints is wrong, the device has too little memory, or the
    /// driver fails.
    pub fn gradients(
        &self,
        states: &[State],
        inputs: &[f64],
        adjoints: &[f64],
    ) -> Result<Gradients, CudaError> {
        let function = compiled(self.gradients.as_ref(), "gradients", "with_gradients")?;
        let (n, nu) = (self.own.n_tangent(), self.nu());
        check_length("adjoints", adjoints.len(), n.checked_mul(self.len()))?;
        let Outputs { numbers, status } = self.call(function, states, inputs, adjoints)?;
        let rows = numbers.chunks_exact(function.sizes().outputs.max(1));
        let columns = |range: std::ops::Range<usize>| {
            let all = rows.clone().flat_map(move |row| &row[range.clone()]);
            all.map(|x| x.to_f64()).collect()
        };
        Ok(Gradients {
            state: columns(0..n),
            input: columns(n..n + nu),
            parameters: columns(n + nu..function.sizes().outputs),
            status,
        })
    }

    /// Calls a function of state, input, parameters and more, in this order.
    fn call(
        &self,
        function: &CudaFunction<R>,
        states: &[State],
        inputs: &[f64],
        rest: &[f64],
    ) -> Result<Outputs<R>, CudaError> {
        let (count, nu) = (self.len(), self.nu());
        check_length("the batch of states", states.len(), Some(count))?;
        check_length("inputs", inputs.len(), nu.checked_mul(count))?;
        let (n_parameters, n_rest) = (self.parameters.rows(), rest.len() / count);
        let parameters = self.parameters.download_states()?;
        let mut all = Vec::with_capacity(function.sizes().inputs * count);
        for (i, state) in states.iter().enumerate() {
            let x = state.numbers().chain(&inputs[nu * i..nu * (i + 1)]);
            all.extend(x.map(|&x| R::from_f64(x)));
            all.extend(&parameters[n_parameters * i..n_parameters * (i + 1)]);
            all.extend(
                rest[n_rest * i..n_rest * (i + 1)]
                    .iter()
                    .map(|&x| R::from_f64(x)),
            );
        }
        function.call_states(count, &all, &[])
    }
}

fn compiled<'a, R>(
    function: Option<&'a CudaFunction<R>>,
    what: &str,
    with: &str,
) -> Result<&'a CudaFunction<R>, CudaError> {
    function.ok_or_else(|| CudaError::Mismatch {
        what: format!("no {what} were compiled: CudaSimulator::{with}"),
    })
}
