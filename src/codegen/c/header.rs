//! The header of a function.

use std::collections::BTreeSet;

use super::names::{CodeError, check};
use super::precision::Precision;
use crate::scalar::traced::{Graph, Port};

/// Text of the header.
///
/// # Errors
/// If a name is not an identifier of C, or two names would be one.
pub(super) fn header(graph: &Graph, name: &str, precision: Precision) -> Result<String, CodeError> {
    let (prefix, real) = (name.to_ascii_uppercase(), precision.real());
    let (version, operations) = (env!("CARGO_PKG_VERSION"), graph.counts().operations());
    let mut taken = BTreeSet::new();
    let inputs = ports(&format!("{prefix}_IN"), graph.inputs(), &mut taken)?;
    let outputs = ports(&format!("{prefix}_OUT"), graph.outputs(), &mut taken)?;
    let (origin, conditions) = (origin(graph), conditions(graph));
    Ok(format!(
        r#"/* {name}: made by dualbody {version}{origin}.
   {operations} operations; matrices are stored column after column. */
#ifndef {prefix}_H
#define {prefix}_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {{
#endif

typedef {real} {name}_real;

{inputs}
{outputs}
/* All inputs one after the other, all outputs likewise; the two must not overlap.
   {conditions} */
int {name}(const {name}_real *in, {name}_real *out);

/* For {name} of one state after the other. Writes what it returns for each to status, unless
   that is NULL; returns for how many that is not 0. */
size_t {name}_batch(size_t count, const {name}_real *in, {name}_real *out, int *status);

#ifdef __cplusplus
}}
#endif

#endif
"#
    ))
}

/// Of which robot the function is, where that is known.
pub(super) fn origin(graph: &Graph) -> String {
    graph.origin().map_or(String::new(), |origin| {
        let (name, fingerprint) = (plain(&origin.name), origin.fingerprint);
        format!(" for the robot {name}, fingerprint {fingerprint:016x}")
    })
}

/// Comment on what the function returns.
pub(super) fn conditions(graph: &Graph) -> String {
    let mut all = graph.conditions().iter().enumerate();
    if all.len() == 0 {
        return "Returns 0.".to_owned();
    }
    let text = "Returns 0, or the number of the first condition that does not hold at these inputs,\n   \
                in which case the outputs are invalid:";
    all.by_ref().fold(text.to_owned(), |text, (index, own)| {
        format!("{text}\n   {}: {}", index + 1, plain(&own.condition))
    })
}

/// Places and lengths of inputs or outputs.
pub(super) fn ports<'a>(
    prefix: &str,
    ports: impl IntoIterator<Item = &'a Port>,
    taken: &mut BTreeSet<String>,
) -> Result<String, CodeError> {
    let mut define = |name: String, value: usize| {
        let line = format!("#define {name} {value}\n");
        if taken.insert(name.clone()) {
            return Ok(line);
        }
        Err(CodeError::NameTwice { name })
    };
    let (mut out, mut first) = (String::new(), 0);
    for port in ports {
        check(&port.name, "an input or output")?;
        let name = format!("{prefix}_{}", port.name.to_ascii_uppercase());
        out += &format!("/* {} */\n", plain(&port.to_string()));
        out += &define(format!("{name}_ROWS"), port.rows)?;
        out += &define(format!("{name}_COLUMNS"), port.columns)?;
        out += &define(name, first)?;
        first += port.len();
    }
    out += "/* all of them */\n";
    out += &define(format!("{prefix}_SIZE"), first)?;
    Ok(out)
}

/// A text that is valid in a comment of C, in ASCII.
fn plain(text: &str) -> String {
    let replaced = text
        .replace('×', "x")
        .replace('²', "^2")
        .replace("*/", "* /");
    let ascii = |c: char| {
        if c.is_ascii() && !c.is_ascii_control() {
            c
        } else {
            '?'
        }
    };
    replaced.chars().map(ascii).collect()
}
