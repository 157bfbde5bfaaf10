//! Distances between links.

use std::sync::Arc;

use dualbody::contact::LinkShapes;

use crate::prelude::*;

/// Shapes of a model, which are kept: to read meshes takes long.
fn shapes_of(own: &PyModel) -> Arc<LinkShapes> {
    let make = || Arc::new(LinkShapes::new(&own.model));
    with_kept(own.id, make, |shapes| shapes.clone())
}

/// Results of `_nearest`, one array each.
type Arrays<'py> = [Array<'py>; 4];

/// Shapes of a model with a width of smoothing, m.
fn smoothed(own: &PyModel, smoothing: f64) -> PyResult<Arc<LinkShapes>> {
    let shapes = shapes_of(own);
    if smoothing == 0.0 {
        return Ok(shapes);
    }
    guarded(|| Arc::new(LinkShapes::clone(&shapes).with_smoothing(smoothing)))
}

functions! {
    /// Distance, points (2, 3), normal (3,) and gradient (nv,) of two links, by the nearest of their collision shapes; with the axes of a batch first.
    fn _nearest(model: &Bound<'py, PyModel>, q, first: &str, second: &str, smoothing: f64) -> PyResult<Arrays<'py>> {
        let (py, own) = (model.py(), model.get());
        let (m, shapes) = (&*own.model, smoothed(own, smoothing)?);
        let q = Rows::read(&argument("q", q, &[m.nq()]))?;
        let tails: [&[usize]; 4] = [&[], &[2, 3], &[3], &[m.nv()]];
        let arrays = tails.map(|tail| room(py, &[q.batch(), tail].concat()));
        let [distance, points, normal, gradient] = arrays;
        let arrays = [distance?, points?, normal?, gradient?];
        let mut out: Vec<&mut [f64]> = arrays.iter().map(numbers_mut).collect();
        let (count, rows) = (q.batch().iter().product(), q.as_slice());
        py.detach(|| {
            in_rows(count, &[1, 6, 3, m.nv()], &mut out, &|k, row| {
                let q = &rows[k * m.nq()..(k + 1) * m.nq()];
                let near = shapes.nearest(m, q, first, second).or_raise()?;
                let [a, b] = near.points;
                let numbers = [near.distance].into_iter().chain(a.into_iter().copied());
                let numbers = numbers.chain(b.into_iter().copied());
                let numbers = numbers.chain(near.normal.into_iter().copied());
                let numbers = numbers.chain(near.gradient.iter().copied());
                row.iter_mut().zip(numbers).for_each(|(out, x)| *out = x);
                Ok(())
            })
        })?;
        Ok(arrays)
    }
}
