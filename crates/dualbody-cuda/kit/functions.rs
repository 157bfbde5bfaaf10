//! The functions of a robot that become kernels.

use std::error::Error;
use std::path::Path;

use dualbody::codegen::{CodeError, CudaSource, RolloutInputs};
use dualbody::scalar::traced::Graph;
use dualbody_cuda::{
    Architecture, Compiler, CudaError, CudaFunction, CudaStepper, Device, Real, graphs,
};

use crate::catalogue::{Ground, Robot};
use crate::sizes::Report;

/// Quantity that a function computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    InverseDynamics,
    ForwardDynamics,
    Step,
    Feedback,
    StepOfVariants,
    Jacobians,
    JacobiansOfVariants,
    Gradients,
}

impl Kind {
    /// Its name in tables.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::InverseDynamics => "inverse dynamics",
            Self::ForwardDynamics => "forward dynamics",
            Self::Step => "step",
            Self::Feedback => "step under feedback",
            Self::StepOfVariants => "step of variants",
            Self::Jacobians => "A and B",
            Self::JacobiansOfVariants => "A and B of variants",
            Self::Gradients => "gradients",
        }
    }

    /// Whether the kernel has the loop over time in it.
    pub(crate) fn is_step(self) -> bool {
        matches!(self, Self::Step | Self::Feedback | Self::StepOfVariants)
    }
}

/// A function of a robot, as a graph.
pub(crate) struct Function {
    pub(crate) kind: Kind,
    pub(crate) graph: Graph,
    /// Names of the parameters in which states differ.
    pub(crate) parameters: Vec<String>,
}

/// A function on the GPU.
pub(crate) enum Loaded<R> {
    Batch(CudaFunction<R>),
    Steps(CudaStepper<R>),
}

impl Function {
    /// Records a function; `None` if the robot has no parameters for variants.
    pub(crate) fn new(robot: &Robot, kind: Kind) -> Result<Option<Self>, Box<dyn Error>> {
        let (simulator, model) = (&robot.simulator, robot.simulator.model());
        let parameters = match kind {
            Kind::StepOfVariants | Kind::JacobiansOfVariants => varied(robot),
            _ => Vec::new(),
        };
        let names: Vec<&str> = parameters.iter().map(String::as_str).collect();
        let graph = match kind {
            Kind::InverseDynamics => graphs::inverse_dynamics(model),
            Kind::ForwardDynamics => graphs::forward_dynamics(model),
            Kind::Step => graphs::step(simulator, &[])?,
            Kind::Feedback => graphs::feedback_step(simulator, &[])?,
            Kind::Jacobians => graphs::linearization(simulator),
            Kind::Gradients => graphs::step_adjoint(simulator, &[])?,
            _ if names.is_empty() => return Ok(None),
            Kind::StepOfVariants => graphs::step(simulator, &names)?,
            Kind::JacobiansOfVariants => graphs::linearization_of_variants(simulator, &names)?,
        };
        Ok(Some(Self {
            kind,
            graph,
            parameters,
        }))
    }

    /// Roles of the inputs of a step.
    fn roles(&self) -> RolloutInputs {
        match self.kind {
            Kind::Feedback => RolloutInputs::of_feedback(),
            _ => RolloutInputs::default(),
        }
    }

    /// Its kernels as CUDA; in parts of another length if one is given.
    pub(crate) fn source<R: Real>(&self, length: Option<usize>) -> Result<CudaSource, CodeError> {
        let (graph, real, roles) = (&self.graph, R::PRECISION, self.roles());
        match (self.kind.is_step(), length) {
            (true, None) => graph.to_cuda_rollout("f", real, &roles),
            (true, Some(length)) => graph.to_cuda_rollout_in_parts("f", real, &roles, length),
            (false, None) => graph.to_cuda("f", real, &[]),
            (false, Some(length)) => graph.to_cuda_in_parts("f", real, &[], length),
        }
    }

    /// Loads it, compiled if it is not already; in parts of another length if one is given.
    pub(crate) fn load<R: Real>(
        &self,
        length: Option<usize>,
        device: &Device,
        with: &Compiler,
    ) -> Result<Loaded<R>, CudaError> {
        let (graph, roles) = (&self.graph, self.roles());
        if self.kind.is_step() {
            let stepper = match length {
                None => CudaStepper::new(graph, "f", &roles, device, with),
                Some(length) => CudaStepper::in_parts(graph, "f", &roles, length, device, with),
            };
            return stepper.map(Loaded::Steps);
        }
        let function = match length {
            None => CudaFunction::new(graph, "f", &[], device, with),
            Some(length) => CudaFunction::in_parts(graph, "f", &[], length, device, with),
        };
        function.map(Loaded::Batch)
    }

    /// Compiles it for an architecture into a folder. Gives the bytes of its machine code, and registers, spilled bytes, instructions, and seconds of processor time to compile,
    /// in a line, unless it was compiled before.
    pub(crate) fn precompile<R: Real>(
        &self,
        compiler: &Compiler,
        architecture: Architecture,
        folder: &Path,
    ) -> Result<(usize, String), CudaError> {
        let source = self.source::<R>(None)?;
        let sizes = Report::of(&source, compiler, architecture);
        let sizes = sizes.map_or_else(|_| String::new(), |sizes| sizes.to_string());
        let all = compiler.precompile(&source, architecture, folder)?;
        Ok((all.iter().map(|own| own.image().len()).sum(), sizes))
    }
}

/// Kinds of functions of a robot that a kit has.
pub(crate) fn kinds(robot: &Robot) -> Vec<Kind> {
    use Kind::{
        Feedback, ForwardDynamics, Gradients, InverseDynamics, Jacobians, JacobiansOfVariants,
        Step, StepOfVariants,
    };
    let mut out = match robot.ground {
        Ground::Absent => vec![
            InverseDynamics,
            ForwardDynamics,
            Step,
            Jacobians,
            Gradients,
            StepOfVariants,
            Feedback,
        ],
        Ground::Soft => vec![Step, Jacobians, Gradients],
        Ground::Relaxed => vec![Step],
    };
    if ["cartpole", "ur5"].contains(&robot.name.as_str()) {
        out.push(JacobiansOfVariants);
    }
    out
}

/// Whether a function of a robot is right in a precision.
pub(crate) fn serves<R: Real>(robot: &Robot) -> bool {
    robot.ground != Ground::Relaxed || R::PRECISION == dualbody::codegen::Precision::Double
}

/// Names of the masses of the last links, and of the damping of the last joint that has one.
fn varied(robot: &Robot) -> Vec<String> {
    const MASSES: usize = 2;
    let layout = robot.simulator.parameter_layout();
    let of = |word: &'static str, most: usize| {
        let names = layout.names().iter().rev();
        names.filter(move |name| name.ends_with(word)).take(most)
    };
    of("mass", MASSES)
        .chain(of("damping", 1))
        .cloned()
        .collect()
}
