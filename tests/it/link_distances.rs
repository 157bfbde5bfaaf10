//! Distances between links of a robot against closed forms and finite differences.

use std::f64::consts::PI;

use dualbody::collision::{Groups, Shape};
use dualbody::contact::{self, LinkPairs, LinkShapes, Nearest, NearestError};
use dualbody::dynamics::forward_kinematics;
use dualbody::joint::JointKind;
use dualbody::model::{
    Collision, Geometry, JointSpec, LinkSpec, Mass, Model, ModelBuilder, UpAxis,
};
use dualbody::spatial::{Quaternion, Transform};
use nalgebra::Vector3;

fn link(name: &str, geometry: Geometry) -> LinkSpec {
    let rotation = Quaternion::exp(&Vector3::new(0.1, 0.2, 0.3)).to_matrix();
    let collision = Collision {
        name: None,
        placement: Transform::new(rotation, Vector3::new(0.0, 0.02, 0.15)),
        geometry,
    };
    LinkSpec::new(name)
        .with_mass(1.0, [0.0, 0.0, 0.1], [0.1; 3])
        .with_collision(collision)
}

/// Two arms with shapes of all kinds that files have, on a table that is fixed to the world.
fn robot() -> Model {
    let mut builder = ModelBuilder::new("two_arms");
    builder.add_link(LinkSpec::new("world"));
    for (name, geometry) in [
        (
            "table",
            Geometry::Box {
                size: [1.0, 1.0, 0.1],
            },
        ),
        (
            "left/arm",
            Geometry::Cylinder {
                radius: 0.05,
                length: 0.3,
            },
        ),
        (
            "left/hand",
            Geometry::Box {
                size: [0.1, 0.2, 0.05],
            },
        ),
        (
            "right/arm",
            Geometry::Capsule {
                radius: 0.06,
                length: 0.1,
            },
        ),
        (
            "right/hand",
            Geometry::Cylinder {
                radius: 0.08,
                length: 0.04,
            },
        ),
    ] {
        builder.add_link(link(name, geometry));
    }
    let hinge = JointKind::Revolute;
    for (kind, parent, child, at, axis) in [
        (
            JointKind::Fixed,
            "world",
            "table",
            [0.0, 0.0, -0.3],
            [0.0, 0.0, 1.0],
        ),
        (
            hinge,
            "world",
            "left/arm",
            [-0.4, 0.0, 0.4],
            [0.0, 1.0, 0.0],
        ),
        (
            hinge,
            "left/arm",
            "left/hand",
            [0.0, 0.0, 0.35],
            [1.0, 0.0, 0.0],
        ),
        (
            hinge,
            "world",
            "right/arm",
            [0.4, 0.1, 0.4],
            [0.0, 1.0, 0.3],
        ),
        (
            hinge,
            "right/arm",
            "right/hand",
            [0.0, 0.0, 0.3],
            [0.0, 1.0, 0.0],
        ),
    ] {
        let joint = JointSpec::new(format!("{child}_joint"), kind, parent, child);
        builder.add_joint(joint.with_translation(at).with_axis(axis));
    }
    builder.build().expect("a robot")
}

const LINKS: [&str; 5] = ["table", "left/arm", "left/hand", "right/arm", "right/hand"];

fn each_pair(mut each: impl FnMut(&Model, &LinkShapes, &[f64], [&str; 2])) {
    let model = robot();
    let shapes = LinkShapes::without_meshes(&model);
    for k in 0..40 {
        let q: Vec<f64> = (0..model.nq())
            .map(|i| (1.7 * k as f64 + 2.3 * i as f64).sin() * 2.5)
            .collect();
        for (i, first) in LINKS.iter().enumerate() {
            for second in &LINKS[i + 1..] {
                each(&model, &shapes, &q, [first, second]);
            }
        }
    }
}

#[test]
fn gradient_of_the_distance_equals_central_differences() {
    let mut compared = 0;
    each_pair(|model, shapes, q, [first, second]| {
        let near = shapes.nearest(model, q, first, second).expect("a distance");
        for k in 0..model.nv() {
            let moved = |h: f64| {
                let mut dv = vec![0.0; model.nv()];
                dv[k] = h;
                let found = shapes
                    .nearest(model, model.integrate(q, &dv).as_slice(), first, second)
                    .ok()?;
                (found.feature.map(|x| x.id) == near.feature.map(|x| x.id))
                    .then_some(found.distance)
            };
            let difference = |h: f64| Some((moved(h)? - moved(-h)?) / (2.0 * h));
            if let (Some(coarse), Some(fine)) = (difference(2e-4), difference(1e-4)) {
                let expected = (4.0 * fine - coarse) / 3.0;
                let found = near.gradient[k];
                assert!(
                    (found - expected).abs() < 1e-7,
                    "{first} {second} {q:?} {k}: {found} {expected}"
                );
                compared += 1;
            }
        }
    });
    assert!(compared > 1000, "{compared}");
}

#[test]
fn points_lie_a_distance_apart_along_the_normal_and_the_order_of_links_turns_them() {
    each_pair(|model, shapes, q, [first, second]| {
        let near = shapes.nearest(model, q, first, second).expect("a distance");
        let apart = near.points[1] - near.points[0] - near.normal * near.distance;
        assert!(apart.norm() < 1e-9, "{first} {second} {q:?}: {apart}");
        let turned = contact::nearest(model, q, second, first).expect("a distance");
        assert!(
            (turned.distance - near.distance).abs() < 1e-9,
            "{first} {second} {q:?}"
        );
    });
}

#[test]
fn nearest_links_of_all_pairs_are_among_those_of_the_broad_phase() {
    let model = robot();
    let mut shapes = LinkShapes::without_meshes(&model);
    shapes
        .shapes_mut()
        .iter_mut()
        .for_each(|shape| shape.margin = 0.1);
    let mut memory = LinkPairs::default();
    let mut found = 0;
    for k in 0..50 {
        let q: Vec<f64> = (0..model.nq())
            .map(|i| (0.7 * k as f64 + 1.9 * i as f64).sin() * 3.0)
            .collect();
        let kinematics = forward_kinematics(&model, &q, &vec![0.0; model.nv()]);
        let pairs = shapes
            .pairs(&model, &kinematics, &mut memory)
            .expect("few pairs")
            .to_vec();
        let mut near = Nearest::new(&model);
        for i in 0..shapes.shapes().len() {
            for j in i + 1..shapes.shapes().len() {
                let links = [i, j].map(|k| shapes.shapes()[k].link);
                assert!(shapes.nearest_into(&model, &kinematics, links, &mut near));
                if near.distance <= 0.2 && shapes.may_touch(i, j) {
                    assert!(pairs.contains(&[i, j]), "{q:?} {i} {j} {}", near.distance);
                    found += 1;
                }
            }
        }
    }
    assert!(found > 10, "{found}");
}

#[test]
fn neighbours_excluded_pairs_and_groups_never_touch() {
    let model = robot();
    let mut shapes = LinkShapes::without_meshes(&model);
    let index = |shapes: &LinkShapes, name: &str| {
        let link = model.find_frame(name).expect("a link");
        shapes
            .shapes()
            .iter()
            .position(|shape| shape.link == link)
            .expect("a shape")
    };
    let [table, arm, hand, other] =
        ["table", "left/arm", "left/hand", "right/hand"].map(|name| index(&shapes, name));
    assert!(!shapes.may_touch(arm, hand) && shapes.may_touch(table, arm));
    assert!(shapes.may_touch(table, hand) && shapes.may_touch(hand, other));
    shapes
        .exclude(&model, &[["right/hand", "left/hand"]])
        .expect("links");
    assert!(!shapes.may_touch(hand, other) && !shapes.may_touch(other, hand));
    shapes.shapes_mut()[hand].groups = Groups { own: 2, mask: 2 };
    assert!(!shapes.may_touch(table, hand));
    let error = shapes
        .exclude(&model, &[["left/hnad", "table"]])
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("left/hnad") && error.contains("left/hand"),
        "{error}"
    );
}

#[test]
fn links_that_touch_at_a_configuration_are_listed_by_name() {
    let model = robot();
    let mut shapes = LinkShapes::without_meshes(&model);
    let neutral = model.neutral();
    assert!(
        shapes
            .touching(&model, neutral.as_slice())
            .expect("few")
            .is_empty()
    );
    let hand = model.find_frame("left/hand").expect("a link");
    for shape in shapes
        .shapes_mut()
        .iter_mut()
        .filter(|shape| shape.link == hand)
    {
        shape.shape = Shape::Sphere { radius: 5.0 };
    }
    let touching = shapes.touching(&model, neutral.as_slice()).expect("few");
    assert!(touching.contains(&["table", "left/hand"]), "{touching:?}");
    assert!(
        touching.iter().all(|pair| pair.contains(&"left/hand")),
        "{touching:?}"
    );
}

#[test]
fn links_without_shapes_unread_meshes_and_lost_configurations_are_errors() {
    let model = robot();
    let neutral = model.neutral();
    let q = neutral.as_slice();
    let unknown = contact::nearest(&model, q, "left/hand", "tabel")
        .unwrap_err()
        .to_string();
    assert!(
        unknown.contains("tabel") && unknown.contains("table"),
        "{unknown}"
    );
    assert!(matches!(
        contact::nearest(&model, q, "world", "table"),
        Err(NearestError::UnknownName(_))
    ));
    let lost = vec![f64::NAN; model.nq()];
    let error = contact::nearest(&model, &lost, "left/hand", "table").unwrap_err();
    assert!(matches!(error, NearestError::NoDistance { .. }), "{error}");
    let mesh = Geometry::Mesh {
        uri: "nowhere.stl".into(),
        path: None,
        scale: [1.0, -1.0, 1.0],
        up_axis: UpAxis::default(),
    };
    let mut builder = ModelBuilder::new("mesh");
    builder.add_link(link("world", Geometry::Sphere { radius: 1.0 }));
    builder.add_link(link("part", mesh));
    builder.add_joint(JointSpec::new("weld", JointKind::Fixed, "world", "part"));
    let mesh = builder.build().expect("a robot");
    let error = contact::nearest(&mesh, &[], "world", "part").unwrap_err();
    assert!(
        matches!(error, NearestError::MissingShape { .. }),
        "{error}"
    );
    assert_eq!(LinkShapes::without_meshes(&mesh).missing().len(), 1);
}

// Of an ellipsoid the moments are m (b² + c²) / 5 and so on; other shapes are those of files.
#[test]
fn volume_inertia_and_distance_to_a_point_equal_closed_forms() {
    let solid = Shape::Box {
        half_extents: [0.5, 1.0, 1.5],
    };
    assert_eq!(solid.volume(), Some(6.0));
    let inertia = solid.inertia(Mass::Density(2.0)).expect("a solid");
    assert!((inertia.mass - 12.0).abs() < 1e-14 && (inertia.rotational.xx - 13.0).abs() < 1e-13);
    let ellipsoid = Shape::Ellipsoid {
        semi_axes: [1.0, 2.0, 3.0],
    };
    assert!((ellipsoid.volume().expect("a solid") - 8.0 * PI).abs() < 1e-13);
    assert!(
        Shape::HalfSpace.volume().is_none()
            && Shape::HalfSpace.inertia(Mass::Kilograms(1.0)).is_none()
    );
    let at = Transform::from_translation(Vector3::new(0.0, 0.0, 1.0));
    for (z, expected) in [(5.0, 1.0), (3.9, -0.1), (-3.0, 1.0)] {
        let near = ellipsoid
            .distance_to_point(&at, &Vector3::new(0.0, 0.0, z))
            .expect("a distance");
        assert!((near.distance - expected).abs() < 1e-12, "{z}: {near:?}");
    }
}
