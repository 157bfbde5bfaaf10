//! A kernel that computes a function of many states.

use super::places::{CudaSizes, Places};
use super::source::{CudaSource, function};
use crate::codegen::{CodeError, Precision};
use crate::scalar::traced::Graph;

impl Graph {
    /// Writes the graph as CUDA, with a kernel `NAME_batch` that computes it for many states, one a thread:
    ///
    /// `(unsigned count, const real *in, const real *shared, real *out, int *status)`
    ///
    /// Number k of state i stands at `k * count + i`, so that threads side by side read and write memory side by side.
    /// The status of a state is 0, or the number, from 1, of the first [condition](Graph::conditions) that does not
    /// hold, or −1 if an output is not finite.
    ///
    /// * `name` – of the function; all other names begin with it
    /// * `shared` – names of inputs that are the same for all states, such as a gain; they stand in an array of their own
    ///
    /// # Errors
    /// If a name is no identifier, two names would be one, or there is no input of a name.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{codegen::{self, Precision}, model::samples};
    ///
    /// let graph = codegen::inverse_dynamics(&samples::pendulum());
    /// let source = graph.to_cuda("pendulum", Precision::Single, &[])?;
    /// assert_eq!((source.kernel(), source.sizes().inputs), ("pendulum_batch", 3));
    /// # Ok::<(), dualbody::codegen::CodeError>(())
    /// ```
    pub fn to_cuda(
        &self,
        name: &str,
        precision: Precision,
        shared: &[&str],
    ) -> Result<CudaSource, CodeError> {
        let shared: Vec<String> = shared.iter().map(|&name| name.to_owned()).collect();
        let places = Places::of(self, &shared)?;
        let text = function(self, &places, name, precision)?;
        Ok(CudaSource {
            kernel: format!("{name}_batch"),
            text: text + &kernel(name),
            sizes: CudaSizes {
                inputs: places.n_own(),
                each_step: 0,
                shared: places.n_shared(),
                outputs: self.n_outputs(),
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
    REAL *__restrict__ out, int *__restrict__ status)
{{
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= count) return;
    int found = {name}(in + i, count, shared, out + i, count);
    REAL zero = 0;
    for (unsigned k = 0; k < {prefix}_OUT_SIZE; ++k) zero += out[(size_t)k * count + i] * 0;
    if (found == 0 && !(zero == 0)) found = -1;
    status[i] = found;
}}
"#
    )
}
