//! Generic functions whose code over `f64` is part of the library.
//!
//! A program compiles each generic function that it calls, with all that this function calls: a step over `f64` alone takes 17 seconds of a CPU at
//! each build. Public functions that programs call over `f64` therefore hand their arguments over to a function without type parameters, which the
//! library has compiled: where [`are_f64`], by [`over_f64`]. For the same reason the parts of a large working memory are [`Opaque`].

use std::any::{Any, type_name};
use std::fmt;
use std::marker::PhantomData;

use super::Scalar;

/// Whether both the data of a model and the scalar are `f64`. In a `const` block, what the other case calls is not compiled.
pub(crate) const fn are_f64<P: Scalar, T: Scalar>() -> bool {
    P::IS_F64 && T::IS_F64
}

/// The same arguments with their types over `f64`, where [`are_f64`]: `over_f64!(state: &State, u: &[f64])`.
macro_rules! over_f64 {
    ($($value:ident: $type:ty),* $(,)?) => {
        ($($crate::scalar::same(castaway::cast!($value, $type)),)*)
    };
}
pub(crate) use over_f64;

/// A value whose type is known to be the one that it was cast to.
#[inline(always)]
pub(crate) fn same<A, B>(cast: Result<A, B>) -> A {
    // What has no derivatives in num-dual is `f64`, or wraps it.
    cast.unwrap_or_else(|_| {
        panic!(
            "{} is not supported, use {}",
            type_name::<B>(),
            type_name::<A>()
        )
    })
}

/// A value whose code for dropping is compiled where the value is made, not in each program that drops it.
pub(crate) struct Opaque<M>(Box<dyn Any + Send + Sync>, PhantomData<fn() -> M>);

impl<M: Any + Send + Sync> Opaque<M> {
    pub(crate) fn new(value: M) -> Self {
        Self(Box::new(value), PhantomData)
    }

    /// The same value, of which only the library knows that it has another type.
    pub(crate) fn retyped<N>(self) -> Opaque<N> {
        Opaque(self.0, PhantomData)
    }

    #[inline]
    pub(crate) fn get(&self) -> &M {
        same(self.0.downcast_ref().ok_or(()))
    }

    #[inline]
    pub(crate) fn get_mut(&mut self) -> &mut M {
        same(self.0.downcast_mut().ok_or(()))
    }
}

impl<M: Any + Clone + Send + Sync> Clone for Opaque<M> {
    fn clone(&self) -> Self {
        Self::new(self.get().clone())
    }
}

impl<M> fmt::Debug for Opaque<M> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("..")
    }
}
