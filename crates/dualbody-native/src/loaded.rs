//! Loading of compiled code, and calls of it: all unsafe code of this crate.

#![expect(
    unsafe_code,
    reason = "foreign functions can be called in no other way"
)]

use std::ffi::c_int;
use std::path::Path;

use dlopen2::raw::Library;
use dualbody::codegen::Source;
use dualbody::scalar::traced::Graph;

use crate::error::NativeError;
use crate::real::Real;

/// `int NAME(const real *in, real *out)`
type Single<R> = unsafe extern "C" fn(*const R, *mut R) -> c_int;
/// `size_t NAME_batch(size_t count, const real *in, real *out, int *status)`
type Batch<R> = unsafe extern "C" fn(usize, *const R, *mut R, *mut c_int) -> usize;

/// Functions of a library that is loaded.
pub(crate) struct Loaded<R> {
    single: Single<R>,
    batch: Batch<R>,
    pub(crate) n_inputs: usize,
    pub(crate) n_outputs: usize,
    /// Keeps the code in memory as long as there are pointers to it.
    _library: Library,
}

impl<R: Real> Loaded<R> {
    /// Loads a file that was compiled from the source of a graph in the precision of `R`.
    pub(crate) fn open(path: &Path, source: &Source, graph: &Graph) -> Result<Self, NativeError> {
        let failure = |error: dlopen2::Error| NativeError::Load {
            path: path.to_owned(),
            reason: error.to_string(),
        };
        let library = Library::open(path).map_err(failure)?;
        let (name, batch) = (&source.name, format!("{}_batch", &source.name));
        // SAFETY: the header of the source declares these names with these types; its text decides which file is loaded.
        let (single, batch) = unsafe {
            let single = library.symbol::<Single<R>>(name).map_err(failure)?;
            (single, library.symbol::<Batch<R>>(&batch).map_err(failure)?)
        };
        Ok(Self {
            single,
            batch,
            n_inputs: graph.n_inputs(),
            n_outputs: graph.n_outputs(),
            _library: library,
        })
    }

    /// Returns 0, or the number from 1 of the first condition that does not hold.
    pub(crate) fn call(&self, inputs: &[R], outputs: &mut [R]) -> c_int {
        assert_eq!(inputs.len(), self.n_inputs, "the inputs of the function");
        assert_eq!(outputs.len(), self.n_outputs, "the outputs of the function");
        // SAFETY: the function reads as many numbers and writes as many, which were just counted; the slices cannot overlap, and it keeps neither.
        unsafe { (self.single)(inputs.as_ptr(), outputs.as_mut_ptr()) }
    }

    /// [`call`](Self::call) for as many states as there are places for statuses; returns for how many a condition does not hold.
    pub(crate) fn call_batch(
        &self,
        inputs: &[R],
        outputs: &mut [R],
        status: &mut [c_int],
    ) -> usize {
        let count = status.len();
        let of = |len: usize| {
            len.checked_mul(count)
                .expect("sizes that memory has room for")
        };
        assert_eq!(
            inputs.len(),
            of(self.n_inputs),
            "the inputs of {count} states"
        );
        assert_eq!(
            outputs.len(),
            of(self.n_outputs),
            "the outputs of {count} states"
        );
        // SAFETY: as in `call`, for each state, in sequence.
        unsafe {
            (self.batch)(
                count,
                inputs.as_ptr(),
                outputs.as_mut_ptr(),
                status.as_mut_ptr(),
            )
        }
    }
}
