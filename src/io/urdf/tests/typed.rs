//! Robots that users of `urdf-rs` hold, beside the text that they were read from.

use urdf_rs::{JointLimit, JointType, Robot};

use super::*;

/// All parts of a model, every number as the shortest text that reads back as the same bits.
fn parts(model: &Model) -> String {
    let builder = model.to_builder().with_source("source");
    format!("{builder:?} {:?} {:?}", model.joints(), model.links())
}

fn read(text: &str) -> Robot {
    urdf_rs::read_from_string(text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn typed(robot: &Robot) -> (Model, ImportReport) {
    ModelOptions::default().load_urdf(robot).unwrap()
}

/// The referee is urdf-rs, whose own reader the library does not use.
#[test]
fn robots_of_urdf_rs_equal_those_of_their_texts_bit_by_bit() {
    let assets = concat!(env!("CARGO_MANIFEST_DIR"), "/assets");
    let mut read_robots = 0;
    for entry in std::fs::read_dir(assets).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "urdf") {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let from_text = load(&text);
        let from_robot = typed(&read(&text));
        assert_eq!(parts(&from_text.0), parts(&from_robot.0), "{path:?}");
        let reasons = |report: &ImportReport| -> Vec<String> {
            let notes = report.warnings.iter();
            let mut reasons: Vec<_> = notes.map(|note| note.reason.clone()).collect();
            reasons.sort();
            reasons
        };
        assert_eq!(reasons(&from_text.1), reasons(&from_robot.1), "{path:?}");
        read_robots += 1;
    }
    assert!(read_robots > 5, "{read_robots} robots");
}

#[test]
fn limits_that_urdf_rs_fills_in_are_none_and_zeros_that_it_reads_are_zero() {
    let no_limit = arm_on(&joint("revolute", "<axis xyz='0 0 1'/>"));
    let (model, report) = typed(&read(&no_limit));
    assert_eq!(model.joints()[0].limits, crate::model::Limits::default());
    assert_eq!(places(&report.warnings), [("robot/joint", "j", 0)]);
    let note = report.warnings[0].to_string();
    assert_eq!(note, "robot/joint \"j\": no <limit>: taken as unlimited");

    let limit = "<axis xyz='0 0 1'/><limit velocity='2' upper='1'/>";
    let (model, report) = typed(&read(&arm_on(&joint("prismatic", limit))));
    let limits = model.joints()[0].limits;
    assert_eq!((limits.lower, limits.upper), (Some(0.0), Some(1.0)));
    assert_eq!((limits.velocity, limits.effort), (Some(2.0), Some(0.0)));
    assert_eq!(report.warnings[0].reason, "effort is limited to 0");
    // A continuous joint has no limits of position, whatever stands there.
    let (model, _) = typed(&read(&arm_on(&joint("continuous", limit))));
    let limits = model.joints()[0].limits;
    assert_eq!((limits.lower, limits.upper), (None, None));
}

#[test]
fn report_on_a_robot_lists_what_is_not_used() {
    let limit = "<limit lower='-1' upper='1' effort='1' velocity='1'/>";
    let parts = format!("{limit}<axis xyz='0 0 1'/><dynamics friction='1'/><mimic joint='j'/>");
    let mut robot = read(&arm_on(&joint("fixed", &parts)));
    robot.name.clear();
    robot.joints[0].safety_controller = Some(Default::default());
    robot.joints[0].limit.jerk = 2.0;
    let texture = urdf_rs::Texture {
        filename: "a.png".into(),
    };
    let rgba = urdf_rs::Vec4([f64::NAN; 4]);
    robot.links[1].visual.push(urdf_rs::Visual {
        material: Some(urdf_rs::Material {
            name: "m".into(),
            color: Some(urdf_rs::Color { rgba }),
            texture: Some(texture),
        }),
        geometry: urdf_rs::Geometry::Sphere { radius: 0.0 },
        ..Default::default()
    });
    let (model, report) = typed(&robot);
    assert_eq!((model.name(), model.nv()), ("robot", 0));
    assert_eq!(model.links()[1].visuals[0].color, None);
    assert_eq!(
        places(&report.ignored),
        [
            ("robot/joint", "j", 0),
            ("robot/joint/limit", "j", 0),
            ("robot/joint/dynamics", "j", 0),
            ("robot/joint/mimic", "j", 0),
            ("robot/link/visual/material", "arm", 0),
        ]
    );
    assert_eq!(
        places(&report.warnings),
        [
            ("robot", "robot", 0),
            ("robot/link/visual/material", "arm", 0),
            ("robot/link/visual/geometry", "arm", 0),
        ]
    );
}

/// A change of a robot for the worse.
type Damage = fn(&mut Robot);

/// Each of these changes to an arm on a revolute joint is an error, not a panic, that names element and reason.
#[test]
fn bad_values_equal_errors_that_name_the_element_and_the_reason() {
    const LIMIT: &str = "<limit lower='-1' upper='1' effort='1' velocity='1'/>";
    let good = read(&arm_on(&joint("revolute", LIMIT)));
    let damages: [(Damage, &[&str]); 20] = [
        (
            |r| r.links[1].inertial.mass.value = f64::NAN,
            &["\"arm\"", "mass is not finite"],
        ),
        (
            |r| r.links[1].inertial.mass.value = -1.0,
            &["\"arm\"", "negative mass -1"],
        ),
        (
            |r| r.links[1].inertial.inertia.ixx = f64::INFINITY,
            &["\"arm\"", "inertia is not finite"],
        ),
        (
            |r| r.links[1].inertial.origin.rpy[1] = f64::NAN,
            &["\"arm\"", "not finite"],
        ),
        (
            |r| r.links[1].name = "world".into(),
            &["two links", "\"world\""],
        ),
        (|r| r.links[1].name.clear(), &["<link>", "name"]),
        (|r| r.links.clear(), &["<robot> \"r\"", "link"]),
        (
            |r| r.joints[0].axis.xyz = urdf_rs::Vec3([0.0; 3]),
            &["joint \"j\"", "zero axis"],
        ),
        (
            |r| r.joints[0].axis.xyz[0] = f64::NAN,
            &["\"j\"", "axis is not finite"],
        ),
        (
            |r| r.joints[0].origin.xyz[2] = f64::NEG_INFINITY,
            &["\"j\"", "not finite"],
        ),
        (
            |r| r.joints[0].origin.xyz[2] = 1e300,
            &["\"j\"", "out of range"],
        ),
        (
            |r| r.joints[0].limit.lower = f64::NAN,
            &["\"j\"", "lower limit is not finite"],
        ),
        (
            |r| r.joints[0].limit.lower = 2.0,
            &["\"j\"", "the lower limit 2 is above"],
        ),
        (
            |r| r.joints[0].limit.effort = -2.0,
            &["\"j\"", "effort limit -2 is negative"],
        ),
        (
            |r| r.joints[0].parent.link = "nothing".into(),
            &["\"j\"", "\"nothing\"", "does not exist"],
        ),
        (
            |r| r.joints[0].child.link = "nothing".into(),
            &["\"j\"", "\"nothing\"", "does not exist"],
        ),
        (
            |r| r.joints[0].parent.link = "arm".into(),
            &["back to it: j"],
        ),
        (
            |r| r.joints.push(r.joints[0].clone()),
            &["two joints", "\"j\""],
        ),
        (
            |r| {
                r.joints[0].mimic = Some(urdf_rs::Mimic {
                    joint: "k".into(),
                    ..Default::default()
                });
            },
            &["\"j\"", "cannot mimic \"k\""],
        ),
        (
            |r| {
                r.joints[0].dynamics = Some(urdf_rs::Dynamics {
                    damping: f64::NAN,
                    friction: 0.0,
                });
            },
            &["\"j\"", "damping is not finite"],
        ),
    ];
    for (damage, expected) in damages {
        let mut bad = good.clone();
        damage(&mut bad);
        let message = ModelOptions::default()
            .load_urdf(&bad)
            .unwrap_err()
            .to_string();
        for part in ["urdf_rs::Robot: "].iter().chain(expected) {
            assert!(message.contains(part), "{part:?} is not in: {message}");
        }
    }
    assert!(ModelOptions::default().load_urdf(&good).is_ok());
    let shapes: [urdf_rs::Geometry; 2] = [
        urdf_rs::Geometry::Sphere { radius: f64::NAN },
        urdf_rs::Geometry::Box {
            size: urdf_rs::Vec3([1.0, -1.0, 1.0]),
        },
    ];
    for geometry in shapes {
        let mut bad = good.clone();
        let collision = urdf_rs::Collision {
            geometry,
            ..Default::default()
        };
        bad.links[1].collision.push(collision);
        let message = ModelOptions::default()
            .load_urdf(&bad)
            .unwrap_err()
            .to_string();
        assert!(message.contains("\"arm\""), "{message}");
    }
}

#[test]
fn joints_in_a_ring_are_an_error_at_any_length() {
    const LINKS: usize = 1000;
    let mut robot = read(&arm_on(&joint("continuous", "")));
    let (link, edge) = (robot.links[1].clone(), robot.joints[0].clone());
    for k in 0..LINKS {
        robot.links.push(urdf_rs::Link {
            name: format!("l{k}"),
            ..link.clone()
        });
        let mut edge = urdf_rs::Joint {
            name: format!("j{k}"),
            joint_type: JointType::Floating,
            ..edge.clone()
        };
        edge.parent.link = format!("l{k}");
        edge.child.link = format!("l{}", (k + 1) % LINKS);
        robot.joints.push(edge);
    }
    let error = ModelOptions::default().load_urdf(&robot).unwrap_err();
    assert!(matches!(error, LoadError::Loop { .. }), "{error}");
    assert_eq!(JointLimit::default(), robot.joints[0].limit);
}

/// A robot that a program made is as little trusted as a text: its meshes are those below the given folders.
#[test]
fn meshes_of_a_robot_are_found_in_the_search_paths_and_below_the_roots_only() {
    let folder = crate::io::temporary::Folder::new();
    let file = folder.write("arm_description/a.stl", "");
    let mut robot = read(&arm_on(&joint("fixed", "")));
    robot.links[1].visual.push(urdf_rs::Visual {
        geometry: urdf_rs::Geometry::Mesh {
            filename: "package://arm_description/a.stl".into(),
            scale: None,
        },
        ..Default::default()
    });
    let found = |options: ModelOptions| {
        let (model, report) = options.load_urdf(&robot).unwrap();
        match &model.links()[1].visuals[0].geometry {
            crate::model::Geometry::Mesh { path, .. } => (path.clone(), report.warnings.len()),
            other => panic!("{other:?}"),
        }
    };
    let options = ModelOptions::default().with_search_path(folder.path(""));
    assert_eq!(found(options.clone()), (Some(file), 0));
    assert_eq!(found(options.with_root("assets")), (None, 1));
    assert_eq!(found(ModelOptions::default()), (None, 1));
}
