//! Geoms: shapes that have mass, are shown and touch.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::assets::{Assets, MeshAsset};
use super::compiler::Compiler;
use super::contact;
use super::entry::Entry;
use super::orientation::{direction, from_z, pose};
use super::scene::MjcfGeom;
use super::solids::{self, Distribution};
use crate::error::LoadError;
use crate::model::Geometry;
use crate::spatial::{Inertia, Symmetric3, Transform};

/// Density where nothing else is said, kg/m³: water.
const DENSITY: f64 = 1000.0;

/// Groups up to this one are shown where nothing else is said.
const SHOWN_GROUPS: f64 = 2.0;

/// Shapes that a geom can have.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    Simple(Geometry),
    Mesh(MeshAsset),
    /// Half axes, m.
    Ellipsoid([f64; 3]),
    Plane,
    /// One that cannot be had, with why.
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
    /// Pose in what it stands in.
    pub(super) X: Transform<f64>,
    pub(super) shape: Shape,
    /// Inertia in what it stands in; zero where it has none.
    pub(super) inertia: Inertia<f64>,
    pub(super) group: f64,
    pub(super) color: Option<[f64; 4]>,
    pub(super) contact: MjcfGeom,
    /// Why its mass cannot be found, if it cannot.
    pub(super) remark: Option<String>,
}

impl Geom {
    /// Reads a geom.
    pub(super) fn read(
        entry: &Entry<'_, '_>,
        compiler: &Compiler,
        assets: &Assets,
    ) -> Result<Self, LoadError> {
        let kind = entry.word("type", &KINDS)?.unwrap_or(Kind::Sphere);
        let ends = ends(entry, kind)?;
        let X = match ends {
            Some(ends) => ends.X,
            None => pose(entry, compiler)?,
        };
        let shape = shape(entry, kind, ends.map(|ends| ends.half), assets)?;
        let material = entry.text("material");
        let color = entry.numbers::<4>("rgba")?;
        let color = color.or_else(|| assets.color(material?));
        let (own, remark) = inertia(entry, &shape)?;
        // The frame of a mesh is that of its file, seen from a reference in it.
        let X_FM = match &shape {
            Shape::Mesh(mesh) => mesh.X_FM.inverse(),
            _ => Transform::identity(),
        };
        let X = X * X_FM;
        Ok(Self {
            X,
            inertia: X.inertia(&own),
            group: entry.number("group")?.unwrap_or_default(),
            color,
            contact: contact::of_geom(entry)?,
            shape,
            remark,
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
struct Ends {
    X: Transform<f64>,
    /// Half of the distance, m.
    half: f64,
}

fn ends(entry: &Entry<'_, '_>, kind: Kind) -> Result<Option<Ends>, LoadError> {
    let Some(numbers) = entry.numbers::<6>("fromto")? else {
        return Ok(None);
    };
    if !matches!(
        kind,
        Kind::Capsule | Kind::Cylinder | Kind::Box | Kind::Ellipsoid
    ) {
        let reason = "is for capsules, cylinders, boxes and ellipsoids";
        return Err(entry.malformed("fromto", reason));
    }
    let [from, to] = [&numbers[..3], &numbers[3..]].map(Vector3::from_column_slice);
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
    // With two ends the length along z is theirs, and what lies across is square where one number is given.
    let along = |i: usize| half.map_or_else(|| positive(i), Ok);
    let across = || match half {
        Some(_) if size.len() < 2 => positive(0),
        _ => positive(1),
    };
    Ok(match kind {
        Kind::Plane => Shape::Plane,
        Kind::HeightField => Shape::None("height fields are not read".into()),
        Kind::Distance => Shape::None("signed distance fields are not read".into()),
        Kind::Mesh => return mesh(entry, assets),
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
            size: [positive(0)?, across()?, along(2)?].map(|half| 2.0 * half),
        }),
        Kind::Ellipsoid => Shape::Ellipsoid([positive(0)?, across()?, along(2)?]),
    })
}

fn mesh(entry: &Entry<'_, '_>, assets: &Assets) -> Result<Shape, LoadError> {
    let name = entry.text("mesh").ok_or_else(|| entry.missing("mesh"))?;
    match assets.mesh_of(name) {
        Some(Ok(mesh)) => Ok(Shape::Mesh(mesh.clone())),
        Some(Err(reason)) => Ok(Shape::None(format!("the mesh \"{name}\" {reason}"))),
        None => Err(entry.malformed("mesh", "there is no mesh of that name")),
    }
}

/// The inertia of a shape in its own frame, or why it is not known.
fn inertia(
    entry: &Entry<'_, '_>,
    shape: &Shape,
) -> Result<(Inertia<f64>, Option<String>), LoadError> {
    let density = entry.number("density")?.unwrap_or(DENSITY);
    let mass = entry.number("mass")?;
    let is_shell = entry.flag("shellinertia", false)?;
    if mass.unwrap_or(density) < 0.0 {
        let name = if mass.is_some() { "mass" } else { "density" };
        return Err(entry.malformed(name, "is negative"));
    }
    let distribution = match shape {
        Shape::Simple(geometry) if is_shell => solids::shell(geometry),
        Shape::Simple(geometry) => solids::solid(geometry),
        Shape::Ellipsoid(half) if is_shell => Some(solids::ellipsoid_shell(*half)),
        Shape::Ellipsoid(half) => Some(solids::ellipsoid(*half)),
        Shape::Mesh(mesh) if mass.unwrap_or(density) > 0.0 => {
            return Ok(
                match mesh_inertia(mesh, [mass.unwrap_or(-1.0), density], is_shell) {
                    Ok(inertia) => (inertia, None),
                    Err(reason) => (Inertia::zero(), Some(reason)),
                },
            );
        }
        _ => None,
    };
    let own = distribution.map(|Distribution { measure, moments }| {
        let mass = mass.unwrap_or(density * measure);
        let moments = Symmetric3::diagonal(&Vector3::from(moments)).to_matrix() * mass;
        let moments = Symmetric3::diagonal(&moments.diagonal());
        Inertia::from_com(mass, &Vector3::zeros(), &moments)
    });
    Ok((own.unwrap_or_else(Inertia::zero), None))
}

/// The inertia of the inside of a mesh, of a mass if that is not negative, or else of a density.
fn mesh_inertia(
    mesh: &MeshAsset,
    [mass, density]: [f64; 2],
    is_shell: bool,
) -> Result<Inertia<f64>, String> {
    if is_shell || mesh.is_shell {
        return Err("shells of meshes have no mass here: give the body an <inertial>".into());
    }
    let Geometry::Mesh { uri, .. } = &mesh.geometry else {
        return Ok(Inertia::zero());
    };
    let of_file = |reason: String| {
        format!(
            "the mesh \"{uri}\" {reason}, so that it has no mass here: give the body an <inertial>"
        )
    };
    let solid = mesh.solid().map_err(of_file)?;
    if solid.mass <= 0.0 {
        return Err(of_file("has no volume".into()));
    }
    let factor = if mass < 0.0 {
        density
    } else {
        mass / solid.mass
    };
    Ok(solid.scaled(factor))
}
