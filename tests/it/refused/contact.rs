//! Laws, points, terrain and materials.

use dualbody::contact::{
    ContactLaw, ContactPoint, Contacts, Feature, HuntCrossley, Material, Materials, Plane,
    Reference, RelaxedRigid, Rigid, SoftContact, Terrain,
};
use dualbody::sim::BATCH_WIDTH;
use dualbody::{Cast, Lanes, Model};
use nalgebra::Vector3;

use super::{INFINITY, NAN, Senseless, refused, spoiled};
use crate::common::asset;

const RIGID: [Senseless<Rigid>; 3] = [
    Senseless {
        said: "the friction of rigid contact is {}",
        set: |law, x| law.friction = x,
        values: &[-0.5, NAN],
    },
    Senseless {
        said: "the restitution of rigid contact is {}",
        set: |law, x| law.restitution = x,
        values: &[1.5, -0.1, NAN],
    },
    Senseless {
        said: "the recovery time of rigid contact is {}",
        set: |law, x| law.recovery_time = x,
        values: &[0.0, -1.0, NAN, INFINITY],
    },
];

const RELAXED: [Senseless<RelaxedRigid>; 9] = [
    Senseless {
        said: "the friction of regularised rigid contact is {}",
        set: |law, x| law.friction = x,
        values: &[-0.5, NAN],
    },
    Senseless {
        said: "a least impedance of {} is",
        set: |law, x| law.impedance.least = x,
        values: &[0.0, 1.0, NAN, -0.5],
    },
    Senseless {
        said: "a largest impedance of {} is",
        set: |law, x| law.impedance.largest = x,
        values: &[0.0, 1.0, NAN, -0.5],
    },
    Senseless {
        said: "the width of the impedance is {}",
        set: |law, x| law.impedance.width = x,
        values: &[0.0],
    },
    Senseless {
        said: "the ratio of impedances of regularised rigid contact is {}",
        set: |law, x| law.friction_impedance_ratio = x,
        values: &[0.0, -1.0, NAN, INFINITY],
    },
    Senseless {
        said: "the time constant of a reference acceleration is {}",
        set: |law, x| law.reference = oscillator(x, 1.0),
        values: &[0.0],
    },
    Senseless {
        said: "the damping ratio of a reference acceleration is {}",
        set: |law, x| law.reference = oscillator(0.02, x),
        values: &[NAN],
    },
    Senseless {
        said: "the stiffness of a reference acceleration is {}",
        set: |law, x| law.reference = direct(x, 1.0),
        values: &[-1.0],
    },
    Senseless {
        said: "the damping of a reference acceleration is {}",
        set: |law, x| law.reference = direct(1.0, x),
        values: &[INFINITY],
    },
];

const SOFT: [Senseless<SoftContact>; 6] = [
    Senseless {
        said: "the friction of soft contact is {}",
        set: |law, x| law.friction = x,
        values: &[-0.5, NAN],
    },
    Senseless {
        said: "the stiffness of soft contact is {}",
        set: |law, x| law.normal.stiffness = x,
        values: &[-1.0],
    },
    Senseless {
        said: "the damping of soft contact is {}",
        set: |law, x| law.normal.damping = x,
        values: &[NAN],
    },
    Senseless {
        said: "the stiffness exponent of soft contact is {}",
        set: |law, x| law.normal.stiffness_exponent = x,
        values: &[-0.5],
    },
    Senseless {
        said: "the damping exponent of soft contact is {}",
        set: |law, x| law.normal.damping_exponent = x,
        values: &[-0.5],
    },
    Senseless {
        said: "soft contact without stiffness and damping",
        set: |law, x| law.normal = HuntCrossley::linear(x, x),
        values: &[0.0],
    },
];

const POINT: [Senseless<ContactPoint>; 5] = [
    Senseless {
        said: "the radius of a sphere is {}",
        set: |point, x| point.feature = Feature::Sphere { radius: x },
        values: &[-0.1, 0.0],
    },
    Senseless {
        said: "the radius of a rim is {}",
        set: |point, x| point.feature = rim(1.0, x, 0.0),
        values: &[NAN],
    },
    Senseless {
        said: "the angle on a rim is {}",
        set: |point, x| point.feature = rim(1.0, 0.1, x),
        values: &[NAN],
    },
    Senseless {
        said: "an axis of a rim of length {}",
        set: |point, x| point.feature = rim(x, 0.1, 0.0),
        values: &[2.0],
    },
    Senseless {
        said: "the coordinate of a contact point is {}",
        set: |point, x| point.center.y = x,
        values: &[NAN],
    },
];

const MATERIAL: [Senseless<Material>; 2] = [
    Senseless {
        said: "the friction is {}",
        set: |material, x| material.friction = x,
        values: &[NAN],
    },
    Senseless {
        said: "the restitution is {}",
        set: |material, x| material.restitution = x,
        values: &[1.5],
    },
];

fn oscillator(time_constant: f64, damping_ratio: f64) -> Reference {
    Reference::TimeConstant {
        time_constant,
        damping_ratio,
    }
}

fn direct(stiffness: f64, damping: f64) -> Reference {
    Reference::Direct { stiffness, damping }
}

fn rim(length: f64, radius: f64, angle: f64) -> Feature {
    Feature::Rim {
        axis: Vector3::z() * length,
        radius,
        angle,
    }
}

/// Asserts that a law is refused by all that takes one, beside points with a good one.
#[track_caller]
fn assert_refused(good: ContactLaw, (law, message): (ContactLaw, String)) {
    let model: Model = asset("box.urdf");
    let message = message.as_str();
    refused(message, || Contacts::new(&model, Terrain::flat(0.0), law));
    let contacts = Contacts::new(&model, Terrain::flat(0.0), good);
    let link = model.link_names()[0];
    refused(message, || contacts.clone().with_law(&model, link, law));
    refused(message, || {
        contacts.clone().with_point(contacts.points()[0], law)
    });
    refused(message, || contacts.with_laws(&[law; 8]));
}

#[test]
fn laws_with_senseless_numbers_are_refused_wherever_they_are_given() {
    let (rigid, relaxed) = (Rigid::default(), RelaxedRigid::default());
    let soft = SoftContact::estimate(1.0, 4, 1e-3);
    for (law, message) in spoiled(&rigid, &RIGID) {
        assert_refused(ContactLaw::Rigid(rigid), (ContactLaw::Rigid(law), message));
    }
    for (law, message) in spoiled(&relaxed, &RELAXED) {
        let law = ContactLaw::RelaxedRigid(law);
        assert_refused(ContactLaw::RelaxedRigid(relaxed), (law, message));
    }
    for (law, message) in spoiled(&soft, &SOFT) {
        assert_refused(ContactLaw::Soft(soft), (ContactLaw::Soft(law), message));
    }
}

#[test]
fn a_senseless_number_in_one_lane_of_one_law_is_refused() {
    let (model, rigid) = (asset("box.urdf"), Rigid::default());
    let contacts = Contacts::new(&model, Terrain::flat(0.0), ContactLaw::Rigid(rigid));
    for (bad, message) in spoiled(&rigid, &RIGID) {
        let mut lane = rigid.cast::<Lanes<BATCH_WIDTH>>();
        lane.friction.0[2] = bad.friction;
        lane.restitution.0[2] = bad.restitution;
        lane.recovery_time.0[2] = bad.recovery_time;
        let mut laws = [ContactLaw::Rigid(rigid.cast()); 8];
        laws[3] = ContactLaw::Rigid(lane);
        refused(&message, || {
            contacts.cast::<Lanes<BATCH_WIDTH>>().with_laws(&laws)
        });
    }
}

#[test]
fn points_terrain_and_materials_with_senseless_numbers_are_refused() {
    let (model, law) = (asset("box.urdf"), ContactLaw::Rigid(Rigid::default()));
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
    for (point, message) in spoiled(&contacts.points()[0], &POINT) {
        refused(&message, || contacts.clone().with_point(point, law));
    }
    let plane = Terrain::Plane(Plane {
        height: NAN,
        slope: [0.0; 2],
    });
    let message = "height or slope of the plane is NaN";
    refused(message, || contacts.clone().with_terrain(plane.clone()));
    refused(message, || Contacts::new(&model, plane.clone(), law));
    let good = Material {
        friction: 0.1,
        ..Material::default()
    };
    for (material, message) in spoiled(&good, &MATERIAL) {
        refused(&message, || {
            Materials::default().with_material("odd", material)
        });
    }
}
