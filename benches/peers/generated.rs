//! Our side of the comparison of generated code: C of a robot's dynamics, its step and its Jacobians; `generated.py` runs it.
//!
//! ```sh
//! generated FILE.urdf fixed|floating NAME FOLDER     # FOLDER/NAME_FUNCTION.c and .h; prints their operations, and where joints are
//! ```

#[path = "../common/mod.rs"]
mod common;

use std::error::Error;

use common::clock::arguments;
use dualbody::codegen::{self, Precision};
use dualbody::model::Base;
use dualbody::{Model, ModelOptions, Simulator};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = arguments();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let (file, base, name, folder) = match arguments[..] {
        [file, "fixed", name, folder] => (file, Base::Fixed, name, folder),
        [file, "floating", name, folder] => (file, Base::Floating, name, folder),
        _ => {
            println!("usage: see benches/peers/generated.py");
            return Ok(());
        }
    };
    let options = ModelOptions::default()
        .with_base(base)
        .with_independent_mimic_joints();
    let simulator = Simulator::new(options.load_urdf_file(file)?.0);
    print_joints(simulator.model());
    write(&simulator, name, folder)
}

/// Name, first of q and of v of each joint.
fn print_joints(model: &Model) {
    println!("nq {}", model.nq());
    println!("nv {}", model.nv());
    println!("mass {:.6}", model.total_mass());
    for name in model.joint_names() {
        let joint = model.joint(name).expect("a joint of the list");
        let (q, v) = (model.joint_q(joint).start, model.joint_v(joint).start);
        println!("joint {name} {q} {v}");
    }
}

fn write(simulator: &Simulator, name: &str, folder: &str) -> Result<(), Box<dyn Error>> {
    let model = simulator.model();
    let functions = [
        ("rnea", codegen::inverse_dynamics(model)),
        ("aba", codegen::forward_dynamics(model)),
        (
            "rnea_derivatives",
            codegen::inverse_dynamics_derivatives(model),
        ),
        ("step", codegen::step(simulator)),
        ("linearization", codegen::linearization(simulator)),
    ];
    for (what, graph) in functions {
        let function = format!("{name}_{what}");
        graph.to_c(&function, Precision::Double)?.save(folder)?;
        println!("operations {what} {}", graph.counts().operations());
    }
    Ok(())
}
