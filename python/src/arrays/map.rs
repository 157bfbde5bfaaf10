//! Functions of rows, of one state and of batches on lanes and cores.

use dualbody::Model;
use dualbody_python_table::Memory as Of;
use pyo3::prelude::*;
use rayon::prelude::*;

use super::Array;
use super::output::{numbers_mut, output};
use super::rows::{Argument, Rows, View, common_batch};
use crate::errors::{about_base, guarded};
use crate::scratch::{Memory, with_kept};
use crate::threads::{install, pool};

/// Number of states that are computed side by side.
pub(crate) const WIDTH: usize = dualbody::sim::BATCH_WIDTH;

/// So many states in vector registers.
pub(crate) type Wide = dualbody::sim::BatchScalar;

/// Batches of fewer rows stay on one thread and keep the interpreter lock.
const FEW: usize = 64;

/// Groups of lanes that one thread takes at a time.
const GROUPS: usize = 4;

/// Largest number of arguments of a function on rows.
const MOST: usize = 6;

/// Fewest rows at the end of a batch that go into lanes together; fewer are computed one by one.
const WORTHWHILE: usize = 3;

/// A function of rows: of one state, and of as many as there are lanes if that exists.
#[derive(Clone, Copy)]
pub(crate) struct Work<'a> {
    pub(crate) one: &'a (dyn Fn(&mut Of<f64>, &[&[f64]], &mut [f64]) + Sync),
    pub(crate) wide: Option<&'a (dyn Fn(&mut Of<Wide>, &[&[Wide]], &mut [Wide]) + Sync)>,
}

/// Applies a function to every row of the arguments, on lanes and cores for batches.
///
/// * `tail` – shape of the result of one row
pub(crate) fn map_rows<'py>(
    py: Python<'py>,
    model: (&Model, u64),
    arguments: &[Argument<'_, 'py>],
    tail: &[usize],
    out: Option<&Bound<'py, PyAny>>,
    work: Work<'_>,
) -> PyResult<Array<'py>> {
    let explained = |error| about_base(py, model.0, error);
    if let Some(array) = map_one(py, model, arguments, tail, out, work).map_err(explained)? {
        return Ok(array);
    }
    let rows: PyResult<Vec<Rows<'py>>> = arguments.iter().map(Rows::read).collect();
    let rows = rows.map_err(explained)?;
    let (batch, shape) = shapes(arguments, &rows, tail)?;
    let array = output(py, out, &shape, rows.iter())?;
    let views: Vec<View<'_>> = rows.iter().map(Rows::view).collect();
    let out = numbers_mut(&array);
    match batch < FEW {
        true => map_views(model, &views, batch, work, out)?,
        false => py.detach(|| map_views(model, &views, batch, work, out))?,
    }
    Ok(array)
}

/// [`map_rows`] of a function of rows that needs no working memory.
pub(crate) fn map_plain<'py>(
    model: (&Model, u64),
    arguments: &[Argument<'_, 'py>],
    tail: &[usize],
    one: &(dyn Fn(&[&[f64]], &mut [f64]) + Sync),
) -> PyResult<Array<'py>> {
    let work = Work {
        one: &|_, x, out| one(x, out),
        wide: None,
    };
    let py = arguments[0].value.py();
    map_rows(py, model, arguments, tail, None, work)
}

/// Applies a function to so many rows, on lanes and for large batches on cores; the interpreter lock is not needed.
pub(crate) fn map_views(
    model: (&Model, u64),
    views: &[View<'_>],
    count: usize,
    work: Work<'_>,
    out: &mut [f64],
) -> PyResult<()> {
    let batch = Batch {
        model,
        views,
        work,
        width: out.len().checked_div(count).unwrap_or(0),
    };
    if count == 1 {
        return guarded(|| batch.each_row(0, out));
    }
    if count < FEW {
        return guarded(|| batch.each_group(0, out));
    }
    let (pool, length) = (pool()?, GROUPS * WIDTH);
    let spread = || {
        let parts = out
            .par_chunks_mut((length * batch.width).max(1))
            .enumerate();
        parts.for_each(|(k, out)| batch.each_group(k * length, out));
    };
    guarded(|| install(&pool, spread))
}

/// Fills rows of several results one by one, on cores for large batches; the interpreter lock is not needed.
///
/// * `widths` – lengths of the rows of each result
/// * `one` – writes the k-th rows of all results, one after the other
pub(crate) fn in_rows(
    count: usize,
    widths: &[usize],
    out: &mut [&mut [f64]],
    one: &(dyn Fn(usize, &mut [f64]) -> PyResult<()> + Sync),
) -> PyResult<()> {
    let width: usize = widths.iter().sum();
    let mut rows = vec![0.0; count * width];
    match count {
        0 => return Ok(()),
        1 => guarded(|| one(0, &mut rows))??,
        _ => {
            let (pool, all) = (pool()?, rows.par_chunks_mut(width.max(1)).enumerate());
            let spread = || all.try_for_each(|(k, row)| one(k, row));
            guarded(|| install(&pool, spread))??;
        }
    }
    for (k, mut rest) in rows.chunks(width.max(1)).enumerate() {
        for (out, &own) in out.iter_mut().zip(widths) {
            let (first, others) = rest.split_at(own);
            out[k * own..(k + 1) * own].copy_from_slice(first);
            rest = others;
        }
    }
    Ok(())
}

/// [`map_rows`] for one state, without memory besides the result; `None` if an argument is a batch.
fn map_one<'py>(
    py: Python<'py>,
    model: (&Model, u64),
    arguments: &[Argument<'_, 'py>],
    tail: &[usize],
    out: Option<&Bound<'py, PyAny>>,
    work: Work<'_>,
) -> PyResult<Option<Array<'py>>> {
    let mut rows: [Option<Rows<'py>>; MOST] = [const { None }; MOST];
    for (rows, argument) in rows.iter_mut().zip(arguments) {
        let own = Rows::read(argument)?;
        if own.lead > 0 {
            return Ok(None);
        }
        *rows = Some(own);
    }
    let array = output(py, out, tail, rows.iter().flatten())?;
    let mut x: [&[f64]; MOST] = [&[]; MOST];
    for (x, rows) in x.iter_mut().zip(rows.iter().flatten()) {
        *x = rows.as_slice();
    }
    let x = &x[..arguments.len()];
    guarded(|| {
        with_memory(model, |memory| {
            (work.one)(&mut memory.one, x, numbers_mut(&array))
        })
    })?;
    Ok(Some(array))
}

/// Number of rows, and shape of the result.
fn shapes(
    arguments: &[Argument<'_, '_>],
    rows: &[Rows<'_>],
    tail: &[usize],
) -> PyResult<(usize, Vec<usize>)> {
    let names = arguments.iter().map(|argument| argument.name);
    let batch = common_batch(names.zip(rows.iter().map(Rows::batch)))?;
    let shape = [batch.as_slice(), tail].concat();
    Ok((batch.iter().product(), shape))
}

/// Runs work with this thread's memory for a model.
pub(crate) fn with_memory<R>((model, id): (&Model, u64), work: impl FnOnce(&mut Memory) -> R) -> R {
    with_kept(id, || Memory::new(model), work)
}

/// Rows of arguments, and the function of them.
struct Batch<'a> {
    model: (&'a Model, u64),
    views: &'a [View<'a>],
    work: Work<'a>,
    /// Numbers of a row of the result.
    width: usize,
}

impl Batch<'_> {
    /// Fills rows of the result, from this one on, one by one.
    fn each_row(&self, first: usize, out: &mut [f64]) {
        with_memory(self.model, |memory| {
            let mut x: [&[f64]; MOST] = [&[]; MOST];
            let x = &mut x[..self.views.len()];
            // Results without numbers are none.
            for (k, out) in out.chunks_exact_mut(self.width.max(1)).enumerate() {
                for (x, view) in x.iter_mut().zip(self.views) {
                    *x = view.row(first + k);
                }
                (self.work.one)(&mut memory.one, x, out);
            }
        });
    }

    /// [`Self::each_row`] on lanes.
    fn each_group(&self, first: usize, out: &mut [f64]) {
        let (views, width) = (self.views, self.width);
        let Some(wide) = self.work.wide else {
            return self.each_row(first, out);
        };
        let lanes = views.iter().map(|view| vec![Wide::default(); view.width]);
        let mut lanes: Vec<Vec<Wide>> = lanes.collect();
        let mut result = vec![Wide::default(); width];
        let mut done = first;
        for group in out.chunks_mut((WIDTH * width).max(1)) {
            let count = group.len() / width.max(1);
            if count < WORTHWHILE {
                self.each_row(done, group);
                continue;
            }
            for (lanes, view) in lanes.iter_mut().zip(views) {
                let rows: [&[f64]; WIDTH] =
                    std::array::from_fn(|i| view.row(done + i.min(count - 1)));
                for (j, x) in lanes.iter_mut().enumerate() {
                    x.0 = std::array::from_fn(|i| rows[i][j]);
                }
            }
            let mut x: [&[Wide]; MOST] = [&[]; MOST];
            for (x, lanes) in x.iter_mut().zip(&lanes) {
                *x = lanes;
            }
            with_memory(self.model, |memory| {
                wide(&mut memory.wide, &x[..views.len()], &mut result)
            });
            for (i, row) in group.chunks_mut(width.max(1)).enumerate() {
                let numbers = row.iter_mut().zip(&result);
                numbers.for_each(|(out, x)| *out = x.0[i]);
            }
            done += count;
        }
    }
}
