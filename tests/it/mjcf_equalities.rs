//! Equalities as regularised constraints against `MuJoCo` in the same text, `tests/mjcf/equalities.xml`.

use dualbody::constraint::{ConstraintKind, Impedance, Reference};
use dualbody::io::{ImportReport, MjcfScene};
use dualbody::{Integrator, ModelOptions, Simulator};
use nalgebra::DVector;

use crate::common::OTHER_ALGORITHM;
use crate::mjcf::{file, find, golden};

fn text(xml: &str) -> (MjcfScene, ImportReport) {
    let loaded = ModelOptions::default().load_mjcf_scene_str(xml);
    loaded.unwrap_or_else(|error| panic!("{error}"))
}

// Of bodies and sites, far from closed; both forms of solref; joints, and tendons alone and in pairs. The rows exceed the coordinates.
#[test]
fn accelerations_equal_those_of_mujoco() {
    let scene = file("equalities");
    assert_eq!(scene.constraints.len(), 10);
    let simulator = Simulator::new(scene.model.clone())
        .with_time_step(scene.options.time_step)
        .with_constraints(scene.constraints.clone());
    for (k, records) in golden("equalities").iter().enumerate() {
        let [q, v, tau, expected] = ["q", "v", "tau", "acceleration"].map(|key| find(records, key));
        let a = simulator.acceleration(&simulator.state(q, v), tau);
        let expected = DVector::from_column_slice(expected);
        let error = (a - &expected).amax() / expected.amax();
        assert!(error < OTHER_ALGORITHM, "state {k}: {error:e}");
    }
}

/// Of a hinge and a slider, by a polynomial of their ways from the references. Where the second joint moves, `MuJoCo` leaves out the acceleration along the
/// curve.
#[test]
fn joints_tied_by_a_polynomial_accelerate_as_in_mujoco() {
    let (scene, report) = text(
        "<mujoco><compiler angle='radian'/><option gravity='0 0 -9.81'><flag contact='disable'/></option><worldbody>
         <body><joint name='a' axis='0 1 0' ref='0.2'/><geom type='capsule' size='0.05' fromto='0 0 0 0.4 0 0'/></body>
         <body><joint name='b' type='slide' axis='1 0 0' ref='0.3'/><geom size='0.1' mass='2'/></body></worldbody>
         <equality><joint joint1='a' joint2='b' polycoef='0.1 0.7 -0.9 0.4 1.3' solref='0.03 0.8'/></equality></mujoco>",
    );
    assert!(report.ignored.is_empty(), "{report}");
    let simulator = Simulator::new(scene.model.clone())
        .with_time_step(scene.options.time_step)
        .with_constraints(scene.constraints.clone());
    for (q, v, expected) in POLYNOMIAL {
        let a = simulator.acceleration(&simulator.state(&q, &v), &[0.0; 2]);
        let error = (a - DVector::from_column_slice(&expected)).amax();
        assert!(
            error < OTHER_ALGORITHM * expected[0].abs(),
            "{q:?}: {error:e}"
        );
    }
}

/// q, v, accelerations.
const POLYNOMIAL: [([f64; 2], [f64; 2], [f64; 2]); 3] = [
    (
        [0.3, 0.4],
        [0.0, 0.0],
        [105.93392852080738, -4.219985161366753],
    ),
    (
        [0.5, -0.6],
        [0.7, 0.0],
        [-1722.9093112230826, -94.46426400877145],
    ),
    (
        [0.25, 0.9],
        [-0.4, 0.0],
        [635.7395818426144, -76.4141809896909],
    ),
];

/// A weld of a flange without mass: for the inverse mass there `MuJoCo` takes the place of the flange in its parent for that of its centre of mass.
#[test]
fn welds_of_bodies_without_mass_yield_as_in_mujoco() {
    let (scene, _) = text(
        "<mujoco><worldbody><body name='arm' pos='0 0 1'><joint name='a' axis='0 1 0'/><geom type='capsule' size='0.05' fromto='0 0 0 0.4 0 0'/>
         <body name='fore' pos='0.4 0 0'><joint name='b' axis='0 1 0'/><joint name='c' axis='0 0 1'/><geom type='capsule' size='0.04' fromto='0 0 0 0.3 0 0'/>
         <body name='flange' pos='0.3 0 0.12' euler='0 30 0'><site name='s'/></body></body></body></worldbody>
         <equality><weld body1='flange' solref='0.02 1'/></equality></mujoco>",
    );
    let simulator = Simulator::new(scene.model.clone())
        .with_time_step(scene.options.time_step)
        .with_constraints(scene.constraints.clone());
    let expected = [18.47315059142807, -15.880212919943693, 0.0];
    let still = simulator.acceleration(&scene.reference, &[0.0; 3]);
    let error = (still - DVector::from_column_slice(&expected)).amax();
    assert!(error < OTHER_ALGORITHM * expected[0], "{error:e}");
    let moving = simulator.state(&[0.1, -0.2, 0.05], &[0.3, 0.2, -0.4]);
    let expected = [-186.82607252569846, 409.08555870191606, -82.32999039712794];
    let a = simulator.acceleration(&moving, &[0.0; 3]);
    let error = (a - DVector::from_column_slice(&expected)).amax();
    assert!(error < OTHER_ALGORITHM * expected[1], "{error:e}");
}

/// With its own length, and with that at the references of the springs of its joints.
#[test]
fn springs_and_dampers_of_tendons_act_as_in_mujoco() {
    let (scene, report) = text(
        "<mujoco><option gravity='0 0 0'><flag contact='disable'/></option><worldbody><body><joint name='a' axis='0 1 0' springref='10'/><geom type='capsule' size='0.05' fromto='0 0 0 0.4 0 0'/></body>
         <body><joint name='b' type='slide' axis='1 0 0'/><geom size='0.1' mass='2'/></body></worldbody>
         <tendon><fixed name='t' stiffness='30' damping='4'><joint joint='a' coef='0.5'/><joint joint='b' coef='-2'/></fixed>
         <fixed name='u' stiffness='7' springlength='0.2'><joint joint='b' coef='1.5'/></fixed></tendon></mujoco>",
    );
    assert!(report.ignored.is_empty(), "{report}");
    // At an instant, not at the end of a step.
    let simulator = Simulator::new(scene.model.clone())
        .with_integrator(Integrator::RungeKutta4)
        .with_constraints(scene.constraints.clone());
    let a = simulator.acceleration(&simulator.state(&[0.3, -0.1], &[0.5, 0.2]), &[0.0; 2]);
    let error = (a - DVector::from_column_slice(&TENDONS)).amax();
    assert!(error < OTHER_ALGORITHM * TENDONS[1].abs(), "{error:e}");
    let (_, report) = text(
        "<mujoco><worldbody><body><joint name='a'/><geom size='0.1'/></body></worldbody>
         <tendon><fixed stiffness='3' springlength='0.1 0.2' range='0 1'><joint joint='a' coef='1'/></fixed></tendon></mujoco>",
    );
    let notes = report.to_string();
    for says in [
        "a range of lengths without force",
        "limits, friction and inertia",
    ] {
        assert!(notes.contains(says), "{notes}");
    }
}

/// Accelerations of the two joints.
const TENDONS: [f64; 2] = [-16.867928731737013, 9.119506122008506];

/// Two sliders that a joint equality ties.
fn tied(equality: &str) -> (MjcfScene, ImportReport) {
    text(&format!(
        "<mujoco><worldbody><body><joint name='a' type='slide'/><geom size='0.1' mass='2'/></body>
         <body><joint name='b' type='slide'/><geom size='0.1' mass='4'/></body></worldbody>
         <equality><joint joint1='a' joint2='b' {equality}/></equality></mujoco>"
    ))
}

// w = ½ + ¼; a step of 2 ms raises a time constant to 4 ms, and a mixed solref is the default.
#[test]
fn solver_parameters_are_read_within_their_bounds() {
    let time = |time_constant, damping_ratio| Reference::TimeConstant {
        time_constant,
        damping_ratio,
    };
    let direct = Reference::Direct {
        stiffness: 100.0,
        damping: 5.0,
    };
    for (solref, expected) in [
        ("", time(0.02, 1.0)),
        ("solref='0.1 0.5'", time(0.1, 0.5)),
        ("solref='0.001 1'", time(0.004, 1.0)),
        ("solref='-100 -5'", direct),
        ("solref='0.1 -5'", time(0.02, 1.0)),
    ] {
        let (scene, report) = tied(solref);
        assert!(report.ignored.is_empty(), "{report}");
        let soft = scene.constraints[0].regularisation().expect("soft");
        assert_eq!(soft.reference, expected, "{solref}");
        assert!((soft.inverse_mass - 0.75).abs() < 1e-12);
    }
    let (scene, _) = tied("solimp='0 2 0.3 0.4 3'");
    let soft = scene.constraints[0].regularisation().expect("soft");
    let Impedance {
        least,
        largest,
        width,
        sigmoid,
    } = soft.impedance;
    assert_eq!((least, largest, width), (1e-4, 0.9999, 0.3));
    assert_eq!((sigmoid.midpoint(), sigmoid.power()), (0.4, 3.0));
    // Without width it is the mean.
    let (scene, _) = tied("solimp='0.5 0.7 0'");
    let flat = scene.constraints[0]
        .regularisation()
        .expect("soft")
        .impedance;
    assert!((flat.at(1.0) - 0.6_f64).abs() < 1e-12 && (flat.at(0.0) - 0.6_f64).abs() < 1e-12);
}

// As `body_invweight0[0]` of MuJoCo 4.0: 1 / m of bodies that slide along their own axes, else the mean over three axes.
#[test]
fn inverse_mass_of_a_slider_is_that_of_its_body() {
    let x = "<joint type='slide' axis='1 0 0'/>";
    let joints =
        |joints: &str| format!("<body name='b'>{joints}<geom size='0.1' mass='2'/></body>");
    let beside = |inside: &str| format!("<body name='b'>{x}{inside}</body>");
    let small = "<geom size='0.1' mass='2'/><body><geom size='0.1' mass='1'/></body>";
    for (body, expected) in [
        (joints(x), 0.5),
        (
            joints(&format!("{x}<joint type='slide' axis='0 0 -3'/>")),
            0.5,
        ),
        (joints(&x.replace("/>", " armature='3'/>")), 0.5),
        (format!("<body euler='10 0 0'>{}</body>", joints(x)), 0.5),
        (joints("<joint type='slide' axis='1 1 0'/>"), 0.5 / 3.0),
        (joints(&x.replace("/>", " pos='1 0 0'/>")), 0.5 / 3.0),
        (joints(&format!("{x}<joint type='hinge'/>")), 0.5 / 3.0),
        (
            beside("<geom size='0.1' mass='2' pos='0.1 0 0'/>"),
            0.5 / 3.0,
        ),
        (
            beside("<geom type='box' size='0.1 0.2 0.3' mass='2' euler='20 30 0'/>"),
            0.5 / 3.0,
        ),
        (beside(small), 1.0 / 9.0),
    ] {
        let (scene, _) = text(&format!(
            "<mujoco><worldbody>{body}</worldbody><equality><connect body1='b' anchor='0 0 0'/></equality></mujoco>"
        ));
        let soft = scene.constraints[0].regularisation().expect("soft");
        let error = soft.inverse_mass - expected;
        assert!(error.abs() < 1e-12, "{body}: {}", soft.inverse_mass);
    }
}

// A carried box that is also stuck to the wall: no motion obeys both.
#[test]
fn contradictory_equalities_share_the_load() {
    let (scene, report) = text(
        "<mujoco><worldbody><body name='hand' mocap='true' pos='0.2 0 1'/>
         <body name='box' pos='0 0 1'><freejoint name='f'/><geom size='0.1' mass='1'/></body></worldbody>
         <equality><weld body1='hand' body2='box' relpose='0 0 0 1 0 0 0'/><weld body1='world' body2='box' relpose='0 0 1 1 0 0 0'/></equality></mujoco>",
    );
    assert!(report.ignored.len() <= 1, "{report}");
    let simulator = scene.simulator();
    let end = simulator
        .rollout(&scene.reference, 1000, |_, _, _| {})
        .last()
        .clone();
    // In the middle, and a little below.
    assert!((end.q[0] - 0.1).abs() < 1e-6, "{}", end.q);
    assert!(end.q[2] < 1.0 && end.q[2] > 0.999, "{}", end.q);
    assert!(end.v.amax() < 1e-6, "{}", end.v);
}

#[test]
fn weld_without_torque_scale_is_a_ball_joint() {
    let (scene, _) = text(
        "<mujoco><worldbody><body name='box' pos='0 0 1'><freejoint name='f'/><geom size='0.1' mass='1'/></body></worldbody>
         <equality><weld body1='box' torquescale='0'/></equality></mujoco>",
    );
    assert!(matches!(
        scene.constraints[0].kind(),
        ConstraintKind::Ball(_)
    ));
}
