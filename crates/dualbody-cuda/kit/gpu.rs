//! Functions of many states on the GPU, from a few states over and over.

use std::path::Path;

use dualbody::codegen::Precision;
use dualbody_cuda::{Compiler, CudaError, Device, Numbers, Real, Schedule, Status, StepInputs};

use crate::cases::Cases;
use crate::functions::Loaded;

/// A GPU, and where its kernels are.
pub(crate) struct Gpu {
    pub(crate) device: Device,
    pub(crate) compiler: Compiler,
}

impl Gpu {
    pub(crate) fn new(folder: &Path) -> Result<Self, CudaError> {
        let compiler = Compiler::new()
            .with_precompiled(folder.join("kernels"))
            .with_cache(std::env::temp_dir().join("dualbody-kit-kernels"));
        Ok(Self {
            device: Device::new(0)?,
            compiler,
        })
    }
}

/// The word of a precision.
pub(crate) fn word<R: Real>() -> &'static str {
    match R::PRECISION {
        Precision::Double => "f64",
        Precision::Single => "f32",
    }
}

/// Arrays of a function on the device.
pub(crate) struct Arrays<R> {
    schedule: Schedule,
    inputs: Numbers<R>,
    start: Numbers<R>,
    each_step: Numbers<R>,
    shared: Numbers<R>,
    /// Outputs, or the states of a motion.
    pub(crate) out: Numbers<R>,
    /// The states that a motion keeps: half of them.
    pub(crate) kept: Numbers<R>,
    pub(crate) status: Status,
}

/// Numbers of the states of `cases` over and over, as they lie on the device.
pub(crate) fn tiled<R: Real>(array: &[f64], rows: usize, cases: usize, count: usize) -> Vec<R> {
    let own = array.len() / cases.max(1);
    let mut out = Vec::with_capacity(rows * count);
    for row in 0..rows {
        let first = out.len();
        let number = |i: usize| R::from_f64(array[i * own + row % own.max(1)]);
        out.extend((0..cases.min(count)).map(number));
        while out.len() < first + count {
            let missing = first + count - out.len();
            let whole = ((out.len() - first) / cases * cases).max(1);
            out.extend_from_within(first..first + missing.min(whole));
        }
    }
    out
}

impl<R: Real> Arrays<R> {
    /// Arrays of `count` states, with outputs of zero.
    ///
    /// * `steps` – steps of a motion, and `every` how many it takes from one state that is kept to the next; no meaning for other functions
    pub(crate) fn new(
        device: &Device,
        loaded: &Loaded<R>,
        cases: &Cases,
        count: usize,
        [steps, every]: [usize; 2],
    ) -> Result<Self, CudaError> {
        /// Beyond any speed here.
        const FASTEST: f64 = 1e6;
        let sizes = match loaded {
            Loaded::Batch(function) => function.sizes(),
            Loaded::Steps(stepper) => stepper.sizes(),
        };
        let schedule = Schedule {
            steps,
            every,
            fastest: FASTEST,
        };
        let array = |given: &[f64], rows: usize| {
            let mut out = Numbers::zeros(device, rows, count)?;
            out.upload(&tiled::<R>(given, rows, cases.count, count))?;
            Ok::<_, CudaError>(out)
        };
        let is_step = matches!(loaded, Loaded::Steps(_));
        let state = if is_step { sizes.outputs } else { 0 };
        let mut shared = Numbers::zeros(device, sizes.shared, 1)?;
        let numbers: Vec<R> = cases.shared.iter().map(|&x| R::from_f64(x)).collect();
        shared.upload(&numbers)?;
        Ok(Self {
            schedule,
            inputs: array(&cases.inputs, sizes.inputs)?,
            start: array(&cases.start, state)?,
            each_step: array(&cases.each_step, sizes.each_step * steps)?,
            shared,
            out: Numbers::zeros(device, sizes.outputs, count)?,
            kept: Numbers::zeros(device, state * schedule.kept(), count)?,
            status: Status::new(device, count)?,
        })
    }

    /// Makes all outputs, and the values passed between kernels of a long function, NaN, by inputs that are NaN.
    pub(crate) fn poison(&mut self, loaded: &Loaded<R>) -> Result<(), CudaError> {
        let nan = |len: usize| vec![R::from_f64(f64::NAN); len];
        for own in [&mut self.out, &mut self.kept] {
            let numbers = nan(own.len());
            own.upload(&numbers)?;
        }
        if let Loaded::Batch(_) = loaded {
            let given = self.inputs.download()?;
            self.inputs.upload(&nan(given.len()))?;
            self.run(loaded)?;
            self.inputs.upload(&given)?;
        }
        Ok(())
    }

    /// Puts the states of a motion back to where they were.
    pub(crate) fn reset(&mut self, loaded: &Loaded<R>) -> Result<(), CudaError> {
        if let Loaded::Steps(_) = loaded {
            self.out.copy_from(&self.start)?;
            self.status = Status::new(self.out.device(), self.status.count())?;
        }
        Ok(())
    }

    /// Passes the kernels on.
    pub(crate) fn run(&mut self, loaded: &Loaded<R>) -> Result<(), CudaError> {
        match loaded {
            Loaded::Batch(function) => {
                function.call(&self.inputs, &self.shared, &mut self.out, &mut self.status)
            }
            Loaded::Steps(stepper) => {
                let inputs = StepInputs {
                    constants: &self.inputs,
                    each_step: &self.each_step,
                    shared: &self.shared,
                };
                stepper.run(
                    self.schedule,
                    &mut self.out,
                    inputs,
                    &mut self.kept,
                    &mut self.status,
                )
            }
        }
    }
}
