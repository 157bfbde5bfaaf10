//! Simulators on a GPU in either precision, and what they are made with.

use std::path::PathBuf;

use dualbody::codegen::Precision;
use dualbody_cuda::{Compiler, CudaError, CudaSimulator, Device, Real};
use pyo3::exceptions::{PyMemoryError, PyOSError};

use crate::errors::Raise;
use crate::prelude::*;

impl Raise for CudaError {
    fn raise(self) -> PyErr {
        let text = self.to_string();
        match self {
            Self::UnknownName(unknown) => unknown.raise(),
            Self::NoMemory { .. } => PyMemoryError::new_err(text),
            Self::Length { .. }
            | Self::EmptyBatch
            | Self::TooMany { .. }
            | Self::Mismatch { .. }
            | Self::Code(_)
            | Self::OtherRobot(_) => value_error(text),
            _ => PyOSError::new_err(text),
        }
    }
}

/// A value of either precision.
#[derive(Debug)]
pub(super) enum Either<D, S> {
    Double(D),
    Single(S),
}

/// A simulator on a GPU.
pub(super) type Gpu = Either<CudaSimulator<f64>, CudaSimulator<f32>>;

/// The same expression for the value of either precision.
macro_rules! on_either {
    ($value:expr, $own:ident => $call:expr) => {
        match $value {
            Either::Double($own) => $call,
            Either::Single($own) => $call,
        }
    };
}
pub(super) use on_either;

/// The same work of either precision without the interpreter lock; what fails is raised.
macro_rules! on_gpu {
    ($py:expr, $gpu:expr, $own:ident => $call:expr) => {{
        let work = || -> Result<_, dualbody_cuda::CudaError> { on_either!($gpu, $own => $call) };
        $py.detach(|| guarded(work)).and_then(OrRaise::or_raise)
    }};
}
pub(super) use on_gpu;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Derivative {
    Jacobians,
    Gradients,
}

/// Arguments that make a simulator on a GPU.
pub(super) struct Wanted {
    count: usize,
    names: Vec<String>,
    /// Those of one state after the other.
    parameters: Vec<f64>,
    precision: Precision,
    derivatives: Vec<Derivative>,
    device: usize,
    compiler: Compiler,
}

impl Wanted {
    pub(super) fn read(
        count: usize,
        parameters: Option<&Bound<'_, PyDict>>,
        precision: &str,
        derivatives: &[String],
        device: usize,
        cache: Option<PathBuf>,
    ) -> PyResult<Self> {
        let (names, parameters) = read_parameters(count, parameters)?;
        let all = [Derivative::Jacobians, Derivative::Gradients];
        let derivatives = derivatives.iter();
        let derivatives = derivatives.map(|name| variant("derivatives", name, &all));
        let compiler = Compiler::new();
        Ok(Self {
            count,
            names,
            parameters,
            precision: variant(
                "precision",
                precision,
                &[Precision::Double, Precision::Single],
            )?,
            derivatives: derivatives.collect::<PyResult<_>>()?,
            device,
            compiler: match cache {
                Some(cache) => compiler.with_cache(cache),
                None => compiler,
            },
        })
    }

    /// Opens the device, records the step, and compiles it.
    pub(super) fn make(&self, simulator: &Simulator) -> PyResult<Gpu> {
        let device = Device::new(self.device).or_raise()?;
        let made = guarded(|| match self.precision {
            Precision::Double => self.compiled(simulator, &device).map(Gpu::Double),
            Precision::Single => self.compiled(simulator, &device).map(Gpu::Single),
        });
        made?.or_raise()
    }

    fn compiled<R: Real>(
        &self,
        simulator: &Simulator,
        device: &Device,
    ) -> Result<CudaSimulator<R>, CudaError> {
        let names: Vec<&str> = self.names.iter().map(String::as_str).collect();
        let (own, compiler) = (simulator.clone(), &self.compiler);
        let mut gpu = CudaSimulator::of_variants(
            own,
            &names,
            &self.parameters,
            self.count,
            device,
            compiler,
        )?;
        if self.derivatives.contains(&Derivative::Jacobians) {
            gpu = gpu.with_jacobians(compiler)?;
        }
        if self.derivatives.contains(&Derivative::Gradients) {
            gpu = gpu.with_gradients(compiler)?;
        }
        Ok(gpu)
    }
}

/// Names of the parameters in which states differ, and their numbers, those of one state after the other.
fn read_parameters(
    count: usize,
    given: Option<&Bound<'_, PyDict>>,
) -> PyResult<(Vec<String>, Vec<f64>)> {
    let (mut names, mut columns) = (Vec::new(), Vec::new());
    for (name, values) in given.into_iter().flatten() {
        names.push(name.extract::<String>()?);
        columns.push(read_vector("parameters", &values, Some(count))?);
    }
    let rows = (0..count).flat_map(|i| columns.iter().map(move |column| column[i]));
    Ok((names, rows.collect()))
}
