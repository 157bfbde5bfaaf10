//! Activations of actuators against those of `MuJoCo` in the same text, `tests/mjcf/activations.xml`.

use dualbody::io::MjcfScene;
use dualbody::sim::{Actuation, Actuator};
use dualbody::{ModelOptions, Simulator};

use crate::common::OTHER_ALGORITHM;
use crate::mjcf::{file, find, golden};

/// The scene without joint limits, which are switched off there.
fn scene() -> (MjcfScene, Simulator) {
    let scene = file("activations");
    let simulator = scene.simulator();
    let own = simulator.actuation().expect("servos").actuators();
    let unlimited: Vec<Actuator> = (own.iter())
        .map(|own| Actuator {
            position: None,
            ..*own
        })
        .collect();
    let actuation = Actuation::ideal(simulator.model()).with_actuators(&unlimited);
    (scene, simulator.with_actuation(actuation))
}

fn check(found: &[f64], expected: &[f64], what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let size = expected.iter().fold(1e-3_f64, |size, x| size.max(x.abs()));
    for (k, (x, y)) in found.iter().zip(expected).enumerate() {
        let error = (x - y).abs() / size;
        assert!(error < OTHER_ALGORITHM, "{what}, {k}: {x} for {y}");
    }
}

// Six actuators have a number of activation there; the nozzle has two inputs that are on their way.
#[test]
fn accelerations_and_next_activations_equal_those_of_mujoco() {
    let (scene, simulator) = scene();
    assert_eq!(simulator.n_activation(), 8);
    for (k, records) in golden("activations").iter().enumerate() {
        let [q, v, control, act, next] =
            ["q", "v", "control", "activation", "next_activation"].map(|key| find(records, key));
        let mut state = simulator.state(q, v);
        // The nozzle is the second of the file.
        let own = |all: &[f64]| -> Vec<f64> {
            let late = [0.0; 2];
            all[..1]
                .iter()
                .chain(&late)
                .chain(&all[1..])
                .copied()
                .collect()
        };
        state.activation.copy_from_slice(&own(act));
        let u = scene.inputs(control);
        let a = simulator.acceleration(&state, &u);
        check(
            a.as_slice(),
            find(records, "acceleration"),
            &format!("state {k}: a"),
        );
        let mut expected = own(next);
        expected[2] = control[1];
        let found = simulator.step(&state, &u).activation;
        check(
            found.as_slice(),
            &expected,
            &format!("state {k}: activation"),
        );
    }
}

#[test]
fn keyframes_have_the_activations_of_their_actuators() {
    let (scene, _) = scene();
    assert_eq!(scene.reference.activation.as_slice(), [0.0; 8]);
    let home = scene.keyframes[0].state.activation.as_slice();
    assert_eq!(home, [0.1, 0.0, 0.0, 0.2, 0.3, 0.4, 0.5, 0.6]);
    let next = scene
        .simulator()
        .step(&scene.reference, &scene.inputs(&[0.0; 8]));
    assert!(next.is_finite());
}

#[test]
fn what_is_odd_about_an_activation_is_said() {
    let text = |actuator: &str, key: &str| {
        let xml = format!(
            "<mujoco><worldbody><body><joint name='j'/><geom size='0.1'/></body></worldbody>\n<actuator>{actuator}</actuator>{key}</mujoco>"
        );
        ModelOptions::default().load_mjcf_scene_str(&xml)
    };
    let smooth = "<motor joint='j' delay='0.01' nsample='9' interp='linear'/>";
    let (scene, report) = text(smooth, "").expect("a joint");
    assert!(scene.actuation[0].servo.is_none() && scene.actuation[0].activation.is_none());
    assert!(report.to_string().contains("interpolated"), "{report}");
    let muscle = "<general joint='j' dyntype='muscle'/><general joint='j' dyntype='filter'/>";
    let (scene, report) =
        text(muscle, "<keyframe><key act='0.1 0.2'/></keyframe>").expect("a joint");
    assert_eq!(scene.keyframes[0].state.activation.as_slice(), [0.2]);
    assert!(
        report.to_string().contains("dynamics of a kind"),
        "{report}"
    );
    for (actuator, key, expected) in [
        (
            "<motor joint='j' delay='-1' nsample='2'/>",
            "",
            "is negative",
        ),
        (
            "<general joint='j' dyntype='integrator' actrange='2 -2' actlimited='true'/>",
            "",
            "above the second",
        ),
        (
            "<motor joint='j'/>",
            "<keyframe><key act='1'/></keyframe>",
            "has 1 numbers, expected 0",
        ),
    ] {
        let error = text(actuator, key).expect_err(expected);
        assert!(error.to_string().contains(expected), "{error}");
    }
    let (_, report) =
        text("<motor joint='j' delay='1e300' nsample='1e300'/>", "").expect("a joint");
    assert!(report.to_string().contains("10 000 time steps"), "{report}");
    let many = "<motor joint='j' delay='20'/>".repeat(200);
    let error = text(&many, "").expect_err("too many inputs");
    assert!(error.to_string().contains("a million inputs"), "{error}");
}

#[test]
fn negative_time_constant_of_a_filter_is_taken_as_none_with_a_warning() {
    let load = |time: f64, kind: &str| {
        let xml = format!(
            "<mujoco><worldbody><body><joint name='j'/><geom size='0.1'/></body></worldbody>\n<actuator>\n<general joint='j' dyntype='{kind}' dynprm='{time}'/></actuator></mujoco>"
        );
        let loaded = ModelOptions::default().load_mjcf_scene_str(&xml);
        loaded.unwrap_or_else(|error| panic!("{error}"))
    };
    for (time, kind, warned) in [
        (-0.1, "filter", true),
        (-0.1, "filterexact", true),
        (0.1, "filter", false),
        (0.0, "filter", false),
        (-0.1, "none", false),
        (-0.1, "integrator", false),
    ] {
        let (_, report) = load(time, kind);
        let of_time = |note: &&dualbody::io::ImportNote| note.reason.contains("time constant -0.1");
        let lines: Vec<u32> = report
            .warnings
            .iter()
            .filter(of_time)
            .map(|note| note.line)
            .collect();
        assert_eq!(
            lines,
            if warned { vec![3] } else { vec![] },
            "{kind} {time}"
        );
    }
}
