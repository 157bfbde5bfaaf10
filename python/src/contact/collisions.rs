//! Bodies that touch each other.

use std::path::PathBuf;

use dualbody::collision::Surface;
use dualbody::contact::{
    CollisionOptions, Compliance, ContactLaw, Contacts, Material, TurningFriction,
};
use nalgebra::Vector3;

use super::law::law_of;
use crate::model::is_text;
use crate::prelude::*;

/// Lets bodies touch each other, where that is asked for.
pub(super) fn with_collisions(
    contacts: Contacts,
    model: &Model,
    value: &Bound<'_, PyAny>,
) -> PyResult<Contacts> {
    let collisions = value.getattr("collisions")?;
    if collisions.is_none() {
        return Ok(contacts);
    }
    let law = match collisions.getattr("law")? {
        own if own.is_none() => law_of("law", &value.getattr("law")?, model)?,
        own => law_of("collisions.law", &own, model)?,
    };
    let materials = by_link(&collisions, "materials", "Material", |own| {
        material(own, model)
    })?;
    let mut options = CollisionOptions {
        self_collision: attribute(&collisions, "self_collision")?,
        excluded: attribute(&collisions, "excluded")?,
        pairs: pairs(&collisions, model)?,
        speculative: attribute(&collisions, "speculative")?,
        turning: turning(&collisions)?,
        materials,
        ..CollisionOptions::default()
    };
    for (link, surface) in by_link(&collisions, "surfaces", "Surface", surface)? {
        options = options.with_surface(&link, surface);
    }
    contacts.with_collisions(model, law, &options).or_raise()
}

/// Values of a class for links, by name.
fn by_link<T>(
    collisions: &Bound<'_, PyAny>,
    name: &str,
    class: &str,
    read: impl Fn(&Bound<'_, PyAny>) -> PyResult<T>,
) -> PyResult<Vec<(String, T)>> {
    let all = collisions.getattr(name)?;
    let of_link = |(link, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let link: String = link.extract()?;
        let place = format!("{name}[\"{link}\"]");
        check_kind(&place, &value, "contact", &[class], "")?;
        Ok((link, read(&value)?))
    };
    all.cast::<PyDict>()?.iter().map(of_link).collect()
}

/// Materials of pairs of links, by both names.
fn pairs(collisions: &Bound<'_, PyAny>, model: &Model) -> PyResult<Vec<([String; 2], Material)>> {
    let all = collisions.getattr("pairs")?;
    let of_pair = |(links, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let place = format!("pairs[{}]", links.repr()?);
        let links = links
            .extract()
            .map_err(|_| wrong_type!("{place}: expected the names of two links"))?;
        check_kind(&place, &value, "contact", &["Material"], "")?;
        Ok((links, material(&value, model)?))
    };
    all.cast::<PyDict>()?.iter().map(of_pair).collect()
}

fn material(value: &Bound<'_, PyAny>, model: &Model) -> PyResult<Material> {
    Ok(fields!(value => Material {
        friction,
        restitution,
        margin,
        turning: turning(value)?,
        compliance: compliance(&value.getattr("compliance")?, model)?,
    }))
}

/// Compliance of a material: a pair of numbers for soft contact, or that of a regularised contact model.
fn compliance(value: &Bound<'_, PyAny>, model: &Model) -> PyResult<Option<Compliance>> {
    if value.is_none() {
        return Ok(None);
    }
    if let Ok((stiffness, damping)) = value.extract() {
        return Ok(Some(Compliance::Soft { stiffness, damping }));
    }
    let hint = " (or stiffness and damping of soft contact)";
    check_kind("compliance", value, "contact", &["RelaxedRigid"], hint)?;
    Ok(match law_of("compliance", value, model)? {
        ContactLaw::RelaxedRigid(law) => Some(Compliance::Regularised {
            reference: law.reference,
            impedance: law.impedance,
        }),
        _ => None,
    })
}

/// Torsional and rolling friction: attributes of these names.
fn turning(value: &Bound<'_, PyAny>) -> PyResult<TurningFriction> {
    Ok(TurningFriction {
        torsional: attribute(value, "torsional_friction")?,
        rolling: attribute(value, "rolling_friction")?,
    })
}

fn surface(value: &Bound<'_, PyAny>) -> PyResult<Surface> {
    let vertices: Vec<[f64; 3]> = attribute(value, "vertices")?;
    let triangles: Vec<[u32; 3]> = attribute(value, "triangles")?;
    let vertices = vertices.into_iter().map(Vector3::from).collect();
    Surface::new(vertices, triangles).map_err(value_error)
}

functions! {
    /// Vertices and triangles of a grid of heights (ny, nx).
    fn _surface_grid(heights, origin: [f64; 2], spacing: [f64; 2]) -> PyResult<(Vec<[f64; 3]>, Vec<[u32; 3]>)> {
        let rows = read_matrix("heights", heights)?.transpose();
        let surface = Surface::grid(origin, spacing, rows.shape().into(), rows.as_slice()).map_err(value_error)?;
        Ok((surface.vertices().iter().map(|&x| x.into()).collect(), surface.triangles().to_vec()))
    }

    /// The pairs of links that an SRDF, a text or a file, excludes, and remarks on what else it holds.
    fn _srdf(model: &Bound<'py, PyModel>, description, prefix: &str) -> PyResult<(Vec<[String; 2]>, Vec<String>)> {
        let (m, options) = (&*model.get().model, CollisionOptions::default());
        let read = match description.extract::<String>() {
            Ok(text) if is_text(&text) => options.with_srdf_str(m, prefix, &text),
            _ => {
                let path = description.extract::<PathBuf>();
                let path = path.map_err(|_| type_error("description is no text and no path"))?;
                options.with_srdf_file(m, prefix, path)
            }
        };
        let (options, rest) = read.or_raise()?;
        let rest = rest.iter().map(ToString::to_string).collect();
        Ok((options.excluded, rest))
    }
}
