//! Joints: frames, axes, directions, limits, and the same robot as a URDF.

use super::*;
use crate::dynamics::{bias_forces, mass_matrix};
use crate::joint::{JointKind, Pitch};
use crate::model::{Base, Limits};
use crate::sim::State;
use crate::tests::{ROUNDING, SAME_ALGEBRA};
use rand::{Rng, SeedableRng};

const HALF_PI: f64 = std::f64::consts::FRAC_PI_2;

fn axis(parts: &str) -> String {
    format!("<axis>{parts}</axis>")
}

/// A hinge `j` between the world and link `a` with this axis.
fn hinge(version: &str, kind: &str, axis: &str) -> String {
    let parts = link("a", "") + &joint("j", kind, "world", "a", axis);
    robot_of(version, &parts)
}

#[test]
fn child_turns_about_the_frame_of_the_joint() {
    // The child b at (2, 0, 0); the hinge about z 1 to its left. After a quarter turn b is at (2, 1, 0) + Rz (0, −1, 0).
    let parts = link("a", "")
        + &anchor("a")
        + &link("b", "<pose>2 0 0 0 0 0</pose>")
        + &joint(
            "j",
            "revolute",
            "a",
            "b",
            "<pose>0 1 0 0 0 0</pose><axis><xyz>0 0 1</xyz></axis>",
        );
    let (model, _) = load(&robot(&parts));
    assert_eq!(model.nv(), 1);
    assert_at(&pose(&model, "b"), [2., 0., 0.], [1., 0., 0.]);
    assert_at(
        &pose_at(&model, &[HALF_PI], "b"),
        [3., 1., 0.],
        [0., 1., 0.],
    );
    // The frame of the joint is called like it, and moves.
    assert_at(
        &pose_at(&model, &[HALF_PI], "j"),
        [2., 1., 0.],
        [0., 1., 0.],
    );
}

#[test]
fn a_child_on_the_frame_of_its_joint_needs_no_link_between() {
    let parts = link("a", "")
        + &anchor("a")
        + &link("b", "<pose relative_to='j'/>")
        + &joint(
            "j",
            "revolute",
            "a",
            "b",
            "<pose relative_to='a'>0.1 0.2 0.3 0.4 0.5 0.6</pose><axis><xyz>0 0 1</xyz></axis>",
        );
    assert_eq!(load(&robot(&parts)).0.link_names(), ["world", "a", "b"]);
}

#[test]
fn joints_towards_the_root_move_the_other_way_round() {
    // The parent b stands 1 beside the child a, which the world holds: a quarter turn of a against b by +90° is one of b against
    // a by −90°, about a's origin: b moves from (1, 0, 0) to (0, −1, 0).
    let backward = link("a", "")
        + &anchor("a")
        + &link("b", "<pose>1 0 0 0 0 0</pose>")
        + &joint("j", "revolute", "b", "a", "<axis><xyz>0 0 1</xyz></axis>");
    let (model, _) = load(&robot(&backward));
    assert_at(
        &pose_at(&model, &[HALF_PI], "b"),
        [0., -1., 0.],
        [0., -1., 0.],
    );
    // A chain of two, both backwards, equals the forward chain with opposite coordinates.
    let ends = |parent: &str, child: &str| {
        joint(
            "j",
            "universal",
            parent,
            child,
            "<axis><xyz>0 0 1</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>",
        )
    };
    let links = link("a", "") + &anchor("a") + &link("b", "");
    let (model, _) = load(&robot(&(links + &ends("b", "a"))));
    let q = [0.3, -0.8];
    // From b to a: Rz(q of axis) Ry(q of axis2); from a to b its inverse.
    assert_eq!(model.joint_names(), ["j"]);
    // Its first coordinate is that of axis2.
    let forward = nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), q[1])
        * nalgebra::Rotation3::from_axis_angle(&Vector3::y_axis(), q[0]);
    let error = pose_at(&model, &q, "b").rotation - forward.inverse().matrix();
    assert!(error.amax() < ROUNDING, "{error}");
}

#[test]
fn axes_equal_those_in_the_frames_that_they_are_expressed_in() {
    // Frame f is turned a quarter about z against the link, so that its x is the link's y; the joint is turned too.
    let turned = format!("<pose>0 0 0 0 0 {QUARTER}</pose>");
    let with = |xyz: &str| {
        let parts = link("a", "")
            + &format!("<frame name='f' attached_to='a'>{turned}</frame>")
            + &joint(
                "j",
                "prismatic",
                "world",
                "a",
                &format!("{turned}<axis>{xyz}</axis>"),
            );
        let model = load(&robot(&parts)).0;
        pose_at(&model, &[1.0], "a").translation
    };
    for (xyz, direction) in [
        ("<xyz>1 0 0</xyz>", Vector3::y()),
        ("<xyz expressed_in=''>1 0 0</xyz>", Vector3::y()),
        ("<xyz expressed_in='a'>1 0 0</xyz>", Vector3::x()),
        ("<xyz expressed_in='__model__'>0 2 0</xyz>", Vector3::y()),
        ("<xyz expressed_in='f'>0 1 0</xyz>", -Vector3::x()),
        ("", Vector3::z()),
    ] {
        assert!(
            (with(xyz) - direction).amax() < ROUNDING,
            "{xyz}: {}",
            with(xyz)
        );
    }
}

#[test]
fn old_axes_are_those_of_the_model_if_they_say_so() {
    for (text, direction) in [
        ("true", Vector3::x()),
        ("1", Vector3::x()),
        ("false", Vector3::y()),
    ] {
        let old = axis(&format!(
            "<xyz>1 0 0</xyz><use_parent_model_frame>{text}</use_parent_model_frame>"
        ));
        let parts = link("a", &format!("<pose>0 0 0 0 0 {QUARTER}</pose>"))
            + &joint("j", "prismatic", "world", "a", &old);
        let model = load(&robot_of("1.5", &parts)).0;
        let moved = pose_at(&model, &[1.0], "a").translation;
        assert!((moved - direction).amax() < ROUNDING, "{text}: {moved}");
    }
}

#[test]
fn types_equal_the_kinds_of_joints() {
    for (name, kinds) in [
        ("revolute", vec![JointKind::Revolute]),
        ("continuous", vec![JointKind::Continuous]),
        ("prismatic", vec![JointKind::Prismatic]),
        ("fixed", vec![]),
        ("ball", vec![JointKind::Spherical]),
        ("screw", vec![JointKind::Screw(Pitch::per_turn(1.0))]),
        ("universal", vec![JointKind::Universal]),
        ("revolute2", vec![JointKind::Universal]),
    ] {
        let axes = "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>";
        let (model, _) = load(&hinge("1.11", name, axes));
        let found: Vec<_> = model.joints().iter().map(|joint| joint.kind).collect();
        assert_eq!(found, kinds, "{name}");
    }
}

// In SDFormat's own test 0.5 m per turn of a right-handed thread are −12.566 rad/m in the older element.
#[test]
fn pitch_of_a_screw_equals_either_element() {
    let pitch = |element: &str| {
        let (model, report) = load(&hinge(
            "1.11",
            "screw",
            &(axis("<xyz>0 0 1</xyz>") + element),
        ));
        assert!(report.ignored.is_empty(), "{report}");
        match model.joints()[0].kind {
            JointKind::Screw(pitch) => pitch.metres_per_radian() * std::f64::consts::TAU,
            kind => panic!("{kind}"),
        }
    };
    let new = "<screw_thread_pitch>0.5</screw_thread_pitch>";
    assert!((pitch(new) - 0.5).abs() < 1e-15);
    assert!((pitch("<thread_pitch>-12.566370614359172</thread_pitch>") - 0.5).abs() < 1e-15);
    assert!((pitch(&format!("{new}<thread_pitch>3</thread_pitch>")) - 0.5).abs() < 1e-15);
    assert!((pitch("") - 1.0).abs() < 1e-15);
}

#[test]
fn axes_of_a_universal_joint_have_limits_and_dynamics_of_their_own() {
    let limit = |upper: f64, damping: f64| {
        format!(
            "<limit><upper>{upper}</upper></limit><dynamics><damping>{damping}</damping></dynamics>"
        )
    };
    let axes = format!(
        "<axis><xyz>1 0 0</xyz>{}</axis><axis2><xyz>0 1 0</xyz>{}</axis2>",
        limit(0.5, 0.1),
        limit(0.7, 0.2)
    );
    let (model, _) = load(&hinge("1.11", "universal", &axes));
    let joint = &model.joints()[0];
    assert_eq!(joint.limits.upper, Some(0.5));
    assert_eq!(joint.second.as_ref().unwrap().limits.upper, Some(0.7));
    assert_eq!(model.damping(), [0.1, 0.2]);
    let id = model.joint(&joint.name).unwrap();
    assert_eq!((model.joint_q(id), model.joint_v(id)), (0..2, 0..2));
}

#[test]
fn limits_equal_those_of_the_file_and_huge_or_negative_ones_are_none() {
    let limits = |limit: &str| {
        let axis = axis(&format!("<xyz>1 0 0</xyz><limit>{limit}</limit>"));
        load(&hinge("1.7", "revolute", &axis)).0.joints()[0].limits
    };
    let all = "<lower>-1</lower><upper>2</upper><velocity>3</velocity><effort>4</effort>";
    let expected = Limits {
        lower: Some(-1.),
        upper: Some(2.),
        velocity: Some(3.),
        effort: Some(4.),
    };
    assert_eq!(limits(all), expected);
    for none in [
        "",
        "<lower>-1e16</lower><upper>1e16</upper><velocity>-1</velocity><effort>-1</effort>",
        "<lower>-inf</lower><upper>inf</upper><velocity>inf</velocity><effort>-inf</effort>",
    ] {
        assert_eq!(limits(none), Limits::default(), "{none}");
    }
}

#[test]
fn dynamics_and_followers_equal_what_the_file_says() {
    let dynamics = "<dynamics><damping>0.5</damping><friction>0.25</friction><spring_stiffness>4</spring_stiffness><spring_reference>0.5</spring_reference></dynamics>";
    let (model, _) = load(&hinge("1.7", "revolute", &axis(dynamics)));
    assert_eq!(
        (model.joints()[0].friction, model.damping()[0]),
        (0.25, 0.5)
    );
    // The spring: τ = −4 (q − 0.5).
    let springs = model.springs();
    assert_eq!((springs[0].stiffness, springs[0].rest), (4.0, 0.5));

    let follower = "<axis><xyz>1 0 0</xyz>
        <mimic joint='u' axis='axis2'><multiplier>2</multiplier><offset>1</offset><reference>3</reference></mimic></axis>";
    let parts = link("a", "")
        + &link("b", "")
        + &joint(
            "u",
            "universal",
            "world",
            "a",
            "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>",
        )
        + &joint("j", "revolute", "a", "b", follower);
    let (model, _) = load(&robot(&parts));
    let joints = model.joints();
    let mimic = joints
        .iter()
        .find_map(|joint| joint.mimic.as_ref())
        .unwrap();
    // q = 2 (leader − 3) + 1 = 2 leader − 5.
    assert_eq!(
        (mimic.leader.as_str(), mimic.multiplier, mimic.offset),
        ("u::axis2", 2.0, -5.0)
    );
    let free = ModelOptions::default().with_independent_mimic_joints();
    assert_eq!(
        (
            model.nv(),
            free.load_sdf_str(&robot(&parts)).unwrap().0.nv()
        ),
        (2, 3)
    );
}

#[test]
fn independent_follower_of_a_missing_joint_loads_with_a_warning() {
    let follower = "<axis><xyz>1 0 0</xyz><mimic joint='k'/></axis>";
    let text = robot(&(link("a", "") + &joint("j", "revolute", "world", "a", follower)));
    assert!(error(&text).to_string().contains("\"k\""));
    let free = ModelOptions::default().with_independent_mimic_joints();
    let (model, report) = free.load_sdf_str(&text).unwrap();
    assert_eq!((model.nv(), &model.joints()[0].mimic), (1, &None));
    let note = &report.warnings[0];
    assert_eq!(
        (note.path.as_str(), note.name.as_str()),
        ("sdf/model/joint", "j")
    );
    assert!(note.reason.contains("\"k\""), "{report}");
}

#[test]
fn base_equals_what_the_joints_and_the_options_say() {
    let free = robot(&link("a", ""));
    let held = robot(&(link("a", "") + &anchor("a")));
    for (text, base, nv, root) in [
        (&free, Base::Auto, 6, "a"),
        (&free, Base::Fixed, 0, "world"),
        (&held, Base::Auto, 0, "world"),
        (&held, Base::Floating, 6, "a"),
    ] {
        let (model, report) = ModelOptions::default()
            .with_base(base)
            .load_sdf_str(text)
            .unwrap();
        assert_eq!(
            (model.nv(), report.root_link.as_str()),
            (nv, root),
            "{base:?}"
        );
    }
    // Of several links that no joint moves, the canonical one is the root.
    let parts = link("a", "")
        + &link("b", "")
        + &link("c", "")
        + &joint("ac", "revolute", "a", "c", "")
        + &joint("bc", "revolute", "b", "c", "");
    for root in ["a", "b"] {
        let text = robot(&parts).replace(
            "name=\"r\"",
            &format!("name=\"r\" canonical_link=\"{root}\""),
        );
        let (model, report) = load(&text);
        assert_eq!((model.nv(), report.root_link.as_str()), (8, root));
    }
}

/// The cart-pole of `assets/cartpole.urdf`: poses in the model, the pivot given on its parent.
const CARTPOLE: &str = r#"<sdf version="1.7"><model name="cartpole">
  <link name="rail"><pose>0 0 1.2 0 0 0</pose>
    <inertial><mass>5</mass><inertia><ixx>10.416697916666667</ixx><ixy>0</ixy><ixz>0</ixz><iyy>6.25e-05</iyy><iyz>0</iyz><izz>10.416697916666667</izz></inertia></inertial></link>
  <link name="cart"><pose>0 0 1.2 0 0 0</pose>
    <inertial><mass>1</mass><inertia><ixx>0.0035416666666666674</ixx><ixy>0</ixy><ixz>0</ixz><iyy>0.0010416666666666669</iyy><iyz>0</iyz><izz>0.0041666666666666675</izz></inertia></inertial></link>
  <link name="pole"><pose relative_to="pivot">0 0 0.5 0 0 0</pose>
    <inertial><mass>0.5</mass><inertia><ixx>0.04166979166666667</ixx><ixy>0</ixy><ixz>0</ixz><iyy>0.04166979166666667</iyy><iyz>0</iyz><izz>6.25e-06</izz></inertia></inertial></link>
  <joint name="world_to_rail" type="fixed"><parent>world</parent><child>rail</child></joint>
  <joint name="linear" type="prismatic"><parent>rail</parent><child>cart</child>
    <axis><xyz>0 1 0</xyz><limit><lower>-2.4</lower><upper>2.4</upper><effort>500</effort><velocity>10</velocity></limit></axis></joint>
  <joint name="pivot" type="continuous"><pose relative_to="cart"/><parent>cart</parent><child>pole</child><axis><xyz>1 0 0</xyz></axis></joint>
</model></sdf>"#;

#[test]
fn the_same_robot_as_sdf_and_urdf_has_the_same_dynamics() {
    let (sdf, report) = load(CARTPOLE);
    let urdf = Model::from_urdf_str(include_str!("../../../../assets/cartpole.urdf")).unwrap();
    assert_eq!(
        (&report.ignored[..], &report.warnings[..]),
        (&[][..], &[][..])
    );
    assert_eq!(sdf.joint_names(), urdf.joint_names());
    for (a, b) in sdf.joints().iter().zip(urdf.joints()) {
        assert_eq!((a.kind, a.limits, a.axis), (b.kind, b.limits, b.axis));
    }
    // The pole's link is in its middle here and at the pivot there.
    let mut rng = rand::rngs::SmallRng::seed_from_u64(7);
    for _ in 0..20 {
        let mut number = || 4.0 * (rng.next_u32() as f64 / u32::MAX as f64) - 2.0;
        let state = State::new(&[number(), number()], &[number(), number()]);
        let (q, v) = (state.q.as_slice(), state.v.as_slice());
        let mass = mass_matrix(&sdf, q) - mass_matrix(&urdf, q);
        let bias = bias_forces(&sdf, q, v) - bias_forces(&urdf, q, v);
        assert!(
            mass.amax() < SAME_ALGEBRA && bias.amax() < SAME_ALGEBRA,
            "{q:?} {v:?}: {mass} {bias}"
        );
        let middle = pose_at(&urdf, q, "pole").point(&Vector3::new(0., 0., 0.5));
        assert!((pose_at(&sdf, q, "pole").translation - middle).amax() < SAME_ALGEBRA);
    }
}
