//! Links that gravity does not act on: against closed forms, against robots whose inertias are set by hand, and derivatives against differences.

use dualbody::autodiff::{VectorFunction, finite_difference, jacobian};
use dualbody::dynamics::{
    bias_forces, forward_dynamics, forward_dynamics_derivatives, forward_dynamics_vjp,
    gravity_forces, inverse_dynamics, inverse_dynamics_derivatives, inverse_dynamics_vjp,
    joint_torque_regressor, mass_matrix, potential_energy, potential_energy_regressor,
};
use dualbody::joint::JointKind;
use dualbody::model::{BodyId, JointSpec, LinkSpec, Model, ModelBuilder};
use dualbody::sim::BatchSimulator;
use dualbody::{Integrator, ModelOptions, Scalar, Simulator, State};
use nalgebra::{DVector, Vector3};

use crate::common::ground::{body, differences};
use crate::common::{FINITE_DIFFERENCE, OTHER_ALGORITHM, SAME_ALGEBRA, generator, random_point};

/// Two links of 0.5 m: 1 kg at 0.25 m, and 2 kg at 0.25 m beyond the second hinge, without gravity by a setting of Gazebo.
const ARM: &str = r#"<robot name="arm">
  <link name="world"/>
  <link name="upper"><inertial><origin xyz="0.25 0 0"/><mass value="1"/><inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0.25 0 0"/><mass value="2"/><inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="continuous"><parent link="world"/><child link="upper"/><axis xyz="0 1 0"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/><origin xyz="0.5 0 0"/><axis xyz="0 1 0"/></joint>
  <gazebo reference="lower"><gravity>OFF</gravity></gazebo>
</robot>"#;

fn arm(off: &str) -> Model {
    Model::from_urdf_str(&ARM.replace("OFF", off)).expect("an arm")
}

// Hinge 1 holds 1 kg at 0.25 m; with gravity on the other link 2 kg at 0.75 m more.
#[test]
fn holding_torque_is_that_of_the_links_with_gravity() {
    for off in ["false", "0", " False "] {
        let held = gravity_forces(&arm(off), &[0.0, 0.0]);
        assert!((held[0].abs() - 2.4525).abs() < 1e-12, "{held}");
        assert!(held[1].abs() < 1e-12);
    }
    let all = gravity_forces(&arm("true"), &[0.0, 0.0]);
    assert!((all[0].abs() - (2.4525 + 9.81 * 1.5)).abs() < 1e-12);
    let other = ARM.replace(
        "<gravity>OFF</gravity>",
        "<turnGravityOff>true</turnGravityOff>",
    );
    let held = gravity_forces(&Model::from_urdf_str(&other).expect("an arm"), &[0.0, 0.0]);
    assert!((held[0].abs() - 2.4525).abs() < 1e-12);
}

#[test]
fn settings_that_name_no_link_or_no_truth_are_warned_of() {
    let warned = |text: &str| {
        let (_, report) = ModelOptions::default().load_urdf_str(text).expect("an arm");
        assert!(report.ignored.is_empty(), "{report}");
        report.warnings.first().map(|note| note.reason.clone())
    };
    assert_eq!(warned(&ARM.replace("OFF", "false")), None);
    let odd = warned(&ARM.replace("OFF", "maybe")).expect("a warning");
    assert!(odd.contains("neither true nor false"), "{odd}");
    let nobody = ARM
        .replace("OFF", "false")
        .replace("reference=\"lower\"", "reference=\"none\"");
    assert!(
        warned(&nobody)
            .expect("a warning")
            .contains("no link \"none\"")
    );
}

#[test]
fn sdf_link_without_gravity_falls_not() {
    let text = "<sdf version='1.9'><model name='b'><link name='a'><gravity>false</gravity><inertial><mass>1</mass>\
        <inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link></model></sdf>";
    for (text, falls) in [(text.to_owned(), false), (text.replace("false", "1"), true)] {
        let (model, report) = ModelOptions::default().load_sdf_str(&text).expect("a body");
        assert!(report.ignored.is_empty(), "{report}");
        let simulator = Simulator::new(model);
        let end = simulator.rollout(&simulator.neutral_state(), 10, |_, _, _| {});
        assert_eq!(end.last().q[2] < 0.0, falls);
    }
}

/// A floating base, links on joints of several kinds, a mimic joint, and links fixed to one another: some without gravity, one of them as a part of a body.
fn robot() -> Model {
    let mut builder = ModelBuilder::new("robot").with_gravity([0.3, -1.0, -9.0]);
    let link = |name: &str, m: f64| {
        LinkSpec::new(name).with_mass(m, [0.1 * m, -0.05, 0.07], [0.03, 0.04, 0.05])
    };
    builder
        .add_link(link("base", 2.0))
        .add_link(link("camera", 0.7).without_gravity())
        .add_link(link("ball", 1.1).without_gravity())
        .add_link(link("slide", 0.6))
        .add_link(link("weight", 0.9).without_gravity())
        .add_link(link("tip", 0.5))
        .add_link(link("finger", 0.4).without_gravity());
    let joint = |name: &str, kind, parent: &str, child: &str| {
        JointSpec::new(name, kind, parent, child)
            .with_translation([0.2, 0.1, -0.1])
            .with_axis([0.6, 0.0, 0.8])
    };
    builder
        .add_joint(joint("mount", JointKind::Fixed, "base", "camera"))
        .add_joint(joint("shoulder", JointKind::Spherical, "camera", "ball"))
        .add_joint(joint("rail", JointKind::Prismatic, "ball", "slide").with_armature(0.1))
        .add_joint(joint("weld", JointKind::Fixed, "slide", "weight"))
        .add_joint(joint("wrist", JointKind::Revolute, "weight", "tip"))
        .add_joint(joint("grip", JointKind::Revolute, "base", "finger"));
    builder.build().expect("a robot")
}

/// Σ Jᵀ of the weights of the links without gravity, which the same robot with gravity everywhere needs beside.
fn weights_without(model: &Model, q: &[f64]) -> DVector<f64> {
    let mut out = DVector::zeros(model.nv());
    for (i, _) in model.bodies().iter().enumerate() {
        let (mass, moment) = model.weightless_part(BodyId(i));
        let slope = |k: usize| {
            let height = |by: f64| {
                let mut dq = vec![0.0; model.nv()];
                dq[k] = by;
                let q = model.integrate(q, &dq);
                let kinematics = dualbody::dynamics::forward_kinematics(
                    model,
                    q.as_slice(),
                    &vec![0.0; model.nv()],
                );
                let pose = kinematics.pose(Some(BodyId(i)));
                (pose.translation * mass + pose.rotation * moment).dot(model.gravity())
            };
            (height(1e-5) - height(-1e-5)) / 2e-5
        };
        for k in 0..model.nv() {
            out[k] += slope(k);
        }
    }
    out
}

/// The robot with gravity on all links.
fn heavy() -> Model {
    let mut builder = ModelBuilder::new("robot").with_gravity([0.3, -1.0, -9.0]);
    let own = robot().to_builder();
    for link in &own.links {
        builder.add_link(LinkSpec::new(&link.name).with_inertia(link.inertia));
    }
    own.joints.iter().for_each(|joint| {
        builder.add_joint(joint.clone());
    });
    builder.build().expect("a robot")
}

#[test]
fn parts_of_bodies_are_the_links_that_were_named() {
    let model = robot();
    let parts: Vec<f64> = (0..model.n_bodies())
        .map(|i| model.weightless_part(BodyId(i)).0)
        .collect();
    assert_eq!(model.n_bodies(), 5);
    let expected = [0.7, 1.1, 0.9, 0.0, 0.4];
    for (part, expected) in parts.iter().zip(expected) {
        assert!((part - expected).abs() < 1e-14, "{parts:?}");
    }
}

#[test]
fn inverse_dynamics_lack_the_weights_and_nothing_else() {
    let (model, heavy) = (robot(), heavy());
    let point = random_point(&model, 3);
    let (q, v, a) = (point.q.as_slice(), point.v.as_slice(), point.w.as_slice());
    let lacking = inverse_dynamics(&heavy, q, v, a) - inverse_dynamics(&model, q, v, a);
    // Lifting against gravity takes −g.
    let error = (lacking + weights_without(&model, q)).amax();
    assert!(error < FINITE_DIFFERENCE, "{error:e}");
    assert_eq!(mass_matrix(&heavy, q), mass_matrix(&model, q));
    let weightless = model.clone().with_gravity(Vector3::zeros());
    let other = heavy.with_gravity(Vector3::zeros());
    assert_eq!(
        inverse_dynamics(&other, q, v, a),
        inverse_dynamics(&weightless, q, v, a)
    );
}

#[test]
fn forward_dynamics_are_inverse_to_inverse_dynamics() {
    let model = robot();
    let point = random_point(&model, 4);
    let (q, v, a) = (point.q.as_slice(), point.v.as_slice(), point.w.as_slice());
    let tau = inverse_dynamics(&model, q, v, a);
    let again = forward_dynamics(&model, q, v, tau.as_slice());
    assert!((again - &point.w).amax() < OTHER_ALGORITHM);
    let h = bias_forces(&model, q, v);
    assert!((mass_matrix(&model, q) * &point.w + h - tau).amax() < OTHER_ALGORITHM);
}

#[test]
fn potential_energy_has_the_gravity_forces_as_its_gradient() {
    let model = robot();
    let point = random_point(&model, 5);
    let q = point.q.as_slice();
    let g = gravity_forces(&model, q);
    for k in 0..model.nv() {
        let energy = |by: f64| {
            let mut dq = vec![0.0; model.nv()];
            dq[k] = by;
            potential_energy(&model, model.integrate(q, &dq).as_slice())
        };
        let slope = (energy(1e-5) - energy(-1e-5)) / 2e-5;
        assert!((slope - g[k]).abs() < FINITE_DIFFERENCE, "{k}");
    }
}

#[test]
fn regressors_times_parameters_equal_what_they_are_of() {
    let model = robot();
    let point = random_point(&model, 6);
    let (q, v, a) = (point.q.as_slice(), point.v.as_slice(), point.w.as_slice());
    let of_body = |i: usize| model.body(BodyId(i)).inertia.to_parameters();
    let values: Vec<f64> = (0..model.n_bodies()).flat_map(of_body).collect();
    let values = DVector::from_vec(values);
    let rotors = DVector::from_iterator(
        model.nv(),
        model.armature().iter().zip(a).map(|(r, a)| r * a),
    );
    let tau = joint_torque_regressor(&model, q, v, a) * &values + rotors;
    assert!((tau - inverse_dynamics(&model, q, v, a)).amax() < SAME_ALGEBRA * 100.0);
    let energy = (potential_energy_regressor(&model, q) * values)[0];
    assert!((energy - potential_energy(&model, q)).abs() < SAME_ALGEBRA * 10.0);
}

/// Inverse dynamics as a function of all parameters.
struct InParameters<'a>(&'a Model, [&'a [f64]; 3]);

impl VectorFunction for InParameters<'_> {
    fn n_outputs(&self) -> usize {
        self.0.nv()
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let model = self.0.cast::<T>().with_parameters(x);
        let [q, v, a] = self
            .1
            .map(|x| x.iter().map(|&x| T::constant(x)).collect::<Vec<_>>());
        y.copy_from_slice(inverse_dynamics(&model, &q, &v, &a).as_slice());
    }
}

#[test]
fn derivatives_in_state_and_parameters_equal_those_of_dual_numbers_and_differences() {
    let model = robot();
    let point = random_point(&model, 7);
    let (q, v, a) = (point.q.as_slice(), point.v.as_slice(), point.w.as_slice());
    let exact = inverse_dynamics_derivatives(&model, q, v, a);
    for k in 0..model.nv() {
        let at = |by: f64| {
            let mut dq = vec![0.0; model.nv()];
            dq[k] = by;
            inverse_dynamics(&model, model.integrate(q, &dq).as_slice(), v, a)
        };
        let numeric = (at(1e-6) - at(-1e-6)) / 2e-6;
        let error = (exact.dq.column(k) - numeric).amax();
        assert!(error < 1e-7, "{k}: {error:e}");
    }
    let mu = DVector::from_fn(model.nv(), |k, _| 0.3 + 0.1 * k as f64);
    let slopes = inverse_dynamics_vjp(&model, q, v, a, mu.as_slice());
    assert!((&slopes.q - exact.dq.tr_mul(&mu)).amax() < OTHER_ALGORITHM);
    let f = InParameters(&model, [q, v, a]);
    let x = model.parameters();
    let all = jacobian(&f, x.as_slice());
    assert!((&slopes.parameters - all.tr_mul(&mu)).amax() < OTHER_ALGORITHM);
    assert!((all - finite_difference::jacobian(&f, x.as_slice())).amax() < 1e-6);
    let forward = forward_dynamics_derivatives(&model, q, v, a);
    let lambda = forward_dynamics_vjp(&model, q, v, a, mu.as_slice());
    assert!((&lambda.q - forward.dq.tr_mul(&mu)).amax() < 1e-8);
}

#[test]
fn jacobians_and_adjoints_of_steps_equal_differences() {
    for integrator in [
        Integrator::SemiImplicitEuler,
        Integrator::ImplicitVelocity,
        Integrator::RungeKutta4,
    ] {
        let model = (6..robot().nv()).fold(robot(), |m, k| m.with_damping(k, 0.2));
        let simulator = Simulator::new(model.clone())
            .with_integrator(integrator)
            .with_time_step(5e-3);
        let state = State::random(&model, &mut generator(2), 1.0);
        let u = vec![0.0; simulator.nu()];
        let step = simulator.linearize(&state, &u);
        let numeric = differences(&simulator, &state, 1e-6);
        let error = (&step.a - numeric).amax();
        assert!(error < 1e-7, "{integrator:?}: {error:e}");
        let lambda: Vec<f64> = (0..simulator.n_tangent())
            .map(|k| (k as f64).sin())
            .collect();
        let slopes = simulator.vjp(&state, &u, &lambda);
        let expected = step.a.tr_mul(&DVector::from_column_slice(&lambda));
        assert!((slopes.state - expected).amax() < OTHER_ALGORITHM);
    }
}

// Lanes, and many states of a robot whose branches would be packed.
#[test]
fn batches_equal_single_rollouts() {
    let simulator = Simulator::new(robot()).with_time_step(2e-3);
    let rng = &mut generator(9);
    let starts: Vec<State> = (0..11)
        .map(|_| State::random(simulator.model(), rng, 1.0))
        .collect();
    let mut batch = BatchSimulator::new(simulator.clone(), starts.len());
    let all = batch.rollout(&starts, 50, |_, _, _| {});
    for (k, start) in starts.iter().enumerate() {
        let alone = simulator.rollout(start, 50, |_, _, _| {});
        assert!((&all.last(k).q - &alone.last().q).amax() < OTHER_ALGORITHM);
    }
}

// A body without gravity flies straight, one half of which is a link with gravity falls half as fast.
#[test]
fn free_bodies_fall_by_the_share_that_gravity_acts_on() {
    let fall = |model: Model| {
        let simulator = Simulator::new(model).with_time_step(1e-3);
        simulator.step(&simulator.neutral_state(), &[]).v[2]
    };
    let point = |name: &str| LinkSpec::new(name).with_mass(1.5, [0.0; 3], [0.1; 3]);
    assert_eq!(fall(body(point("a").without_gravity())), 0.0);
    let mut pair = ModelBuilder::new("pair");
    pair.add_link(point("a"))
        .add_link(point("b").without_gravity());
    pair.add_joint(JointSpec::new("weld", JointKind::Fixed, "a", "b"));
    let speed: f64 = fall(pair.build().expect("a pair"));
    assert!((speed + 0.5 * 9.81e-3).abs() < 1e-15, "{speed}");
}

#[test]
fn written_urdf_reads_back_and_mjcf_has_gravity_compensation() {
    let model = robot();
    let again = Model::from_urdf_str(&model.to_urdf().expect("a URDF")).expect("a robot");
    let again = again.with_gravity(*model.gravity());
    let point = random_point(&model, 8);
    let apart =
        gravity_forces(&again, point.q.as_slice()) - gravity_forces(&model, point.q.as_slice());
    assert!(apart.amax() < OTHER_ALGORITHM);
    let mjcf = model.to_mjcf().expect("an MJCF");
    let named = |line: &&str| line.contains("gravcomp=\"1\"");
    let names: Vec<&str> = mjcf.lines().filter(named).collect();
    assert_eq!(names.len(), 4, "{names:?}");
    for link in ["camera", "ball", "weight", "finger"] {
        assert!(
            names
                .iter()
                .any(|line| line.contains(&format!("name=\"{link}\""))),
            "{link}"
        );
    }
    // Masses apart, each at its own link.
    assert_eq!(mjcf.matches("<inertial").count(), 7);
}
