//! Kernels in machine code, without a GPU.

use dualbody::codegen::{CudaKernel, CudaSource, Precision, RolloutInputs};
use dualbody::model::samples;
use dualbody::{Simulator, scalar::traced::Graph};
use dualbody_cuda::{Architecture, Compiled, graphs};

use crate::errors::{Folder, has_nvrtc};

/// Every kernel of a simulator.
fn kernels(simulator: &Simulator, precision: Precision) -> Vec<CudaSource> {
    let model = simulator.model();
    let parameters = simulator.parameter_layout();
    let names: Vec<&str> = parameters
        .names()
        .iter()
        .map(String::as_str)
        .take(3)
        .collect();
    let step = graphs::step(simulator, &names).expect("parameters");
    let feedback = graphs::feedback_step(simulator, &[]).expect("no parameters");
    let roles = RolloutInputs::of_feedback();
    let rolled = |graph: &Graph, roles| graph.to_cuda_rollout("f", precision, roles);
    let functions = [
        graphs::inverse_dynamics(model),
        graphs::forward_dynamics(model),
        graphs::linearization(simulator),
        graphs::step_adjoint(simulator, &names).expect("parameters"),
    ];
    let all = functions
        .iter()
        .map(|graph| graph.to_cuda("f", precision, &[]));
    let steps = [
        rolled(&step, &RolloutInputs::default()),
        rolled(&feedback, &roles),
    ];
    all.chain(steps)
        .collect::<Result<_, _>>()
        .expect("names that C takes")
}

/// Checks that the machine code of a kernel, an ELF file, contains the name of the kernel.
fn check(kernel: &CudaKernel, found: &Compiled) {
    let log = found.log().expect("a kernel that was not there");
    assert!(log.contains("registers"), "{}: {log}", kernel.name());
    let image = found.image();
    assert!(image.starts_with(b"\x7fELF"));
    let name = kernel.name().as_bytes();
    assert!(image.windows(name.len()).any(|part| part == name));
}

#[test]
fn every_kernel_compiles_for_two_architectures() {
    let folder = Folder::new("code");
    if !has_nvrtc(&folder) {
        return;
    }
    let simulator = Simulator::new(samples::cartpole());
    for precision in [Precision::Double, Precision::Single] {
        for source in kernels(&simulator, precision) {
            for architecture in [Architecture::new(8, 0), Architecture::new(9, 0)] {
                let found = folder.compiler().compile_all(&source, architecture);
                let found = found.unwrap_or_else(|error| panic!("{error}"));
                assert_eq!(found.len(), source.kernels.len());
                for (kernel, found) in source.kernels.iter().zip(found) {
                    check(kernel, &found);
                }
            }
        }
    }
}
