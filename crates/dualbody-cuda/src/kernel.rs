//! A kernel on a device.

use std::fmt;

use cudarc::driver::CudaFunction;
use cudarc::nvrtc::Ptx;
use dualbody::Model;
use dualbody::codegen::{CudaSizes, CudaSource, check_origin};
use dualbody::scalar::traced::{Condition, Graph, Origin};

use crate::compiler::Compiler;
use crate::device::Device;
use crate::error::CudaError;

/// The loaded kernels of a function, with its inputs and outputs.
pub(crate) struct Kernel {
    /// Those of the parts of a long function, in their order.
    pub(crate) functions: Vec<CudaFunction>,
    pub(crate) sizes: CudaSizes,
    pub(crate) device: Device,
    name: String,
    conditions: Vec<Condition>,
    origin: Option<Origin>,
}

impl Kernel {
    /// Compiles the text of a graph, or finds it compiled, and loads it.
    pub(crate) fn load(
        graph: &Graph,
        source: &CudaSource,
        device: &Device,
        compiler: &Compiler,
    ) -> Result<Self, CudaError> {
        let compiled = compiler.compile_all(source, device.architecture()?)?;
        let both = source.kernels.iter().zip(&compiled);
        let functions = both.map(|(kernel, compiled)| {
            let image = Ptx::from_binary(compiled.image().to_vec());
            let module = device.context.load_module(image);
            let module = module.map_err(device.failure("load a kernel"))?;
            let function = module.load_function(kernel.name());
            function.map_err(device.failure("find a kernel"))
        });
        Ok(Self {
            functions: functions.collect::<Result<_, _>>()?,
            sizes: source.sizes,
            device: device.clone(),
            name: source.kernels[0].name().to_owned(),
            conditions: graph.conditions().to_vec(),
            origin: graph.origin().cloned(),
        })
    }

    /// The condition of a status, in words.
    pub(crate) fn condition(&self, status: i32) -> &str {
        let index = usize::try_from(status).ok().and_then(|k| k.checked_sub(1));
        let condition = index.and_then(|k| self.conditions.get(k));
        condition.map_or("", |own| &own.condition)
    }

    /// Checks that it was recorded from a robot, and that the robot has not changed since.
    pub(crate) fn check_robot(&self, model: &Model) -> Result<(), CudaError> {
        Ok(check_origin(self.origin.as_ref(), model)?)
    }
}

impl fmt::Debug for Kernel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Kernel({}: {:?})", self.name, self.sizes)
    }
}
