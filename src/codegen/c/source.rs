//! The files of a function.

use std::path::Path;
use std::{fs, io};

use super::body::Body;
use super::expression::Words;
use super::function::{Arguments, Function};
use super::header::header;
use super::names::{CodeError, check};
use super::precision::Precision;
use crate::scalar::traced::Graph;

/// Most operations of a part. Compilers take longer per operation in longer ones; in shorter ones more numbers go
/// through memory. Measured with GCC 12, `-O2 -march=native`; processor seconds to compile, and µs of a call:
///
/// | | 250 | 500 | 1,000 | 2,000 | 5,000 |
/// |---|---|---|---|---|---|
/// | inverse dynamics, UR5 | 0.15, 0.24 | 0.15, 0.23 | – | 0.14, 0.23 | – |
/// | step, Panda | 0.6, 0.71 | 0.6, 0.71 | 0.7, 0.69 | 0.8, 0.72 | – |
/// | A and B, Panda | 3.5, 3.5 | 3.8, 3.6 | 4.5, 3.7 | 6.5, 3.9 | 10.6, 3.9 |
/// | A and B, quadruped | 13.5, 11.3 | 14.7, 12.0 | – | 18.1, 13.8 | – |
/// | step, humanoid | 2.8, 3.4 | 3.0, 3.4 | 3.2, 3.4 | 3.9, 3.5 | 7.4, 3.2 |
const LENGTH: usize = 500;

/// A function as C: a header and a source.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Source {
    /// Name of the function, and of the files without extension.
    pub name: String,
    /// Text of the header, `NAME.h`: names, sizes and units of all inputs and outputs, and the functions.
    pub header: String,
    /// Text of the source, `NAME.c`.
    pub source: String,
}

impl Source {
    /// Writes both files into a folder, which is created if necessary.
    ///
    /// # Errors
    /// If writing fails.
    pub fn save(&self, folder: impl AsRef<Path>) -> io::Result<()> {
        let folder = folder.as_ref();
        fs::create_dir_all(folder)?;
        fs::write(folder.join(format!("{}.h", self.name)), &self.header)?;
        fs::write(folder.join(format!("{}.c", self.name)), &self.source)
    }
}

impl Graph {
    /// Writes the graph as a function of C99, without dependencies and allocation; see [`codegen`](crate::codegen).
    ///
    /// * `name` – of the function; all other names begin with it
    ///
    /// # Errors
    /// If a name is not an identifier of C, or two names would be one in the header.
    pub fn to_c(&self, name: &str, precision: Precision) -> Result<Source, CodeError> {
        check(name, "the function")?;
        let prefix = name.to_ascii_uppercase();
        let header = header(self, name, precision)?;
        let words = Words {
            precision,
            prefix: &prefix,
            inputs: (0..self.n_inputs()).map(|i| format!("in[{i}]")).collect(),
            stride: "",
        };
        let body = Body::new(self, words, LENGTH);
        Ok(Source {
            name: name.to_owned(),
            header,
            source: source(&body, name, precision),
        })
    }
}

/// Arguments of functions in C.
const ARGUMENTS: Arguments = Arguments {
    declared: "const REAL *restrict in, REAL *restrict out",
    passed: "in, out",
    unused: "(void)in; (void)out;",
    waiting: "REAL *restrict w",
};

fn source(body: &Body<'_>, name: &str, precision: Precision) -> String {
    let prefix = name.to_ascii_uppercase();
    let suffix = match precision {
        Precision::Double => "",
        Precision::Single => "F",
    };
    let fma = precision.fma();
    let Function { parts, statements } = Function::of(body, name, &ARGUMENTS);
    // An attribute tells compilers not to inline the parts again.
    let part = if parts.is_empty() { "" } else { PART };
    let declared = ARGUMENTS.declared;
    format!(
        r#"#include "{name}.h"

#include <math.h>

#define REAL {name}_real

#ifdef FP_FAST_FMA{suffix}
#define {prefix}_FMA(a, b, c) {fma}(a, b, c)
#else
#define {prefix}_FMA(a, b, c) ((a) * (b) + (c))
#endif

{part}{parts}int {name}({declared})
{{
{statements}}}

size_t {name}_batch(size_t count, const REAL *in, REAL *out, int *status)
{{
    size_t broken = 0;
    for (size_t i = 0; i < count; ++i) {{
        const int found = {name}(in + i * {prefix}_IN_SIZE, out + i * {prefix}_OUT_SIZE);
        broken += found != 0;
        if (status) status[i] = found;
    }}
    return broken;
}}
"#
    )
}

/// Keyword of the parts of a long function.
const PART: &str = r#"#ifdef __GNUC__
#define PART static __attribute__((noinline))
#else
#define PART static
#endif

"#;
