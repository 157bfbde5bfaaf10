//! Readings of sensors against those that `MuJoCo` computes of the same text, `tests/mjcf/sensors.xml`.

use dualbody::sim::{Sensor, Sensors};
use dualbody::spatial::Representation;
use dualbody::{Integrator, Model, ModelOptions, Simulator, State};

use crate::common::OTHER_ALGORITHM;
use crate::mjcf::{Record, file, find, golden};

/// Gravity of the description, m/s².
const GRAVITY: [f64; 3] = [0.3, -0.2, -9.7];

/// Farther than anything in the description, m: the reading of a ray that hits nothing; `MuJoCo` has −1 there.
const RANGE: f64 = 100.0;

/// Our sensors by their names in the description.
fn sensors(model: &Model) -> Sensors {
    let frame = |name: &str| model.find_frame(name).expect("a frame");
    let joint = |name: &str| model.find_joint(name).expect("a joint");
    let (imu, tip, mixed) = (frame("imu"), frame("tip"), Representation::Mixed);
    let field = [0.2, 0.1, -0.5];
    let range = |name: &str| Sensor::RangeFinder {
        frame: frame(name),
        direction: [0.0, 0.0, 1.0],
        range: RANGE,
    };
    let velocity = |representation| Sensor::FrameVelocity {
        frame: tip,
        representation,
    };
    let acceleration = Sensor::FrameAcceleration {
        frame: tip,
        representation: mixed,
    };
    Sensors::new(
        model,
        [
            ("shoulder_q", Sensor::JointPosition(joint("shoulder"))),
            ("slide_v", Sensor::JointVelocity(joint("slide"))),
            ("imu_a", Sensor::Accelerometer(imu)),
            ("imu_w", Sensor::Gyro(imu)),
            ("imu_b", Sensor::Magnetometer { frame: imu, field }),
            ("tip_a", Sensor::Accelerometer(tip)),
            ("tip_v", velocity(Representation::Body)),
            ("wrist", Sensor::Wrench(frame("plate"))),
            ("tip_p", Sensor::FramePose(tip)),
            ("tip_lv", velocity(mixed)),
            ("tip_la", acceleration),
            ("com", Sensor::CenterOfMass),
            ("com_v", Sensor::CenterOfMassVelocity),
            ("momentum", Sensor::Momentum),
            ("imu_d", range("imu")),
            ("down_d", range("down")),
            ("up_d", range("up")),
            ("side_d", range("side")),
            ("back_d", range("back_eye")),
            ("front_d", range("front")),
            ("tip_d", range("tip")),
        ],
    )
}

/// A sensor of `MuJoCo`, and which of the numbers of one of ours it has.
const PARTS: [(&str, &str, usize); 25] = [
    ("shoulder_q", "shoulder_q", 0),
    ("slide_v", "slide_v", 0),
    ("imu_a", "imu_a", 0),
    ("imu_w", "imu_w", 0),
    ("imu_b", "imu_b", 0),
    ("tip_a", "tip_a", 0),
    ("tip_v", "tip_v", 0),
    ("wrist_f", "wrist", 0),
    ("wrist_n", "wrist", 3),
    ("tip_p", "tip_p", 0),
    ("tip_r", "tip_p", 3),
    ("tip_lv", "tip_lv", 0),
    ("tip_av", "tip_lv", 3),
    ("tip_la", "tip_la", 0),
    ("tip_aa", "tip_la", 3),
    ("com", "com", 0),
    ("com_v", "com_v", 0),
    ("momentum", "momentum", 3),
    ("imu_d", "imu_d", 0),
    ("down_d", "down_d", 0),
    ("up_d", "up_d", 0),
    ("side_d", "side_d", 0),
    ("back_d", "back_d", 0),
    ("front_d", "front_d", 0),
    ("tip_d", "tip_d", 0),
];

/// The readings of a state under forces of all joints, that of the base among them.
fn read(model: &Model, sensors: &Sensors, records: &[Record]) -> Vec<f64> {
    let [q, v, tau] = ["q", "v", "tau"].map(|key| find(records, key));
    let simulator = Simulator::new(model.clone()).with_integrator(Integrator::RungeKutta4);
    let y = sensors.read(&simulator, &State::new(q, v), tau);
    y.as_slice().to_vec()
}

#[test]
fn readings_equal_those_that_mujoco_finds_of_the_same_text() {
    let model = file("sensors").model;
    let sensors = sensors(&model);
    let states = golden("sensors");
    let mut hits = 0;
    for (k, records) in states[..states.len() - 1].iter().enumerate() {
        let y = read(&model, &sensors, records);
        for (theirs, ours, first) in PARTS {
            let expected = find(records, &format!("sensor:{theirs}"));
            let start = sensors.range(ours).expect("a sensor").start + first;
            for (i, expected) in expected.iter().enumerate() {
                let expected = match theirs {
                    // Accelerations of frames have that of the world against gravity there.
                    "tip_la" => expected + GRAVITY[i],
                    _ if theirs.ends_with("_d") && *expected < 0.0 => RANGE,
                    _ => *expected,
                };
                hits += usize::from(theirs.ends_with("_d") && expected < RANGE);
                let error = (y[start + i] - expected).abs();
                let tolerance = OTHER_ALGORITHM * expected.abs().max(1.0);
                assert!(
                    error < tolerance,
                    "state {k}: {theirs}[{i}] is {}, MuJoCo's {expected}",
                    y[start + i]
                );
            }
        }
    }
    assert!(hits > 12, "{hits} rays hit something");
}

/// Those of the file: position and orientation, force and torque, linear and angular belong to one sensor here.
#[test]
fn sensors_of_the_file_are_those_that_are_written_by_hand() {
    let scene = file("sensors");
    let by_hand = sensors(&scene.model);
    let known = scene.known_sensors();
    let simulator = Simulator::new(scene.model.clone());
    let state = State::new(scene.reference.q.as_slice(), &[0.1; 9]);
    let [own, hand] = [&known, &by_hand].map(|all| all.read(&simulator, &state, &[0.2; 9]));
    let same = [
        ("shoulder_q", "shoulder_q"),
        ("imu_b", "imu_b"),
        ("tip_a", "tip_a"),
        ("wrist_f", "wrist"),
        ("tip_r", "tip_p"),
        ("tip_av", "tip_lv"),
        ("down_d", "down_d"),
    ];
    for (theirs, ours) in same {
        let [theirs, ours] = [(&known, theirs), (&by_hand, ours)]
            .map(|(all, name)| all.range(name).expect("a sensor"));
        assert_eq!(own.as_slice()[theirs], hand.as_slice()[ours]);
    }
    // The robot has walls beside it on the world, and they do not move.
    assert!(known.range("com").is_some());
    assert_eq!(
        known.range("tip_la"),
        None,
        "its numbers have gravity in them"
    );
    let reach = scene.sensors.iter().find(|own| own.name == "tip_d");
    assert_eq!(reach.expect("a sensor").noise.limit, RANGE);
}

#[test]
fn sensors_that_cannot_be_had_are_named() {
    let xml = "<mujoco><worldbody><body name='b'><joint name='j'/><geom size='0.1'/><site name='s'/></body></worldbody>
      <sensor><gyro site='s' noise='0.1'/><clock/>
      <framepos objtype='xbody' objname='b'/><framepos objtype='body' objname='b'/><touch site='s'/></sensor></mujoco>";
    let (scene, report) = ModelOptions::default()
        .load_mjcf_scene_str(xml)
        .expect("a scene");
    let text = report.to_string();
    for reason in ["is not modelled", "inertial frame", "counts all contact"] {
        assert!(text.contains(reason), "{reason} is not in {text}");
    }
    let names = scene.known_sensors();
    assert_eq!(names.names()[0], "gyro 0.x");
    assert_eq!(names.len(), 3 + 7 + 1);
    assert_eq!(scene.sensors[0].noise.white, 0.1);
    let broken = xml.replace("noise='0.1'", "noise='-1'");
    let error = ModelOptions::default()
        .load_mjcf_scene_str(&broken)
        .unwrap_err();
    assert!(error.to_string().contains("negative"), "{error}");
}
