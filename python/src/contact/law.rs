//! Laws of contact.

use dualbody::contact::{
    ContactLaw, HuntCrossley, Impedance, Reference, RelaxedRigid, Rigid, Sigmoid, SoftContact,
};

use crate::prelude::*;

/// Points on which a robot stands, and depth (m) by which it sinks in, of a soft contact that is given by its name.
const SOFT: (usize, f64) = (4, 1e-3);

/// A law, or that of a kind by its name, with the numbers that the kind has by default.
///
/// * `name` – name of the argument, for errors
pub(super) fn law_of(name: &str, value: &Bound<'_, PyAny>, model: &Model) -> PyResult<ContactLaw> {
    if let Ok(kind) = value.extract::<String>() {
        return match kind.as_str() {
            "rigid" => Ok(ContactLaw::Rigid(Rigid::default())),
            "relaxed" => Ok(ContactLaw::RelaxedRigid(RelaxedRigid::default())),
            "soft" => {
                let (points, depth) = SOFT;
                let soft = SoftContact::estimate(model.total_mass(), points, depth);
                Ok(ContactLaw::Soft(soft))
            }
            _ => Err(invalid!(
                "{name} is {kind:?}, not \"rigid\", \"soft\" or \"relaxed\""
            )),
        };
    }
    let hint = " (or \"rigid\", \"soft\", \"relaxed\")";
    check_kind(
        name,
        value,
        "contact",
        &["SoftContact", "RelaxedRigid", "Rigid"],
        hint,
    )?;
    match kind_of(value)?.as_str() {
        "SoftContact" => Ok(ContactLaw::Soft(SoftContact {
            normal: normal_of(value)?,
            friction: attribute(value, "friction")?,
        })),
        "Rigid" => Ok(ContactLaw::Rigid(
            fields!(value => Rigid { friction, restitution, recovery_time }),
        )),
        _ => relaxed(value).map(ContactLaw::RelaxedRigid),
    }
}

/// The reference acceleration of an object that has one by its numbers.
pub(super) fn reference_of(value: &Bound<'_, PyAny>) -> PyResult<Reference> {
    let number = |name: &str| -> PyResult<f64> { attribute(value, name) };
    Ok(match attribute(value, "direct")? {
        Some((stiffness, damping)) => Reference::Direct { stiffness, damping },
        None => Reference::TimeConstant {
            time_constant: number("time_constant")?,
            damping_ratio: number("damping_ratio")?,
        },
    })
}

/// The impedance of an object that has one by its numbers.
pub(super) fn impedance_of(value: &Bound<'_, PyAny>) -> PyResult<Impedance> {
    let [least, largest, width, midpoint, power] = read_numbers("impedance", value)?;
    let sigmoid = guarded(|| Sigmoid::new(midpoint, power))?;
    Ok(Impedance {
        least,
        largest,
        width,
        sigmoid,
    })
}

fn relaxed(value: &Bound<'_, PyAny>) -> PyResult<RelaxedRigid> {
    let (reference, impedance) = (reference_of(value)?, impedance_of(value)?);
    Ok(
        fields!(value => RelaxedRigid { friction, reference: reference, impedance: impedance, friction_impedance_ratio }),
    )
}

/// A normal force, with those numbers that an object has of it.
pub(super) fn normal_of(value: &Bound<'_, PyAny>) -> PyResult<HuntCrossley> {
    Ok(fields!(value => HuntCrossley { stiffness, damping, stiffness_exponent, damping_exponent }))
}

/// Its numbers, in the order of the fields in Python.
fn numbers_of(own: &HuntCrossley) -> [f64; 4] {
    [
        own.stiffness,
        own.damping,
        own.stiffness_exponent,
        own.damping_exponent,
    ]
}

functions! {
    /// Numbers of `SoftContact.estimate(mass, points, depth)`: friction and those of the normal force.
    fn _estimate_soft_contact(mass: f64, points, depth: f64) -> PyResult<(f64, [f64; 4])> {
        let points = whole("points", points)?;
        let own = SoftContact::estimate(mass, points, depth);
        Ok((own.friction, numbers_of(&own.normal)))
    }

    /// Numbers of the normal force of a law, damped for a restitution at a speed.
    fn _with_restitution(law, restitution: f64, speed: f64) -> PyResult<[f64; 4]> {
        let normal = normal_of(law)?;
        guarded(|| numbers_of(&normal.with_restitution(restitution, speed)))
    }

    /// Restitution of the normal force of a law at a speed.
    fn _restitution(law, speed: f64) -> PyResult<Option<f64>> {
        let normal = normal_of(law)?;
        guarded(|| normal.restitution(speed))
    }

    /// Time of contact of a mass at a speed under the normal force of a law.
    fn _impact_time(law, mass: f64, speed: f64) -> PyResult<f64> {
        let normal = normal_of(law)?;
        guarded(|| normal.impact_time(mass, speed))
    }
}
