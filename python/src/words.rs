//! Texts of the library in Python's words.

/// What the library's messages name, and what that is called in Python; longer names before those that they begin with.
const NAMES: [(&str, &str); 9] = [
    ("Simulator::linearize", "Simulator.linearize"),
    (
        "Simulator::state makes a state with them",
        "Simulator.neutral_contact() makes them",
    ),
    ("memory::set_limit", "set_memory_limit"),
    ("`System::robot`", "`model`"),
    ("`System::rate`", "`rate`"),
    ("`Compiler::new`", "compiler=Compiler(…)"),
    ("`Compiler::with_cache`", "compiler=Compiler(cache=…)"),
    ("with_locked_joint", "with_locked_joints"),
    (
        "`Lanes::is_supported`, or take `f64`",
        "for one state at a time",
    ),
];

/// A message with the names of Python in place of those of Rust.
pub(crate) fn for_python(text: &str) -> String {
    let replace = |text: String, (rust, python): &(&str, &str)| match text.contains(rust) {
        true => text.replace(rust, python),
        false => text,
    };
    NAMES.iter().fold(text.to_owned(), replace)
}

/// The name of a kind as words of Python are written: `non_finite` of `NonFinite`.
pub(crate) fn snake(kind: impl std::fmt::Debug) -> String {
    let mut out = String::new();
    for c in format!("{kind:?}").chars() {
        if c.is_uppercase() && !out.is_empty() {
            out.push('_');
        }
        out.extend(c.to_lowercase());
    }
    out
}
