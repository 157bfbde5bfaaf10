//! Skeleton of a robot, or of a member of a world, that has no shapes: bones between its joints and balls at its centres of mass.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::meshes::Piece;
use super::shape::{Shape, pose};
use crate::model::{BodyId, Geometry, Model};
use crate::spatial::Transform;

/// Radius of a bone and of a ball, as parts of the longest reach from a joint.
const THICKNESS: [f64; 2] = [0.022, 0.05];

/// A bone from each joint to those that its body carries and to the centre of mass, where there is a ball.
///
/// * `has` – whether a body is one of those that are drawn
pub(super) fn skeleton(model: &Model, has: &dyn Fn(usize) -> bool) -> Vec<Shape> {
    let bodies = model.bodies();
    let own = || bodies.iter().enumerate().filter(|(i, _)| has(*i));
    // There is no bone from the world to a robot.
    let reach = own().map(|(_, b)| match b.parent {
        Some(_) => b.placement.translation.norm().max(b.inertia.com().norm()),
        None => b.inertia.com().norm(),
    });
    let largest = reach.fold(0.1, f64::max);
    let (bone, ball) = (largest * THICKNESS[0], largest * THICKNESS[1]);
    let mut shapes = Vec::new();
    for (i, body) in own() {
        let children = bodies
            .iter()
            .filter(|child| child.parent == Some(BodyId(i)));
        let ends = children.map(|child| child.placement.translation);
        for end in ends
            .chain([body.inertia.com()])
            .filter(|end| end.norm() > 0.0)
        {
            shapes.push(on(
                i,
                Transform::new(turned_to(&end), end * 0.5),
                Geometry::Capsule {
                    radius: bone,
                    length: end.norm(),
                },
            ));
        }
        let com = Transform::from_translation(body.inertia.com());
        shapes.push(on(i, com, Geometry::Sphere { radius: ball }));
    }
    shapes
}

fn on(body: usize, X: Transform<f64>, geometry: Geometry) -> Shape {
    Shape {
        body: Some(body),
        pose: pose(&X),
        color: None,
        piece: Piece::of(&geometry),
    }
}

/// A rotation that turns z to a direction.
pub(super) fn turned_to(direction: &Vector3<f64>) -> Matrix3<f64> {
    let z = Vector3::z();
    // Opposite to z every axis across is as good as another.
    let rotation = Rotation3::rotation_between(&z, direction);
    rotation.map_or_else(
        || Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0)),
        Into::into,
    )
}
