//! Machines that run kernels: the CPU, or a GPU.

use dualbody::codegen::RolloutInputs;
use dualbody::scalar::traced::Graph;
use dualbody_cuda::{
    Compiler, CudaFunction, CudaStepper, Device, Numbers, Outputs, Real, Schedule, Status,
    StepInputs,
};

/// Numbers for a rollout, those of one state after the other.
#[derive(Clone, Debug)]
pub(crate) struct Run<R> {
    pub(crate) schedule: Schedule,
    pub(crate) count: usize,
    pub(crate) state: Vec<R>,
    pub(crate) constants: Vec<R>,
    pub(crate) each_step: Vec<R>,
    pub(crate) shared: Vec<R>,
    pub(crate) status: Vec<i32>,
    pub(crate) taken: Vec<u32>,
}

/// Results of a rollout: its final `Run`, and the recorded trajectory of each state, one after the other.
pub(crate) struct Left<R> {
    pub(crate) run: Run<R>,
    pub(crate) kept: Vec<R>,
}

pub(crate) trait Machine {
    /// Runs the kernel of a function.
    fn batch<R: Real>(
        &self,
        graph: &Graph,
        shared: &[&str],
        count: usize,
        numbers: [&[R]; 2],
    ) -> Outputs<R>;

    /// Runs the kernel of a step.
    fn rollout<R: Real>(&self, graph: &Graph, inputs: &RolloutInputs, run: Run<R>) -> Left<R>;
}

/// A GPU.
pub(crate) struct Gpu {
    pub(crate) device: Device,
    pub(crate) compiler: Compiler,
}

impl Machine for Gpu {
    fn batch<R: Real>(
        &self,
        graph: &Graph,
        shared: &[&str],
        count: usize,
        numbers: [&[R]; 2],
    ) -> Outputs<R> {
        let function =
            CudaFunction::new(graph, "f", shared, &self.device, &self.compiler).expect("a kernel");
        function
            .call_states(count, numbers[0], numbers[1])
            .expect("a run")
    }

    fn rollout<R: Real>(&self, graph: &Graph, inputs: &RolloutInputs, run: Run<R>) -> Left<R> {
        let stepper =
            CudaStepper::new(graph, "f", inputs, &self.device, &self.compiler).expect("a kernel");
        assert!(
            run.status.iter().all(|&status| status == 0),
            "a GPU starts from the beginning"
        );
        let (sizes, count, schedule) = (stepper.sizes(), run.count, run.schedule);
        let array = |rows: usize, count: usize, numbers: &[R]| {
            Numbers::from_states(&self.device, rows, count, numbers).expect("an array")
        };
        let mut state = array(sizes.outputs, count, &run.state);
        let constants = array(sizes.inputs, count, &run.constants);
        let each_step = array(sizes.each_step * schedule.steps, count, &run.each_step);
        let shared = array(sizes.shared, 1, &run.shared);
        let mut kept =
            Numbers::zeros(&self.device, sizes.outputs * schedule.kept(), count).expect("an array");
        let mut status = Status::new(&self.device, count).expect("an array");
        let given = StepInputs {
            constants: &constants,
            each_step: &each_step,
            shared: &shared,
        };
        stepper
            .run(schedule, &mut state, given, &mut kept, &mut status)
            .expect("a run");
        let run = Run {
            state: state.download_states().expect("numbers"),
            status: status.found().expect("numbers"),
            taken: status.taken().expect("numbers"),
            ..run
        };
        Left {
            run,
            kept: kept.download_states().expect("numbers"),
        }
    }
}
