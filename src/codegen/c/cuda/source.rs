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
/// processor seconds, and kB stored and loaded: spilled, and handed from part to part. All parts were in one text, as those
/// of rollouts are:
///
/// | | 250 | 500 | 1,000 | 2,000 | 20,000 |
/// |---|---|---|---|---|---|
/// | step, Panda | 1.0; 0 | 0.8; 0 | 0.8; 0 | 0.8; 0 | 0.8; 0 |
/// | A and B, Panda | 6.5; 0, 41 | 6.2; 2, 31 | 5.9; 7, 21 | 6.0; 10, 13 | 8.5; 20, 0 |
/// | step, humanoid | – | 5.6; 3, 21 | 5.3; 0, 17 | 5.4; 2, 14 | 7.7; 13, 0 |
/// | A and B, humanoid | – | 143; 70, 424 | 141; 258, 315 | 164; 418, 236 | – |
pub(super) const LENGTH: usize = 2000;
/// Most operations of a part of a step, in a kernel that takes many.
pub(super) const LENGTH_OF_STEPS: usize = 10_000;

/// A kernel as CUDA: one text, without includes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CudaKernel {
    name: String,
    text: String,
}

impl CudaKernel {
    pub(super) fn new(name: String, text: String) -> Self {
        Self { name, text }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The text, for NVRTC or `nvcc`.
    pub fn text(&self) -> &str {
        &self.text
    }
}

/// A function as CUDA: kernels, which are to be started one after the other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CudaSource {
    pub(super) kernels: Vec<CudaKernel>,
    pub(super) sizes: CudaSizes,
    pub(super) precision: Precision,
}

impl CudaSource {
    /// The kernels, in the order in which they are to be started; at least one.
    pub fn kernels(&self) -> &[CudaKernel] {
        &self.kernels
    }

    /// Numbers that the kernels read and write.
    pub fn sizes(&self) -> CudaSizes {
        self.sizes
    }

    /// Precision of the numbers.
    pub fn precision(&self) -> Precision {
        self.precision
    }
}

/// Layout of the numbers of a state in memory.
#[derive(Clone, Copy)]
pub(super) enum Layout {
    /// One beside the other.
    OneState,
    /// As many apart as there are states, `n`.
    ManyStates,
    /// As many apart as there are states in a tile.
    Tiles,
}

impl Layout {
    /// Factor of the index of a number.
    pub(super) fn stride(self) -> &'static str {
        match self {
            Self::OneState => "",
            Self::ManyStates => " * n",
            Self::Tiles => " * TILE",
        }
    }

    /// Arguments of a function.
    fn arguments(self) -> &'static Arguments {
        match self {
            Self::ManyStates => &Arguments {
                declared: "const REAL *__restrict__ in, size_t n, const REAL *__restrict__ shared, \
                           REAL *__restrict__ out",
                passed: "in, n, shared, out",
                unused: "(void)in; (void)n; (void)shared; (void)out;",
                waiting: "REAL *__restrict__ w",
            },
            Self::OneState | Self::Tiles => &Arguments {
                declared: "const REAL *__restrict__ in, const REAL *__restrict__ shared, \
                           REAL *__restrict__ out",
                passed: "in, shared, out",
                unused: "(void)in; (void)shared; (void)out;",
                waiting: "REAL *__restrict__ w",
            },
        }
    }
}

/// The statements of a graph.
///
/// * `prefix` – name of the function, in capitals
/// * `length` – most operations of a part
pub(super) fn body<'a>(
    graph: &'a Graph,
    places: &Places<'_>,
    prefix: &'a str,
    precision: Precision,
    layout: Layout,
    length: usize,
) -> Body<'a> {
    let words = Words {
        precision,
        prefix,
        inputs: places.expressions.clone(),
        stride: layout.stride(),
    };
    Body::new(graph, words, length)
}

/// Text of the function of a graph, and of all that kernels need besides.
///
/// # Errors
/// If a name is no identifier, or two names would be one.
pub(super) fn function(
    graph: &Graph,
    places: &Places<'_>,
    name: &str,
    precision: Precision,
    layout: Layout,
    length: usize,
) -> Result<String, CodeError> {
    let head = head(graph, places, name, precision)?;
    let (prefix, arguments) = (name.to_ascii_uppercase(), layout.arguments());
    let body = body(graph, places, &prefix, precision, layout, length);
    let Function { parts, statements } = Function::of(&body, name, arguments);
    let (declared, conditions) = (arguments.declared, conditions(graph));
    Ok(format!(
        r#"{head}#define PART static __device__ __noinline__

{parts}/* {conditions} */
static __device__ int {name}({declared})
{{
{statements}}}
"#
    ))
}

/// The beginning of the text of a kernel.
///
/// # Errors
/// If a name is no identifier, or two names would be one.
pub(super) fn head(
    graph: &Graph,
    places: &Places<'_>,
    name: &str,
    precision: Precision,
) -> Result<String, CodeError> {
    check(name, "the function")?;
    let prefix = name.to_ascii_uppercase();
    let (real, fma, version) = (precision.real(), precision.fma(), env!("CARGO_PKG_VERSION"));
    let (origin, places) = (origin(graph), defines(graph, places, &prefix)?);
    let operations = graph.counts().operations();
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
#ifdef __CUDACC__
#define UNROLL_16 _Pragma("unroll 16")
#else
#define UNROLL_16
#endif
#ifndef INFINITY
#define INFINITY (1.0 / 0.0)
#define NAN (0.0 / 0.0)
#endif

{places}
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
