//! Poses against those found by hand.

use super::*;
use crate::tests::ROUNDING;

/// A robot in which nothing moves, so that every frame stands in the world.
fn still(version: &str, parts: &str) -> Model {
    load(&robot_of(version, &format!("<static>true</static>{parts}"))).0
}

const X: [f64; 3] = [1., 0., 0.];
const Y: [f64; 3] = [0., 1., 0.];

#[test]
fn poses_equal_those_of_each_rule_of_relation() {
    let turned = format!("<pose>1 2 3 0 0 {QUARTER}</pose>");
    // Link a stands at (1, 2, 3) with its x axis along y; its own (1, 0, 0) is at (1, 3, 3).
    let a = link("a", &turned);
    let on_a = "<pose relative_to=\"a\">1 0 0 0 0 0</pose>";
    let plain = "<pose>1 0 0 0 0 0</pose>";
    let b = link("b", "");
    let joint_to_b = |parts: &str| joint("j", "fixed", "a", "b", parts);
    for (rule, parts, frame, position, x_axis) in [
        ("link in model", a.clone(), "a", [1., 2., 3.], Y),
        (
            "model in world",
            format!("{turned}{}", link("b", plain)),
            "b",
            [1., 3., 3.],
            Y,
        ),
        (
            "link to link",
            a.clone() + &link("b", on_a),
            "b",
            [1., 3., 3.],
            Y,
        ),
        (
            "link to itself named model",
            a.clone() + &link("b", "<pose relative_to=\"__model__\">1 0 0 0 0 0</pose>"),
            "b",
            X,
            X,
        ),
        (
            "frame in model",
            a.clone() + &format!("<frame name='f'>{plain}</frame>"),
            "f",
            X,
            X,
        ),
        (
            "frame where it is attached",
            a.clone() + &format!("<frame name='f' attached_to='a'>{plain}</frame>"),
            "f",
            [1., 3., 3.],
            Y,
        ),
        (
            "frame attached and related",
            a.clone() + &b + &format!("<frame name='f' attached_to='b'>{on_a}</frame>"),
            "f",
            [1., 3., 3.],
            Y,
        ),
        (
            "link to frame",
            a.clone()
                + "<frame name='f' attached_to='a'/>"
                + &link("b", "<pose relative_to='f'>1 0 0 0 0 0</pose>"),
            "b",
            [1., 3., 3.],
            Y,
        ),
        // The joint stands on its child b, at (0, 0, 5) + (0, 0, 1).
        (
            "link to joint",
            a.clone()
                + &link("b", "<pose>0 0 5 0 0 0</pose>")
                + &joint_to_b("<pose>0 0 1 0 0 0</pose>")
                + &link("c", "<pose relative_to='j'/>"),
            "c",
            [0., 0., 6.],
            X,
        ),
        // The joint stands on a, and b on the joint.
        (
            "joint to link",
            a.clone() + &link("b", "<pose relative_to='j'>1 0 0 0 0 0</pose>") + &joint_to_b(on_a),
            "b",
            [1., 4., 3.],
            Y,
        ),
        (
            "degrees",
            link("b", "<pose degrees='true'>1 2 3 0 0 90</pose>"),
            "b",
            [1., 2., 3.],
            Y,
        ),
        // (x y z w) = (0 0 1 1) is a quarter turn about z.
        (
            "quaternion",
            link(
                "b",
                "<pose rotation_format='quat_xyzw'>1 2 3 0 0 1 1</pose>",
            ),
            "b",
            [1., 2., 3.],
            Y,
        ),
        ("empty pose", link("b", "<pose/>"), "b", [0.; 3], X),
    ] {
        let found = pose(&still("1.11", &parts), frame);
        let expected = (Vector3::from(position), Vector3::from(x_axis));
        let error = (found.translation - expected.0).amax()
            + (found.rotation.column(0) - expected.1).amax();
        assert!(error < 10.0 * ROUNDING, "{rule}: {found:?}");
    }
}

// Roll, pitch and yaw about fixed axes: R = Rz(y) Ry(p) Rx(r). With yaw and roll of a quarter turn, x goes to y and z
// to Rz Rx z = Rz (−y) = x.
#[test]
fn angles_turn_about_fixed_axes() {
    let model = still(
        "1.11",
        &link("a", &format!("<pose>0 0 0 {QUARTER} 0 {QUARTER}</pose>")),
    );
    let rotation = pose(&model, "a").rotation;
    assert!(
        (rotation.column(2) - Vector3::x()).amax() < ROUNDING,
        "{rotation}"
    );
}

#[test]
fn versions_read_poses_as_they_did() {
    let a = link("a", "<pose>1 2 3 0 0 0</pose>");
    // Before 1.7 the attribute that names a frame is `frame`, and relative_to is none.
    let parts = a.clone() + &link("b", "<pose frame='a'>1 0 0 0 0 0</pose>");
    assert_at(&pose(&still("1.6", &parts), "b"), [2., 2., 3.], X);
    assert_at(&pose(&still("1.7", &parts), "b"), [1., 0., 0.], X);
    let parts = a.clone() + &link("b", "<pose relative_to='a'>1 0 0 0 0 0</pose>");
    assert_at(&pose(&still("1.5", &parts), "b"), [1., 0., 0.], X);
    assert_at(&pose(&still("1.8", &parts), "b"), [2., 2., 3.], X);
    // Degrees and quaternions come with 1.9: before, they are read with a warning.
    for turned in [
        "degrees='1'>0 0 0 0 0 90<",
        "rotation_format='quat_xyzw'>0 0 0 0 0 1 1<",
    ] {
        let parts = link("b", &format!("<pose {turned}/pose>"));
        for (version, warnings) in [("1.9", 0), ("1.8", 1)] {
            assert_at(&pose(&still(version, &parts), "b"), [0.; 3], Y);
            let report = load(&robot_of(version, &parts)).1;
            let is_late = |note: &&ImportNote| note.reason.contains("from version 1.9");
            assert_eq!(
                report.warnings.iter().filter(is_late).count(),
                warnings,
                "{report}"
            );
        }
    }
}

#[test]
fn nested_models_stand_on_their_placement_frames() {
    // The tip of the arm stands at (1, 0, 0) + Rz (0, 0, 0); it is 2 above its link, which is then at (1, 0, −2),
    // turned.
    let arm = format!(
        "<model name='arm' placement_frame='tip'><pose>1 0 0 0 0 {QUARTER}</pose>{}{}<frame name='tip' attached_to='upper'><pose>0 0 2 0 0 0</pose></frame></model>",
        link("upper", ""),
        link("lower", "<pose relative_to='upper'>1 0 0 0 0 0</pose>"),
    );
    let outside = link("hat", "<pose relative_to='arm::tip'>0 0 1 0 0 0</pose>")
        + "<frame name='on' attached_to='arm::lower'/><frame name='model' attached_to='arm'/>";
    let model = still("1.8", &(arm + &outside));
    assert_at(&pose(&model, "arm::tip"), [1., 0., 0.], Y);
    assert_at(&pose(&model, "arm::upper"), [1., 0., -2.], Y);
    assert_at(&pose(&model, "arm::lower"), [1., 1., -2.], Y);
    assert_at(&pose(&model, "on"), [1., 1., -2.], Y);
    assert_at(&pose(&model, "model"), [1., 0., -2.], Y);
    assert_at(&pose(&model, "hat"), [1., 0., 1.], Y);
}

#[test]
fn poses_pass_through_two_placement_frames() {
    // In `in` the link is 1 below the placed frame; in `out` the placed frame is that link.
    let inner = format!(
        "<model name='in' placement_frame='p'>{}<frame name='p'><pose>0 0 1 0 0 0</pose></frame></model>",
        link("l", "")
    );
    let outer = format!(
        "<model name='out' placement_frame='in::l'><pose>5 0 0 0 0 0</pose>{inner}{}</model>",
        link("k", "")
    );
    let model = still("1.11", &outer);
    assert_at(&pose(&model, "out::in::l"), [5., 0., 0.], X);
    assert_at(&pose(&model, "out::k"), [5., 0., 1.], X);
}

#[test]
fn inertia_and_shapes_stand_in_their_frames() {
    let parts = "<link name='a'><pose>0 0 1 0 0 0</pose>
        <inertial><pose relative_to='__model__'>0 0 3 0 0 0</pose><mass>2</mass><inertia><ixx>1</ixx><ixy>0</ixy><ixz>0</ixz><iyy>1</iyy><iyz>0</iyz><izz>1</izz></inertia></inertial>
        <visual name='v'><pose relative_to='f'/><geometry><box><size>1 2 3</size></box></geometry></visual>
        <collision name='c'><pose>1 0 0 0 0 0</pose><geometry><sphere><radius>1</radius></sphere></geometry></collision></link>
        <frame name='f'><pose>0 0 7 0 0 0</pose></frame>";
    let (model, _) = load(&robot(parts));
    let link = &model.links()[0];
    assert_eq!(
        model.to_builder().links[0].inertia.com(),
        Vector3::new(0., 0., 2.)
    );
    assert_eq!(
        link.visuals[0].placement.translation,
        Vector3::new(0., 0., 6.)
    );
    assert_eq!(
        link.collisions[0].placement.translation,
        Vector3::new(1., 0., 0.)
    );
}

#[test]
fn pose_in_a_world_is_relative_to_frames_and_models_in_it() {
    let world = format!(
        "<sdf version='1.9'><world name='w'><gravity>0 0 -1.6</gravity><frame name='f' attached_to='table'><pose>0 0 1 0 0 0</pose></frame>
         <model name='table'><pose>4 0 0 0 0 0</pose></model>
         <model name='r'><pose relative_to='f'>0 1 0 0 0 0</pose>{}{}</model></world></sdf>",
        link("a", ""),
        anchor("a")
    );
    let options = ModelOptions::default().with_model_name("r");
    let (model, _) = options.load_sdf_str(&world).unwrap();
    assert_at(&pose(&model, "a"), [4., 1., 1.], X);
    assert_eq!(*model.gravity(), Vector3::new(0., 0., -1.6));
    let (model, _) = options.with_gravity([0.; 3]).load_sdf_str(&world).unwrap();
    assert_eq!(*model.gravity(), Vector3::zeros());
}
