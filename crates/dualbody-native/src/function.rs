//! A graph as a compiled function.

use std::fmt;

use dualbody::scalar::traced::{BrokenCondition, Graph};

use crate::compiler::Compiler;
use crate::error::NativeError;
use crate::loaded::Loaded;
use crate::real::Real;

/// A graph as a compiled function over `f64`, or over `f32` at half the memory and seven digits.
///
/// Calls from several threads at once are fine. Results are those of the graph to the last rounding or two (`f64`), and the same on every run.
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
///     Err(NativeError::NoCompiler { .. }) => println!("no C compiler here"),
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

    /// Number of inputs, those of all ports together.
    pub fn n_inputs(&self) -> usize {
        self.loaded.n_inputs
    }

    /// Number of outputs, those of all ports together.
    pub fn n_outputs(&self) -> usize {
        self.loaded.n_outputs
    }

    /// Computes the outputs, as [`Graph::evaluate_into`] does. Does not allocate, except for an error.
    ///
    /// * `inputs` – the numbers of all inputs, one input after the other
    /// * `outputs` – output, likewise; not to be used where a condition does not hold
    ///
    /// # Errors
    /// If a condition of the graph does not hold.
    ///
    /// # Panics
    /// If there are not as many inputs or outputs.
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

    /// [`call`](Self::call) without the name of the condition; `false` if one does not hold.
    pub(crate) fn holds(&self, inputs: &[R], outputs: &mut [R]) -> bool {
        self.loaded.call(inputs, outputs) == 0
    }

    /// [`call`](Self::call) for one state after the other. Does not allocate. Returns for how many a condition does not hold.
    ///
    /// * `status` – output, one for each state: 0, or the number, from 1, of the first condition that does not hold there
    ///
    /// # Panics
    /// If inputs or outputs are not as many for each status.
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
