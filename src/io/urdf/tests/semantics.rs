//! Tests of the meaning of URDF elements.

use crate::tests::ROUNDING;
use approx::assert_relative_eq;
use nalgebra::{Matrix3, Rotation3, Vector3};

use super::*;
use crate::io::temporary::Folder;
use crate::joint::JointKind;
use crate::model::{Geometry, Limits, Mimic, samples};

#[test]
fn cartpole_file_equals_the_cartpole_built_in_code() {
    let (read, report) = load(include_str!("../../../../assets/cartpole.urdf"));
    let built = samples::cartpole();
    assert_eq!(read.name(), built.name());
    assert_eq!(read.joint_names(), built.joint_names());
    assert_eq!(read.gravity(), built.gravity());
    assert_eq!(read.n_bodies(), built.n_bodies());
    for (read, built) in read.bodies().iter().zip(built.bodies()) {
        assert_eq!((read.parent, read.joint), (built.parent, built.joint));
        assert_relative_eq!(read.inertia.mass, built.inertia.mass);
        assert_relative_eq!(
            read.inertia.first_moment,
            built.inertia.first_moment,
            epsilon = ROUNDING
        );
        let moments = |inertia: &crate::spatial::Inertia<f64>| inertia.rotational.to_matrix();
        assert_relative_eq!(
            moments(&read.inertia),
            moments(&built.inertia),
            epsilon = ROUNDING
        );
        assert_relative_eq!(
            read.placement.rotation,
            built.placement.rotation,
            epsilon = ROUNDING
        );
        assert_relative_eq!(
            read.placement.translation,
            built.placement.translation,
            epsilon = ROUNDING
        );
    }
    assert_eq!((report.warnings, report.ignored), (vec![], vec![]));
}

#[test]
fn options_set_gravity_and_the_default_is_earth() {
    let text = arm_on(&joint("continuous", ""));
    assert_eq!(load(&text).0.gravity(), &Vector3::new(0.0, 0.0, -9.81));
    let options = ModelOptions::default().with_gravity([0.0, 1.62, 0.0]);
    let (model, _) = options.load_urdf_str(&text).unwrap();
    assert_eq!(model.gravity(), &Vector3::new(0.0, 1.62, 0.0));
}

// A body turned by R sees its moments J as R J Rᵀ; the frame of a fixed link shows the pose that was read.
#[test]
fn rpy_equals_turns_about_the_fixed_axes_x_then_y_then_z() {
    for [r, p, y] in [
        [0.3, -0.7, 1.9],
        [0.0, std::f64::consts::FRAC_PI_2, 0.4],
        [-3.0, 0.2, 0.0],
    ] {
        let origin = format!("<origin xyz='1 2 3' rpy='{r} {p} {y}'/>");
        let (model, _) = load(&arm_on(&joint("fixed", &origin)));
        let pose = model.frames()[1].placement;
        let turn = |axis, angle| Rotation3::from_axis_angle(&axis, angle);
        let expected =
            turn(Vector3::z_axis(), y) * turn(Vector3::y_axis(), p) * turn(Vector3::x_axis(), r);
        assert_relative_eq!(pose.rotation, *expected.matrix(), epsilon = ROUNDING);
        assert_eq!(pose.translation, Vector3::new(1.0, 2.0, 3.0));
    }
}

#[test]
fn quaternion_of_version_1_1_equals_its_rpy_and_is_ignored_before() {
    let text = arm_on(&joint("fixed", "<origin quat_xyzw='0 0 0.6 0.8'/>"));
    let (old, report) = load(&text);
    assert_eq!(old.frames()[1].placement.rotation, Matrix3::identity());
    assert_eq!(
        places(&report.ignored),
        [("robot/joint/origin@quat_xyzw", "j", 1)]
    );
    let (new, _) = load(&text.replacen("<robot", "<robot version='1.1'", 1));
    // cos = 0.8² − 0.6², sin = 2 · 0.6 · 0.8
    let expected = Matrix3::new(0.28, -0.96, 0.0, 0.96, 0.28, 0.0, 0.0, 0.0, 1.0);
    assert_relative_eq!(
        new.frames()[1].placement.rotation,
        expected,
        epsilon = ROUNDING
    );
}

// A quarter turn about z swaps the moments about x and y; the parallel axes add m (|c|² 1 − c cᵀ) with c = (0, 0, 2),
// m = 3.
#[test]
fn inertia_in_a_turned_frame_equals_the_hand_computation() {
    let inertial = r#"<inertial><origin xyz="0 0 2" rpy="0 0 1.5707963267948966"/><mass value="3"/>
        <inertia ixx="0.2" ixy="0.01" ixz="0.02" iyy="0.3" iyz="0.03" izz="0.4"/></inertial>"#;
    let (model, _) = load(&robot(&format!("<link name='arm'>{inertial}</link>")));
    let inertia = model.to_builder().links[0].inertia;
    assert_eq!(
        (inertia.mass, inertia.com()),
        (3.0, Vector3::new(0.0, 0.0, 2.0))
    );
    // x' = y, y' = −x: Jxx' = Jyy, Jyy' = Jxx, Jxy' = −Jxy, Jxz' = −Jyz, Jyz' = Jxz.
    let expected = Matrix3::new(12.3, -0.01, -0.03, -0.01, 12.2, 0.02, -0.03, 0.02, 0.4);
    assert_relative_eq!(
        inertia.rotational.to_matrix(),
        expected,
        epsilon = 10.0 * ROUNDING
    );
}

#[test]
fn every_type_of_joint_equals_its_kind() {
    for (name, kind) in [
        ("revolute", JointKind::Revolute),
        ("continuous", JointKind::Continuous),
        ("prismatic", JointKind::Prismatic),
        ("floating", JointKind::Floating),
        ("planar", JointKind::Planar),
        ("spherical", JointKind::Spherical),
    ] {
        let (model, _) = load(&arm_on(&joint(name, "")));
        assert_eq!(model.joints()[0].kind, kind);
    }
}

#[test]
fn axis_equals_the_unit_vector_and_x_where_it_is_missing() {
    let axis_of = |parts: &str| load(&arm_on(&joint("continuous", parts))).0.joints()[0].axis;
    assert_eq!(axis_of(""), Vector3::x());
    assert_eq!(axis_of("<axis xyz='0 0 -5'/>"), -Vector3::z());
    assert_relative_eq!(
        axis_of("<axis xyz='3e-200 4e-200 0'/>"),
        Vector3::new(0.6, 0.8, 0.0)
    );
}

#[test]
fn limits_are_there_exactly_where_the_file_has_them() {
    let limits = |kind: &str, version: &str, parts: &str| {
        let text = arm_on(&joint(kind, parts));
        let text = text.replacen("<robot", &format!("<robot version='{version}'"), 1);
        load(&text).0.joints()[0].limits
    };
    let some = |lower, upper, velocity, effort| Limits {
        lower,
        upper,
        velocity,
        effort,
    };
    let none = Limits::default();
    let full = "<limit lower='-1' upper='2' velocity='3' effort='4'/>";
    let all = some(Some(-1.0), Some(2.0), Some(3.0), Some(4.0));
    for (kind, version, parts, expected) in [
        ("revolute", "1.0", full, all),
        ("prismatic", "1.0", full, all),
        (
            "continuous",
            "1.0",
            full,
            some(None, None, Some(3.0), Some(4.0)),
        ),
        ("revolute", "1.0", "", none),
        ("continuous", "1.0", "", none),
        (
            "revolute",
            "1.0",
            "<limit/>",
            some(Some(0.0), Some(0.0), None, None),
        ),
        ("revolute", "1.2", "<limit/>", none),
        (
            "revolute",
            "1.2",
            "<limit upper='2'/>",
            some(None, Some(2.0), None, None),
        ),
        (
            "revolute",
            "1.0",
            "<limit upper='2' velocity='0'/>",
            some(Some(0.0), Some(2.0), Some(0.0), None),
        ),
        (
            "prismatic",
            "1.0",
            "<limit lower='-inf' upper='inf' velocity='inf' effort='1'/>",
            some(None, None, None, Some(1.0)),
        ),
    ] {
        assert_eq!(
            limits(kind, version, parts),
            expected,
            "{kind} {version} {parts}"
        );
    }
}

#[test]
fn damping_friction_and_mimic_equal_the_file() {
    let follower = joint("continuous", "<mimic joint='k' multiplier='-2'/>")
        + &joint("continuous", "<dynamics damping='0.3' friction='0.4'/>")
            .replace("\"j\"", "\"k\"")
            .replace("\"arm\"", "\"hand\"")
        + &format!("<link name='hand'>{INERTIAL}</link>");
    let (model, report) = load(&arm_on(&follower));
    // The mimic joint adds its damping, zero, to the only coordinate.
    assert_eq!(model.damping(), [0.3]);
    assert_eq!(model.joints()[1].friction, 0.4);
    let mimic = Mimic {
        leader: "k".into(),
        multiplier: -2.0,
        offset: 0.0,
    };
    assert_eq!(model.joints()[0].mimic, Some(mimic));
    let told = |path| report.warnings.iter().any(|warning| warning.path == path);
    assert!(told("robot/joint/dynamics") && !told("robot/joint/mimic"));
    let free = ModelOptions::default().with_independent_mimic_joints();
    let (free, _) = free.load_urdf_str(&arm_on(&follower)).unwrap();
    assert_eq!((model.nv(), free.nv()), (1, 2));
}

#[test]
fn independent_follower_of_a_missing_joint_loads_with_a_warning() {
    let text = arm_on(&joint("continuous", "<mimic joint='k' multiplier='-2'/>"));
    let free = ModelOptions::default().with_independent_mimic_joints();
    let (model, report) = free.load_urdf_str(&text).unwrap();
    assert_eq!((model.nv(), &model.joints()[0].mimic), (1, &None));
    let of_mimic = |note: &&ImportNote| note.path == "robot/joint/mimic" && note.name == "j";
    let warning = report.warnings.iter().find(of_mimic).expect("a warning");
    assert!(warning.reason.contains("\"k\""), "{report}");
    assert!(model.to_urdf().is_ok());
}

fn visual(material: &str) -> String {
    format!("<visual><geometry><sphere radius='1'/></geometry>{material}</visual>")
}

#[test]
fn colours_equal_those_of_the_material_that_is_named() {
    let red = "<material name='red'><color rgba='1 0 0 1'/></material>";
    let visuals = [
        visual("<material name='red'/>"),
        visual("<material name='blue'><color rgba='0 0 1 0.5'/></material>"),
        visual("<material name='blue'/>"),
        visual("<material name='red'><color rgba='0.5 0 0 1'/></material>"),
        visual("<material name='absent'/>"),
        visual("<material name='faulty'><color rgba='1 1 1'/></material>"),
        visual(""),
    ];
    let text = robot(&format!(
        "<link name='arm'>{}{INERTIAL}</link>{red}",
        visuals.concat()
    ));
    let (model, report) = load(&text);
    let colours: Vec<_> = model.links()[0].visuals.iter().map(|v| v.color).collect();
    let blue = Some([0.0, 0.0, 1.0, 0.5]);
    let dark = Some([0.5, 0.0, 0.0, 1.0]);
    assert_eq!(
        colours,
        [
            Some([1.0, 0.0, 0.0, 1.0]),
            blue,
            blue,
            dark,
            None,
            None,
            None
        ]
    );
    let warned = [
        "robot/link/visual/material/color",
        "robot/link/visual/material",
    ];
    assert_eq!(
        report
            .warnings
            .iter()
            .map(|w| w.path.as_str())
            .collect::<Vec<_>>(),
        warned
    );
}

#[test]
fn shapes_equal_the_file_with_names_and_poses() {
    let shapes = r#"<collision name="a"><origin xyz="1 0 0"/><geometry><box size="1 2 3"/></geometry></collision>
        <collision><geometry><cylinder radius="1" length="2"/></geometry></collision>
        <collision><geometry><capsule radius="3" length="4"/></geometry></collision>
        <collision><geometry><sphere radius="5"/></geometry></collision>"#;
    let (model, _) = load(&robot(&format!(
        "<link name='arm'>{shapes}{INERTIAL}</link>"
    )));
    let collisions = &model.links()[0].collisions;
    let geometries: Vec<_> = collisions.iter().map(|c| c.geometry.clone()).collect();
    assert_eq!(
        geometries,
        [
            Geometry::Box {
                size: [1.0, 2.0, 3.0]
            },
            Geometry::Cylinder {
                radius: 1.0,
                length: 2.0
            },
            Geometry::Capsule {
                radius: 3.0,
                length: 4.0
            },
            Geometry::Sphere { radius: 5.0 },
        ]
    );
    assert_eq!(
        (&collisions[0].name, &collisions[1].name),
        (&Some("a".into()), &None)
    );
    assert_eq!(collisions[0].placement.translation.x, 1.0);
}

#[test]
fn meshes_have_the_path_of_their_file_or_a_warning() {
    let mesh = |uri: &str| {
        visual("").replace(
            "<sphere radius='1'/>",
            &format!("<mesh filename='{uri}' scale='1 1 -1'/>"),
        )
    };
    let uris = [
        "package://arm_description/meshes/a &amp; b.stl",
        "package://arm_description/meshes/a%20%26%20b.stl",
        "../meshes/c.stl",
        "package://absent/d.stl",
    ];
    let visuals: String = uris.iter().map(|uri| mesh(uri)).collect();
    let folder = Folder::new();
    let found = folder.write("arm_description/meshes/a & b.stl", "");
    folder.write("arm_description/meshes/c.stl", "");
    let file = folder.write(
        "arm_description/urdf/arm.urdf",
        robot(&format!("<link name='arm'>{visuals}{INERTIAL}</link>")),
    );
    let (model, report) = ModelOptions::default().load_urdf_file(file).unwrap();
    let path = |visual: &crate::model::Visual| match &visual.geometry {
        Geometry::Mesh { path, scale, .. } => {
            assert_eq!(*scale, [1.0, 1.0, -1.0]);
            path.clone()
        }
        other => panic!("{other:?}"),
    };
    let paths: Vec<_> = model.links()[0].visuals.iter().map(path).collect();
    assert_eq!(paths[0], Some(found.clone()));
    assert_eq!(paths[1], Some(found));
    assert!(
        paths[2]
            .as_ref()
            .is_some_and(|path| path.ends_with("urdf/../meshes/c.stl"))
    );
    assert_eq!(paths[3], None);
    assert_eq!(report.warnings.len(), 1);
    assert!(report.warnings[0].reason.contains("package://absent/d.stl"));
}

#[test]
fn escaped_line_breaks_separate_numbers_and_stay_in_names() {
    let text = robot(&format!(
        "<link name='world'/><link name='a&#10;b &amp; c'>{INERTIAL}</link>
         <joint name='j' type='fixed'><parent link='world'/><child link='a&#10;b &amp; c'/><origin xyz='1&#10;2&#9;3'/></joint>"
    ));
    let (model, report) = load(&text);
    assert_eq!(model.link_names(), ["world", "a\nb & c"]);
    let placement = model.frames()[1].placement;
    assert_eq!(placement.translation, Vector3::new(1., 2., 3.));
    assert_eq!(report.ignored, []);
}
