//! Joints of the world.

use super::*;

fn world(parts: &str) -> String {
    format!("<sdf version='1.10'><world name='w'><gravity>0 0 -9.81</gravity>{parts}</world></sdf>")
}

fn model(name: &str, parts: &str) -> String {
    format!("<model name='{name}'>{parts}</model>")
}

/// Options that choose a model.
fn choosing(name: &str) -> ModelOptions {
    ModelOptions::default().with_model_name(name)
}

const X: [f64; 3] = [1., 0., 0.];

// The hinge stands on its child, which the model's pose and its own put at (1, 0, 2).
#[test]
fn a_joint_of_the_world_equals_one_inside_the_model() {
    let pendulum = |outside: &str| {
        let bob = link("bob", "<pose>0 0 2 0 0 0</pose>");
        world(&(model("r", &format!("<pose>1 0 0 0 0 0</pose>{bob}")) + outside))
    };
    for (kind, n) in [("fixed", 0), ("revolute", 1), ("ball", 3)] {
        let (model, report) = load(&pendulum(&joint(
            "j",
            kind,
            "world",
            "r::bob",
            "<axis><xyz>0 1 0</xyz></axis>",
        )));
        assert_eq!(model.nv(), n, "{report}");
        assert_at(&pose(&model, "bob"), [1., 0., 2.], X);
    }
    // A hinge at the origin turns (1, 0, 2) by a quarter about y: x goes to −z, and z to x.
    let axis = "<pose relative_to='world'/><axis><xyz>0 1 0</xyz></axis>";
    let (model, _) = load(&pendulum(&joint("j", "revolute", "world", "r::bob", axis)));
    let angle = [std::f64::consts::FRAC_PI_2];
    assert_at(
        &pose_at(&model, &angle, "bob"),
        [2., 0., -1.],
        [0., 0., -1.],
    );
    // Hung 2 above the link and turned by a quarter about y, it is 2 beside the hinge, at (1, 0, 4) − 2 x.
    let axis = "<pose>0 0 2 0 0 0</pose><axis><xyz>0 1 0</xyz></axis>";
    let (model, _) = load(&pendulum(&joint("j", "revolute", "world", "r::bob", axis)));
    assert_eq!(model.joint_names(), ["j"]);
    assert_at(
        &pose_at(&model, &angle, "bob"),
        [-1., 0., 4.],
        [0., 0., -1.],
    );
}

#[test]
fn models_that_joints_of_the_world_join_are_one_robot() {
    let table = model(
        "table",
        &("<static>1</static><pose>0 0 1 0 0 0</pose>".to_owned() + &link("top", "")),
    );
    let arm = model(
        "arm",
        &("<pose>0 0 1.5 0 0 0</pose>".to_owned()
            + &link("base", "")
            + &link("tip", "<pose>1 0 0 0 0 0</pose>")
            + &joint("elbow", "revolute", "base", "tip", "")),
    );
    let ball = model("ball", &link("ball", "<pose>7 0 0 0 0 0</pose>"));
    let parts = table
        + &ball
        + &arm
        + "<frame name='plate' attached_to='table::top'/><frame name='edge' attached_to='plate'><pose>0 1 0 0 0 0</pose></frame>"
        + &joint("mount", "prismatic", "edge", "arm::base", "")
        + &joint("string", "revolute", "world", "ball::ball", "");
    let (robot, report) = choosing("arm").load_sdf_str(&world(&parts)).unwrap();
    assert_eq!(
        (robot.name(), robot.joint_names().join(" ")),
        ("arm", "mount elbow".into())
    );
    assert_eq!(robot.link_names(), ["world", "table::top", "base", "tip"]);
    assert_eq!(robot.total_mass(), 2.0);
    // The slide goes along z from the base at height 1.5; the tip is 1 along x of it.
    assert_at(&pose_at(&robot, &[0.25, 0.0], "tip"), [1., 0., 1.75], X);
    assert_at(&pose(&robot, "table::top"), [0., 0., 1.], X);
    assert_eq!(
        places(&report.ignored),
        [
            ("sdf/world/model", "ball", 1),
            ("sdf/world/joint", "string", 1)
        ]
    );
    let (ball, _) = choosing("ball").load_sdf_str(&world(&parts)).unwrap();
    assert_eq!(ball.joint_names(), ["string"]);
}

#[test]
fn two_models_that_a_joint_joins_need_no_choice_and_float_as_one() {
    let parts = model("a", &link("l", ""))
        + &model(
            "b",
            &("<pose relative_to='a'>0 0 3 0 0 0</pose>".to_owned() + &link("l", "")),
        );
    let (robot, _) = load(&world(
        &(parts.clone() + &joint("j", "revolute", "a::l", "b::l", "")),
    ));
    assert_eq!(
        (robot.name(), robot.nv(), robot.link_names().join(" ")),
        ("a", 7, "l b::l".into())
    );
    let apart = pose(&robot, "l").inverse() * pose(&robot, "b::l");
    assert_at(&apart, [0., 0., 3.], X);
    // The same by a frame on the first, 1 above it.
    let on_a = "<frame name='f' attached_to='a'><pose>0 0 1 0 0 0</pose></frame>";
    let by_frame = joint("j", "revolute", "f", "b::l", "<pose relative_to='f'/>");
    let (robot, _) = load(&world(&(parts.clone() + on_a + &by_frame)));
    let turned = [0., 0., 0., 1., 0., 0., 0., std::f64::consts::FRAC_PI_2];
    let [hinge, other] = ["l", "b::l"].map(|link| pose_at(&robot, &turned, link));
    assert_at(&(hinge.inverse() * other), [0., 0., 3.], [0., 1., 0.]);
    // A frame without a parent is in the world, and connects no models.
    let still = "<frame name='f'/>".to_owned()
        + &joint("j", "revolute", "f", "a::l", "")
        + &joint("k", "revolute", "f", "b::l", "");
    let text = world(&(parts + &still));
    assert!(matches!(error(&text), LoadError::ModelChoice { .. }));
    let (a, _) = choosing("a").load_sdf_str(&text).unwrap();
    assert_eq!(a.joint_names(), ["j"]);
}

#[test]
fn joints_of_the_world_that_cannot_be_equal_errors_that_name_them() {
    let a = || {
        model(
            "a",
            &(link("l", "") + &joint("k", "revolute", "world", "l", "")),
        )
    };
    let with = |joint: String| error(&world(&(a() + &joint)));
    let unknown = with(joint("j", "revolute", "a::l", "ghost::l", ""));
    assert!(
        matches!(&unknown, LoadError::UnknownFrame { name, frame, .. } if name == "j" && frame == "ghost::l"),
        "{unknown:?}"
    );
    let twice = with(joint("k", "revolute", "world", "a::l", ""));
    assert!(
        matches!(&twice, LoadError::Loop { joints, .. } if *joints == ["a::k", "k"] || *joints == ["k", "k"]),
        "{twice:?}"
    );
    let circle = "<frame name='f' attached_to='g'/><frame name='g' attached_to='f'/>".to_owned()
        + &joint("j", "fixed", "f", "a::l", "");
    assert!(matches!(with(circle), LoadError::FrameCycle { .. }));
}
