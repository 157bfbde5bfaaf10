//! Inputs of joints from `<ros2_control>` and `<transmission>` of a URDF.

use dualbody::io::ImportReport;
use dualbody::sim::{Actuation, Actuator, Servo};
use dualbody::{Model, ModelOptions, Simulator};

/// A cart of 2 kg with two more on it, a hinge that follows another, and a lid that does not move.
const ROBOT: &str = r#"<robot name="carts"><link name="world"/>
<link name="a"><inertial><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<link name="b"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<link name="c"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<link name="d"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<link name="e"/>
<joint name="x" type="prismatic"><parent link="world"/><child link="a"/><axis xyz="1 0 0"/><limit lower="-9" upper="9" effort="50" velocity="90"/></joint>
<joint name="y" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/><limit lower="-9" upper="9" effort="50" velocity="90"/></joint>
<joint name="h" type="continuous"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/></joint>
<joint name="m" type="continuous"><parent link="c"/><child link="d"/><axis xyz="0 0 1"/><mimic joint="h"/></joint>
<joint name="f" type="fixed"><parent link="d"/><child link="e"/></joint>
"#;

fn load(parts: &str) -> (Model, ImportReport) {
    let text = format!("{ROBOT}{parts}</robot>");
    let loaded = ModelOptions::default().load_urdf_str(&text);
    loaded.unwrap_or_else(|error| panic!("{error}"))
}

fn control(joints: &str) -> String {
    format!("<ros2_control name='all' type='system'>{joints}</ros2_control>")
}

fn simulator(parts: &str) -> Simulator {
    let (model, report) = load(parts);
    report.simulator(model)
}

/// What is remarked beside that which the robot itself has, with lines from the end of the robot on.
fn remarks(parts: &str) -> Vec<(u32, String)> {
    let (_, plain) = load("");
    let (_, report) = load(parts);
    let last = u32::try_from(ROBOT.lines().count()).expect("a short text");
    let notes = [&report.warnings[plain.warnings.len()..], &report.ignored];
    let mut out: Vec<_> = (notes.into_iter().flatten())
        .map(|note| (note.line - last, note.reason.clone()))
        .collect();
    out.sort();
    out
}

#[test]
fn joints_without_interface_have_no_input_and_efforts_stay_within_their_range() {
    let all = simulator("");
    assert_eq!(all.input_names(), ["x", "y", "h"]);
    let one = simulator(&control(
        "<joint name='x'><command_interface name='effort'><param name='min'>-4</param><param name='max'> 6 </param></command_interface>
         <state_interface name='position'/></joint><joint name='h'><state_interface name='velocity'/></joint>",
    ));
    assert_eq!(one.input_names(), ["x"]);
    for (u, force) in [(3.0, 3.0), (100.0, 6.0), (-5.0, -4.0)] {
        let next = one.step(&one.neutral_state(), &[u]);
        let expected = force / 5.0 * one.time_step();
        assert!((next.v[0] - expected).abs() < 1e-12, "{u}: {}", next.v[0]);
    }
    // The effort limit of the joint bounds an input without a range.
    let plain = simulator(&control(
        "<joint name='x'><command_interface name='effort'/></joint>",
    ));
    let next = plain.step(&plain.neutral_state(), &[80.0]);
    assert!((next.v[0] - 10.0 * plain.time_step()).abs() < 1e-12);
    assert_eq!(simulator(&control("")).nu(), 0);
}

/// The simulator that has these servos, by hand.
fn by_hand(servos: &[(&str, Servo)]) -> Simulator {
    let (model, _) = load("");
    let mut actuation = Actuation::from_model(&model);
    for (joint, servo) in servos {
        let k = model.joint_v(model.joint(joint).expect("a joint")).start;
        let own = actuation.actuators()[k];
        let servo = Some(*servo);
        let own = Actuator { servo, ..own };
        actuation = actuation
            .with_actuator(&model, joint, own)
            .expect("a joint");
    }
    let names: Vec<&str> = servos.iter().map(|(joint, _)| *joint).collect();
    let simulator = Simulator::new(model).with_actuation(actuation);
    simulator.with_actuated_joints(&names).expect("joints")
}

#[test]
fn servos_equal_those_set_by_hand_whatever_their_gains_are_called() {
    let expected = by_hand(&[
        (
            "y",
            Servo::position(300.0, 20.0).with_input_range(-1.0, 0.5),
        ),
        ("x", Servo::velocity(7.0)),
    ]);
    let end = |own: &Simulator| {
        let moved = own.rollout(&own.neutral_state(), 100, |time, _, u| {
            u.copy_from_slice(&[2.0 * (5.0 * time).sin(), 0.3]);
        });
        moved.last().clone()
    };
    let y = |joint: &str, interface: &str, name: &str| {
        format!(
            "<joint name='y'>{joint}<command_interface name='{name}'><param name='min'>-1</param><param name='max'>0.5</param>{interface}</command_interface></joint>"
        )
    };
    let param = |name: &str, x: &str| format!("<param name='{name}'>{x}</param>");
    for (p, d, v) in [
        ("kp", "kd", "kp"),
        ("P", "D", "P"),
        ("pos_kp", "pos_kd", "vel_kp"),
        ("position_kp", "position_kd", "velocity_p"),
    ] {
        let gains = param(p, "300") + &param(d, "2e1");
        let x = param(v, "7");
        for y in [y(&gains, "", "position"), y("", &gains, "position_pid")] {
            let x = format!(
                "<joint name='x'><command_interface name='velocity'>{x}</command_interface></joint>"
            );
            let own = simulator(&control(&(y + &x)));
            assert_eq!(own.input_names(), expected.input_names());
            assert_eq!(own.actuation(), expected.actuation(), "{p}");
            assert_eq!(end(&own), end(&expected));
        }
    }
}

// The input is a quantity of the joint, on whichever side of the gear the law is stated.
#[test]
fn reduction_is_the_gear_of_the_servo_and_leaves_the_law_at_the_joint() {
    let joints = "<joint name='x'><command_interface name='position'><param name='kp'>300</param><param name='kd'>20</param></command_interface></joint>
      <joint name='h'><command_interface name='effort'/></joint>";
    let geared = |n: &str| {
        let one = |joint: &str| {
            format!(
            "<transmission name='t{joint}'><plugin>transmission_interface/SimpleTransmission</plugin><actuator name='motor' role='actuator1'/>
             <joint name='{joint}' role='joint1'><mechanical_reduction>{n}</mechanical_reduction></joint></transmission>"
        )
        };
        simulator(&control(&format!("{joints}{}{}", one("x"), one("h"))))
    };
    let plain = simulator(&control(joints));
    let end = |own: &Simulator| {
        let moved = own.rollout(&own.neutral_state(), 50, |_, _, u| {
            u.copy_from_slice(&[0.4, 0.1]);
        });
        moved.last().clone()
    };
    for n in ["50", "-0.25", "1"] {
        let own = geared(n);
        let actuators = own.actuation().expect("servos").actuators();
        let gear: f64 = n.parse().expect("a number");
        assert_eq!(actuators[0].servo.expect("a servo").gear, gear);
        let (found, expected) = (end(&own), end(&plain));
        assert!((&found.q - &expected.q).amax() < 1e-12 && (&found.v - &expected.v).amax() < 1e-11);
    }
}

#[test]
fn transmissions_of_ros_1_are_inputs_by_their_interfaces() {
    let transmission = |joint: &str, interface: &str| {
        format!(
        "<transmission name='t'><type>transmission_interface/SimpleTransmission</type><joint name='{joint}'><hardwareInterface>{interface}</hardwareInterface></joint>
         <actuator name='a'><mechanicalReduction>20</mechanicalReduction></actuator></transmission>"
    )
    };
    let effort = transmission("h", "hardware_interface/EffortJointInterface");
    let position = transmission("x", "PositionJointInterface");
    let (model, report) = load(&(effort.clone() + &position));
    let commands = report.commands.clone().expect("transmissions");
    assert_eq!(commands[0].0, "h");
    assert_eq!(commands[0].1.expect("behind a gear").gear, 20.0);
    assert_eq!(report.simulator(model).input_names(), ["h", "x"]);
    assert!(
        report.to_string().contains("no gains in the file"),
        "{report}"
    );
    assert!(remarks(&effort).is_empty());
    // Text of a joint that ROS 2 drives too.
    let both = control("<joint name='h'><command_interface name='effort'/></joint>") + &effort;
    let (_, report) = load(&both);
    assert_eq!(report.commands.expect("one").len(), 1);
    assert_eq!(remarks(&both)[0].1, "the joint has another input");
}

#[test]
fn everything_that_is_not_used_is_reported_with_its_line() {
    let parts = "<ros2_control name='all' type='system'>
<hardware><plugin>driver</plugin><param name='port'>1</param></hardware>
<joint name='x'>
<param name='pos_ki'>3</param>
<command_interface name='position'/>
<command_interface name='acceleration'/>
<command_interface name='effort'/>
<command_interface name='velocity'/>
<state_interface name='position'><param name='initial_value'>1</param></state_interface>
</joint>
<sensor name='imu'/>
<gpio name='io'/>
<joint name='none'><command_interface name='effort'/></joint>
<joint name='m'><command_interface name='effort'/></joint>
<joint name='f'><command_interface name='effort'/></joint>
<joint name='x'><command_interface name='effort'/></joint>
<joint name='y'>
<command_interface name='velocity'>
<param name='kp'>nan</param>
</command_interface></joint>
<joint name='h'><command_interface name='effort'>
<param name='min'>2</param><param name='max'>-PI</param>
</command_interface></joint>
<transmission name='d'><plugin>transmission_interface/DifferentialTransmission</plugin></transmission>
<transmission name='t'><plugin>transmission_interface/SimpleTransmission</plugin><joint name='h'>
<mechanical_reduction>0</mechanical_reduction>
<offset>1</offset>
</joint></transmission>
</ros2_control>
<transmission name='four'><type>transmission_interface/FourBarLinkageTransmission</type></transmission>";
    let found = remarks(parts);
    let lines: Vec<u32> = found.iter().map(|(line, _)| *line).collect();
    assert_eq!(
        lines,
        [
            2, 4, 5, 6, 8, 9, 11, 12, 13, 14, 15, 16, 18, 19, 22, 24, 26, 27, 30
        ],
        "{found:#?}"
    );
    let said = |line: u32| {
        let note = found.iter().find(|(own, _)| *own == line);
        note.expect("a remark").1.as_str()
    };
    for (line, words) in [
        (5, "no gains in the file: the joint has another input"),
        (6, "\"acceleration\""),
        (13, "no joint of this name"),
        (14, "follows another"),
        (15, "does not move"),
        (18, "input of the joint is its effort"),
        (19, "\"nan\" is not a finite number"),
        (22, "\"-PI\" is not a finite number"),
        (24, "DifferentialTransmission"),
        (26, "reduction of 0"),
    ] {
        assert!(said(line).contains(words), "{line}: {}", said(line));
    }
    let (model, report) = load(parts);
    assert_eq!(report.simulator(model).input_names(), ["x", "y", "h"]);
}

#[test]
fn broken_elements_are_remarks_and_no_panics() {
    for parts in [
        "<ros2_control/>",
        "<transmission/>",
        "<ros2_control><joint/></ros2_control>",
        "<ros2_control><joint><command_interface/></joint></ros2_control>",
        "<ros2_control><joint name='x'><command_interface name='effort'><param/><param name='max'/></command_interface></joint></ros2_control>",
        "<transmission><type>SimpleTransmission</type><joint/></transmission>",
        "<transmission type='SimpleTransmission'><joint name='x'/><actuator name='a'/></transmission>",
        "<ros2_control><joint name='x'><command_interface name='effort'/></joint>
         <transmission><plugin>SimpleTransmission</plugin><joint name='x'><mechanical_reduction>1e-320</mechanical_reduction></joint></transmission></ros2_control>",
        "<ros2_control><joint name='x'><command_interface name='effort'><param name='min'>3</param><param name='max'>2</param></command_interface></joint></ros2_control>",
    ] {
        let (model, report) = load(parts);
        let simulator = report.simulator(model);
        assert!(simulator.nu() <= 1, "{parts}");
        assert!(parts.contains("'effort'") || report.commands.as_ref().is_some_and(Vec::is_empty));
        let has_remark = parts.contains("command_interface") || parts.contains("<transmission");
        assert_eq!(!remarks(parts).is_empty(), has_remark, "{parts}: {:?}", remarks(parts));
    }
}

/// Its square is infinite, and so would be what the motor gives against a motion.
#[test]
fn a_reduction_whose_square_is_infinite_is_a_remark() {
    let parts = "<transmission><type>SimpleTransmission</type><joint name='x'><hardwareInterface>EffortJointInterface</hardwareInterface></joint>
      <actuator name='m'><mechanicalReduction>1e300</mechanicalReduction></actuator></transmission>";
    let told = remarks(parts);
    assert!(
        told.iter().any(|(_, reason)| reason.contains("reduction")),
        "{told:?}"
    );
    let simulator = simulator(parts);
    let next = simulator.step(&simulator.neutral_state(), &[5.0]);
    assert!(
        (next.v[0] - simulator.time_step()).abs() < 1e-12,
        "{next:?}"
    );
}

#[test]
fn locked_joints_have_no_input_and_independent_mimic_joints_may() {
    let parts = control(
        "<joint name='x'><command_interface name='effort'/></joint><joint name='m'><command_interface name='effort'/></joint>",
    );
    let text = format!("{ROBOT}{parts}</robot>");
    let options = ModelOptions::default().with_independent_mimic_joints();
    let (model, report) = options.clone().load_urdf_str(&text).expect("a robot");
    assert_eq!(report.simulator(model).input_names(), ["x", "m"]);
    let options = options.with_locked_joint("x", &[0.0]);
    let (model, report) = options.load_urdf_str(&text).expect("a robot");
    assert_eq!(report.simulator(model).input_names(), ["m"]);
}
