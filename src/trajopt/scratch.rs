//! Working memory of a system, of any types.

use std::any::Any;
use std::fmt;

/// Working memory that the functions of a [`System`](super::System) keep from call to call, one for each thread.
///
/// A function gets its memory by type from [`get`](Self::get), which makes it at the first call and returns it at later calls, so only the first call
/// allocates. Systems without working memory ignore it. Each system needs its own `Scratch`.
///
/// # Examples
/// ```
/// use dualbody::trajopt::Scratch;
///
/// let mut scratch = Scratch::new();
/// scratch.get(|| vec![0.0; 3])[1] = 5.0;
/// assert_eq!(scratch.get(Vec::<f64>::new), &[0.0, 5.0, 0.0]);
/// ```
#[derive(Default)]
pub struct Scratch {
    memories: Vec<Box<dyn Any + Send>>,
}

impl Scratch {
    /// Makes an empty working memory.
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns the memory of type `M`; the first call makes it, which may allocate.
    pub fn get<M: Any + Send>(&mut self, make: impl FnOnce() -> M) -> &mut M {
        let found = self.memories.iter().position(|memory| memory.is::<M>());
        let at = found.unwrap_or_else(|| {
            self.memories.push(Box::new(make()));
            self.memories.len() - 1
        });
        let memory = self.memories[at].downcast_mut();
        memory.expect("the memory that was found by its type")
    }
}

impl fmt::Debug for Scratch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Scratch({} memories)", self.memories.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memories_of_each_type_are_made_once_and_kept_apart() {
        let mut scratch = Scratch::new();
        *scratch.get(|| 1_u8) += 1;
        *scratch.get(|| 5_i32) += 1;
        assert_eq!((*scratch.get(|| 0_u8), *scratch.get(|| 0_i32)), (2, 6));
        assert_eq!(scratch.memories.len(), 2);
    }
}
