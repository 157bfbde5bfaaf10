//! Tracing of computations.

use super::graph::Graph;
use super::number::{Traced, Tracing};
use super::port::{Port, find};
use crate::scalar::Scalar;

/// Inputs and outputs of a trace, declared as they are needed.
#[derive(Debug, Default)]
pub struct Tracer {
    inputs: Vec<Port>,
    outputs: Vec<Port>,
    results: Vec<Traced>,
}

impl Tracer {
    /// Declares an input and returns its entries, in column-major order.
    ///
    /// # Panics
    /// If an input of that name exists.
    pub fn input(&mut self, port: Port) -> Vec<Traced> {
        let name = &port.name;
        assert!(
            find(&self.inputs, name).is_none(),
            "there are two inputs with the name \"{name}\""
        );
        let first: usize = self.inputs.iter().map(Port::len).sum();
        let numbers = first..first + port.len();
        self.inputs.push(port);
        numbers.map(Traced::input).collect()
    }

    /// Declares an output, in column-major order.
    ///
    /// # Panics
    /// If an output of that name exists, or the number of entries is wrong.
    pub fn output<'a>(&mut self, port: Port, numbers: impl IntoIterator<Item = &'a Traced>) {
        let name = &port.name;
        assert!(
            find(&self.outputs, name).is_none(),
            "there are two outputs with the name \"{name}\""
        );
        let before = self.results.len();
        self.results.extend(numbers);
        let given = self.results.len() - before;
        assert_eq!(
            given,
            port.len(),
            "number of entries of the output \"{name}\", given and in its port"
        );
        self.outputs.push(port);
    }
}

/// Records a computation as a [`Graph`].
///
/// The result of `work` depends only on its inputs and on constants, which are folded: parameters of a robot, a time
/// step. Nodes without effect on an output are dropped. The same computation gives the same graph, on all machines with the same mathematical functions.
///
/// # Panics
/// If `work` reads the [value](Scalar::value) of a number that depends on an input; the message contains the location.
///
/// # Examples
/// ```
/// use dualbody::scalar::traced::{Port, trace};
/// use dualbody::{dynamics::inverse_dynamics, model::samples};
///
/// let model = samples::pendulum(); // 1 kg, 1 m
/// let graph = trace(|t| {
///     let [q, v, a] = ["q", "v", "a"].map(|name| t.input(Port::vector(name, 1)));
///     let tau = inverse_dynamics(&model, &q, &v, &a);
///     t.output(Port::vector("tau", 1).with_unit("N m"), tau.iter());
/// });
/// // τ = m l² / 3 a + m g l / 2 sin q: two products, a sum, a sine
/// assert!(graph.counts().operations() <= 4, "{graph}");
/// let tau = graph.evaluate(&[std::f64::consts::FRAC_PI_2, 0.0, 3.0])?;
/// assert!((tau[0] - (1.0 + 0.5 * 9.81)).abs() < 1e-12);
/// # Ok::<(), dualbody::scalar::traced::BrokenCondition>(())
/// ```
pub fn trace(work: impl FnOnce(&mut Tracer)) -> Graph {
    let tracing = Tracing::start();
    let mut tracer = Tracer::default();
    work(&mut tracer);
    let results = tracer.results.iter().map(|x| x.node()).collect::<Vec<_>>();
    let recording = tracing.finish();
    let Tracer {
        inputs, outputs, ..
    } = tracer;
    Graph::new(inputs, outputs, &recording, &results)
}

impl Graph {
    /// Records what the graph computes once more, in the innermost trace, over numbers that are made of traced ones:
    /// [`Traced`] itself, or dual numbers over it.
    pub(crate) fn replay<T: Scalar>(&self, inputs: &[T]) -> Vec<T> {
        let mut out = vec![T::zero(); self.n_outputs()];
        let held = self.evaluate_into(inputs, &mut self.scratch(), &mut out);
        // A number that is recorded takes every condition over.
        held.unwrap_or_else(|broken| panic!("{broken}"));
        out
    }
}
