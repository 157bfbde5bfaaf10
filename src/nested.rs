//! Iterators over the items of items, forwards only: `flat_map` of the standard library, which also goes backwards and says how many items are left, is a
//! dozen times as much code in each of a hundred places.

/// The items of what `each` makes of the items of `outer`, one after the other.
#[derive(Clone)]
pub(crate) struct Nested<I, U: IntoIterator, F> {
    outer: I,
    each: F,
    open: Option<U::IntoIter>,
}

impl<I: Iterator, U: IntoIterator, F: FnMut(I::Item) -> U> Iterator for Nested<I, U, F> {
    type Item = U::Item;

    #[inline]
    fn next(&mut self) -> Option<U::Item> {
        loop {
            if let Some(item) = self.open.as_mut().and_then(Iterator::next) {
                return Some(item);
            }
            self.open = Some((self.each)(self.outer.next()?).into_iter());
        }
    }
}

/// `flat_map` and `flatten` in little code.
pub(crate) trait IntoNested: Iterator + Sized {
    /// The items of each `each(item)`.
    #[inline]
    fn nested<U: IntoIterator, F: FnMut(Self::Item) -> U>(self, each: F) -> Nested<Self, U, F> {
        Nested {
            outer: self,
            each,
            open: None,
        }
    }
}

impl<I: Iterator> IntoNested for I {}

#[cfg(test)]
mod tests {
    use super::IntoNested;

    #[test]
    fn items_of_items_equal_those_of_the_standard_library() {
        let up_to = |n: usize| 0..n;
        for outer in [vec![], vec![0], vec![2, 0, 0, 3], vec![0, 0]] {
            let expected: Vec<usize> = outer.iter().copied().flat_map(up_to).collect();
            assert_eq!(
                outer.into_iter().nested(up_to).collect::<Vec<_>>(),
                expected
            );
        }
    }
}
