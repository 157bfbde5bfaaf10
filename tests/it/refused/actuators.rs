//! Motors, friction and limits of joints.

use dualbody::contact::HuntCrossley;
use dualbody::model::samples;
use dualbody::sim::{
    Actuation, Actuator, CoulombFriction, PositionLimits, TorqueSpeed, VelocityLimit,
};

use super::{NAN, Senseless, refused, spoiled};

const ACTUATOR: [Senseless<Actuator>; 10] = [
    Senseless {
        said: "effort limit is {}",
        set: |actuator, x| actuator.effort = Some(x),
        values: &[-1.0],
    },
    Senseless {
        said: "force of Coulomb friction is {}",
        set: |actuator, x| actuator.friction = Some(friction(x, 0.1)),
        values: &[-1.0],
    },
    Senseless {
        said: "slip velocity of Coulomb friction is {}",
        set: |actuator, x| actuator.friction = Some(friction(1.0, x)),
        values: &[0.0],
    },
    Senseless {
        said: "position limit is {}",
        set: |actuator, x| actuator.position = Some(limits(x, 100.0)),
        values: &[NAN],
    },
    Senseless {
        said: "lower position limit of {} is above",
        set: |actuator, x| actuator.position = Some(limits(x, 100.0)),
        values: &[2.0],
    },
    Senseless {
        said: "stiffness of a joint limit is {}",
        set: |actuator, x| actuator.position = Some(limits(-1.0, x)),
        values: &[-1.0],
    },
    Senseless {
        said: "torque of a motor is {}",
        set: |actuator, x| actuator.torque_speed = Some(curve(x, 2.0)),
        values: &[NAN],
    },
    Senseless {
        said: "is not above the threshold of {}",
        set: |actuator, x| actuator.torque_speed = Some(curve(1.0, x)),
        values: &[1.0],
    },
    Senseless {
        said: "speed limit is {}",
        set: |actuator, x| actuator.velocity = Some(speed_limit(x, 1.0)),
        values: &[-1.0],
    },
    Senseless {
        said: "damping of a speed limit is {}",
        set: |actuator, x| actuator.velocity = Some(speed_limit(1.0, x)),
        values: &[-1.0],
    },
];

fn friction(force: f64, slip_velocity: f64) -> CoulombFriction {
    CoulombFriction::smoothed(force, slip_velocity)
}

fn limits(lower: f64, stiffness: f64) -> PositionLimits {
    PositionLimits {
        lower: Some(lower),
        upper: Some(1.0),
        stop: HuntCrossley::linear(stiffness, 1.0),
    }
}

fn curve(torque: f64, maximum: f64) -> TorqueSpeed {
    TorqueSpeed {
        torque,
        threshold: 1.0,
        maximum,
    }
}

fn speed_limit(speed: f64, damping: f64) -> VelocityLimit {
    VelocityLimit { speed, damping }
}

#[test]
fn actuators_with_senseless_numbers_are_refused() {
    let (model, none) = (samples::cartpole(), Actuator::default());
    for (actuator, message) in spoiled(&none, &ACTUATOR) {
        let ideal = || Actuation::ideal(&model);
        refused(&message, || {
            ideal().with_actuator(&model, "linear", actuator)
        });
        refused(&message, || ideal().with_actuators(&[none, actuator]));
    }
}
