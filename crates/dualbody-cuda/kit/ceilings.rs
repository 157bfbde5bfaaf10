//! Limits of a GPU: fused multiply-adds and bytes of memory a second; and the least that a function needs of both.

use std::collections::BTreeMap;

use dualbody::Scalar;
use dualbody::codegen::RolloutInputs;
use dualbody::scalar::traced::{Graph, Operation, Port, trace};
use dualbody_cuda::{
    Compiler, CudaError, CudaStepper, Device, Moment, Numbers, Real, Schedule, Status, StepInputs,
};

/// Chains that do not wait for one another.
const CHAINS: usize = 8;
/// Links of a chain in one step.
const LINKS: usize = 100;
/// Steps of a run.
const STEPS: usize = 400;
/// States of a run.
const COUNT: usize = 1 << 18;
/// Numbers that are copied.
const COPIED: usize = 1 << 27;
/// Runs, of which the median counts.
const RUNS: usize = 5;

/// The graph of the chains: a step of numbers that stay as they are, near one.
pub(crate) fn chains() -> Graph {
    trace(|t| {
        let x = t.input(Port::vector("v", CHAINS));
        let factors = t.input(Port::vector("factors", 2));
        let mut all = x.clone();
        for _ in 0..LINKS {
            for own in &mut all {
                *own = own.mul_add(factors[0], factors[1]);
            }
        }
        t.output(Port::vector("v_next", CHAINS), &all);
    })
}

/// Roles of the inputs of the chains.
pub(crate) fn roles() -> RolloutInputs {
    RolloutInputs {
        each_step: Vec::new(),
        ..RolloutInputs::default()
    }
}

/// Fused multiply-adds a second.
pub(crate) fn multiply_adds<R: Real>(
    device: &Device,
    compiler: &Compiler,
) -> Result<f64, CudaError> {
    let stepper = CudaStepper::<R>::new(&chains(), "chains", &roles(), device, compiler)?;
    let mut state = Numbers::zeros(device, CHAINS, COUNT)?;
    let number = |k: usize| R::from_f64(1.0 + 1e-3 * (k as f64).sin());
    let numbers: Vec<R> = (0..CHAINS * COUNT).map(number).collect();
    let mut factors = Numbers::zeros(device, 2, COUNT)?;
    let both = [0.999, 1e-3].map(R::from_f64);
    factors.upload(&both.map(|x| vec![x; COUNT]).concat())?;
    let (none, shared) = (
        Numbers::zeros(device, 0, COUNT)?,
        Numbers::zeros(device, 0, 1)?,
    );
    let mut kept = Numbers::zeros(device, 0, COUNT)?;
    let schedule = Schedule {
        steps: STEPS,
        every: 0,
        fastest: 1e9,
    };
    let seconds = median_of(RUNS, || {
        state.upload(&numbers)?;
        let mut status = Status::new(device, COUNT)?;
        let inputs = StepInputs {
            constants: &factors,
            each_step: &none,
            shared: &shared,
        };
        let start = device.moment()?;
        stepper.run(schedule, &mut state, inputs, &mut kept, &mut status)?;
        device.moment()?.since(&start)
    })?;
    Ok((CHAINS * LINKS * STEPS * COUNT) as f64 / seconds)
}

/// Bytes of its memory that the device reads and writes in a second, in a copy.
pub(crate) fn bandwidth(device: &Device) -> Result<f64, CudaError> {
    let numbers: Vec<f32> = (0..COPIED).map(|k| k as f32).collect();
    let mut from = Numbers::zeros(device, COPIED, 1)?;
    from.upload(&numbers)?;
    let mut to = Numbers::zeros(device, COPIED, 1)?;
    let seconds = median_of(RUNS, || {
        let start = device.moment()?;
        to.copy_from(&from)?;
        device.moment()?.since(&start)
    })?;
    Ok((2 * size_of::<f32>() * COPIED) as f64 / seconds)
}

/// The median of some times, s, after a first one that does not count.
pub(crate) fn median_of(
    runs: usize,
    mut run: impl FnMut() -> Result<f64, CudaError>,
) -> Result<f64, CudaError> {
    run()?;
    let mut all = (0..runs).map(|_| run()).collect::<Result<Vec<_>, _>>()?;
    all.sort_by(f64::total_cmp);
    Ok(all[all.len() / 2])
}

/// Time that some work took on the device, s.
pub(crate) fn timed(
    device: &Device,
    work: impl FnOnce() -> Result<(), CudaError>,
) -> Result<f64, CudaError> {
    let start: Moment = device.moment()?;
    work()?;
    device.moment()?.since(&start)
}

/// Operations that a graph needs at least, where a product and the sum that alone uses it are one.
pub(crate) fn fewest_operations(graph: &Graph) -> usize {
    let mut uses: BTreeMap<usize, usize> = BTreeMap::new();
    let operands = graph.nodes().iter().flat_map(Operation::operands);
    for used in operands.chain(graph.results().iter().copied()) {
        *uses.entry(used.index()).or_default() += 1;
    }
    let is_fused = |node: dualbody::scalar::traced::NodeId| {
        matches!(graph.nodes()[node.index()], Operation::Mul(..)) && uses[&node.index()] == 1
    };
    let fused = graph.nodes().iter().filter(|node| match node {
        Operation::Add(a, b) | Operation::Sub(a, b) => is_fused(*a) || is_fused(*b),
        Operation::Neg(_) => true,
        _ => false,
    });
    graph.counts().operations() - fused.count()
}
