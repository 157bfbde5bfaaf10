//! MJCF: descriptions of this folder's neighbour `tests/mjcf` against `MuJoCo`'s results for the same text, and other files that are read.

use std::fs;
use std::path::PathBuf;

use dualbody::constraint::ConstraintKind;
use dualbody::contact::{ContactLaw, Reference};
use dualbody::dynamics::{bias_forces, forward_dynamics, frame_pose, mass_matrix};
use dualbody::io::{ImportReport, MjcfScene};
use dualbody::model::samples;
use dualbody::sim::{Actuation, Actuator, Interval};
use dualbody::spatial::Quaternion;
use dualbody::{Base, Integrator, Model, ModelOptions, Simulator, State};
use nalgebra::{DMatrix, DVector, Vector3};

use crate::common::{OTHER_ALGORITHM, SAME_ALGEBRA};

/// Descriptions with golden values, made by `tests/mjcf/make.py`.
const DESCRIPTIONS: [&str; 4] = ["chain", "free", "world", "attach"];

/// One with actuators, which act.
const SERVOS: &str = "servos";

/// Numbers are compared relative to the largest of a record, or to this if all are smaller.
const NEGLIGIBLE: f64 = 1e-3;

fn path(file: &str) -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "tests", "mjcf", file]
        .iter()
        .collect()
}

pub(crate) fn file(name: &str) -> MjcfScene {
    let loaded = ModelOptions::default().load_mjcf_scene_file(path(&format!("{name}.xml")));
    loaded.unwrap_or_else(|error| panic!("{error}")).0
}

fn text(xml: &str) -> (MjcfScene, ImportReport) {
    let loaded = ModelOptions::default().load_mjcf_scene_str(xml);
    loaded.unwrap_or_else(|error| panic!("{error}"))
}

/// A description with one body that turns about y, and more.
fn rod(more: &str) -> String {
    format!(
        "<mujoco><worldbody><body name='rod'><joint name='hinge' axis='0 1 0'/>\n<geom type='capsule' fromto='0 0 0 0 0 -1' size='0.02' mass='1'/>\n</body></worldbody>{more}</mujoco>"
    )
}

pub(crate) type Record = (String, DMatrix<f64>);

/// The records of golden values: those of each state, and of the motion at the end.
pub(crate) fn golden(name: &str) -> Vec<Vec<Record>> {
    let text = fs::read_to_string(path(&format!("{name}.txt"))).expect("golden values");
    let mut out: Vec<Vec<Record>> = Vec::new();
    for line in text.lines() {
        let (key, rest) = line.split_once(' ').expect("a key");
        match (key, out.last_mut()) {
            ("state" | "motion", _) => out.push(Vec::new()),
            (_, None) => {}
            (_, Some(records)) => records.push((key.into(), matrix(rest))),
        }
    }
    out
}

fn matrix(text: &str) -> DMatrix<f64> {
    let numbers: Vec<f64> = text
        .split(' ')
        .map(|word| word.parse().expect("a number"))
        .collect();
    DMatrix::from_row_slice(numbers[0] as usize, numbers[1] as usize, &numbers[2..])
}

pub(crate) fn find<'a>(records: &'a [Record], name: &str) -> &'a [f64] {
    let found = records.iter().find(|(key, _)| key == name);
    found.unwrap_or_else(|| panic!("no {name}")).1.as_slice()
}

/// Forces of dampers and springs.
fn passive(model: &Model, q: &[f64], v: &[f64]) -> DVector<f64> {
    let mut tau = DVector::from_fn(model.nv(), |k, _| -model.damping()[k] * v[k]);
    for joint in model.joints() {
        let id = model.joint(&joint.name).expect("a joint");
        let (at_q, at_v) = (model.joint_q(id), model.joint_v(id));
        if at_v.len() == 1 {
            let spring = &model.springs()[at_v.start];
            tau[at_v.start] -= spring.stiffness * (q[at_q.start] - spring.rest);
        }
    }
    tau
}

fn check(ours: &DMatrix<f64>, theirs: &[f64], what: &str) {
    let theirs = DMatrix::from_column_slice(ours.nrows(), ours.ncols(), theirs);
    let size = theirs.amax().max(NEGLIGIBLE);
    let error = (ours - &theirs).amax() / size;
    assert!(error < OTHER_ALGORITHM, "{what}: {error:e}");
}

#[test]
fn dynamics_equal_those_that_mujoco_finds_of_the_same_text() {
    for name in DESCRIPTIONS {
        let model = file(name).model;
        let states = golden(name);
        for (k, records) in states[..states.len() - 1].iter().enumerate() {
            let at = |what: &str| format!("{name}, state {k}: {what}");
            let [q, v, tau] = ["q", "v", "tau"].map(|key| find(records, key));
            let total = DVector::from_column_slice(tau) + passive(&model, q, v);
            let a = forward_dynamics(&model, q, v, total.as_slice());
            let column = |x: &DVector<f64>| DMatrix::from_column_slice(x.len(), 1, x.as_slice());
            check(
                &mass_matrix(&model, q),
                find(records, "mass_matrix"),
                &at("M"),
            );
            check(
                &column(&bias_forces(&model, q, v)),
                find(records, "bias_forces"),
                &at("h"),
            );
            check(&column(&a), find(records, "acceleration"), &at("a"));
            check_poses(&model, q, records, &at("poses"));
        }
    }
}

fn check_poses(model: &Model, q: &[f64], records: &[Record], at: &str) {
    for (key, pose) in records {
        let Some(frame) = key.strip_prefix("pose:") else {
            continue;
        };
        let id = model
            .frame(frame)
            .unwrap_or_else(|| panic!("{at}: no frame {frame}"));
        let ours = frame_pose(model, q, id);
        let position = ours.translation.iter().copied();
        let entries = ours.rotation.transpose();
        let all: Vec<f64> = position.chain(entries.iter().copied()).collect();
        check(
            &DMatrix::from_vec(12, 1, all),
            pose.as_slice(),
            &format!("{at} of {frame}"),
        );
    }
}

#[test]
fn joints_keep_their_names_and_order() {
    for name in DESCRIPTIONS {
        let text = fs::read_to_string(path(&format!("{name}.txt"))).expect("golden values");
        let joints = text.lines().find_map(|line| line.strip_prefix("joints "));
        let model = file(name).model;
        let expected: Vec<&str> = joints.expect("names").split(' ').collect();
        assert_eq!(model.joint_names(), expected, "{name}");
    }
}

// Runge and Kutta's method in both, one second in steps of 0.1 ms.
#[test]
fn a_second_of_motion_equals_that_of_mujoco() {
    let records = golden("chain").pop().expect("a motion");
    let model = file("chain").model;
    let simulator = Simulator::new(model)
        .with_time_step(1e-4)
        .with_integrator(Integrator::RungeKutta4);
    let [q, v] = ["q", "v"].map(|key| find(&records, key));
    let mut state = simulator.state(q, v);
    let u = vec![0.0; simulator.nu()];
    for _ in 0..10_000 {
        state = simulator.step(&state, &u);
    }
    let [q, v] = ["end_q", "end_v"].map(|key| DVector::from_column_slice(find(&records, key)));
    let error = (state.q - q).amax().max((state.v - v).amax());
    assert!(error < OTHER_ALGORITHM, "{error:e}");
}

/// The simulator of the scene of actuators, by Runge and Kutta's method, and its states.
fn servos() -> (MjcfScene, Simulator, Vec<Vec<Record>>) {
    let scene = file(SERVOS);
    let model = scene.model.clone();
    // Limits and friction losses are switched off there.
    let actuators = scene.simulator().actuation().expect("servos").clone();
    let unlimited: Vec<Actuator> = (actuators.actuators().iter())
        .map(|own| Actuator {
            position: None,
            ..*own
        })
        .collect();
    let simulator = scene
        .simulator()
        .with_actuation(Actuation::ideal(&model).with_actuators(&unlimited))
        .with_time_step(1e-4);
    (scene, simulator, golden(SERVOS))
}

#[test]
fn accelerations_under_controls_equal_those_of_mujoco() {
    let (scene, simulator, states) = servos();
    assert_eq!(scene.options.integrator, Integrator::RungeKutta4);
    for (k, records) in states[..states.len() - 1].iter().enumerate() {
        let [q, v, control] = ["q", "v", "control"].map(|key| find(records, key));
        let a = simulator.acceleration(&simulator.state(q, v), &scene.inputs(control));
        let a = DMatrix::from_column_slice(a.len(), 1, a.as_slice());
        check(&a, find(records, "acceleration"), &format!("state {k}: a"));
    }
}

// Runge and Kutta's method in both, one second in steps of 0.1 ms, while inputs and forces are at their limits and within.
#[test]
fn a_second_of_motion_under_controls_equals_that_of_mujoco() {
    let (scene, simulator, mut states) = servos();
    let records = states.pop().expect("a motion");
    let [q, v, control] = ["q", "v", "control"].map(|key| find(&records, key));
    let (mut state, u) = (simulator.state(q, v), scene.inputs(control));
    for _ in 0..10_000 {
        state = simulator.step(&state, &u);
    }
    let [q, v] = ["end_q", "end_v"].map(|key| DVector::from_column_slice(find(&records, key)));
    let error = (state.q - q).amax().max((state.v - v).amax());
    assert!(error < OTHER_ALGORITHM, "{error:e}");
}

#[test]
fn reference_is_where_the_file_has_its_bodies() {
    for name in ["chain", "world"] {
        let (scene, states) = (file(name), golden(name));
        let expected = DVector::from_column_slice(find(&states[0], "q"));
        assert!(
            (scene.reference.q - expected).amax() < SAME_ALGEBRA,
            "{name}"
        );
    }
}

#[test]
fn defaults_that_limit_joints_do_not_reach_free_ones() {
    let xml = r#"<mujoco><default><joint limited="true" actuatorfrclimited="true"/></default><worldbody><body name="box">
        <joint name="root" type="free"/><geom type="box" size="0.1 0.1 0.1"/></body></worldbody></mujoco>"#;
    let (scene, report) = text(xml);
    assert_eq!((scene.model.nq(), scene.model.nv()), (7, 6), "{report}");
}

#[test]
fn a_free_body_alone_floats_and_options_hold_it() {
    let free = "<mujoco><worldbody><body name='box' pos='0 0 2'><freejoint/><geom size='0.1'/></body></worldbody></mujoco>";
    let (scene, _) = text(free);
    assert!(scene.model.has_floating_base() && scene.reference.q[2] == 2.0);
    let held = ModelOptions::default()
        .with_base(Base::Fixed)
        .load_mjcf_str(free);
    let held = held.expect("a box").0;
    let pose = frame_pose(&held, &[], held.frame("box").expect("a link"));
    assert_eq!((held.nv(), pose.translation.z), (0, 2.0));
}

#[test]
fn what_is_not_used_is_in_the_report_with_its_line() {
    let xml = rod(
        "\n<option wind='1 0 0' colour='red'/>\n<actuator><muscle joint='hinge'/></actuator>\n<sensor>\n<jointpos joint='hinge'/></sensor><thing/>",
    );
    let (scene, report) = text(&xml);
    let notes: Vec<(&str, u32)> = report
        .ignored
        .iter()
        .map(|note| (&*note.path, note.line))
        .collect();
    let expected = [
        ("mujoco/option@wind", 4),
        ("mujoco/option@colour", 4),
        ("mujoco/actuator/muscle", 5),
        ("mujoco/thing", 7),
    ];
    for note in expected {
        assert!(notes.contains(&note), "{note:?} is not in {notes:?}");
    }
    assert_eq!(notes.len(), expected.len(), "{report}");
    assert_eq!(
        (
            scene.sensors[0].kind.as_str(),
            scene.sensors[0].object.as_str()
        ),
        ("jointpos", "hinge")
    );
    assert!(scene.actuation[0].servo.is_none());
}

#[test]
fn geoms_of_other_numbers_of_contact_than_the_first_are_in_the_report() {
    let ball = |numbers: &str| format!("<geom type='sphere' size='0.1' mass='1' {numbers}/>");
    let world = |geoms: &[String]| {
        let all = geoms.join("\n");
        text(&format!(
            "<mujoco><worldbody><body pos='0 0 1'><freejoint/>\n{all}</body></worldbody></mujoco>"
        ))
    };
    let alike = [
        ball("friction='0.7'"),
        ball("friction='0.7 0.1'"),
        ball("friction='0.7' condim='3'"),
    ];
    assert!(world(&alike).1.ignored.is_empty());
    let idle = [
        ball("friction='0.7'"),
        ball("friction='0.2' contype='0' conaffinity='0'"),
    ];
    assert!(world(&idle).1.ignored.is_empty());
    let differ = [
        ball("friction='0.7'"),
        ball("friction='0.2'"),
        ball("friction='0.7' solref='0.01 1'"),
        ball("friction='0.7' condim='1'"),
    ];
    let report = world(&differ).1;
    let [of_link] = &report.ignored[..] else {
        panic!("{report}")
    };
    assert_eq!(of_link.line, 3);
    assert!(
        of_link.reason.contains("of a link") && of_link.reason.contains("3 geoms"),
        "{report}"
    );
    let many = |n: usize| -> Vec<String> {
        let friction = |k: usize| format!("friction='0.{k:02}'");
        (0..n).map(|k| ball(&friction(k))).collect()
    };
    let warns = |n| world(&many(n)).1.to_string().contains("first 64 touch");
    assert!(warns(65) && !warns(64));
}

// q₁ − 0.2 = 0.1 + 3 (q₂ − 0.5)
#[test]
fn joint_equality_counts_from_the_references() {
    let (scene, _) = text(
        "<mujoco><compiler angle='radian'/><worldbody><body><joint name='a' ref='0.2'/><geom size='0.1'/>
         <body><joint name='b' ref='0.5'/><geom size='0.1'/></body></body></worldbody>
         <equality><joint joint1='a' joint2='b' polycoef='0.1 3 0 0 0'/><joint joint1='b' polycoef='0.7 0 0 0 0'/></equality></mujoco>",
    );
    let ConstraintKind::Coupler { ratio, offset, .. } = scene.constraints[0].kind() else {
        panic!("{:?}", scene.constraints[0])
    };
    assert!((ratio - 3.0).abs() < SAME_ALGEBRA && (offset + 1.2).abs() < SAME_ALGEBRA);
    let ConstraintKind::Tendon { length, .. } = scene.constraints[1].kind() else {
        panic!("{:?}", scene.constraints[1])
    };
    assert!((length - 1.2).abs() < SAME_ALGEBRA);
}

// A crank and a slider: the ends of two rods meet where the file has them, and the simulator keeps them together as they fall.
#[test]
fn connected_bodies_stay_together() {
    let (scene, report) = text(
        "<mujoco><option timestep='0.001'/><worldbody>
         <body name='a' pos='-1 0 0'><joint name='a'  axis='0 1 0'/><geom type='capsule' fromto='0 0 0 1 0 1' size='0.02' contype='0' conaffinity='0'/></body>
         <body name='b' pos='1 0 0' euler='0 0 30'><joint name='c' type='slide' axis='0.8660254037844386 -0.5 0'/><joint name='b' axis='0.5 0.8660254037844386 0'/>
         <geom type='capsule' fromto='0 0 0 -0.8660254037844386 0.5 1' size='0.02' contype='0' conaffinity='0'/></body>
         </worldbody><equality><connect body1='a' body2='b' anchor='1 0 1'/></equality></mujoco>",
    );
    assert!(report.ignored.is_empty(), "{report}");
    let simulator = scene.simulator();
    let end = simulator
        .rollout(&scene.reference, 300, |_, _, _| {})
        .last()
        .clone();
    let ConstraintKind::Ball([one, other]) = scene.constraints[0].kind() else {
        panic!("{:?}", scene.constraints[0])
    };
    let at = |anchor: &dualbody::constraint::Anchor| {
        let pose = frame_pose(
            &scene.model,
            end.q.as_slice(),
            anchor.frame.expect("a frame"),
        );
        pose.point(&anchor.placement.translation)
    };
    assert!(
        (end.q.clone() - scene.reference.q.clone()).amax() > 1e-3,
        "nothing moves"
    );
    // The rods pull the soft constraint apart: by 0.1807 mm in `MuJoCo` after the same steps.
    let distance = (at(one) - at(other)).norm();
    assert!((distance / 1.807e-4 - 1.0).abs() < 0.01, "{distance:e}");
}

#[test]
fn fixed_tendon_of_an_equality_is_the_sum_of_its_joints() {
    let (scene, _) = text(
        "<mujoco><worldbody><body><joint name='a'/><geom size='0.1'/><body><joint name='b'/><geom size='0.1'/></body></body></worldbody>
         <tendon><fixed name='t'><joint joint='a' coef='0.5'/><joint joint='b' coef='-2'/></fixed></tendon>
         <equality><tendon tendon1='t' polycoef='0.25 0 0 0 0'/></equality></mujoco>",
    );
    let ConstraintKind::Tendon {
        coefficients,
        length,
        ..
    } = scene.constraints[0].kind()
    else {
        panic!("{:?}", scene.constraints[0])
    };
    assert_eq!((&coefficients[..], *length), (&[0.5, -2.0][..], 0.25));
}

#[test]
fn keyframes_are_states_with_the_velocity_of_free_bodies_in_the_body() {
    let (scene, _) = text(
        "<mujoco><worldbody><body name='a'><freejoint name='f'/><geom size='0.1'/></body>
         <body name='b'><joint name='h'/><geom size='0.1'/></body></worldbody>
         <actuator><motor joint='h'/></actuator>
         <keyframe><key name='home' time='2' qpos='1 2 3 2 0 0 2 0.5' qvel='1 0 0 0 0 4 0.25' ctrl='0.7'/></keyframe></mujoco>",
    );
    let key = &scene.keyframes[0];
    assert_eq!(
        (key.name.as_str(), key.time, key.control[0]),
        ("home", 2.0, 0.7)
    );
    // A quarter turn about z: the world's x is the body's −y.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let q = DVector::from_row_slice(&[1.0, 2.0, 3.0, half, 0.0, 0.0, half, 0.5]);
    let v = DVector::from_row_slice(&[0.0, -1.0, 0.0, 0.0, 0.0, 4.0, 0.25]);
    assert!((&key.state.q - q).amax() < SAME_ALGEBRA && (&key.state.v - v).amax() < SAME_ALGEBRA);
}

#[test]
fn motors_limit_the_effort_of_their_joints_and_are_the_inputs() {
    let (scene, report) = text(&rod(
        "<actuator><motor name='m' joint='hinge' gear='20' ctrlrange='-2 2' forcerange='-1 1'/></actuator>",
    ));
    assert!(report.ignored.is_empty(), "{report}");
    let joint = scene.model.joint("hinge").expect("a joint");
    assert_eq!(scene.model.limits(joint).effort, Some(20.0));
    assert_eq!(scene.simulator().effort_bounds(), (vec![-2.0], vec![2.0]));
    let pushed = scene.simulator().acceleration(&scene.reference, &[-0.5])[0];
    let weighed = scene.simulator().acceleration(&scene.reference, &[0.0])[0];
    let inertia = mass_matrix(&scene.model, &[0.0])[(0, 0)];
    assert!((pushed - weighed + 10.0 / inertia).abs() < OTHER_ALGORITHM * 100.0);
}

#[test]
fn a_ball_comes_to_rest_on_the_ground_of_the_file() {
    let (scene, _) = text(
        "<mujoco><option timestep='0.001' impratio='10'/><worldbody><geom type='plane' size='1 1 1' pos='0 0 0.5' friction='0.3'/>
         <body name='ball' pos='0 0 0.62'><freejoint/><geom name='g' size='0.1' friction='0.8'/></body></worldbody></mujoco>",
    );
    let simulator = scene.simulator();
    let end = simulator
        .rollout(&scene.reference, 1500, |_, _, _| {})
        .last()
        .clone();
    assert!((end.q[2] - 0.6).abs() < 2e-3, "{}", end.q[2]);
    assert_eq!(scene.contacts.geoms[0].name.as_deref(), Some("g"));
}

#[test]
fn sites_with_the_name_of_a_body_get_another_one_with_a_warning() {
    let (scene, report) = text(
        "<mujoco><worldbody><body name='a'><joint name='a'/><geom size='0.1'/><site name='a' pos='1 0 0'/><site name='tip'/></body></worldbody></mujoco>",
    );
    assert_eq!(scene.model.frame_names(), ["world", "a", "a::site", "tip"]);
    assert_eq!(report.warnings.len(), 1, "{report}");
}

#[test]
fn several_joints_of_a_body_load_without_warnings() {
    let (scene, report) = text(
        "<mujoco><worldbody><body name='a'><joint name='x' type='slide' axis='1 0 0'/><joint name='y' type='slide' axis='0 1 0'/><joint name='turn'/><geom size='0.1'/></body></worldbody></mujoco>",
    );
    assert!(
        report.warnings.is_empty() && report.ignored.is_empty(),
        "{report}"
    );
    let model = scene.model;
    assert_eq!(model.link_names(), ["world", "x::link", "y::link", "a"]);
    assert!(model.check_mass_matrix().is_ok());
}

#[test]
fn balanced_weight_is_that_part_of_the_weight() {
    let held = |balanced: f64| {
        let xml = format!(
            "<mujoco><worldbody><body name='a' gravcomp='{balanced}'><joint type='slide'/><geom size='0.1' mass='2'/></body></worldbody></mujoco>"
        );
        bias_forces(&text(&xml).0.model, &[0.0], &[0.0])[0]
    };
    for balanced in [0.0, 0.25, 1.0] {
        let weight = 2.0 * 9.81 * (1.0 - balanced);
        assert!(
            (held(balanced) - weight).abs() < SAME_ALGEBRA * 20.0,
            "{balanced}"
        );
    }
}

fn assets() -> Vec<Model> {
    let folder = format!("{}/assets", env!("CARGO_MANIFEST_DIR"));
    let files = fs::read_dir(folder)
        .expect("assets")
        .map(|file| file.expect("a file").path());
    let urdf = files.filter(|path| path.extension().is_some_and(|ending| ending == "urdf"));
    let load = |path| Model::from_urdf_file(path).unwrap_or_else(|error| panic!("{error}"));
    let mut models: Vec<Model> = urdf.map(load).collect();
    models.extend([
        samples::pendulum(),
        samples::double_pendulum(),
        samples::cartpole(),
        samples::arm(),
    ]);
    models
}

// URDF → model → MJCF → model → MJCF → model.
#[test]
fn mjcf_that_was_written_reads_back_as_the_same_robot() {
    let mut compared = 0;
    for model in assets() {
        let name = model.name().to_owned();
        let Ok(xml) = model.to_mjcf() else { continue };
        let (scene, report) = text(&xml);
        assert!(report.ignored.is_empty(), "{name}: {report}");
        let again = scene.model;
        assert_eq!(again.link_names(), model.link_names(), "{name}");
        // Joints that follow others are joints of their own, tied by a constraint.
        if again.nv() != model.nv() {
            assert_eq!(again.nv() - model.nv(), scene.constraints.len(), "{name}");
            continue;
        }
        let twice = text(
            &again
                .to_mjcf()
                .unwrap_or_else(|error| panic!("{name}: {error}")),
        )
        .0
        .model;
        let mut random = rand_of(7);
        let state = State::random(&model, &mut random, 1.0);
        let (q, v) = (state.q.as_slice(), state.v.as_slice());
        for other in [&again, &twice] {
            let (M, h) = (mass_matrix(&model, q), bias_forces(&model, q, v));
            let size = [M.amax(), h.amax()].map(|x| x.max(NEGLIGIBLE));
            let errors = [
                (M - mass_matrix(other, q)).amax() / size[0],
                (h - bias_forces(other, q, v)).amax() / size[1],
            ];
            assert!(
                errors[0].max(errors[1]) < OTHER_ALGORITHM,
                "{name}: {errors:?}"
            );
            assert_eq!(other.damping(), model.damping(), "{name}");
        }
        compared += 1;
    }
    assert!(compared >= 8, "{compared} robots");
}

// Joints of one body, with places, axes and another frame below: the links between them have no inertia, and become joints of one body again.
#[test]
fn joints_of_one_body_are_written_as_joints_of_one_body() {
    let xml = "<mujoco><worldbody><body name='base' pos='0 0 1'><joint name='x' type='slide' axis='1 0 0'/>
      <joint name='turn' axis='0 1 1' pos='0.1 0 0.2' armature='0.1' damping='2' range='-1 2'/><joint name='tilt' axis='1 0 0' pos='0 0.3 0'/>
      <geom type='box' size='0.1 0.2 0.3'/><body name='arm' pos='0.2 0 0' euler='10 20 30'><joint name='a' type='ball' pos='0 0 0.1'/>
      <geom type='capsule' size='0.05 0.2'/></body><body name='hand' pos='0 0.3 0' euler='0 0 40'><joint name='b' axis='0 0 1' pos='0.1 0 0'/>
      <joint name='c' type='slide' axis='0 1 0.5'/><geom size='0.1'/></body></body></worldbody></mujoco>";
    let model = text(xml).0.model;
    let written = model.to_mjcf().expect("an MJCF");
    assert!(!written.contains("left out"), "{written}");
    let again = text(&written).0.model;
    assert_eq!(again.link_names(), model.link_names());
    assert_same_dynamics(&model, &again);
}

// A description of another format: a virtual link between two joints that are turned towards each other.
#[test]
fn virtual_links_are_left_out_with_a_remark_and_the_rest_moves_as_before() {
    let urdf = "<robot name='r'><link name='world'/><link name='virtual'/><link name='fixed'/><link name='body'><inertial><origin xyz='0.1 0 0.2'/><mass value='2'/>
      <inertia ixx='0.1' iyy='0.2' izz='0.15' ixy='0' ixz='0' iyz='0'/></inertial></link>
      <joint name='first' type='continuous'><origin xyz='0 0.1 1' rpy='0.3 0 0.2'/><axis xyz='0 1 0.2'/><parent link='world'/><child link='virtual'/></joint>
      <joint name='held' type='fixed'><origin xyz='0.3 0 0' rpy='0 0.5 0'/><parent link='virtual'/><child link='fixed'/></joint>
      <joint name='second' type='prismatic'><origin xyz='0.2 0 0.1' rpy='0.7 -0.4 1.1'/><axis xyz='1 0 0'/><limit lower='-1' upper='1' effort='5' velocity='1'/>
      <parent link='fixed'/><child link='body'/></joint></robot>";
    let model = Model::from_urdf_str(urdf).expect("a robot");
    let written = model.to_mjcf().expect("an MJCF");
    for link in ["virtual", "fixed"] {
        let remark = format!("left out: the link {link}, which has no inertia");
        assert!(written.contains(&remark), "{written}");
    }
    let again = text(&written).0.model;
    assert_eq!(again.joint_names(), ["first", "second"]);
    assert_same_dynamics(&model, &again);
    // The base of a floating robot has no other joint on its body.
    let options = ModelOptions::default().with_base(Base::Floating);
    let urdf = urdf.replace("continuous", "fixed");
    let (floating, _) = options.load_urdf_str(&urdf).expect("a floating robot");
    let refused = floating.to_mjcf().expect_err("a base without mass");
    assert!(refused.to_string().contains("virtual"), "{refused}");
}

fn assert_same_dynamics(model: &Model, other: &Model) {
    let mut random = rand_of(3);
    for _ in 0..3 {
        let state = State::random(model, &mut random, 1.0);
        let (q, v) = (state.q.as_slice(), state.v.as_slice());
        let M = mass_matrix(model, q) - mass_matrix(other, q);
        let h = bias_forces(model, q, v) - bias_forces(other, q, v);
        assert!(M.amax().max(h.amax()) < 1e-12, "{M}{h}");
        assert_eq!(model.damping(), other.damping());
    }
}

// An arm whose tip is held towards a site of the world, and what MuJoCo 4.0 finds: `qacc` at two states, and `qpos` after 100 steps of Runge and Kutta.
#[test]
fn servos_as_seen_from_another_site_equal_those_of_mujoco() {
    let (scene, report) = text(REACH);
    assert!(report.ignored.is_empty(), "{report}");
    let simulator = scene.simulator();
    for (q, v, control, acceleration, end) in REACHED {
        let state = simulator.state(&q, &v);
        let u = scene.inputs(&control);
        let a = simulator.acceleration(&state, &u) - DVector::from_column_slice(&acceleration);
        assert!(a.amax() < 1e-9 * acceleration[3].abs(), "{a}");
        let motion = simulator.rollout(&state, 100, |_, _, own| own.copy_from_slice(&u));
        let off = &motion.last().q - DVector::from_column_slice(&end);
        assert!(off.amax() < 1e-9, "{off}");
    }
}

const REACH: &str = "<mujoco><option timestep='0.001' integrator='RK4'/><worldbody><site name='goal' pos='0.4 -0.1 0.5' euler='20 -35 60'/>
  <body name='upper' pos='0 0 0.4'><joint name='yaw' axis='0 0 1'/><joint name='pitch' axis='0 1 0'/><geom type='capsule' fromto='0 0 0 0.3 0 0' size='0.03'/>
  <body name='lower' pos='0.3 0 0'><joint name='elbow' axis='0 1 0.2'/><joint name='roll' axis='1 0 0'/>
  <geom type='capsule' fromto='0 0 0 0.25 0 0.1' size='0.03'/><site name='tip' pos='0.25 0.02 0.1' euler='10 40 -30'/></body></body></worldbody>
  <actuator><position name='x' site='tip' refsite='goal' kp='60' kv='4' gear='1 0 0 0 0 0'/>
  <position name='turn' site='tip' refsite='goal' kp='5' gear='0 0 0 0.3 -0.7 1.1' ctrlrange='-1 1'/>
  <motor name='pull' site='tip' refsite='goal' gear='0.5 2 -1 0.1 0.2 0.3'/>
  <general name='mixed' site='tip' refsite='goal' gear='0 1 0.5 0.2 0 0' gainprm='7' biasprm='0.3 -9 -2' biastype='affine' forcerange='-3 2'/></actuator></mujoco>";

/// Configuration, velocity, control; acceleration, and the configuration afterwards.
type Reached = ([f64; 4], [f64; 4], [f64; 4], [f64; 4], [f64; 4]);

const REACHED: [Reached; 2] = [
    (
        [0.3, -0.4, 0.7, 0.2],
        [0.5, -1.0, 0.8, 1.5],
        [0.2, -0.5, 0.7, 1.5],
        [
            -248.57839974371797,
            104.50865381080773,
            -122.36325610539132,
            -2771.6343724558424,
        ],
        [
            0.5027584966708909,
            -0.20767633489706303,
            -0.5220820969291895,
            -8.730319046950168,
        ],
    ),
    (
        [-0.6, 0.5, -0.9, 1.1],
        [-1.2, 0.3, 0.4, -0.7],
        [-0.4, 1.8, -0.3, -0.2],
        [
            1282.440954136777,
            -439.34068340349313,
            -4692.775893300399,
            16312.50483037522,
        ],
        [
            -0.934124489151193,
            0.6785953006806651,
            -1.5770073389221557,
            3.9926430010327563,
        ],
    ),
];

// Stiff gains at a long step: the matrices of that step against differences.
#[test]
fn a_step_with_a_servo_from_another_site_has_the_slopes_of_differences() {
    let xml = REACH.replace("kp='60' kv='4'", "kp='1e5' kv='300'");
    let (scene, _) = text(&xml);
    let simulator = scene.simulator();
    let simulator = simulator.with_integrator(Integrator::SemiImplicitEuler);
    let simulator = simulator.with_time_step(0.01);
    let state = simulator.state(&REACHED[0].0, &[0.0; 4]);
    // MuJoCo's `actuator_length` there is 0.27968593.
    let u = scene.inputs(&[0.28, 0.0, 0.0, 0.0]);
    let (own, small) = (simulator.linearize(&state, &u), 1e-6);
    for k in 0..u.len() + 4 {
        let end = |sign: f64| {
            let (mut state, mut u) = (state.clone(), u.clone());
            match k.checked_sub(u.len()) {
                Some(i) => state.q[i] += sign * small,
                None => u[k] += sign * small,
            }
            simulator.step(&state, &u).v
        };
        let slope = (end(1.0) - end(-1.0)) / (2.0 * small);
        let column = match k.checked_sub(u.len()) {
            Some(i) => own.a.column(i).rows(4, 4).into_owned(),
            None => own.b.column(k).rows(4, 4).into_owned(),
        };
        let off = (column - &slope).amax() / slope.amax().max(1.0);
        assert!(off < 1e-6, "{k}: {off:e}");
    }
}

#[test]
fn a_reference_site_that_moves_is_in_the_report() {
    let moved = REACH.replace("refsite='goal'", "refsite='own'");
    let moved = moved.replace("<site name='tip'", "<site name='own'/><site name='tip'");
    let (scene, report) = text(&moved);
    assert_eq!(report.ignored.len(), 4, "{report}");
    assert!(report.to_string().contains("\"own\" moves"), "{report}");
    assert_eq!(scene.simulator().nu(), 0);
}

// A wall of the world has a type of its own; the balls, which do not touch each other, would otherwise be thrown apart.
#[test]
fn geoms_of_the_world_keep_types_and_parameters_of_all_others() {
    let balls = |wall: &str| {
        let (scene, _) = text(&format!(
            "<mujoco><option gravity='0 0 0'/><worldbody>{wall}
             <body name='a'><joint name='x' type='slide' axis='1 0 0'/><geom size='0.1' contype='1' conaffinity='0'/></body>
             <body name='b' pos='0.05 0 0'><joint name='y' type='slide' axis='1 0 0'/><geom size='0.1' contype='1' conaffinity='0'/></body></worldbody></mujoco>"
        ));
        let end = scene
            .simulator()
            .rollout(&scene.reference, 20, |_, _, _| {});
        end.last().v.amax()
    };
    let near = "<geom type='box' size='0.1 1 1' pos='-0.15 0 0'/>";
    assert_eq!(balls(""), 0.0);
    assert_eq!(balls(&near.replace("-0.15", "-5")), 0.0);
    assert!(balls(near) > 0.01, "the wall pushes");
}

fn rand_of(seed: u64) -> impl rand::Rng {
    use rand::SeedableRng;
    rand::rngs::Xoshiro256PlusPlus::seed_from_u64(seed)
}

#[test]
fn orientations_in_five_ways_are_the_same() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let turn = Quaternion::exp(&Vector3::new(0.0, quarter, 0.0)).to_matrix();
    for way in [
        "quat='1 0 1 0'",
        "axisangle='0 2 0 90'",
        "euler='0 90 0'",
        "xyaxes='0 0 -1 0 3 0'",
        "zaxis='5 0 0'",
    ] {
        let xml = format!(
            "<mujoco><worldbody><body name='a'><geom size='0.1'/><site name='s' {way}/></body></worldbody></mujoco>"
        );
        let model = text(&xml).0.model;
        let pose = frame_pose(&model, &[], model.frame("s").expect("a site"));
        assert!(
            (pose.rotation - turn).amax() < SAME_ALGEBRA,
            "{way}: {}",
            pose.rotation
        );
    }
}

/// Flags disable contact, limits, friction losses and equalities, or all of them.
#[test]
fn flags_disable_constraints() {
    let acting = |flags: &str| {
        let (scene, _) = text(&format!(
            "<mujoco><option><flag {flags}/></option><worldbody><geom type='plane' size='1 1 1'/><body pos='0 0 0.05'>
             <joint name='z' type='slide' axis='0 0 1' limited='true' range='0.01 1' frictionloss='3'/><geom size='0.1' mass='1'/></body></worldbody>
             <equality><joint joint1='z' polycoef='0.5'/></equality></mujoco>"
        ));
        let joint = &scene.model.joints()[0];
        let simulator = scene.simulator();
        [
            simulator.contacts().is_some(),
            joint.limits.lower.is_some(),
            joint.friction > 0.0,
            !simulator.constraints().is_empty(),
        ]
    };
    assert_eq!(acting("contact='enable'"), [true; 4]);
    assert_eq!(acting("constraint='disable'"), [false; 4]);
    for (k, flag) in ["contact", "limit", "frictionloss", "equality"]
        .iter()
        .enumerate()
    {
        let mut expected = [true; 4];
        expected[k] = false;
        assert_eq!(acting(&format!("{flag}='disable'")), expected, "{flag}");
    }
}

/// A free joint without a name is found by its body; links that are fixed to that body have other poses.
#[test]
fn free_bodies_are_found_by_their_own_names() {
    let (scene, _) = text(
        "<mujoco><worldbody><body name='a' pos='1 2 3'><freejoint/><geom size='0.1'/><body name='fixed' pos='0 0 1'><geom size='0.1'/></body></body>
         <body name='b'><freejoint name='own'/><geom size='0.1'/></body></worldbody></mujoco>",
    );
    let mut state = scene.reference.clone();
    let pose = state.free_pose(&scene.model, "a").expect("a free body");
    assert_eq!(pose.translation, Vector3::new(1.0, 2.0, 3.0));
    assert_eq!(state.free_pose(&scene.model, "a::joint"), Ok(pose));
    state.set_free_pose(&scene.model, "b", &pose).expect("one");
    assert_eq!(state.free_pose(&scene.model, "own"), Ok(pose));
    let error = state.free_pose(&scene.model, "fixed").expect_err("none");
    assert!(error.to_string().contains("a::joint"), "{error}");
}

/// Broken descriptions, each with words of its error.
#[test]
fn broken_descriptions_are_errors_that_name_the_place() {
    let body = |inside: &str| {
        format!("<mujoco><worldbody>\n<body name='b'>{inside}</body></worldbody></mujoco>")
    };
    for (xml, says) in [
        ("<robot/>".to_owned(), "expected <mujoco>"),
        (
            body("<joint type='gear'/>"),
            "MJCF text:2: <joint> \"b\": type = \"gear\": expected one of hinge",
        ),
        (body("<joint axis='1 2'/>"), "expected 3 numbers, found 2"),
        (
            body("<joint axis='0 0 0'/><geom size='1'/>"),
            "has a zero axis",
        ),
        (body("<joint range='nan 1'/>"), "range is not finite"),
        (body("<joint limited='true'/>"), "has no attribute range"),
        (
            body("<joint class='none'/>"),
            "there is no default class of that name",
        ),
        (
            body("<geom type='box' size='1 1'/>"),
            "has too few numbers for the type",
        ),
        (body("<geom size='-1'/>"), "a length is not positive"),
        (
            body("<geom type='mesh' mesh='m'/>"),
            "there is no mesh of that name",
        ),
        (body("<geom size='1' mass='-1'/>"), "is negative"),
        (body("<inertial pos='0 0 0'/>"), "has no attribute mass"),
        (
            body("<inertial mass='1' diaginertia='1 1 1' fullinertia='1 1 1 0 0 0'/>"),
            "one of the two",
        ),
        (body("<body quat='0 0 0 0'/>"), "has no direction"),
        (
            body("<body><freejoint/></body>"),
            "a free joint is the only one of a body of the world",
        ),
        (
            body("<joint name='j'/><joint name='j'/><geom size='1'/>"),
            "two joints with the name \"j\"",
        ),
        (
            body("<replicate count='9999999'><geom size='1'/></replicate>"),
            "add more than 10000 elements",
        ),
        (rod("<actuator><motor joint='none'/></actuator>"), "none"),
        (
            rod("<actuator><position joint='hinge' kv='1' dampratio='1'/></actuator>"),
            "is given together with kv",
        ),
        (
            rod("<actuator><position joint='hinge' kp='-1'/></actuator>"),
            "is negative",
        ),
        (
            rod("<equality><connect body1='rod' body2='none' anchor='0 0 0'/></equality>"),
            "there is no body of that name",
        ),
        (
            rod("<equality><joint joint1='none'/></equality>"),
            "there is no joint of that name",
        ),
        (
            rod("<keyframe><key qpos='1 2'/></keyframe>"),
            "has 2 numbers, expected 1",
        ),
        (rod("<option timestep='0'/>"), "is not positive"),
        (
            rod("<compiler coordinate='global'/>"),
            "global coordinates are not read",
        ),
        (rod("<include file='none.xml'/>"), "there is no such file"),
        (
            rod("<default><default/></default>"),
            "has no attribute class",
        ),
    ] {
        let error = ModelOptions::default()
            .load_mjcf_str(&xml)
            .map(|_| ())
            .unwrap_err()
            .to_string();
        assert!(
            error.starts_with("MJCF text") && error.contains(says),
            "{error}\nnot: {says}"
        );
    }
}

/// Hostile descriptions: an error, or a robot, in no time and not much memory.
#[test]
fn hostile_descriptions_neither_hang_nor_overflow_the_stack() {
    let nested = |open: &str, close: &str, n: usize| {
        format!(
            "<mujoco><worldbody>{}{}</worldbody></mujoco>",
            open.repeat(n),
            close.repeat(n)
        )
    };
    let many = 50_000;
    let bodies = nested("<body><geom size='1'/>", "</body>", many);
    let model = ModelOptions::default()
        .load_mjcf_str(&bodies)
        .expect("a chain")
        .0;
    assert_eq!(model.link_names().len(), many + 1);
    assert!(
        ModelOptions::default()
            .load_mjcf_str(&nested("<frame pos='1 0 0'>", "</frame>", many))
            .is_ok()
    );
    let replicas = nested("<replicate count='50'>", "</replicate>", 40)
        .replace("</replicate>", "<geom size='1'/></replicate>");
    assert!(ModelOptions::default().load_mjcf_str(&replicas).is_err());
    // Names grow with each level.
    let deep = nested("<replicate count='1' sep='-'>", "</replicate>", many);
    assert!(ModelOptions::default().load_mjcf_str(&deep).is_err());
    let long = format!(
        "<mujoco><worldbody><replicate count='9000' sep='{}'><geom size='1'/></replicate></worldbody></mujoco>",
        "-".repeat(many)
    );
    let error = ModelOptions::default()
        .load_mjcf_str(&long)
        .map(|_| ())
        .unwrap_err();
    assert!(error.to_string().contains("too long"), "{error}");
    let classes = format!(
        "<mujoco>{}{}</mujoco>",
        "<default class='a'>".repeat(3),
        "</default>".repeat(3)
    );
    assert!(ModelOptions::default().load_mjcf_str(&classes).is_ok());
    let deep: String = (0..many)
        .map(|i| format!("<default class='c{i}'>"))
        .collect();
    let deep = format!("<mujoco>{deep}{}</mujoco>", "</default>".repeat(many));
    let error = ModelOptions::default()
        .load_mjcf_str(&deep)
        .map(|_| ())
        .unwrap_err();
    assert!(error.to_string().contains("nested more than"), "{error}");
}

/// Height of the upper of two balls over one another after it has fallen on the lower one, or through it.
fn height_of_upper(upper: &str, more: &str) -> f64 {
    let (scene, _) = text(&format!(
        "<mujoco><option timestep='0.002'/><worldbody><geom name='floor' type='plane' size='1 1 1'/>
         <body name='lower' pos='0 0 0.1'><freejoint/><geom name='lower' size='0.1'/></body>
         <body name='upper' pos='0 0 0.35'><freejoint/><geom name='upper' size='0.1' {upper}/></body></worldbody>{more}</mujoco>"
    ));
    let end = scene
        .simulator()
        .rollout(&scene.reference, 500, |_, _, _| {});
    let upper = scene.model.frame("upper").expect("a ball");
    frame_pose(&scene.model, end.last().q.as_slice(), upper)
        .translation
        .z
}

#[test]
fn bodies_touch_as_types_pairs_and_exclusions_say() {
    let pair = "<contact><pair geom1='lower' geom2='upper'/></contact>";
    let exclude = "<contact><exclude body1='lower' body2='upper'/></contact>";
    for (upper, more, expected) in [
        ("", "", 0.3),
        ("", exclude, 0.1),
        // Types of one side are enough.
        ("contype='2' conaffinity='1'", "", 0.3),
        ("contype='2' conaffinity='2'", "", f64::NEG_INFINITY),
        ("contype='0' conaffinity='0'", "", f64::NEG_INFINITY),
        ("contype='0' conaffinity='0'", pair, 0.3),
    ] {
        let height = height_of_upper(upper, more);
        let right = match expected.is_finite() {
            true => (height - expected).abs() < 5e-3,
            false => height < -1.0,
        };
        assert!(right, "{upper} {more}: {height}");
    }
}

// The mean of both by the weights 1 and 3, the larger friction; the geom of priority alone.
#[test]
fn laws_have_the_mixed_numbers_of_both_geoms() {
    let law = |geom: &str| {
        let (scene, _) = text(&format!(
            "<mujoco><option impratio='7'/><worldbody><geom type='plane' size='1 1 1' friction='0.3' solref='0.04 0.8' solimp='0.8 0.9 0.002 0.4 3'/>
             <body><freejoint/><geom size='0.1' {geom}/></body></worldbody></mujoco>"
        ));
        let simulator = scene.simulator();
        let ContactLaw::RelaxedRigid(law) = simulator.contacts().expect("a ground").laws()[0]
        else {
            panic!("another law")
        };
        law
    };
    let mixed = law("friction='0.6' solmix='3' solref='0.08 0.4'");
    let Reference::TimeConstant {
        time_constant,
        damping_ratio,
    } = mixed.reference
    else {
        panic!("{mixed:?}")
    };
    let numbers = [
        (mixed.friction, 0.6),
        (mixed.friction_impedance_ratio, 7.0),
        (time_constant, 0.07),
        (damping_ratio, 0.5),
        (mixed.impedance.least, 0.875),
        (mixed.impedance.largest, 0.9375),
        (mixed.impedance.width, 0.00125),
        (mixed.impedance.sigmoid.midpoint(), 0.475),
        (mixed.impedance.sigmoid.power(), 2.25),
    ];
    for (own, expected) in numbers {
        assert!(
            (own - expected).abs() < SAME_ALGEBRA,
            "{mixed:?}: {expected}"
        );
    }
    let first = law("friction='0.1' priority='1' condim='1' solref='-900 -40'");
    let direct = Reference::Direct {
        stiffness: 900.0,
        damping: 40.0,
    };
    assert_eq!((first.friction, first.reference), (0.0, direct));
    // Time constants are not below two steps.
    let Reference::TimeConstant { time_constant, .. } =
        law("priority='1' solref='0.001 1'").reference
    else {
        panic!("another reference")
    };
    assert_eq!(time_constant, 0.004);
}

#[test]
fn bodies_on_several_joints_do_not_touch_their_neighbours() {
    let (scene, _) = text(
        "<mujoco><option gravity='0 0 0'/><worldbody><body name='a'><joint name='a' armature='1'/><geom size='0.1'/>
         <body name='pad'><geom size='0.12'/></body>
         <body name='b'><joint name='x'/><joint name='y' axis='0 1 0'/><geom size='0.1'/></body></body></worldbody></mujoco>",
    );
    assert_eq!(scene.contacts.excluded, [["a", "b"], ["pad", "b"]]);
    let still = scene.simulator().acceleration(&scene.reference, &[]);
    assert_eq!(still.amax(), 0.0);
}

#[test]
fn short_forms_of_servos_are_general_ones() {
    let servo = |defaults: &str, actuator: &str| {
        let (scene, report) = text(&rod(&format!(
            "<default>{defaults}</default><actuator><{actuator} joint='hinge'/></actuator>"
        )));
        assert!(report.ignored.is_empty(), "{report}");
        scene.actuation[0].servo.expect("a servo")
    };
    let gains = |s: dualbody::sim::Servo| [s.gain, s.bias, s.position_gain, s.velocity_gain];
    // As MuJoCo 4.0 compiles them.
    for (defaults, actuator, expected) in [
        ("", "position", [1.0, 0.0, 1.0, 0.0]),
        ("", "position kp='3' kv='2'", [3.0, 0.0, 3.0, 2.0]),
        ("<velocity kv='7'/>", "velocity", [7.0, 0.0, 0.0, 7.0]),
        ("<velocity kv='7'/>", "position", [1.0, 0.0, 1.0, 0.0]),
        (
            "<general gainprm='5' biasprm='0 -1 -1' biastype='affine'/>",
            "motor",
            [1.0, 0.0, 0.0, 0.0],
        ),
        (
            "<general gainprm='5' biasprm='0 -1 -1'/>",
            "position",
            [5.0, 0.0, 5.0, 1.0],
        ),
        ("<position kp='5' kv='2'/>", "general", [5.0, 0.0, 5.0, 2.0]),
        (
            "<position kv='9'/>",
            "position kp='3' kv='0'",
            [3.0, 0.0, 3.0, 0.0],
        ),
        (
            "<general biastype='affine'/>",
            "general gainprm='100' biasprm='2 -100 -1'",
            [100.0, 2.0, 100.0, 1.0],
        ),
    ] {
        assert_eq!(
            gains(servo(defaults, actuator)),
            expected,
            "{defaults} {actuator}"
        );
    }
    let inherits = servo("", "position inheritrange='0.5'");
    assert_eq!(inherits.input_range, None); // the joint has no range
    let (scene, _) = text(
        "<mujoco><compiler angle='radian'/><worldbody><body><joint name='j' range='-1 2'/><geom size='0.1'/></body></worldbody>
         <actuator><position joint='j' inheritrange='0.5'/></actuator></mujoco>",
    );
    let range = scene.actuation[0].servo.and_then(|own| own.input_range);
    assert_eq!(
        range,
        Some(Interval {
            lower: -0.25,
            upper: 1.25
        })
    );
}
