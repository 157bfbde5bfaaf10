//! The kernels of a robot.

use std::error::Error;
use std::path::Path;

use dualbody::codegen::{CodeError, CudaSource, Precision, RolloutInputs};
use dualbody::scalar::traced::Graph;
use dualbody::{Model, Simulator};
use dualbody_cuda::graphs;

/// Robots whose derivatives take long to compile; they are counted where their name has `+` at its end.
const LARGE: [&str; 2] = ["quadruped", "humanoid"];

pub(crate) struct Kernel {
    /// Kernel and precision.
    pub(crate) name: String,
    pub(crate) source: CudaSource,
    pub(crate) operations: usize,
}

/// All kernels of a robot of the assets.
pub(crate) fn kernels(robot: &str) -> Result<Vec<Kernel>, Box<dyn Error>> {
    let (name, all) = match robot.strip_suffix('+') {
        Some(name) => (name, true),
        None => (robot, !LARGE.contains(&robot)),
    };
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
    let model = Model::from_urdf_file(assets.join(format!("{name}.urdf")))?;
    let simulator = Simulator::new(model.clone()).with_time_step(1e-3);
    let mut out = Vec::new();
    let batch = |graph: &Graph, precision| graph.to_cuda("f", precision, &[]);
    add(&mut out, "rnea", &graphs::inverse_dynamics(&model), batch)?;
    add(&mut out, "aba", &graphs::forward_dynamics(&model), batch)?;
    let rollout =
        |graph: &Graph, precision| graph.to_cuda_rollout("f", precision, &RolloutInputs::default());
    add(
        &mut out,
        "rollout",
        &graphs::step(&simulator, &[])?,
        rollout,
    )?;
    if all {
        add(
            &mut out,
            "gradients",
            &graphs::step_adjoint(&simulator, &[])?,
            batch,
        )?;
        add(
            &mut out,
            "jacobians",
            &graphs::linearization(&simulator),
            batch,
        )?;
    }
    Ok(out)
}

/// Adds a kernel in both precisions.
fn add(
    out: &mut Vec<Kernel>,
    name: &str,
    graph: &Graph,
    source: impl Fn(&Graph, Precision) -> Result<CudaSource, CodeError>,
) -> Result<(), CodeError> {
    for (precision, word) in [(Precision::Double, "f64"), (Precision::Single, "f32")] {
        out.push(Kernel {
            name: format!("{name}/{word}"),
            source: source(graph, precision)?,
            operations: graph.counts().operations(),
        });
    }
    Ok(())
}
