//! Rows of numbers.

use crate::nested::IntoNested;
/// Rows of equal width, in sequence.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Rows {
    pub(super) width: usize,
    pub(super) length: usize,
    pub(super) numbers: Vec<f64>,
}

impl Rows {
    pub(super) fn new(width: usize) -> Self {
        Self {
            width,
            ..Self::default()
        }
    }

    pub(super) fn from_columns(columns: &[&[f64]], length: usize) -> Self {
        let row = |k: usize| columns.iter().map(move |column| column[k]);
        Self {
            width: columns.len(),
            length,
            numbers: (0..length).nested(row).collect(),
        }
    }

    pub(super) fn row(&self, k: usize) -> &[f64] {
        &self.numbers[k * self.width..(k + 1) * self.width]
    }

    pub(super) fn column(&self, j: usize) -> impl Iterator<Item = f64> + '_ {
        self.numbers.iter().skip(j).copied().step_by(self.width)
    }

    pub(super) fn push(&mut self, row: &[f64], what: &str) {
        let (given, width) = (row.len(), self.width);
        assert_eq!(given, width, "{what} has {width} entries");
        self.numbers.extend_from_slice(row);
        self.length += 1;
    }

    /// A row of which nothing is known.
    pub(super) fn push_unknown(&mut self) {
        let longer = self.numbers.len() + self.width;
        self.numbers.resize(longer, f64::NAN);
        self.length += 1;
    }

    /// A row that may be empty, then nothing is known of it. The first one that is not makes the columns, unknown in
    /// the past.
    pub(super) fn push_if_known(&mut self, row: &[f64], what: &str) {
        if self.width == 0 && !row.is_empty() {
            self.width = row.len();
            self.numbers = vec![f64::NAN; self.width * self.length];
        }
        if row.is_empty() {
            self.push_unknown();
        } else {
            self.push(row, what);
        }
    }
}
