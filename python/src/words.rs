//! Texts of the library in Python's words.

/// What the library's messages name, and what that is called in Python; longer names before those that they begin with.
const NAMES: [(&str, &str); 21] = [
    ("ModelOptions::with_base(Base::Fixed)", "base=\"fixed\""),
    (
        "ModelOptions::with_base(Base::Floating)",
        "base=\"floating\"",
    ),
    (
        "ModelOptions::with_independent_mimic_joints",
        "independent_mimic_joints=True",
    ),
    ("ModelOptions::with_massless_links", "massless_links="),
    ("see MasslessLinks", "see massless_links="),
    ("UpAxis::Ignore", "mesh_up_axis=\"ignore\""),
    ("UpAxis::Honour", "mesh_up_axis=\"honour\""),
    ("Actuation::from_model", "actuation=\"model\""),
    ("JointSpec::with_spring", "the spring of JointSpec"),
    ("Model::with_spring", "Model.with_spring"),
    ("Simulator::linearize", "Simulator.linearize"),
    (
        "Simulator::state makes a state with them",
        "Simulator.neutral_contact() makes them",
    ),
    ("`System::robot`", "`model`"),
    ("`System::rate`", "`rate`"),
    ("`Compiler::new`", "compiler=Compiler(…)"),
    ("`Compiler::with_cache`", "compiler=Compiler(cache=…)"),
    ("the folders of with_root", "the folders of roots"),
    ("by with_model_name", "by model_name="),
    ("with_search_path says", "search_paths= says"),
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
