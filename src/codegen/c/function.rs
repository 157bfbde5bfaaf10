//! A function and its parts.

use super::body::Body;

/// Arguments of a function.
pub(super) struct Arguments {
    /// Their declarations.
    pub(super) declared: &'static str,
    /// Their names, where they are handed on.
    pub(super) passed: &'static str,
    /// Statements by which none of them is unused.
    pub(super) unused: &'static str,
    /// Declaration of the array in which numbers wait for later parts.
    pub(super) waiting: &'static str,
}

/// Text of a function.
pub(super) struct Function {
    /// Functions of the parts of a long one, declared as `PART`; empty if it is short.
    pub(super) parts: String,
    /// Statements between its braces.
    pub(super) statements: String,
}

impl Function {
    pub(super) fn of(body: &Body<'_>, name: &str, arguments: &Arguments) -> Self {
        let (parts, statements) = if body.is_split() {
            (parts(body, name, arguments), calls(body, name, arguments))
        } else {
            (String::new(), body.part(0))
        };
        let (given, status) = (body.given_outputs(), body.status());
        let unused = arguments.unused;
        Self {
            parts,
            statements: format!("    {unused}\n{statements}{given}{status}"),
        }
    }
}

/// The parts of a long function.
fn parts(body: &Body<'_>, name: &str, arguments: &Arguments) -> String {
    let Arguments {
        declared,
        unused,
        waiting,
        ..
    } = arguments;
    let part = |k: usize| {
        let statements = body.part(k);
        format!(
            r#"PART void {name}_part_{k}({declared}, {waiting})
{{
    {unused} (void)w;
{statements}}}

"#
        )
    };
    (0..body.parts()).map(part).collect()
}

/// Calls of the parts, with the array in which numbers wait for later ones.
fn calls(body: &Body<'_>, name: &str, arguments: &Arguments) -> String {
    let passed = arguments.passed;
    let call = |k: usize| format!("    {name}_part_{k}({passed}, w);\n");
    let all: String = (0..body.parts()).map(call).collect();
    format!("    REAL w[{}];\n{all}", body.waiting().max(1))
}
