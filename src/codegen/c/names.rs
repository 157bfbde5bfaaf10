//! Names in C.

/// Error for a graph that cannot be written as code.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CodeError {
    /// A name is not an identifier of C, or is reserved there.
    #[error("the name \"{name}\" of {of} is not an identifier of C: {reason}")]
    Name {
        /// The name.
        name: String,
        /// Input or output that has it.
        of: String,
        /// Reason why it is none.
        reason: &'static str,
    },
    /// Two items would have the same name in the header.
    #[error("two inputs or outputs would both be called {name} in the header")]
    NameTwice {
        /// The name in the header.
        name: String,
    },
    /// There is no input with this name.
    #[error("there is no input \"{name}\": the inputs are {}", .known.join(", "))]
    NoInput {
        /// The name.
        name: String,
        /// Names of the inputs.
        known: Vec<String>,
    },
    /// A graph is not a step: its outputs are not the next state.
    #[error(
        "the outputs ({outputs} numbers) do not match the first inputs, so the graph is not a step that can be repeated"
    )]
    NoStep {
        /// Number of the outputs.
        outputs: usize,
    },
}

/// Words of C, up to C23, and of the headers that code includes, or that a program has anyway.
const WORDS: &str = "\
    acos alignas alignof asin atan2 auto bool break case char const constexpr continue cos default do \
    double else enum exp extern exit fabs false float fma for fmin fmax goto if inline int int8_t \
    int16_t int32_t int64_t j0 j1 jn log long main malloc nullptr pow printf register restrict return \
    round short signed sin size_t sizeof sqrt static static_assert struct switch tan tanh thread_local \
    true typedef typeof union unsigned void volatile while y0 y1 yn uint8_t uint32_t gamma";

/// Most characters that compilers must tell names with external linkage apart by (C99, section 5.2.4.1), less those that
/// are put before and after.
const LONGEST: usize = 48;

/// Checks that a name is an identifier.
pub(super) fn check(name: &str, of: &str) -> Result<(), CodeError> {
    let fail = |reason| {
        Err(CodeError::Name {
            name: name.to_owned(),
            of: of.to_owned(),
            reason,
        })
    };
    let is_letter = |c: char| c.is_ascii_alphabetic();
    match name.chars().next() {
        None => return fail("it is empty"),
        Some(first) if !is_letter(first) => return fail("it does not start with a letter a to z"),
        Some(_) => {}
    }
    let is_part = |c: char| is_letter(c) || c.is_ascii_digit() || c == '_';
    if !name.chars().all(is_part) {
        return fail("it has other characters than letters a to z, digits and underscores");
    }
    if name.len() > LONGEST {
        return fail("it is longer than compilers must tell apart");
    }
    if WORDS.split_whitespace().any(|word| word == name) {
        return fail("it is a word of the language or its library");
    }
    Ok(())
}

crate::error::debug_by_message! { CodeError }
