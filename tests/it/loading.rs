//! From a file to its dynamics.

use dualbody::dynamics::{
    bias_forces, center_of_mass, forward_dynamics, frame_pose, gravity_forces, inverse_dynamics,
    mass_matrix,
};
use dualbody::model::samples;
use dualbody::{Base, LoadError, Model, ModelOptions};
use nalgebra::DVector;

use crate::common::{
    OTHER_ALGORITHM, SAME_ALGEBRA, assert_close, assert_close_vector, random_point,
};

const CARTPOLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/cartpole.urdf");

#[test]
fn cartpole_file_has_the_dynamics_of_the_sample() {
    let (file, sample) = (
        Model::from_urdf_file(CARTPOLE).expect("the cart-pole"),
        samples::cartpole(),
    );
    assert_eq!(file.joint_names(), sample.joint_names());
    for seed in 0..5 {
        let point = random_point(&sample, seed);
        let (q, v) = (point.q.as_slice(), point.v.as_slice());
        assert_close(
            &mass_matrix(&file, q),
            &mass_matrix(&sample, q),
            SAME_ALGEBRA,
            "mass matrix",
        );
        assert_close_vector(
            &bias_forces(&file, q, v),
            &bias_forces(&sample, q, v),
            SAME_ALGEBRA,
            "bias forces",
        );
        for link in ["cart", "pole"] {
            let pose = |model: &Model| {
                frame_pose(model, q, model.frame(link).expect("a link")).translation
            };
            assert!((pose(&file) - pose(&sample)).norm() < SAME_ALGEBRA);
        }
    }
}

#[test]
fn cartpole_file_keeps_limits_frames_and_shapes() {
    let (model, report) = ModelOptions::default()
        .load_urdf_file(CARTPOLE)
        .expect("the cart-pole");
    assert!(
        report.warnings.is_empty() && report.ignored.is_empty(),
        "{report}"
    );
    let linear = model.limits(model.joint("linear").expect("a joint"));
    assert_eq!((linear.lower, linear.upper), (Some(-2.4), Some(2.4)));
    assert_eq!((linear.effort, linear.velocity), (Some(500.0), Some(10.0)));
    assert_eq!(
        *model.limits(model.joint("pivot").expect("a joint")),
        dualbody::model::Limits::default()
    );
    for frame in ["cart_frame", "rail_frame"] {
        assert!(model.frame(frame).is_some(), "{frame}");
    }
    let shapes: usize = model.links().iter().map(|link| link.visuals.len()).sum();
    assert_eq!(shapes, 3);
}

#[test]
fn gravity_and_base_of_the_options_override_the_file() {
    let text = std::fs::read_to_string(CARTPOLE).expect("the file");
    let options = ModelOptions::default()
        .with_gravity([0.0, 0.0, -1.62])
        .with_base(Base::Floating);
    let (model, _) = options.load_urdf_str(&text).expect("the cart-pole");
    assert_eq!((model.nv(), model.gravity().z), (8, -1.62));
    let weight = gravity_forces(&model, model.neutral().as_slice());
    assert!(
        (weight[2] - 6.5 * 1.62).abs() < SAME_ALGEBRA,
        "rail, cart and pole float: {weight}"
    );
}

// Names, sizes and masses as their makers publish them.
#[test]
fn every_robot_of_the_assets_loads_with_its_size_and_mass() {
    for (file, joints, nv, mass) in [
        ("acrobot", 2, 2, 2.0),
        ("box", 0, 6, 1.0),
        ("double_pendulum", 2, 2, 2.0),
        ("four_bar", 3, 3, 1.04),
        ("hopper", 4, 4, 4.0),
        ("humanoid", 29, 35, 33.341_157),
        ("panda", 9, 8, 16.822),
        ("quadruped", 12, 18, 13.741),
        ("sphere", 0, 6, 1.0),
        ("ur5", 6, 6, 17.05),
    ] {
        let path = format!("{}/assets/{file}.urdf", env!("CARGO_MANIFEST_DIR"));
        let (model, report) = ModelOptions::default().load_urdf_file(path).expect(file);
        assert!(report.ignored.is_empty(), "{report}");
        assert_eq!((model.n_joints(), model.nv()), (joints, nv), "{file}");
        assert!(
            (model.total_mass() - mass).abs() < 1e-2,
            "{file}: {} kg",
            model.total_mass()
        );
        assert!(model.inertia_flaws().is_empty(), "{file}");
    }
}

/// A chain of rods on revolute joints about x and y in turn.
fn chain(n: usize) -> String {
    let mut xml = String::from("<robot name=\"chain\"><link name=\"world\"/>");
    for i in 0..n {
        let parent = if i == 0 {
            "world".to_owned()
        } else {
            format!("l{}", i - 1)
        };
        let axis = if i % 2 == 0 { "1 0 0" } else { "0 1 0" };
        xml += &format!(
            "<link name=\"l{i}\"><inertial><origin xyz=\"0 0 -0.005\"/><mass value=\"0.01\"/>\
             <inertia ixx=\"1e-5\" ixy=\"0\" ixz=\"0\" iyy=\"1e-5\" iyz=\"0\" izz=\"1e-5\"/></inertial></link>\
             <joint name=\"j{i}\" type=\"continuous\"><origin xyz=\"0 0 -0.01\"/><parent link=\"{parent}\"/>\
             <child link=\"l{i}\"/><axis xyz=\"{axis}\"/></joint>"
        );
    }
    xml + "</robot>"
}

// Loading, inverse and forward dynamics of 5,000 links on the 2 MiB of an ordinary thread.
#[test]
fn dynamics_of_a_chain_of_5000_links_fit_an_ordinary_stack_and_invert_each_other() {
    const LINKS: usize = 5_000;
    let work = || {
        let model = Model::from_urdf_str(&chain(LINKS)).expect("a chain");
        let q = DVector::from_fn(LINKS, |k, _| 1e-4 * (k as f64).sin());
        let zero = DVector::zeros(LINKS);
        let a = DVector::from_fn(LINKS, |k, _| (0.1 * k as f64).cos());
        let tau = inverse_dynamics(&model, q.as_slice(), zero.as_slice(), a.as_slice());
        let back = forward_dynamics(&model, q.as_slice(), zero.as_slice(), tau.as_slice());
        let last = model.frame("l4999").expect("the last link");
        assert!(
            (frame_pose(&model, zero.as_slice(), last).translation.z + 50.0).abs()
                < OTHER_ALGORITHM
        );
        // τ is of the size of 1e5 N·m at the root, so the last digits are those of a chain, not of one link.
        assert_close_vector(&back, &a, 1e3 * OTHER_ALGORITHM, "chain");
    };
    let thread = std::thread::Builder::new()
        .stack_size(2 << 20)
        .spawn(work)
        .expect("a thread");
    thread.join().expect("no overflow");
}

/// A slider, then two hinges, of which the second moves a link without inertia; the same in each format.
const SLIDER_AND_HINGES: [&str; 2] = [
    r#"<robot name="r"><link name="world"/>
    <link name="a"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
    <link name="b"><inertial><origin xyz="0.5 0 0"/><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
    <link name="c"/>
    <joint name="slide" type="prismatic"><parent link="world"/><child link="a"/><axis xyz="0 0 1"/><limit effort="1" velocity="1"/></joint>
    <joint name="hinge" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/></joint>
    <joint name="idle" type="continuous"><parent link="b"/><child link="c"/><axis xyz="0 1 0"/></joint></robot>"#,
    r#"<sdf version="1.11"><model name="r">
    <link name="a"><inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link>
    <link name="b"><inertial><pose>0.5 0 0 0 0 0</pose><mass>2</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link>
    <frame name="c" attached_to="b"/>
    <joint name="slide" type="prismatic"><parent>world</parent><child>a</child><axis><xyz>0 0 1</xyz></axis></joint>
    <joint name="hinge" type="continuous"><parent>a</parent><child>b</child><axis><xyz>0 1 0</xyz></axis></joint></model></sdf>"#,
];

fn load_text(options: &ModelOptions, text: &str) -> Result<Model, LoadError> {
    let loaded = match text.starts_with("<robot") {
        true => options.load_urdf_str(text),
        false => options.load_sdf_str(text),
    };
    loaded.map(|(model, _)| model)
}

// On the locked hinge the mass of b is at (cos 90°, −sin 90°) / 2 below a: what slides weighs 3 kg, and c stands where
// b does.
#[test]
fn robot_with_joints_kept_at_load_equals_the_sum_of_its_locked_parts() {
    for text in SLIDER_AND_HINGES {
        let options = ModelOptions::default()
            .with_kept_joints(["slide"])
            .with_locked_joint("hinge", &[std::f64::consts::FRAC_PI_2]);
        let model = load_text(&options, text).expect("a slider");
        assert_eq!(model.joint_names(), ["slide"]);
        assert!((mass_matrix(&model, &[0.0])[0] - 3.0).abs() < SAME_ALGEBRA);
        assert!(
            ["a", "b", "c"]
                .iter()
                .all(|link| model.frame(link).is_some())
        );
        let height = center_of_mass(&model, &[0.0]).z;
        assert!((height + 1.0 / 3.0).abs() < SAME_ALGEBRA, "{height}");
        let hinge = load_text(&ModelOptions::default().with_kept_joints(["hinge"]), text);
        assert_eq!(hinge.expect("a hinge").joint_names(), ["hinge"]);
    }
}

#[test]
fn unknown_joint_to_keep_or_to_lock_is_an_error_that_names_it() {
    for text in SLIDER_AND_HINGES {
        let fail = |options: ModelOptions| {
            let error = load_text(&options, text).expect_err("an unknown joint");
            assert!(matches!(error, LoadError::JointChoice { .. }), "{error}");
            error.to_string()
        };
        let keep = fail(ModelOptions::default().with_kept_joints(["slide", "elbow"]));
        assert!(
            keep.contains("\"elbow\"") && keep.contains("slide, hinge"),
            "{keep}"
        );
        let lock = fail(ModelOptions::default().with_locked_joint("elbow", &[0.0]));
        assert!(
            lock.contains("text: ") && lock.contains("\"elbow\""),
            "{lock}"
        );
        let long = fail(ModelOptions::default().with_locked_joint("hinge", &[0.0, 1.0]));
        assert!(long.contains("\"hinge\""), "{long}");
        let both = ModelOptions::default().with_kept_joints(["hinge"]);
        let both = fail(both.with_locked_joint("hinge", &[0.0]));
        assert!(both.contains("\"hinge\""), "{both}");
        // Flaws of the description itself are still reported.
        let flaw = text.replace("0 1 0", "0 0 0");
        let kept = ModelOptions::default().with_kept_joints(["slide"]);
        let error = load_text(&kept, &flaw).expect_err("a zero axis");
        assert!(matches!(error, LoadError::ZeroAxis { .. }), "{error}");
    }
}
