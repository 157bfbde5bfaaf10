//! Poses, inertias and shapes from Python.

use std::path::PathBuf;

use dualbody::model::{Geometry, Mass, UpAxis};
use dualbody::spatial::{Inertia, Symmetric3, Transform};
use nalgebra::{Matrix3, Vector3};

use crate::prelude::*;

/// A pose from a matrix [[R, p], [0, 1]], or from a translation.
pub(crate) fn read_pose(name: &'static str, value: &Bound<'_, PyAny>) -> PyResult<Transform<f64>> {
    use numpy::{PyArrayMethods, PyUntypedArrayMethods};
    let array = numbers(name, value)?;
    // SAFETY: the array is in C order, and its numbers are copied before Python goes on.
    let x = unsafe { array.as_slice().unwrap_or(&[]) };
    match array.shape() {
        [3] => Ok(Transform::from_translation(Vector3::new(x[0], x[1], x[2]))),
        [4, 4] => {
            let rotation = Matrix3::from_fn(|i, j| x[4 * i + j]);
            let off = (rotation.transpose() * rotation - Matrix3::identity()).norm();
            if !(off < 1e-6 && rotation.determinant() > 0.0) {
                refuse!("{name}[:3, :3] is not a rotation");
            }
            Ok(Transform::new(rotation, Vector3::new(x[3], x[7], x[11])))
        }
        shape => Err(shape_error(
            name,
            shape,
            "(4, 4), or (3,) for a translation",
        )),
    }
}

/// An inertia from mass, centre of mass in the link frame and the matrix about the centre of mass.
pub(super) fn inertia_of(mass: f64, com: [f64; 3], about_com: [[f64; 3]; 3]) -> Inertia<f64> {
    let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = about_com;
    Inertia::from_com(mass, &com.into(), &Symmetric3::new(xx, xy, xz, yy, yz, zz))
}

/// A shape of Python.
pub(crate) fn read_geometry(shape: &Bound<'_, PyAny>) -> PyResult<Geometry> {
    let read = |name: &str| shape.getattr(name);
    Ok(match kind_of(shape)?.as_str() {
        "Box" => Geometry::Box {
            size: read_numbers("size", shape)?,
        },
        "Ellipsoid" => Geometry::Ellipsoid {
            size: read_numbers("size", shape)?,
        },
        "Sphere" => Geometry::Sphere {
            radius: read("radius")?.extract()?,
        },
        "Mesh" => {
            let uri: String = read("path")?.extract()?;
            Geometry::Mesh {
                path: Some(PathBuf::from(&uri)).filter(|path| path.exists()),
                uri,
                scale: read_numbers("scale", shape)?,
                up_axis: UpAxis::Auto,
            }
        }
        kind => {
            let (radius, length) = (read("radius")?.extract()?, read("length")?.extract()?);
            match kind {
                "Cylinder" => Geometry::Cylinder { radius, length },
                _ => Geometry::Capsule { radius, length },
            }
        }
    })
}

functions! {
    /// Matrix of inertia of a solid shape about its centre.
    fn _solid_inertia(shape, mass: f64) -> PyResult<((f64, f64, f64), (f64, f64, f64), (f64, f64, f64))> {
        let inertia = read_geometry(shape)?.inertia(Mass::Kilograms(mass));
        let m = inertia.ok_or_else(|| value_error("a mesh is no solid of a known inertia"))?.to_matrix();
        let row = |k: usize| (m[(k, 3)], m[(k, 4)], m[(k, 5)]);
        Ok((row(3), row(4), row(5)))
    }
}
