//! Robots to measure.

use dualbody::contact::{ContactLaw, Contacts, RelaxedRigid, Terrain};
use dualbody::joint::JointKind;
use dualbody::model::{JointSpec, LinkSpec, Model, ModelBuilder};
use dualbody::{ModelOptions, Simulator, State};

/// The robots of `assets/` that most benches go through.
pub(crate) const ASSETS: [&str; 5] = ["cartpole", "ur5", "panda", "quadruped", "humanoid"];

/// Where the quadruped touches the ground.
pub(crate) const FEET: [&str; 4] = ["FR_foot", "FL_foot", "RR_foot", "RL_foot"];

/// Hip, thigh and knee of each of its legs when it stands, rad.
pub(crate) const CROUCH: [f64; 3] = [0.0, 0.8, -1.6];

/// Where the description of a robot of `assets/` lies.
pub(crate) fn path(name: &str) -> String {
    format!("{}/../assets/{name}.urdf", env!("CARGO_MANIFEST_DIR"))
}

/// A robot of `assets/`; joints that mimic others are joints of their own, as other engines have them.
pub(crate) fn asset(name: &str) -> Model {
    let options = ModelOptions::default().with_independent_mimic_joints();
    let (model, _) = options
        .load_urdf_file(path(name))
        .expect("the assets can be loaded");
    model
}

/// The quadruped with regularised contact at its feet, and a state in which all four are a millimetre deep.
pub(crate) fn standing() -> (Simulator, State) {
    standing_under(ContactLaw::RelaxedRigid(RelaxedRigid::default()))
}

/// The same under any law of contact.
pub(crate) fn standing_under(law: ContactLaw) -> (Simulator, State) {
    let model = asset("quadruped");
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law)
        .with_links(&model, &FEET)
        .expect("it has feet");
    let simulator = Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(1e-3);
    let mut state = simulator.neutral_state();
    for leg in state.q.as_mut_slice()[7..].chunks_mut(3) {
        leg.copy_from_slice(&CROUCH);
    }
    let report = simulator.contact_report(&state, &vec![0.0; simulator.nu()]);
    state.q[2] += report.points[0].depth - 1e-3;
    (simulator, state)
}

/// `n` rods one after the other.
pub(crate) fn chain(n: usize) -> Model {
    tree("chain", n, |i| i.checked_sub(1))
}

/// `n` rods of which each carries two: as deep as the logarithm of `n`.
pub(crate) fn bush(n: usize) -> Model {
    tree("bush", n, |i| (i > 0).then(|| (i - 1) / 2))
}

/// `n` rods of 1 kg and 1 m on revolute joints about x, y and z in turn.
fn tree(name: &str, n: usize, parent: impl Fn(usize) -> Option<usize>) -> Model {
    const ROD: [f64; 3] = [1.0 / 12.0, 1.0 / 12.0, 1e-3];
    let mut builder = ModelBuilder::new(name);
    builder.add_link(LinkSpec::new("world"));
    for i in 0..n {
        let mut axis = [0.0; 3];
        axis[i % 3] = 1.0;
        let (carrier, offset) = match parent(i) {
            Some(p) => (format!("rod{p}"), -1.0),
            None => ("world".to_owned(), 0.0),
        };
        let rod = format!("rod{i}");
        builder.add_link(LinkSpec::new(&rod).with_mass(1.0, [0.0, 0.0, -0.5], ROD));
        builder.add_joint(
            JointSpec::new(format!("joint{i}"), JointKind::Continuous, carrier, rod)
                .with_translation([0.0, 0.0, offset])
                .with_axis(axis),
        );
    }
    builder.build().expect("the trees are well formed")
}
