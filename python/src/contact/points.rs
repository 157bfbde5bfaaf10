//! Where a robot touches the ground.

use dualbody::Model;
use dualbody::contact::{
    ContactOptions, ContactPoint, Contacts, Feature, NoMeshes, Smoothing, SolverOptions,
};
use dualbody::model::{BodyId, FrameId};
use nalgebra::Vector3;
use pyo3::prelude::*;

use super::law::law_of;
use super::terrain::terrain_of;
use crate::errors::{OrRaise, guarded};

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
