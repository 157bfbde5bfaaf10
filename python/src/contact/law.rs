//! Laws of contact.

use dualbody::Model;
use dualbody::contact::{
    ContactLaw, HuntCrossley, Impedance, Reference, RelaxedRigid, Rigid, Sigmoid, SoftContact,
};
use pyo3::prelude::*;

use crate::counts::whole;
use crate::errors::{guarded, value_error};
use crate::kinds::check_kind;
use crate::python::functions;

type Numbers = (String, Vec<f64>);

pub(super) fn numbers_of<'py, T: FromPyObjectOwned<'py>>(value: &Bound<'py, PyAny>) -> PyResult<T> {
    value
        .call_method0("_numbers")?
        .extract()
        .map_err(Into::into)
}

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
                let soft = guarded(|| SoftContact::estimate(model.total_mass(), points, depth))?;
                Ok(ContactLaw::Soft(soft))
            }
            _ => Err(value_error(format_args!(
                "{name} is {kind:?}, not \"rigid\", \"soft\" or \"relaxed\""
            ))),
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
    let (kind, x): Numbers = numbers_of(value)?;
    match (kind.as_str(), x.as_slice()) {
        (
            "soft",
            &[
                friction,
                stiffness,
                damping,
                stiffness_exponent,
                damping_exponent,
            ],
        ) => {
            let normal = HuntCrossley {
                stiffness,
                damping,
                stiffness_exponent,
                damping_exponent,
            };
            Ok(ContactLaw::Soft(SoftContact { normal, friction }))
        }
        ("rigid", &[friction, restitution, recovery_time]) => Ok(ContactLaw::Rigid(Rigid {
            friction,
            restitution,
            recovery_time,
        })),
        ("relaxed_time", &[time_constant, damping_ratio, ref rest @ ..]) => relaxed(
            Reference::TimeConstant {
                time_constant,
                damping_ratio,
            },
            rest,
        ),
        ("relaxed_direct", &[stiffness, damping, ref rest @ ..]) => {
            relaxed(Reference::Direct { stiffness, damping }, rest)
        }
        _ => Err(value_error(format_args!(
            "law is of the unknown kind \"{kind}\""
        ))),
    }
}

fn relaxed(reference: Reference, x: &[f64]) -> PyResult<ContactLaw> {
    let &[
        friction,
        friction_impedance_ratio,
        least,
        largest,
        width,
        midpoint,
        power,
    ] = x
    else {
        return Err(value_error(
            "law does not have the parameters of regularised contact",
        ));
    };
    let sigmoid = guarded(|| Sigmoid::new(midpoint, power))?;
    let impedance = Impedance {
        least,
        largest,
        width,
        sigmoid,
    };
    Ok(ContactLaw::RelaxedRigid(RelaxedRigid {
        friction,
        reference,
        impedance,
        friction_impedance_ratio,
    }))
}

functions! {
    /// Numbers of `SoftContact.estimate(mass, points, depth)`: friction and those of the normal force.
    fn _estimate_soft_contact(mass: f64, points, depth: f64) -> PyResult<[f64; 5]> {
        let points = whole("points", points)?;
        let SoftContact { normal, friction } = guarded(|| SoftContact::estimate(mass, points, depth))?;
        Ok([
            friction,
            normal.stiffness,
            normal.damping,
            normal.stiffness_exponent,
            normal.damping_exponent,
        ])
    }
}

fn normal_of([stiffness, damping, stiffness_exponent, damping_exponent]: [f64; 4]) -> HuntCrossley {
    HuntCrossley {
        stiffness,
        damping,
        stiffness_exponent,
        damping_exponent,
    }
}

functions! {
    /// Numbers of a normal force that is damped for a restitution at a speed.
    fn _with_restitution(normal: [f64; 4], restitution: f64, speed: f64) -> PyResult<[f64; 4]> {
        let found = guarded(|| normal_of(normal).with_restitution(restitution, speed))?;
        Ok([
            found.stiffness,
            found.damping,
            found.stiffness_exponent,
            found.damping_exponent,
        ])
    }
}

/// Restitution of a normal force at a speed.
#[pyfunction]
pub(crate) fn _restitution(normal: [f64; 4], speed: f64) -> PyResult<Option<f64>> {
    guarded(|| normal_of(normal).restitution(speed))
}

/// Time of contact of a mass at a speed.
#[pyfunction]
pub(crate) fn _impact_time(normal: [f64; 4], mass: f64, speed: f64) -> PyResult<f64> {
    guarded(|| normal_of(normal).impact_time(mass, speed))
}
