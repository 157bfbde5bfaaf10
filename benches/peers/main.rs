//! Our side of the comparison with other engines: times of one robot, one line a quantity; `run.sh` runs it in turn with theirs.
//!
//! ```sh
//! peers FILE.urdf fixed|floating
//! ```

#[path = "../common/mod.rs"]
mod common;

use common::clock::{Clock, arguments, is_test};
use common::functions::{
    aba, crba, forward_derivatives, inverse_derivatives, linearize, rnea, step,
};
use common::points::{Point, points};
use common::robots::path;
use dualbody::model::Base;
use dualbody::{ModelOptions, Simulator};

fn main() {
    let arguments = arguments();
    match &arguments[..] {
        [] if is_test() => report(&path("panda"), Base::Fixed, Clock::ONCE),
        [file, base] if base == "fixed" => report(file, Base::Fixed, Clock::EXACT),
        [file, base] if base == "floating" => report(file, Base::Floating, Clock::EXACT),
        _ => println!("usage: peers FILE.urdf fixed|floating; bash benches/peers/run.sh does all"),
    }
}

fn report(file: &str, base: Base, clock: Clock) {
    let options = ModelOptions::default()
        .with_base(base)
        .with_independent_mimic_joints();
    let (model, _) = options
        .load_urdf_file(file)
        .unwrap_or_else(|error| panic!("{error}"));
    let simulator = Simulator::new(model);
    let s = &simulator;
    println!("nv {}", s.model().nv());
    println!("mass {:.6}", s.model().total_mass());
    let points = points(s);
    let time = |name: &str, function: &mut dyn FnMut(&Point<f64>)| {
        println!("{name} {:.6}", clock.over(&points, function) * 1e6);
    };
    time("rnea", &mut rnea(s));
    time("crba", &mut crba(s));
    time("aba", &mut aba(s));
    time("inverse_dynamics_derivatives", &mut inverse_derivatives(s));
    time("forward_dynamics_derivatives", &mut forward_derivatives(s));
    time("step", &mut step(s));
    time("linearize", &mut linearize(s));
}
