//! A kernel for rollouts of many states.

use std::fmt::Write;
use std::ops::Range;

use super::places::{CudaSizes, Places, known};
use super::source::{CudaKernel, CudaSource, LENGTH, Layout, function};
use crate::codegen::{CodeError, Precision};
use crate::scalar::traced::Graph;

/// Roles of the inputs of a step in a rollout kernel.
///
/// The first inputs are the state, of the same length as the outputs, which are the next state. All other inputs are constant for each state, such as
/// parameters of its robot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RolloutInputs {
    /// Inputs that change in each step; `u` by default.
    pub each_step: Vec<String>,
    /// Inputs that are equal for all states, such as a gain; none by default.
    pub shared: Vec<String>,
    /// Inputs of the state that are compared with the divergence bound; `v` by default.
    pub speeds: Vec<String>,
}

impl Default for RolloutInputs {
    fn default() -> Self {
        Self {
            each_step: vec!["u".to_owned()],
            shared: Vec::new(),
            speeds: vec!["v".to_owned()],
        }
    }
}

impl RolloutInputs {
    /// Roles of the inputs of a [step under feedback](crate::codegen::feedback_step): all states share reference and gain.
    pub fn of_feedback() -> Self {
        Self {
            each_step: Vec::new(),
            shared: ["x0", "u0", "K"].map(str::to_owned).to_vec(),
            ..Self::default()
        }
    }
}

impl Graph {
    /// Writes a step as CUDA, with a kernel `NAME_rollout` for many steps of many states, one state per thread:
    ///
    /// `(unsigned count, unsigned steps, unsigned every, real fastest, real *state, const real *in, const real *each_step, const real
    /// *shared, real *kept, int *status, unsigned *taken)`
    ///
    /// The state is updated in place. Entry k of state i is at `k * count + i`; `each_step` and `kept` are sequences of such blocks. The state is
    /// stored in `kept` after each `every` steps (never if that is 0). A state whose status is not 0 is not changed. A state stops at its last valid
    /// value with the status k at the k-th violated condition, from 1, −1 if the next state is not finite or faster than `fastest`, and −2 at an
    /// input that is not finite. The number of steps taken is added to `taken`.
    ///
    /// * `name` – of the function; all other names begin with it
    ///
    /// # Errors
    /// If a name is not an identifier, two names would be one, there is no input with this name, or the outputs are not as long as the first inputs.
    pub fn to_cuda_rollout(
        &self,
        name: &str,
        precision: Precision,
        inputs: &RolloutInputs,
    ) -> Result<CudaSource, CodeError> {
        self.to_cuda_rollout_in_parts(name, precision, inputs, LENGTH)
    }

    /// [`to_cuda_rollout`](Self::to_cuda_rollout) with another length of the parts.
    ///
    /// * `length` – maximum number of operations of a part
    ///
    /// # Errors
    /// As [`to_cuda_rollout`](Self::to_cuda_rollout).
    pub fn to_cuda_rollout_in_parts(
        &self,
        name: &str,
        precision: Precision,
        inputs: &RolloutInputs,
        length: usize,
    ) -> Result<CudaSource, CodeError> {
        let places = Places::of(self, &inputs.shared, Layout::OneState.stride())?;
        let roles = Roles::of(self, &places, inputs)?;
        let text = function(self, &places, name, precision, Layout::OneState, length)?;
        Ok(CudaSource {
            kernels: vec![CudaKernel::new(
                format!("{name}_rollout"),
                text + &roles.kernel(name),
            )],
            sizes: CudaSizes {
                inputs: roles.constants.iter().map(Range::len).sum(),
                each_step: roles.each_step.iter().map(Range::len).sum(),
                shared: places.n_shared(),
                outputs: self.n_outputs(),
                work: 0,
            },
            precision,
        })
    }
}

/// Ranges of the numbers that a state has its own of, by role.
#[derive(Default)]
struct Roles {
    speeds: Vec<Range<usize>>,
    each_step: Vec<Range<usize>>,
    constants: Vec<Range<usize>>,
}

impl Roles {
    fn of(graph: &Graph, places: &Places<'_>, inputs: &RolloutInputs) -> Result<Self, CodeError> {
        known(graph.inputs(), &inputs.each_step)?;
        known(graph.inputs(), &inputs.speeds)?;
        let (n, mut out, mut state) = (graph.n_outputs(), Self::default(), 0);
        for (port, first) in &places.own {
            let (numbers, is_of) = (*first..first + port.len(), |names: &[String]| {
                names.iter().any(|name| name == &port.name)
            });
            let is_state = numbers.end <= n && !is_of(&inputs.each_step);
            match is_state {
                true if is_of(&inputs.speeds) => out.speeds.push(numbers.clone()),
                true => {}
                false if is_of(&inputs.each_step) => out.each_step.push(numbers.clone()),
                false => out.constants.push(numbers.clone()),
            }
            state += if is_state { port.len() } else { 0 };
        }
        if state != n {
            return Err(CodeError::NoStep { outputs: n });
        }
        Ok(out)
    }

    /// Text of the kernel. A product of a number with zero is zero, unless the number is not finite.
    fn kernel(&self, name: &str) -> String {
        let prefix = name.to_ascii_uppercase();
        let constants = loads(&self.constants, "in", "k", "");
        let n_each_step: usize = self.each_step.iter().map(Range::len).sum();
        let row = format!("(size_t)step * {n_each_step} + k");
        let each_step = loads(&self.each_step, "each_step", &row, " zero += x[k] * 0;");
        let speeds = self.speeds.iter().map(|Range { start, end }| {
            format!("        UNROLL for (unsigned k = {start}; k < {end}; ++k) if (!(FABS(next[k]) <= fastest)) found = -1;\n")
        });
        let speeds: String = speeds.collect();
        format!(
            r#"
#ifdef __CUDACC__
#define UNROLL _Pragma("unroll")
#else
#define UNROLL
#endif
#define FABS(a) ((a) < 0 ? -(a) : (a))

KERNEL void {name}_rollout(unsigned count, unsigned steps, unsigned every, REAL fastest, REAL *state,
    const REAL *__restrict__ in, const REAL *__restrict__ each_step, const REAL *__restrict__ shared,
    REAL *__restrict__ kept, int *__restrict__ status, unsigned *__restrict__ taken)
{{
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= count || status[i] != 0) return;
    REAL x[{prefix}_IN_SIZE], next[{prefix}_OUT_SIZE];
    UNROLL for (unsigned k = 0; k < {prefix}_OUT_SIZE; ++k) x[k] = state[(size_t)k * count + i];
{constants}    int found = 0;
    unsigned step = 0, left = every;
    for (; step < steps; ++step) {{
        REAL zero = 0;
{each_step}        if (!(zero == 0)) {{ found = -2; break; }}
        found = {name}(x, shared, next);
        if (found) break;
        UNROLL for (unsigned k = 0; k < {prefix}_OUT_SIZE; ++k) zero += next[k] * 0;
        if (!(zero == 0)) found = -1;
{speeds}        if (found) break;
        UNROLL for (unsigned k = 0; k < {prefix}_OUT_SIZE; ++k) x[k] = next[k];
        if (every != 0 && --left == 0) {{
            UNROLL for (unsigned k = 0; k < {prefix}_OUT_SIZE; ++k) kept[(size_t)k * count + i] = x[k];
            kept += (size_t){prefix}_OUT_SIZE * count;
            left = every;
        }}
    }}
    UNROLL for (unsigned k = 0; k < {prefix}_OUT_SIZE; ++k) state[(size_t)k * count + i] = x[k];
    status[i] = found;
    taken[i] += step;
}}
"#
        )
    }
}

/// Statements that read the numbers of some ranges, which are consecutive in an array.
///
/// * `row` – the row of the array, of the index `k` in it
fn loads(ranges: &[Range<usize>], array: &str, row: &str, then: &str) -> String {
    let (mut out, mut first) = (String::new(), 0);
    for Range { start, end } in ranges {
        let row = row.replace('k', &format!("(k - {})", start - first));
        // Writing to a string does not fail.
        let _ = writeln!(
            out,
            "    UNROLL for (unsigned k = {start}; k < {end}; ++k) {{ x[k] = {array}[({row}) * (size_t)count + i];{then} }}"
        );
        first += end - start;
    }
    out
}
