//! Contacts, terrain, motors, constraints and forces of a simulator, from the small classes of Python that describe them.
//!
//! Each class has a method `_numbers` that gives its kind and numbers in the order of the fields here.

use dualbody::constraint::{Anchor, Constraint};
use dualbody::contact::{
    ContactLaw, ContactOptions, ContactPoint, Contacts, Feature, HeightField, HuntCrossley,
    Impedance, NoMeshes, Reference, RelaxedRigid, Rigid, Sigmoid, Smoothing, SoftContact,
    SolverOptions, Terrain,
};
use dualbody::model::{BodyId, FrameId};
use dualbody::sim::{
    Actuation, Actuator, CoulombFriction, ExternalForce, FrameActuator, PositionLimits,
    TorqueSpeed, VelocityLimit,
};
use dualbody::spatial::Force;
use dualbody::{Model, Simulator};
use nalgebra::Vector3;
use pyo3::prelude::*;

use crate::dynamics::representation;
use crate::errors::{OrRaise, guarded, value_error};
use crate::model::read_pose;

type Numbers = (String, Vec<f64>);

fn numbers_of<'py, T: FromPyObjectOwned<'py>>(value: &Bound<'py, PyAny>) -> PyResult<T> {
    value
        .call_method0("_numbers")?
        .extract()
        .map_err(Into::into)
}

fn law_of(value: &Bound<'_, PyAny>) -> PyResult<ContactLaw> {
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
            "law has not the numbers of a relaxed rigid contact",
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

/// Numbers of `SoftContact.estimate(mass, points, depth)`: friction and those of the normal force.
#[pyfunction]
pub(crate) fn _estimate_soft_contact(mass: f64, points: usize, depth: f64) -> PyResult<[f64; 5]> {
    let SoftContact { normal, friction } = guarded(|| SoftContact::estimate(mass, points, depth))?;
    Ok([
        friction,
        normal.stiffness,
        normal.damping,
        normal.stiffness_exponent,
        normal.damping_exponent,
    ])
}

pub(crate) fn terrain_of(value: &Bound<'_, PyAny>) -> PyResult<Terrain> {
    let (kind, x, size): (String, Vec<f64>, [usize; 2]) = numbers_of(value)?;
    guarded(|| match (kind.as_str(), x.as_slice()) {
        ("plane", &[px, py, pz, nx, ny, nz]) => Ok(Terrain::plane([px, py, pz], [nx, ny, nz])),
        ("height_field", &[x, y, dx, dy, ref heights @ ..]) => Ok(Terrain::HeightField(
            HeightField::new([x, y], [dx, dy], size, heights),
        )),
        _ => Err(value_error(format_args!(
            "terrain is of the unknown kind \"{kind}\""
        ))),
    })?
}

/// Height and slope (h, ∂h/∂x, ∂h/∂y) of a terrain at (x, y).
#[pyfunction]
pub(crate) fn _terrain_surface(
    terrain: &Bound<'_, PyAny>,
    x: f64,
    y: f64,
) -> PyResult<(f64, f64, f64)> {
    let ground = terrain_of(terrain)?.surface(&x, &y);
    Ok((ground.height, ground.slope[0], ground.slope[1]))
}

/// A point of contact: link, body, centre, kind, numbers of the kind.
pub(crate) type Point = (usize, usize, [f64; 3], String, Vec<f64>);

pub(crate) fn point_numbers(point: &ContactPoint) -> Point {
    let (kind, x) = match point.feature {
        Feature::Sphere { radius } => ("sphere", vec![radius]),
        Feature::Rim {
            axis,
            radius,
            angle,
        } => ("rim", vec![axis.x, axis.y, axis.z, radius, angle]),
        _ => ("corner", Vec::new()),
    };
    (
        point.link.0,
        point.body.0,
        point.center.into(),
        kind.into(),
        x,
    )
}

fn point_of((link, body, center, kind, x): &Point) -> ContactPoint {
    let feature = match (kind.as_str(), x.as_slice()) {
        ("sphere", &[radius]) => Feature::Sphere { radius },
        ("rim", &[x, y, z, radius, angle]) => Feature::Rim {
            axis: Vector3::new(x, y, z),
            radius,
            angle,
        },
        _ => Feature::Corner,
    };
    ContactPoint {
        link: FrameId(*link),
        body: BodyId(*body),
        center: (*center).into(),
        feature,
    }
}

pub(crate) fn contacts_of(model: &Model, value: &Bound<'_, PyAny>) -> PyResult<Contacts> {
    let terrain = terrain_of(&value.getattr("terrain")?)?;
    let law = law_of(&value.getattr("law")?)?;
    let points: Option<Vec<Point>> = value.getattr("points")?.extract()?;
    let mut contacts = match points {
        None => {
            let options = ContactOptions {
                mesh_points: value.getattr("mesh_points")?.extract()?,
            };
            guarded(|| Contacts::with_options(model, terrain, law, &options))?
        }
        Some(points) => {
            let options = ContactOptions::default();
            guarded(|| {
                let none = Contacts::with_meshes(model, terrain, law, &options, &mut NoMeshes);
                let add = |all: Contacts, point| all.with_point(point_of(point), law);
                points.iter().fold(none.with_selection(|_| false), add)
            })?
        }
    };
    if let Some(links) = value.getattr("links")?.extract::<Option<Vec<String>>>()? {
        let links: Vec<&str> = links.iter().map(String::as_str).collect();
        contacts = contacts.with_links(model, &links).or_raise()?;
    }
    for (link, law) in value.getattr("laws")?.cast::<pyo3::types::PyDict>()? {
        let (link, law): (String, _) = (link.extract()?, law_of(&law)?);
        contacts = guarded(|| contacts.with_law(model, &link, law))?.or_raise()?;
    }
    if let Some((kappa, reach)) = value
        .getattr("smoothing")?
        .extract::<Option<(f64, Option<f64>)>>()?
    {
        let smoothing = guarded(|| {
            let smoothing = Smoothing::new(kappa);
            reach.map_or(smoothing, |reach| smoothing.with_reach(reach))
        })?;
        contacts = contacts.with_smoothing(smoothing);
    }
    if let Some((tolerance, iterations, acceptable, points_per_link, points)) =
        value.getattr("solver")?.extract()?
    {
        let options = SolverOptions {
            tolerance,
            iterations,
            acceptable,
            points_per_link,
            points,
        };
        contacts = guarded(|| contacts.with_solver_options(options))?;
    }
    Ok(contacts)
}

pub(crate) fn actuation_of(model: &Model, value: &Bound<'_, PyAny>) -> PyResult<Actuation> {
    let base: String = value.getattr("base")?.extract()?;
    let mut actuation = match base.as_str() {
        "ideal" => Actuation::ideal(model),
        "model" => Actuation::from_model(model),
        _ => {
            return Err(value_error(format_args!(
                "base is \"{base}\", not \"ideal\" or \"model\""
            )));
        }
    };
    for (joint, actuator) in value.getattr("actuators")?.cast::<pyo3::types::PyDict>()? {
        let (joint, actuator): (String, _) = (joint.extract()?, actuator_of(&actuator)?);
        actuation = guarded(|| actuation.with_actuator(model, &joint, actuator))?.or_raise()?;
    }
    Ok(actuation)
}

fn actuator_of(value: &Bound<'_, PyAny>) -> PyResult<Actuator> {
    let torque_speed = value
        .getattr("torque_speed")?
        .extract::<Option<(f64, f64, f64)>>()?;
    let friction = value.getattr("friction")?.extract::<Option<(f64, f64)>>()?;
    let velocity = value.getattr("velocity")?.extract::<Option<(f64, f64)>>()?;
    let position = value
        .getattr("position")?
        .extract::<Option<(Option<f64>, Option<f64>, [f64; 4])>>()?;
    Ok(Actuator {
        torque_speed: torque_speed.map(|(torque, threshold, maximum)| TorqueSpeed {
            torque,
            threshold,
            maximum,
        }),
        effort: value.getattr("effort")?.extract()?,
        friction: friction.map(|(force, slip_velocity)| CoulombFriction {
            force,
            slip_velocity,
        }),
        position: position.map(|(lower, upper, stop)| PositionLimits {
            lower,
            upper,
            stop: stop_of(stop),
        }),
        velocity: velocity.map(|(speed, damping)| VelocityLimit { speed, damping }),
    })
}

fn stop_of([stiffness, damping, stiffness_exponent, damping_exponent]: [f64; 4]) -> HuntCrossley {
    HuntCrossley {
        stiffness,
        damping,
        stiffness_exponent,
        damping_exponent,
    }
}

fn anchor_of(model: &Model, value: &Bound<'_, PyAny>) -> PyResult<Anchor> {
    let frame: Option<String> = value.getattr("frame")?.extract()?;
    let placement = read_pose("placement", &value.getattr("placement")?)?;
    let frame = frame
        .map(|name| model.find_frame(&name).or_raise())
        .transpose()?;
    guarded(|| Anchor::new(frame, placement))
}

fn constraint_of(model: &Model, value: &Bound<'_, PyAny>) -> PyResult<Constraint> {
    let kind: String = value.getattr("_kind")?.extract()?;
    let anchors = || -> PyResult<[Anchor; 2]> {
        Ok([
            anchor_of(model, &value.getattr("a")?)?,
            anchor_of(model, &value.getattr("b")?)?,
        ])
    };
    let number = |name: &str| -> PyResult<f64> { value.getattr(name)?.extract() };
    let constraint = match kind.as_str() {
        "weld" => Constraint::weld(anchors()?),
        "ball" => Constraint::ball(anchors()?),
        "distance" => {
            let (anchors, length) = (anchors()?, number("length")?);
            guarded(|| Constraint::distance(anchors, length))?
        }
        _ => {
            let (one, other): (String, String) = value.getattr("joints")?.extract()?;
            let (ratio, offset) = (number("ratio")?, number("offset")?);
            guarded(|| Constraint::coupler(model, [&one, &other], ratio, offset))?.or_raise()?
        }
    };
    match value.getattr("time_constant")?.extract::<Option<f64>>()? {
        None => Ok(constraint),
        Some(time) => guarded(|| constraint.with_time_constant(time)),
    }
}

fn force_of(x: [f64; 6]) -> Force<f64> {
    Force::from_array(x)
}

/// Adds to a simulator what its description in Python names, besides contacts.
pub(crate) fn with_parts(
    mut simulator: Simulator,
    parts: &Bound<'_, PyAny>,
) -> PyResult<Simulator> {
    let model = simulator.model().clone();
    let list = |name: &str| -> PyResult<Vec<Bound<'_, PyAny>>> { parts.get_item(name)?.extract() };
    let constraints = list("constraints")?;
    if !constraints.is_empty() {
        let all: Vec<Constraint> = constraints
            .iter()
            .map(|c| constraint_of(&model, c))
            .collect::<PyResult<_>>()?;
        simulator = guarded(|| simulator.with_constraints(all))?;
    }
    let forces = list("external_forces")?;
    if !forces.is_empty() {
        let one = |value: &Bound<'_, PyAny>| {
            let place = anchor_of(&model, &value.getattr("place")?)?;
            let (force, name): ([f64; 6], String) = (
                value.getattr("force")?.extract()?,
                value.getattr("representation")?.extract()?,
            );
            let representation = representation(&name)?;
            guarded(|| ExternalForce::constant(place, force_of(force), representation))
        };
        let all: Vec<ExternalForce> = forces.iter().map(one).collect::<PyResult<_>>()?;
        simulator = guarded(|| simulator.with_external_forces(all))?;
    }
    let actuators = list("frame_actuators")?;
    if !actuators.is_empty() {
        let all: Vec<FrameActuator> = actuators
            .iter()
            .map(|a| frame_actuator_of(&model, a))
            .collect::<PyResult<_>>()?;
        simulator = guarded(|| simulator.with_frame_actuators(all))?;
    }
    Ok(simulator)
}

fn frame_actuator_of(model: &Model, value: &Bound<'_, PyAny>) -> PyResult<FrameActuator> {
    let name: String = value.getattr("name")?.extract()?;
    let place = anchor_of(model, &value.getattr("place")?)?;
    let (wrench, axes): ([f64; 6], String) = (
        value.getattr("wrench")?.extract()?,
        value.getattr("representation")?.extract()?,
    );
    let representation = representation(&axes)?;
    let limits: Option<(f64, f64)> = value.getattr("limits")?.extract()?;
    guarded(|| {
        let actuator = FrameActuator::new(name, place, force_of(wrench), representation);
        match limits {
            Some((lower, upper)) => actuator.with_limits(lower, upper),
            None => actuator,
        }
    })
}
