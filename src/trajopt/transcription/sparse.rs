//! A sparse matrix whose pattern is fixed and whose numbers change.

use clarabel::algebra::CscMatrix;

/// Takes an entry: row, column, value.
pub(super) type Sink<'a> = dyn FnMut(usize, usize, f64) + 'a;

/// A matrix by columns, and where each entry goes that its source hands out.
pub(super) struct Sparse {
    pub(super) matrix: CscMatrix<f64>,
    /// The place of each entry, in the order of the source.
    places: Vec<usize>,
}

impl Sparse {
    /// The pattern of a source, which hands out the same entries in the same order at every call, none twice.
    ///
    /// * `rows`, `columns` – shape of the matrix
    pub(super) fn new(rows: usize, columns: usize, source: impl FnOnce(&mut Sink<'_>)) -> Self {
        let mut entries = Vec::new();
        source(&mut |row, column, _| entries.push((column, row)));
        let mut order: Vec<usize> = (0..entries.len()).collect();
        order.sort_unstable_by_key(|&k| entries[k]);
        let mut places = vec![0; entries.len()];
        let (mut starts, mut row_of) = (vec![0; columns + 1], Vec::with_capacity(order.len()));
        for (place, &k) in order.iter().enumerate() {
            let (column, row) = entries[k];
            places[k] = place;
            row_of.push(row);
            starts[column + 1] = place + 1;
        }
        for column in 0..columns {
            starts[column + 1] = starts[column + 1].max(starts[column]);
        }
        let zeros = vec![0.0; order.len()];
        Self {
            matrix: CscMatrix::new(rows, columns, starts, row_of, zeros),
            places,
        }
    }

    /// Takes new numbers from the source.
    pub(super) fn fill(&mut self, source: impl FnOnce(&mut Sink<'_>)) {
        let mut places = self.places.iter();
        let values = &mut self.matrix.nzval;
        source(&mut |_, _, value| {
            let &place = places.next().expect("the same entries at every call");
            values[place] = value;
        });
        assert!(places.next().is_none(), "the same entries at every call");
    }

    pub(super) fn values(&self) -> &Vec<f64> {
        &self.matrix.nzval
    }

    /// Rows and values of a column.
    pub(super) fn column(&self, j: usize) -> impl Iterator<Item = (usize, f64)> {
        let range = self.matrix.colptr[j]..self.matrix.colptr[j + 1];
        let rows = self.matrix.rowval[range.clone()].iter().copied();
        rows.zip(self.matrix.nzval[range].iter().copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_in_any_order_are_where_they_belong() {
        let entries = [
            (2, 3, 1.0),
            (0, 0, 2.0),
            (1, 3, 3.0),
            (2, 0, 4.0),
            (0, 3, 5.0),
        ];
        let source = |out: &mut Sink<'_>| entries.iter().for_each(|&(i, j, x)| out(i, j, x));
        let mut sparse = Sparse::new(3, 4, source);
        sparse.fill(source);
        assert!(sparse.matrix.check_format().is_ok());
        for &(i, j, x) in &entries {
            assert_eq!(sparse.matrix.get_entry((i, j)), Some(x));
        }
        assert_eq!(
            sparse.column(3).collect::<Vec<_>>(),
            [(0, 5.0), (1, 3.0), (2, 1.0)]
        );
        assert_eq!(sparse.column(1).count(), 0);
    }
}
