//! Where a robot touches the ground.

use dualbody::contact::{
    ContactOptions, ContactPoint, Contacts, Feature, NoMeshes, Smoothing, SolverOptions,
    TurningFriction,
};
use dualbody::model::{BodyId, FrameId};
use nalgebra::{Matrix3, Vector3};

use super::collisions::with_collisions;
use super::law::law_of;
use super::terrain::terrain_of;
use crate::prelude::*;

/// A point of contact: link, body, centre, kind, parameters of the kind.
pub(crate) type Point = (usize, usize, [f64; 3], String, Vec<f64>);

pub(crate) fn point_numbers(point: &ContactPoint) -> Point {
    let (kind, x) = match point.feature {
        Feature::Sphere { radius } => ("sphere", vec![radius]),
        Feature::Rim {
            axis,
            radius,
            angle,
        } => ("rim", vec![axis.x, axis.y, axis.z, radius, angle]),
        Feature::Ellipsoid { semi_axes } => ("ellipsoid", semi_axes.as_slice().to_vec()),
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
        ("ellipsoid", x) if x.len() == 9 => Feature::Ellipsoid {
            semi_axes: Matrix3::from_column_slice(x),
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

/// Contacts at the points that the shapes have, or at those that travelled with a simulator.
fn placed(model: &Model, value: &Bound<'_, PyAny>) -> PyResult<Contacts> {
    let terrain = terrain_of(&value.getattr("terrain")?)?;
    let law = law_of("law", &value.getattr("law")?, model)?;
    let Some(points) = attribute::<Option<Vec<Point>>>(value, "points")? else {
        let mesh_points = attribute(value, "mesh_points")?;
        let options = ContactOptions { mesh_points };
        return Contacts::with_options(model, terrain, law, &options).or_raise();
    };
    let options = ContactOptions::default();
    guarded(|| {
        let none = Contacts::with_meshes(model, terrain, law, &options, &mut NoMeshes);
        let add = |all: Contacts, point| all.with_point(point_of(point), law);
        none.map(|none| points.iter().fold(none.with_selection(|_| false), add))
    })?
    .or_raise()
}

/// Contacts with what is given link by link.
fn with_links(
    mut contacts: Contacts,
    model: &Model,
    value: &Bound<'_, PyAny>,
) -> PyResult<Contacts> {
    if let Some(links) = attribute::<Option<Vec<String>>>(value, "links")? {
        let links: Vec<&str> = links.iter().map(String::as_str).collect();
        contacts = contacts.with_links(model, &links).or_raise()?;
    }
    for (link, law) in value.getattr("laws")?.cast::<PyDict>()? {
        let link: String = link.extract()?;
        let law = law_of(&format!("laws[\"{link}\"]"), &law, model)?;
        contacts = contacts.with_law(model, &link, law).or_raise()?;
    }
    for (link, own) in value.getattr("turning")?.cast::<PyDict>()? {
        let (link, (torsional, rolling)) = (link.extract::<String>()?, own.extract()?);
        let turning = TurningFriction { torsional, rolling };
        let with = contacts.with_turning_friction(model, &link, turning);
        contacts = with.or_raise()?;
    }
    for (link, margin) in value.getattr("margins")?.cast::<PyDict>()? {
        let (link, margin) = (link.extract::<String>()?, margin.extract()?);
        contacts = guarded(|| contacts.with_margin(model, &link, margin))?.or_raise()?;
    }
    Ok(contacts)
}

pub(crate) fn contacts_of(model: &Model, value: &Bound<'_, PyAny>) -> PyResult<Contacts> {
    let hint = ", as in Contacts(Terrain.flat(), \"rigid\")";
    check_kind("contacts", value, "contact", &["Contacts"], hint)?;
    let contacts = with_links(placed(model, value)?, model, value)?;
    let mut contacts = with_collisions(contacts, model, value)?;
    let smoothing = value.getattr("smoothing")?;
    if !smoothing.is_none() {
        check_kind("smoothing", &smoothing, "contact", &["Smoothing"], "")?;
        let kappa = attribute(&smoothing, "kappa")?;
        let mut own = Smoothing::new(kappa);
        if let Some(reach) = attribute(&smoothing, "reach")? {
            own = own.with_reach(reach);
        }
        contacts = contacts.with_smoothing(own);
    }
    let solver = value.getattr("solver")?;
    if !solver.is_none() {
        check_kind("solver", &solver, "contact", &["SolverOptions"], "")?;
        let count = |name: &str| attribute(&solver, name);
        let options = fields!(solver => SolverOptions {
            tolerance,
            iterations: count("iterations")?,
            acceptable,
            points_per_link: count("points_per_link")?,
            points: count("points")?,
            warm_start,
        });
        contacts = contacts.with_solver_options(options);
    }
    contacts.check_memory().or_raise()?;
    Ok(contacts)
}
