//! Arrays of numbers: shapes, batches, results.
//!
//! A vector argument of length n has the shape (…, n); what stands before n is the batch. Arguments without a batch are used for all of it.

use std::cell::RefCell;

use dualbody::Model;
use nalgebra::DMatrix;
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use rayon::prelude::*;

use crate::errors::{guarded, type_error, value_error};
use crate::scratch::Memory;
use crate::threads::on_pool;

/// Number of states that are computed side by side.
pub(crate) const WIDTH: usize = dualbody::sim::BATCH_WIDTH;
/// So many states in vector registers.
pub(crate) type Wide = dualbody::sim::BatchScalar;

pub(crate) type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

/// Batches of fewer rows stay on one thread and keep the interpreter lock.
const FEW: usize = 64;
/// Groups of lanes that one thread takes at a time.
const GROUPS: usize = 4;
/// Largest number of arguments of a function on rows.
const MOST: usize = 6;
/// Fewest rows at the end of a batch that go into lanes together; fewer are computed one by one.
const WORTHWHILE: usize = 3;

/// An argument with its name and the shape of one row.
pub(crate) struct Argument<'a, 'py> {
    pub(crate) name: &'static str,
    pub(crate) value: &'a Bound<'py, PyAny>,
    pub(crate) tail: &'a [usize],
}

pub(crate) fn argument<'a, 'py>(
    name: &'static str,
    value: &'a Bound<'py, PyAny>,
    tail: &'a [usize],
) -> Argument<'a, 'py> {
    Argument { name, value, tail }
}

/// An array of numbers in C order that was read from an argument.
pub(crate) struct Rows<'py> {
    array: Array<'py>,
    /// Length of a row.
    width: usize,
    /// Number of axes of the batch.
    lead: usize,
}

impl<'py> Rows<'py> {
    /// Reads an argument, without a copy if it holds `float64` in C order.
    pub(crate) fn read(argument: &Argument<'_, 'py>) -> PyResult<Self> {
        let array = numbers(argument.name, argument.value)?;
        let (shape, tail) = (array.shape(), argument.tail);
        let Some(lead) = shape.len().checked_sub(tail.len()) else {
            return Err(wrong_shape(argument, shape));
        };
        if shape[lead..] != *tail {
            return Err(wrong_shape(argument, shape));
        }
        Ok(Self {
            width: tail.iter().product(),
            lead,
            array,
        })
    }

    pub(crate) fn into_array(self) -> Array<'py> {
        self.array
    }

    /// The shape of the batch.
    pub(crate) fn batch(&self) -> &[usize] {
        &self.array.shape()[..self.lead]
    }

    pub(crate) fn as_slice(&self) -> &[f64] {
        // SAFETY: the array is aligned and in C order, and alive as long as `self`. As for every function of NumPy that releases the
        // interpreter lock, it is the caller's part not to write to an argument from another thread meanwhile.
        unsafe { self.array.as_slice().unwrap_or(&[]) }
    }

    fn view(&self) -> View<'_> {
        View {
            numbers: self.as_slice(),
            width: self.width,
            single: self.lead == 0,
        }
    }
}

/// The numbers of an argument, row by row.
#[derive(Clone, Copy)]
struct View<'a> {
    numbers: &'a [f64],
    width: usize,
    single: bool,
}

impl<'a> View<'a> {
    fn row(&self, k: usize) -> &'a [f64] {
        let k = if self.single { 0 } else { k };
        &self.numbers[k * self.width..(k + 1) * self.width]
    }
}

fn wrong_shape(argument: &Argument<'_, '_>, shape: &[usize]) -> PyErr {
    let (name, tail) = (argument.name, argument.tail);
    let tail: Vec<String> = tail.iter().map(ToString::to_string).collect();
    value_error(format_args!(
        "{name} has the shape {shape:?}, expected (…, {})",
        tail.join(", ")
    ))
}

/// An array of `float64` in C order: the argument itself, or a copy.
pub(crate) fn numbers<'py>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<Array<'py>> {
    if let Ok(array) = value.cast::<PyArrayDyn<f64>>()
        && array.is_c_contiguous()
        && array.is_aligned()
    {
        return Ok(array.clone());
    }
    converted(name, value)
}

static CONVERT: PyOnceLock<Py<PyAny>> = PyOnceLock::new();

#[cold]
fn converted<'py>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<Array<'py>> {
    let py = value.py();
    let convert = CONVERT.import(py, "dualbody._convert", "numbers")?;
    Ok(convert
        .call1((name, value))?
        .cast_into::<PyArrayDyn<f64>>()?)
}

/// A new array whose numbers are not set.
pub(crate) fn empty<'py>(py: Python<'py>, shape: &[usize]) -> Array<'py> {
    // SAFETY: the numbers are plain `f64`; who asks for the array sets them before Python sees it.
    unsafe { PyArrayDyn::new(py, shape, false) }
}

/// The numbers of an array that this call made or was given as output.
#[expect(clippy::mut_from_ref, reason = "NumPy's arrays are shared by nature")]
pub(crate) fn numbers_mut<'a>(array: &'a Array<'_>) -> &'a mut [f64] {
    // SAFETY: the array is in C order and aligned; it is new, or an output that does not overlap the arguments.
    unsafe { array.as_slice_mut().unwrap_or(&mut []) }
}

/// The array for a result: that of the caller, or a new one.
fn output<'a, 'py: 'a>(
    py: Python<'py>,
    out: Option<&Bound<'py, PyAny>>,
    shape: &[usize],
    arguments: impl Iterator<Item = &'a Rows<'py>>,
) -> PyResult<Array<'py>> {
    let Some(out) = out else {
        return Ok(empty(py, shape));
    };
    let array = checked_output("out", out, shape)?;
    let range = |numbers: &[f64]| numbers.as_ptr_range();
    let own = range(numbers_mut(&array));
    for argument in arguments {
        let other = range(argument.as_slice());
        if own.start < other.end && other.start < own.end {
            return Err(value_error("out overlaps an argument"));
        }
    }
    Ok(array)
}

/// An array that a result can be written to.
pub(crate) fn checked_output<'py>(
    name: &str,
    out: &Bound<'py, PyAny>,
    shape: &[usize],
) -> PyResult<Array<'py>> {
    let array = out
        .cast::<PyArrayDyn<f64>>()
        .map_err(|_| type_error(format_args!("{name} is not an array of numpy.float64")))?;
    if array.shape() != shape {
        let given = array.shape();
        return Err(value_error(format_args!(
            "{name} has the shape {given:?}, expected {shape:?}"
        )));
    }
    // SAFETY: the pointer is that of a living array.
    let flags = unsafe { (*array.as_array_ptr()).fields.flags };
    let writeable = flags & numpy::npyffi::NPY_ARRAY_WRITEABLE != 0;
    if !(array.is_c_contiguous() && array.is_aligned() && writeable) {
        return Err(value_error(format_args!(
            "{name} is not a writeable array in C order"
        )));
    }
    Ok(array.clone())
}

/// A function of rows: of one state, and of as many as there are lanes if that exists.
#[derive(Clone, Copy)]
pub(crate) struct Work<'a> {
    pub(crate) one: &'a (dyn Fn(&mut Memory, &[&[f64]], &mut [f64]) + Sync),
    pub(crate) wide: Option<&'a (dyn Fn(&mut Memory, &[&[Wide]], &mut [Wide]) + Sync)>,
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
    if let Some(array) = map_one(py, model, arguments, tail, out, work)? {
        return Ok(array);
    }
    let rows: Vec<Rows<'py>> = arguments.iter().map(Rows::read).collect::<PyResult<_>>()?;
    let (batch, shape) = shapes(arguments, &rows, tail)?;
    let array = output(py, out, &shape, rows.iter())?;
    let views: Vec<View<'_>> = rows.iter().map(Rows::view).collect();
    let (count, width) = (batch, tail.iter().product::<usize>());
    let numbers = numbers_mut(&array);
    if count < FEW {
        guarded(|| each_group(model, &views, work, 0, width, numbers))?;
    } else {
        let length = GROUPS * WIDTH;
        on_pool(py, || {
            let parts = numbers.par_chunks_mut((length * width).max(1)).enumerate();
            parts.for_each(|(k, out)| each_group(model, &views, work, k * length, width, out));
        })?;
    }
    Ok(array)
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
    guarded(|| with_memory(model, |memory| (work.one)(memory, x, numbers_mut(&array))))?;
    Ok(Some(array))
}

/// Number of rows, and shape of the result.
fn shapes(
    arguments: &[Argument<'_, '_>],
    rows: &[Rows<'_>],
    tail: &[usize],
) -> PyResult<(usize, Vec<usize>)> {
    let first = rows.iter().position(|rows| rows.lead > 0);
    let batch = first.map_or(&[][..], |k| rows[k].batch());
    for (argument, rows) in arguments.iter().zip(rows) {
        if rows.lead > 0 && rows.batch() != batch {
            let (name, own) = (argument.name, rows.batch());
            let other = arguments[first.unwrap_or(0)].name;
            return Err(value_error(format_args!(
                "{name} is a batch of shape {own:?}, {other} one of shape {batch:?}"
            )));
        }
    }
    Ok((batch.iter().product(), [batch, tail].concat()))
}

thread_local! {
    static MEMORIES: RefCell<Vec<Memory>> = const { RefCell::new(Vec::new()) };
}

/// Working memory that a thread keeps, for as many models.
const KEPT: usize = 8;

/// Runs work with this thread's memory for a model, which is made at the first call.
fn with_memory<R>((model, id): (&Model, u64), work: impl FnOnce(&mut Memory) -> R) -> R {
    MEMORIES.with_borrow_mut(|all| {
        let at = match all.iter().position(|memory| memory.id() == id) {
            Some(at) => at,
            None => {
                if all.len() == KEPT {
                    all.remove(0);
                }
                all.push(Memory::new(model, id));
                all.len() - 1
            }
        };
        work(&mut all[at])
    })
}

fn each_row(
    model: (&Model, u64),
    views: &[View<'_>],
    work: Work<'_>,
    first: usize,
    width: usize,
    out: &mut [f64],
) {
    with_memory(model, |memory| {
        let mut x: [&[f64]; MOST] = [&[]; MOST];
        let x = &mut x[..views.len()];
        let count = out.len().checked_div(width).unwrap_or(0);
        for k in 0..count {
            for (x, view) in x.iter_mut().zip(views) {
                *x = view.row(first + k);
            }
            (work.one)(memory, x, &mut out[k * width..(k + 1) * width]);
        }
    });
}

fn each_group(
    model: (&Model, u64),
    views: &[View<'_>],
    work: Work<'_>,
    first: usize,
    width: usize,
    out: &mut [f64],
) {
    let Some(wide) = work.wide else {
        return each_row(model, views, work, first, width, out);
    };
    let mut lanes: Vec<Vec<Wide>> = views
        .iter()
        .map(|view| vec![Wide::default(); view.width])
        .collect();
    let mut result = vec![Wide::default(); width];
    let mut done = first;
    for group in out.chunks_mut((WIDTH * width).max(1)) {
        let count = group.len() / width.max(1);
        if count < WORTHWHILE {
            each_row(model, views, work, done, width, group);
            continue;
        }
        for (lanes, view) in lanes.iter_mut().zip(views) {
            let rows: [&[f64]; WIDTH] = std::array::from_fn(|i| view.row(done + i.min(count - 1)));
            for (j, x) in lanes.iter_mut().enumerate() {
                x.0 = std::array::from_fn(|i| rows[i][j]);
            }
        }
        let mut x: [&[Wide]; MOST] = [&[]; MOST];
        for (x, lanes) in x.iter_mut().zip(&lanes) {
            *x = lanes;
        }
        with_memory(model, |memory| wide(memory, &x[..views.len()], &mut result));
        for (i, row) in group.chunks_mut(width.max(1)).enumerate() {
            row.iter_mut()
                .zip(&result)
                .for_each(|(out, x)| *out = x.0[i]);
        }
        done += count;
    }
}

/// A vector as an array, in its own memory.
pub(crate) fn vector<'py>(py: Python<'py>, x: Vec<f64>) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_vec(py, x)
}

/// A matrix as an array.
pub(crate) fn matrix<'py>(py: Python<'py>, m: &DMatrix<f64>) -> Array<'py> {
    let array = empty(py, &[m.nrows(), m.ncols()]);
    write_matrix(m, numbers_mut(&array));
    array
}

/// Writes a matrix row by row.
pub(crate) fn write_matrix<T: Copy>(m: &DMatrix<T>, out: &mut [T])
where
    T: nalgebra::Scalar,
{
    let columns = m.ncols();
    for (j, column) in m.column_iter().enumerate() {
        for (i, &x) in column.iter().enumerate() {
            out[i * columns + j] = x;
        }
    }
}

/// A matrix from an array with two axes.
pub(crate) fn read_matrix(name: &'static str, value: &Bound<'_, PyAny>) -> PyResult<DMatrix<f64>> {
    let array = numbers(name, value)?;
    let &[rows, columns] = array.shape() else {
        let shape = array.shape();
        return Err(value_error(format_args!(
            "{name} has the shape {shape:?}, expected a matrix"
        )));
    };
    // SAFETY: as in `Rows::as_slice`; the numbers are copied at once.
    let numbers = unsafe { array.as_slice().unwrap_or(&[]) };
    Ok(DMatrix::from_row_slice(rows, columns, numbers))
}

/// A vector of a known length, or of any.
pub(crate) fn read_vector(
    name: &'static str,
    value: &Bound<'_, PyAny>,
    length: Option<usize>,
) -> PyResult<Vec<f64>> {
    let array = numbers(name, value)?;
    let shape = array.shape();
    if shape.len() != 1 || length.is_some_and(|length| shape[0] != length) {
        let expected = length.map_or("n".to_owned(), |length| length.to_string());
        return Err(value_error(format_args!(
            "{name} has the shape {shape:?}, expected ({expected},)"
        )));
    }
    // SAFETY: as in `Rows::as_slice`; the numbers are copied at once.
    Ok(unsafe { array.as_slice().unwrap_or(&[]) }.to_vec())
}
