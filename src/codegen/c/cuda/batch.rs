//! Kernels that evaluate a function for many states.

use super::places::{CudaSizes, Places};
use super::source::{CudaKernel, CudaSource, Layout, body, function, length};
use super::stages::stages;
use crate::codegen::{CodeError, Precision};
use crate::scalar::traced::Graph;

impl Graph {
    /// Writes the graph as CUDA, with kernels that evaluate it for many states, one state per thread:
    ///
    /// `(unsigned count, const real *in, const real *shared, real *work, real *out, int *status)`
    ///
    /// There is one kernel, `NAME_batch`, or, for a long function, one kernel for each part, `NAME_part_K`; launch these in order on the same arrays.
    /// Each kernel is a separate text, so they can be compiled in parallel.
    ///
    /// Entry k of state i is at `k * count + i`, so that memory access of neighbouring threads is coalesced. The status of a state is 0, or the
    /// index, from 1, of the first violated [condition](Graph::conditions), or −1 if an output is not finite. Parts exchange values in `work`, which
    /// has [`work`](CudaSizes::work) values for each state, in whole tiles of [32](CudaSizes::TILE) states.
    ///
    /// * `name` – of the function; all other names begin with it
    /// * `shared` – names of inputs that are equal for all states, such as a gain; they are in a separate array
    ///
    /// # Errors
    /// If a name is not an identifier, two names would be one, or there is no input with this name.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{codegen::{self, Precision}, model::samples};
    ///
    /// let graph = codegen::inverse_dynamics(&samples::pendulum());
    /// let source = graph.to_cuda("pendulum", Precision::Single, &[])?;
    /// assert_eq!((source.kernels[0].name(), source.sizes.inputs), ("pendulum_batch", 3));
    /// # Ok::<(), dualbody::codegen::CodeError>(())
    /// ```
    pub fn to_cuda(
        &self,
        name: &str,
        precision: Precision,
        shared: &[&str],
    ) -> Result<CudaSource, CodeError> {
        self.to_cuda_in_parts(name, precision, shared, length(self))
    }

    /// [`to_cuda`](Self::to_cuda) with another length of the parts.
    ///
    /// Shorter parts spill fewer values and exchange more; the optimum depends on the graph and the GPU.
    ///
    /// * `length` – maximum number of operations of a part
    ///
    /// # Errors
    /// As [`to_cuda`](Self::to_cuda).
    pub fn to_cuda_in_parts(
        &self,
        name: &str,
        precision: Precision,
        shared: &[&str],
        length: usize,
    ) -> Result<CudaSource, CodeError> {
        let shared: Vec<String> = shared.iter().map(|&name| name.to_owned()).collect();
        let places = Places::of(self, &shared, Layout::Tiles.stride())?;
        let prefix = name.to_ascii_uppercase();
        let parts = body(self, &places, &prefix, precision, Layout::Tiles, length);
        let (kernels, work) = if parts.is_split() {
            let work = places.n_own() + parts.waiting() + self.n_outputs();
            (stages(self, &places, &parts, name, precision)?, work)
        } else {
            let places = Places::of(self, &shared, Layout::ManyStates.stride())?;
            let text = function(self, &places, name, precision, Layout::ManyStates, length)?;
            let one = CudaKernel::new(format!("{name}_batch"), text + &kernel(name));
            (vec![one], 0)
        };
        Ok(CudaSource {
            kernels,
            sizes: CudaSizes {
                inputs: places.n_own(),
                each_step: 0,
                shared: places.n_shared(),
                outputs: self.n_outputs(),
                work,
            },
            precision,
        })
    }
}

/// A product of a number with zero is zero, unless the number is not finite.
fn kernel(name: &str) -> String {
    let prefix = name.to_ascii_uppercase();
    format!(
        r#"
KERNEL void {name}_batch(unsigned count, const REAL *__restrict__ in, const REAL *__restrict__ shared,
    REAL *__restrict__ work, REAL *__restrict__ out, int *__restrict__ status)
{{
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= count) return;
    (void)work;
    int found = {name}(in + i, count, shared, out + i);
    REAL zero = 0;
    UNROLL_16 for (unsigned k = 0; k < {prefix}_OUT_SIZE; ++k) zero += out[(size_t)k * count + i] * 0;
    if (found == 0 && !(zero == 0)) found = -1;
    status[i] = found;
}}
"#
    )
}
