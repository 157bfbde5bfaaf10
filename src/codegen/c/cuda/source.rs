//! The text of a function on the device.

use std::collections::BTreeSet;

use super::places::{CudaSizes, Places};
use crate::codegen::c::body::Body;
use crate::codegen::c::expression::Words;
use crate::codegen::c::function::{Arguments, Function};
use crate::codegen::c::header::{conditions, origin, ports};
use crate::codegen::c::names::check;
use crate::codegen::{CodeError, Precision};
use crate::scalar::traced::Graph;

/// Most operations of a part. NVRTC takes longer per operation in much longer ones, and keeps more numbers than fit into
/// registers; in shorter ones more numbers are handed through memory. Measured with NVRTC 12.9 for `sm_90` in `f64`;
/// processor seconds, and kB stored and loaded: spilled, and handed from part to part:
///
/// | | 250 | 500 | 1,000 | 2,000 | 20,000 |
/// |---|---|---|---|---|---|
/// | step, Panda | 1.0; 0 | 0.8; 0 | 0.8; 0 | 0.8; 0 | 0.8; 0 |
/// | A and B, Panda | 6.5; 0, 41 | 6.2; 2, 31 | 5.9; 7, 21 | 6.0; 10, 13 | 8.5; 20, 0 |
/// | step, humanoid | – | 5.6; 3, 21 | 5.3; 0, 17 | 5.4; 2, 14 | 7.7; 13, 0 |
/// | A and B, humanoid | – | 143; 70, 424 | 141; 258, 315 | 164; 418, 236 | – |
const LENGTH: usize = 2000;

/// A kernel as CUDA: one text, without includes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CudaSource {
    pub(super) kernel: String,
    pub(super) text: String,
    pub(super) sizes: CudaSizes,
    pub(super) precision: Precision,
}

impl CudaSource {
    /// Name of the kernel.
    pub fn kernel(&self) -> &str {
        &self.kernel
    }

    /// The text, for NVRTC or `nvcc`.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Numbers that the kernel reads and writes.
    pub fn sizes(&self) -> CudaSizes {
        self.sizes
    }

    /// Precision of the numbers.
    pub fn precision(&self) -> Precision {
        self.precision
    }
}

/// Arguments of functions on the device: numbers of one state stand `n`, or `m`, apart.
const ARGUMENTS: Arguments = Arguments {
    declared: "const REAL *__restrict__ in, size_t n, const REAL *__restrict__ shared, \
               REAL *__restrict__ out, size_t m",
    passed: "in, n, shared, out, m",
    unused: "(void)in; (void)n; (void)shared; (void)out; (void)m;",
    waiting: "REAL *__restrict__ w",
};

/// Text of the function of a graph, and of all that kernels need besides.
///
/// # Errors
/// If a name is no identifier, or two names would be one.
pub(super) fn function(
    graph: &Graph,
    places: &Places<'_>,
    name: &str,
    precision: Precision,
) -> Result<String, CodeError> {
    check(name, "the function")?;
    let prefix = name.to_ascii_uppercase();
    let words = Words {
        precision,
        prefix: &prefix,
        inputs: places.expressions.clone(),
        output_stride: " * m",
    };
    let body = Body::new(graph, words, LENGTH);
    let Function { parts, statements } = Function::of(&body, name, &ARGUMENTS);
    let (real, fma, declared) = (precision.real(), precision.fma(), ARGUMENTS.declared);
    let (version, origin, places) = (
        env!("CARGO_PKG_VERSION"),
        origin(graph),
        defines(graph, places, &prefix)?,
    );
    let (conditions, operations) = (conditions(graph), graph.counts().operations());
    Ok(format!(
        r#"/* {name}: made by dualbody {version}{origin}.
   {operations} operations; matrices are stored column after column. */
#define REAL {real}
#define {prefix}_FMA(a, b, c) {fma}(a, b, c)
#ifdef __cplusplus
#define KERNEL extern "C" __global__
#else
#define KERNEL __global__
#endif
#define PART static __device__ __noinline__
#ifndef INFINITY
#define INFINITY (1.0 / 0.0)
#define NAN (0.0 / 0.0)
#endif

{places}
{parts}/* {conditions} */
static __device__ int {name}({declared})
{{
{statements}}}
"#
    ))
}

/// Places and lengths of inputs and outputs.
fn defines(graph: &Graph, places: &Places<'_>, prefix: &str) -> Result<String, CodeError> {
    let mut taken = BTreeSet::new();
    let own = places.own.iter().map(|(port, _)| *port);
    Ok([
        ports(&format!("{prefix}_IN"), own, &mut taken)?,
        ports(
            &format!("{prefix}_SHARED"),
            places.shared.iter().copied(),
            &mut taken,
        )?,
        ports(&format!("{prefix}_OUT"), graph.outputs(), &mut taken)?,
    ]
    .concat())
}
