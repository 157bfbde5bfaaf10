//! Distances between links.

use std::cell::RefCell;

use dualbody::contact::{LinkShapes, Nearest, NearestError};
use numpy::PyArrayMethods;
use pyo3::prelude::*;

use crate::arrays::{read_vector, vector};
use crate::errors::{OrRaise, Raise, value_error};
use crate::model::PyModel;
use crate::scratch::find_or_make;

thread_local! {
    /// Shapes of models, with the identities of these: to read meshes takes long.
    static SHAPES: RefCell<Vec<(u64, LinkShapes)>> = const { RefCell::new(Vec::new()) };
}

impl Raise for NearestError {
    fn raise(self) -> PyErr {
        match self {
            Self::UnknownName(unknown) => unknown.raise(),
            other => value_error(other),
        }
    }
}

/// Distance, points (2, 3), normal (3,) and gradient (nv,) of two links, by the nearest of their collision shapes.
#[pyfunction]
pub(crate) fn _nearest<'py>(
    model: &Bound<'py, PyModel>,
    q: &Bound<'py, PyAny>,
    first: &str,
    second: &str,
) -> PyResult<(f64, Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let (py, own) = (model.py(), model.get());
    let m = &*own.model;
    let q = read_vector("q", q, Some(m.nq()))?;
    let near = SHAPES.with_borrow_mut(|all| {
        let make = || Ok::<_, PyErr>((own.id, LinkShapes::new(m)));
        let (_, shapes) = find_or_make(all, |(id, _)| *id == own.id, make)?;
        shapes.nearest(m, &q, first, second).or_raise()
    })?;
    let Nearest {
        distance,
        points: [a, b],
        normal,
        gradient,
        ..
    } = near;
    let points = vector(py, [a.x, a.y, a.z, b.x, b.y, b.z].to_vec());
    Ok((
        distance,
        points.reshape([2, 3])?.into_any(),
        vector(py, vec![normal.x, normal.y, normal.z]).into_any(),
        vector(py, gradient.as_slice().to_vec()).into_any(),
    ))
}
