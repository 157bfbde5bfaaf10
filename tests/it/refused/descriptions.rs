//! Shapes and joints that are given to a builder: errors, where others panic.

use dualbody::joint::JointKind;
use dualbody::model::{Collision, Geometry, JointSpec, LinkSpec, Mass, ModelBuilder};
use dualbody::spatial::Transform;

use super::{NAN, Senseless, spoiled};

const GEOMETRY: [Senseless<Geometry>; 5] = [
    Senseless {
        said: "radius = \"{}\": is negative",
        set: |shape, radius| *shape = Geometry::Sphere { radius },
        values: &[-0.1],
    },
    Senseless {
        said: "radius = \"{}\": is not positive",
        set: |shape, radius| *shape = Geometry::Sphere { radius },
        values: &[0.0],
    },
    Senseless {
        said: "length = \"{}\": is negative",
        set: |shape, length| {
            *shape = Geometry::Cylinder {
                radius: 0.1,
                length,
            };
        },
        values: &[-1.0],
    },
    Senseless {
        said: "<collision> \"link\": size is not finite",
        set: |shape, radius| {
            *shape = Geometry::Capsule {
                radius,
                length: 1.0,
            };
        },
        values: &[NAN],
    },
    Senseless {
        said: "size = \"{}\": is negative",
        set: |shape, y| {
            *shape = Geometry::Box {
                size: [1.0, y, 1.0],
            };
        },
        values: &[-1.0],
    },
];

const JOINT: [Senseless<JointSpec>; 3] = [
    Senseless {
        said: "damping = \"{}\": is negative",
        set: |joint, x| *joint = joint.clone().with_damping(x),
        values: &[-1.0],
    },
    Senseless {
        said: "armature = \"{}\": is negative",
        set: |joint, x| *joint = joint.clone().with_armature(x),
        values: &[-1.0],
    },
    Senseless {
        said: "spring stiffness = \"{}\": is negative",
        set: |joint, x| *joint = joint.clone().with_spring(x, 0.0),
        values: &[-1.0],
    },
];

#[test]
fn shapes_with_senseless_numbers_are_errors() {
    let good = Geometry::Sphere { radius: 1.0 };
    for (geometry, message) in spoiled(&good, &GEOMETRY) {
        let collision = Collision {
            name: None,
            placement: Transform::identity(),
            geometry,
        };
        let mut builder = ModelBuilder::new("odd");
        let link = LinkSpec::new("link").with_mass(1.0, [0.0; 3], [1.0; 3]);
        builder.add_link(link.with_collision(collision));
        let error = builder.build().expect_err(&message).to_string();
        assert!(error.contains(&message), "{error}");
    }
}

#[test]
fn joints_with_senseless_numbers_are_errors() {
    let good = JointSpec::new("joint", JointKind::Revolute, "world", "ball");
    for (joint, message) in spoiled(&good, &JOINT) {
        let mut builder = ModelBuilder::new("odd");
        builder.add_link(LinkSpec::new("world"));
        builder.add_link(LinkSpec::solid_sphere("ball", 0.1, Mass::Kilograms(1.0)));
        builder.add_joint(joint);
        let error = builder.build().expect_err(&message).to_string();
        assert!(error.contains(&message), "{error}");
    }
}
