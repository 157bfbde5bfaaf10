//! Names and shapes of the inputs and outputs of a graph.

use std::fmt;

/// An input or an output of a graph: a number, a vector, or a matrix in column-major order.
///
/// # Examples
/// ```
/// use dualbody::scalar::traced::Port;
///
/// let port = Port::matrix("A", 4, 4).with_unit("1");
/// assert_eq!((port.name.as_str(), port.len(), port.to_string().as_str()), ("A", 16, "A (4 × 4), 1"));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Port {
    /// The name.
    pub name: String,
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
    /// The units; empty if unknown.
    pub unit: String,
}

#[expect(
    clippy::len_without_is_empty,
    reason = "a count, none of which is rare"
)]
impl Port {
    /// A single number.
    pub fn number(name: impl Into<String>) -> Self {
        Self::matrix(name, 1, 1)
    }

    /// A vector of the given length.
    pub fn vector(name: impl Into<String>, rows: usize) -> Self {
        Self::matrix(name, rows, 1)
    }

    /// A matrix.
    pub fn matrix(name: impl Into<String>, rows: usize, columns: usize) -> Self {
        Self {
            name: name.into(),
            rows,
            columns,
            unit: String::new(),
        }
    }

    /// Sets the units of the entries, as a comment in generated code.
    #[must_use]
    pub fn with_unit(mut self, unit: impl Into<String>) -> Self {
        self.unit = unit.into();
        self
    }

    /// Number of entries.
    pub fn len(&self) -> usize {
        self.rows * self.columns
    }
}

impl fmt::Display for Port {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.name)?;
        match (self.rows, self.columns) {
            (1, 1) => {}
            (rows, 1) => write!(f, " ({rows})")?,
            (rows, columns) => write!(f, " ({rows} × {columns})")?,
        }
        if self.unit.is_empty() {
            return Ok(());
        }
        write!(f, ", {}", self.unit)
    }
}

/// The port of a name, with the index of its first number among those of all.
pub(super) fn find<'a>(ports: &'a [Port], name: &str) -> Option<(&'a Port, usize)> {
    let mut first = 0;
    for port in ports {
        if port.name == name {
            return Some((port, first));
        }
        first += port.len();
    }
    None
}
