//! The files of a function.

use std::path::Path;
use std::{fs, io};

use super::body::Body;
use super::expression::Words;
use super::header::header;
use super::names::{CodeError, check};
use super::precision::Precision;
use crate::scalar::traced::Graph;

/// A function as C: a header and a source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    name: String,
    header: String,
    source: String,
}

impl Source {
    /// Name of the function, and of the files without their endings.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Text of the header, `NAME.h`: names, sizes and units of all inputs and outputs, and the functions.
    pub fn header(&self) -> &str {
        &self.header
    }

    /// Text of the source, `NAME.c`.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// Writes both files into a folder, which is made if it is not there.
    ///
    /// # Errors
    /// If that is not possible.
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
    /// If a name is no identifier of C, or two names would be one in the header.
    pub fn to_c(&self, name: &str, precision: Precision) -> Result<Source, CodeError> {
        check(name, "the function")?;
        let prefix = name.to_ascii_uppercase();
        let header = header(self, name, precision)?;
        let words = Words {
            precision,
            prefix: &prefix,
        };
        let body = Body::new(self, words);
        Ok(Source {
            name: name.to_owned(),
            header,
            source: source(&body, name, precision),
        })
    }
}

fn source(body: &Body<'_>, name: &str, precision: Precision) -> String {
    let prefix = name.to_ascii_uppercase();
    let (suffix, fma) = match precision {
        Precision::Double => ("", "fma"),
        Precision::Single => ("F", "fmaf"),
    };
    let (parts, statements) = if body.is_split() {
        (parts(body, name), calls(body, name))
    } else {
        (String::new(), body.part(0))
    };
    let (given, status) = (body.given_outputs(), body.status());
    format!(
        r#"#include "{name}.h"

#include <math.h>

#define REAL {name}_real

#ifdef FP_FAST_FMA{suffix}
#define {prefix}_FMA(a, b, c) {fma}(a, b, c)
#else
#define {prefix}_FMA(a, b, c) ((a) * (b) + (c))
#endif

{parts}int {name}(const REAL *restrict in, REAL *restrict out)
{{
    (void)in; (void)out;
{statements}{given}{status}}}

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

/// The parts of a long function, which compilers are told not to put together again.
fn parts(body: &Body<'_>, name: &str) -> String {
    let part = |k: usize| {
        let statements = body.part(k);
        format!(
            r#"PART void {name}_part_{k}(const REAL *restrict in, REAL *restrict out, REAL *restrict w)
{{
    (void)in; (void)out; (void)w;
{statements}}}

"#
        )
    };
    let all: String = (0..body.parts()).map(part).collect();
    format!(
        r#"#ifdef __GNUC__
#define PART static __attribute__((noinline))
#else
#define PART static
#endif

{all}"#
    )
}

/// Calls of the parts, with the array in which numbers wait for later ones.
fn calls(body: &Body<'_>, name: &str) -> String {
    let call = |k: usize| format!("    {name}_part_{k}(in, out, w);\n");
    let all: String = (0..body.parts()).map(call).collect();
    format!("    REAL w[{}];\n{all}", body.waiting().max(1))
}
