//! Distances between links of a robot against closed forms and finite differences.

use std::f64::consts::PI;

use dualbody::collision::{Groups, Shape};
use dualbody::contact::{self, LinkPairs, LinkShapes, Nearest, NearestError};
use dualbody::dynamics::forward_kinematics;
use dualbody::model::{Mass, Model};
use dualbody::spatial::Transform;
use nalgebra::Vector3;

/// Two arms with shapes of all kinds that files have, on a table that is fixed to the world.
fn robot() -> Model {
    let link = |name: &str, geometry: &str| {
        format!(
            r#"<link name="{name}"><inertial><origin xyz="0 0 0.1"/><mass value="1"/>
               <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
               <collision><origin xyz="0 0.02 0.15" rpy="0.1 0.2 0.3"/><geometry>{geometry}</geometry></collision></link>"#
        )
    };
    let joint = |name: &str, kind: &str, parent: &str, child: &str, xyz: &str, axis: &str| {
        format!(
            r#"<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
               <origin xyz="{xyz}" rpy="0.2 -0.1 0.4"/><axis xyz="{axis}"/></joint>"#
        )
    };
    let parts = [
        r#"<robot name="two_arms"><link name="world"/>"#.to_owned(),
        r#"<link name="table"><collision><geometry><box size="1 1 0.1"/></geometry></collision></link>"#.to_owned(),
        joint("legs", "fixed", "world", "table", "0 0 -0.3", "0 0 1"),
        link("left/arm", r#"<cylinder radius="0.05" length="0.3"/>"#),
        link("left/hand", r#"<box size="0.1 0.2 0.05"/>"#),
        link("right/arm", r#"<sphere radius="0.06"/>"#),
        link("right/hand", r#"<cylinder radius="0.08" length="0.04"/>"#),
        joint("left/shoulder", "continuous", "world", "left/arm", "-0.4 0 0.4", "0 1 0"),
        joint("left/wrist", "continuous", "left/arm", "left/hand", "0 0 0.35", "1 0 0"),
        joint("right/shoulder", "continuous", "world", "right/arm", "0.4 0.1 0.4", "0 1 0.3"),
        joint("right/wrist", "continuous", "right/arm", "right/hand", "0 0 0.3", "0 1 0"),
        "</robot>".to_owned(),
    ];
    Model::from_urdf_str(&parts.concat()).expect("a robot")
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
        let link = shapes.find_link(&model, name).expect("a link");
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
    let hand = shapes.find_link(&model, "left/hand").expect("a link");
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
    let q = model.neutral();
    let unknown = contact::nearest(&model, q.as_slice(), "left/hand", "tabel")
        .unwrap_err()
        .to_string();
    assert!(
        unknown.contains("tabel") && unknown.contains("table"),
        "{unknown}"
    );
    assert!(matches!(
        contact::nearest(&model, q.as_slice(), "world", "table"),
        Err(NearestError::UnknownName(_))
    ));
    let lost = vec![f64::NAN; model.nq()];
    let error = contact::nearest(&model, &lost, "left/hand", "table").unwrap_err();
    assert!(matches!(error, NearestError::NoDistance { .. }), "{error}");
    let mesh = Model::from_urdf_str(
        r#"<robot name="mesh"><link name="world"><collision><geometry><sphere radius="1"/></geometry></collision></link>
           <link name="part"><collision><geometry><mesh filename="nowhere.stl"/></geometry></collision></link>
           <joint name="weld" type="fixed"><parent link="world"/><child link="part"/></joint></robot>"#,
    );
    let mesh = mesh.expect("a robot");
    let error = contact::nearest(&mesh, &[], "world", "part").unwrap_err();
    assert!(
        matches!(error, NearestError::MissingShape { .. }),
        "{error}"
    );
    assert_eq!(LinkShapes::new(&mesh).missing().len(), 1);
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
    for (z, expected) in [(5.0, 1.0), (3.5, -0.5), (-3.0, 1.0)] {
        let near = ellipsoid
            .distance_to_point(&at, &Vector3::new(0.0, 0.0, z))
            .expect("a distance");
        assert!((near.distance - expected).abs() < 1e-12, "{z}: {near:?}");
    }
}
