//! A graph as a compiled function.

use std::fmt;

use dualbody::scalar::traced::{BrokenCondition, Graph};

use crate::compiler::Compiler;
use crate::error::NativeError;
use crate::loaded::Loaded;
use crate::real::Real;

/// A graph as a compiled function over `f64`, or over `f32` with half the memory and seven digits.
///
/// Several threads may call it at once. Results equal those of the graph to one or two roundings (`f64`), and are the same in every run.
///
/// # Examples
/// ```
/// use dualbody::{codegen, model::samples};
/// use dualbody_native::{Compiler, NativeError, NativeFunction};
///
/// let graph = codegen::mass_matrix(&samples::pendulum());
/// match NativeFunction::<f64>::new(&graph, "pendulum_m", &Compiler::default()) {
///     Ok(function) => {
///         let mut m = [0.0];
///         function.call(&[0.3], &mut m)?;
///         assert!((m[0] - 1.0 / 3.0).abs() < 1e-15);
///     }
///     Err(NativeError::NoCompiler { .. }) => println!("no C compiler"),
///     Err(error) => return Err(error.into()),
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct NativeFunction<R = f64> {
    name: String,
    loaded: Loaded<R>,
    /// Conditions of the graph, in words.
    conditions: Vec<String>,
}

impl<R: Real> NativeFunction<R> {
    /// Compiles and loads a graph, or finds it compiled.
    ///
    /// * `name` – of the function, an identifier of C
    ///
    /// # Errors
    /// If the name is not an identifier, the compiler is missing or refuses the text or its flags, or the file cannot be stored or loaded. If a
    /// [`StopSignal`](dualbody::StopSignal) ends the compiler.
    pub fn new(graph: &Graph, name: &str, compiler: &Compiler) -> Result<Self, NativeError> {
        let source = graph.to_c(name, R::PRECISION)?;
        let file = compiler.compile(&source)?;
        let loaded = Loaded::open(&file, &source, graph).or_else(|_| {
            // A file that was damaged since is compiled once more.
            Compiler::forget(&file);
            Loaded::open(&compiler.compile(&source)?, &source, graph)
        })?;
        let conditions = graph.conditions().iter();
        Ok(Self {
            name: name.to_owned(),
            loaded,
            conditions: conditions.map(|own| own.condition.clone()).collect(),
        })
    }

    /// Number of entries of all inputs.
    pub fn n_inputs(&self) -> usize {
        self.loaded.n_inputs
    }

    /// Number of entries of all outputs.
    pub fn n_outputs(&self) -> usize {
        self.loaded.n_outputs
    }

    /// Computes the outputs, as [`Graph::evaluate_into`] does. Does not allocate, except for an error.
    ///
    /// * `inputs` – entries of all inputs in sequence
    /// * `outputs` – output, entries of all outputs; invalid if a condition is violated
    ///
    /// # Errors
    /// If a condition of the graph is violated.
    ///
    /// # Panics
    /// If the number of inputs or outputs is wrong.
    pub fn call(&self, inputs: &[R], outputs: &mut [R]) -> Result<(), BrokenCondition> {
        match usize::try_from(self.loaded.call(inputs, outputs)) {
            Ok(0) => Ok(()),
            number => Err(self.broken(number.unwrap_or(1) - 1)),
        }
    }

    fn broken(&self, index: usize) -> BrokenCondition {
        let condition = self.conditions.get(index).cloned();
        BrokenCondition {
            index,
            condition: condition.unwrap_or_default(),
        }
    }

    /// [`call`](Self::call) without the name of the condition; `false` if one is violated.
    pub(crate) fn holds(&self, inputs: &[R], outputs: &mut [R]) -> bool {
        self.loaded.call(inputs, outputs) == 0
    }

    /// [`call`](Self::call) for one state after the other. Does not allocate. Returns the number of states that violate a condition.
    ///
    /// * `status` – output, one for each state: 0, or the index, from 1, of the first violated condition
    ///
    /// # Panics
    /// If the length of inputs or outputs does not fit the number of states.
    pub fn call_batch(&self, inputs: &[R], outputs: &mut [R], status: &mut [i32]) -> usize {
        self.loaded.call_batch(inputs, outputs, status)
    }
}

impl<R> fmt::Debug for NativeFunction<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sizes = (self.loaded.n_inputs, self.loaded.n_outputs);
        write!(
            f,
            "NativeFunction({}: {} -> {})",
            self.name, sizes.0, sizes.1
        )
    }
}
