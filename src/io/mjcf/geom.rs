//! Geoms: shapes that have mass, are shown and touch.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::assets::{Assets, MeshAsset};
use super::compiler::Compiler;
use super::contact;
use super::entry::Entry;
use super::geom_mass::Material;
use super::height_field::HeightAsset;
use super::orientation::{direction, from_z, pose};
use super::scene::MjcfGeom;
use crate::error::LoadError;
use crate::model::Geometry;
use crate::scalar::MapEach;
use crate::spatial::Transform;

/// By default, groups up to this one are shown.
const SHOWN_GROUPS: f64 = 2.0;

/// Shapes that a geom can have.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    Simple(Geometry),
    Mesh(MeshAsset),
    Plane,
    Heights(HeightAsset),
    /// An unsupported one, with the reason.
    None(String),
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Plane,
    HeightField,
    Sphere,
    Capsule,
    Ellipsoid,
    Cylinder,
    Box,
    Mesh,
    Distance,
}

const KINDS: [(&str, Kind); 9] = [
    ("plane", Kind::Plane),
    ("hfield", Kind::HeightField),
    ("sphere", Kind::Sphere),
    ("capsule", Kind::Capsule),
    ("ellipsoid", Kind::Ellipsoid),
    ("cylinder", Kind::Cylinder),
    ("box", Kind::Box),
    ("mesh", Kind::Mesh),
    ("sdf", Kind::Distance),
];

/// A geom.
#[derive(Debug)]
pub(super) struct Geom {
    /// Pose in its parent.
    pub(super) X: Transform<f64>,
    pub(super) shape: Shape,
    pub(super) group: f64,
    pub(super) color: Option<[f64; 4]>,
    pub(super) contact: MjcfGeom,
    pub(super) material: Material,
}

impl Geom {
    /// Reads a geom.
    pub(super) fn read(
        entry: &Entry<'_, '_>,
        compiler: &Compiler,
        assets: &Assets,
    ) -> Result<Self, LoadError> {
        let kind = entry.word("type", &KINDS)?.unwrap_or(Kind::Sphere);
        let ends = ends_of(entry, kind)?;
        let X = match ends {
            Some(ends) => ends.X,
            None => pose(entry, compiler)?,
        };
        let shape = shape(entry, kind, ends.map(|ends| ends.half), assets)?;
        let of_material = assets.material(entry)?;
        let color = entry.numbers::<4>("rgba")?.or(of_material);
        let material = Material::read(entry)?;
        // The frame of a mesh is that of its file, seen from a reference in it.
        let X_FM = match &shape {
            Shape::Mesh(mesh) => mesh.X_FM.inverse(),
            _ => Transform::identity(),
        };
        let X = X * X_FM;
        Ok(Self {
            X,
            group: entry.number("group")?.unwrap_or_default(),
            color,
            contact: contact::of_geom(entry)?,
            shape,
            material,
        })
    }

    pub(super) fn is_shown(&self) -> bool {
        self.group <= SHOWN_GROUPS
    }

    pub(super) fn touches(&self) -> bool {
        (self.contact.contype, self.contact.conaffinity) != (0, 0)
    }

    /// The shape as a model holds it, if it does.
    pub(super) fn geometry(&self) -> Option<&Geometry> {
        match &self.shape {
            Shape::Simple(geometry) => Some(geometry),
            Shape::Mesh(mesh) => Some(&mesh.geometry),
            _ => None,
        }
    }
}

/// The two ends that a shape reaches from and to.
#[derive(Clone, Copy)]
pub(super) struct Ends {
    pub(super) X: Transform<f64>,
    /// Half of the distance, m.
    half: f64,
}

fn ends_of(entry: &Entry<'_, '_>, kind: Kind) -> Result<Option<Ends>, LoadError> {
    let ends = ends(entry)?;
    if ends.is_some()
        && !matches!(
            kind,
            Kind::Capsule | Kind::Cylinder | Kind::Box | Kind::Ellipsoid
        )
    {
        let reason = "is for capsules, cylinders, boxes and ellipsoids";
        return Err(entry.malformed("fromto", reason));
    }
    Ok(ends)
}

/// The ends that an element states, if it does: its place is between them, its z axis points from the second to the first.
pub(super) fn ends(entry: &Entry<'_, '_>) -> Result<Option<Ends>, LoadError> {
    let Some(numbers) = entry.numbers::<6>("fromto")? else {
        return Ok(None);
    };
    let [from, to] = [&numbers[..3], &numbers[3..]].map_each(Vector3::from_column_slice);
    let z = direction(&(from - to));
    let z = z.ok_or_else(|| entry.malformed("fromto", "both ends are the same"))?;
    Ok(Some(Ends {
        X: Transform::new(from_z(&z), (from + to) / 2.0),
        half: (from - to).norm() / 2.0,
    }))
}

fn shape(
    entry: &Entry<'_, '_>,
    kind: Kind,
    half: Option<f64>,
    assets: &Assets,
) -> Result<Shape, LoadError> {
    let size = entry.list("size", 3)?.unwrap_or_default();
    let positive = |i: usize| match size.get(i) {
        Some(&x) if x > 0.0 => Ok(x),
        Some(_) => Err(entry.malformed("size", "a length is not positive")),
        None => Err(entry.malformed("size", "has too few numbers for the type")),
    };
    if !matches!(kind, Kind::Mesh | Kind::Distance) && entry.text("mesh").is_some() {
        let reason = "a primitive that is fitted to a mesh is not modelled";
        return Ok(Shape::None(reason.into()));
    }
    // With two ends, their distance is the length along z; one given number makes the cross-section square.
    let along = |i: usize| half.map_or_else(|| positive(i), Ok);
    let across = || match half {
        Some(_) if size.len() < 2 => positive(0),
        _ => positive(1),
    };
    Ok(match kind {
        Kind::Plane => Shape::Plane,
        Kind::HeightField => {
            let names = ["hfield", "height field"];
            return of_asset(entry, names, |name| assets.heights_of(name), Shape::Heights);
        }
        Kind::Distance => Shape::None("signed distance fields are not read".into()),
        Kind::Mesh => {
            return of_asset(entry, ["mesh"; 2], |name| assets.mesh_of(name), Shape::Mesh);
        }
        Kind::Sphere => Shape::Simple(Geometry::Sphere {
            radius: positive(0)?,
        }),
        Kind::Capsule => Shape::Simple(Geometry::Capsule {
            radius: positive(0)?,
            length: 2.0 * along(1)?,
        }),
        Kind::Cylinder => Shape::Simple(Geometry::Cylinder {
            radius: positive(0)?,
            length: 2.0 * along(1)?,
        }),
        Kind::Box => Shape::Simple(Geometry::Box {
            size: [positive(0)?, across()?, along(2)?].map_each(|half| 2.0 * half),
        }),
        Kind::Ellipsoid => Shape::Simple(Geometry::Ellipsoid {
            size: [positive(0)?, across()?, along(2)?].map_each(|half| 2.0 * half),
        }),
    })
}

/// The shape of an asset that an attribute of the geom names.
fn of_asset<'a, A: Clone + 'a>(
    entry: &Entry<'_, '_>,
    [attribute, kind]: [&'static str; 2],
    find: impl FnOnce(&str) -> Option<Result<&'a A, &'a str>>,
    shape: impl FnOnce(A) -> Shape,
) -> Result<Shape, LoadError> {
    let name = entry.text(attribute);
    let name = name.ok_or_else(|| entry.missing(attribute))?;
    match find(name) {
        Some(Ok(asset)) => Ok(shape(asset.clone())),
        Some(Err(reason)) => Ok(Shape::None(format!("the {kind} \"{name}\" {reason}"))),
        None => Err(entry.malformed(attribute, &format!("there is no {kind} of that name"))),
    }
}
