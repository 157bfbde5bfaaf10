//! Inertias as the file states them, and what the compiler makes of them.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{Matrix3, Vector3};

use super::compiler::Compiler;
use super::entry::Entry;
use super::orientation::{orientation, pose};
use crate::error::LoadError;
use crate::linalg::symmetric_eigen3;
use crate::spatial::{Inertia, Symmetric3, Transform};

/// Reads an `<inertial>`: the inertia in its parent.
pub(super) fn read(entry: &Entry<'_, '_>, compiler: &Compiler) -> Result<Inertia<f64>, LoadError> {
    let mass = entry.number("mass")?.ok_or_else(|| entry.missing("mass"))?;
    let X = pose(entry, compiler)?;
    let full = entry.numbers::<6>("fullinertia")?;
    let diagonal = entry.numbers::<3>("diaginertia")?;
    let moments = match (full, diagonal) {
        (Some(_), Some(_)) => {
            let reason = "is given together with diaginertia: give one of the two";
            return Err(entry.malformed("fullinertia", reason));
        }
        (Some(_), None) if orientation(entry, compiler)?.is_some() => {
            let reason = "is given together with an orientation: its axes are those of the body";
            return Err(entry.malformed("fullinertia", reason));
        }
        (Some([xx, yy, zz, xy, xz, yz]), None) => Symmetric3::new(xx, xy, xz, yy, yz, zz),
        (None, diagonal) => Symmetric3::diagonal(&diagonal.unwrap_or_default().into()),
    };
    let own = Inertia::from_com(mass, &Vector3::zeros(), &moments);
    Ok(X.inertia(&own))
}

/// Raises mass and moments to the bounds of the compiler, and balances moments that no body can have.
pub(super) fn bounded(inertia: Inertia<f64>, compiler: &Compiler) -> Inertia<f64> {
    let least = [compiler.boundmass, compiler.boundinertia];
    if least == [0.0; 2] && !compiler.balanceinertia {
        return inertia;
    }
    let com = match inertia.mass {
        0.0 => Vector3::zeros(),
        _ => inertia.com(),
    };
    let mass = inertia.mass.max(least[0]);
    let about_com = Transform::from_translation(-com)
        .inertia(&inertia)
        .rotational;
    Inertia::from_com(mass, &com, &bounded_moments(about_com, compiler))
}

fn bounded_moments(moments: Symmetric3<f64>, compiler: &Compiler) -> Symmetric3<f64> {
    let matrix = moments.to_matrix();
    let size = matrix.amax();
    if !size.is_finite() {
        return moments;
    }
    let scaled = match size {
        0.0 => matrix,
        _ => matrix / size,
    };
    let Some((values, R)) = symmetric_eigen3(&scaled) else {
        return moments;
    };
    let mut principal = (values * size).map(|x| x.max(compiler.boundinertia));
    let is_impossible = 2.0 * principal.max() > principal.sum();
    if compiler.balanceinertia && is_impossible {
        principal = Vector3::repeat(principal.mean());
    }
    if principal == values * size {
        return moments;
    }
    let bounded: Matrix3<f64> = R * Matrix3::from_diagonal(&principal) * R.transpose();
    let at = |i: usize, j: usize| bounded[(i, j)];
    Symmetric3::new(at(0, 0), at(0, 1), at(0, 2), at(1, 1), at(1, 2), at(2, 2))
}
