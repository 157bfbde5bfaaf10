//! The kernels of a long function: one for each part, each a text of its own.
//!
//! In one text, the parts would be compiled in sequence, and entries of a state would be `count` apart, where each has
//! an address of its own to be computed. Here all entries of a state are in a tile of the workspace, at distances that are
//! constants of the text, and so of the instructions. A part of A and B of a humanoid that has 2,000 operations and 548 outputs
//! takes NVRTC 12.9 (`sm_90`, `f64`) 2.8 s instead of 7.6 s, has 4,773 instructions instead of 12,613, and spills 8,792 bytes instead
//! of 17,044.

use super::places::{CudaSizes, Places};
use super::source::{CudaKernel, head};
use crate::codegen::c::body::Body;
use crate::codegen::c::header::conditions;
use crate::codegen::{CodeError, Precision};
use crate::scalar::traced::Graph;

/// The kernels of the parts of a function, in their order.
///
/// # Errors
/// If a name is not an identifier, or two names would be one.
pub(super) fn stages(
    graph: &Graph,
    places: &Places<'_>,
    body: &Body<'_>,
    name: &str,
    precision: Precision,
) -> Result<Vec<CudaKernel>, CodeError> {
    let head = head(graph, places, name, precision)?;
    let tiles = tiles(graph, body, &name.to_ascii_uppercase());
    let last = body.parts() - 1;
    let stage = |k: usize| {
        let first = |text: String| if k == 0 { text } else { String::new() };
        let at_last = |text: String| if k == last { text } else { String::new() };
        let (begin, end) = (first(begin(name)), at_last(end(body, name)));
        let (own, statements) = (format!("{name}_part_{k}"), body.part(k));
        let kernel = kernel(name, &own, &[begin, statements, end].concat());
        let status = at_last(status(graph, body, name));
        CudaKernel::new(own, [&*head, &tiles, &status, &kernel].concat())
    };
    Ok((0..=last).map(stage).collect())
}

/// Sizes of a tile: the numbers of some states in the workspace, their inputs, what waits for later parts, and their outputs.
fn tiles(graph: &Graph, body: &Body<'_>, prefix: &str) -> String {
    let (tile, waiting, outputs) = (CudaSizes::TILE, body.waiting(), graph.n_outputs());
    format!(
        r#"#define TILE {tile}
#define {prefix}_WAITING {waiting}
#define {prefix}_WORK ({prefix}_IN_SIZE + {prefix}_WAITING + {outputs})

"#
    )
}

fn kernel(name: &str, own: &str, statements: &str) -> String {
    let prefix = name.to_ascii_uppercase();
    format!(
        r#"KERNEL void {own}(unsigned count, const REAL *__restrict__ given, const REAL *__restrict__ shared,
    REAL *__restrict__ work, REAL *__restrict__ found, int *__restrict__ status)
{{
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= count) return;
    REAL *const in = work + (size_t)(i / TILE) * (TILE * {prefix}_WORK) + i % TILE;
    REAL *const w = in + TILE * {prefix}_IN_SIZE, *const out = w + TILE * {prefix}_WAITING;
    (void)given; (void)shared; (void)found; (void)status; (void)w; (void)out;
{statements}}}
"#
    )
}

/// Statements that put the inputs of a state into its tile.
fn begin(name: &str) -> String {
    let prefix = name.to_ascii_uppercase();
    format!(
        "    UNROLL_16 for (unsigned k = 0; k < {prefix}_IN_SIZE; ++k) in[k * TILE] = given[(size_t)k * count + i];\n"
    )
}

/// Statements that take the outputs of a state from its tile. A product of a number with zero is zero, unless the number
/// is not finite.
fn end(body: &Body<'_>, name: &str) -> String {
    let (prefix, given) = (name.to_ascii_uppercase(), body.given_outputs());
    format!(
        r#"{given}    REAL zero = 0;
    UNROLL_16 for (unsigned k = 0; k < {prefix}_OUT_SIZE; ++k) {{
        found[(size_t)k * count + i] = out[k * TILE];
        zero += out[k * TILE] * 0;
    }}
    int number = {name}_status(in, shared, w);
    if (number == 0 && !(zero == 0)) number = -1;
    status[i] = number;
"#
    )
}

/// The function of the conditions.
fn status(graph: &Graph, body: &Body<'_>, name: &str) -> String {
    let (status, conditions) = (body.status(), conditions(graph));
    format!(
        r#"/* {conditions} */
static __device__ int {name}_status(const REAL *in, const REAL *shared, const REAL *w)
{{
    (void)in; (void)shared; (void)w;
{status}}}

"#
    )
}
