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

/// Most operations of a function that is one part, and of the parts of a step. Values passed between parts go through memory, whose traffic takes longer than what is computed, so that one
/// long part is faster than several that fit into registers. Millions of states a second on an H200, `f32` and `f64`, 262,144 states at once; NVRTC 13.0:
///
/// | | 1,000 | 2,000 | 4,000 | 10,000 |
/// |---|---|---|---|---|
/// | step, quadruped | 1,120, 567 | 1,510, 658 | 3,540, 1,280 | the same: one part |
/// | step, humanoid | 195, 128 | 205, 137 | 215, 134 | 277, 126 |
/// | gradients, Panda | 460, 201 | 640, 220 | 794, 281 | 1,550, 258 |
/// | A and B, UR5 | 399, 192 | 545, 264 | 1,730, 898 | the same: one part |
/// | A and B, Panda | 171, 77 | 165, 77 | 167, 90 | 287, 153 |
pub(super) const LENGTH: usize = 10_000;

/// Most operations of a part of a longer function. There, longer parts bring nothing, and NVRTC takes minutes for some of them: A and B of a quadruped with soft contact are 14.6 and 8.4
/// million states a second in parts of 2,000 operations, 14.0 and 8.5 in parts of 10,000.
const PART: usize = 2000;

/// Most operations of the parts of a function of many states.
pub(super) fn length(graph: &Graph) -> usize {
    match graph.counts().operations() {
        0..=LENGTH => LENGTH,
        _ => PART,
    }
}

/// A CUDA kernel: one text, without includes.
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

/// A function as CUDA kernels, to be launched in order.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct CudaSource {
    /// The kernels, in launch order; at least one.
    pub kernels: Vec<CudaKernel>,
    /// Numbers of values that the kernels read and write.
    pub sizes: CudaSizes,
    /// Precision of the values.
    pub precision: Precision,
}

/// Layout of the entries of a state in memory.
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
/// If a name is not an identifier, or two names would be one.
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
/// If a name is not an identifier, or two names would be one.
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
