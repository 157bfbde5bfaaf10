//! Generic functions whose code over `f64` is part of the library.
//!
//! A program compiles each generic function that it calls, with all that this function calls: a step over `f64` alone takes 17 seconds of a CPU at
//! each build. Public functions that programs call over `f64` therefore hand over to a function without type parameters, which the library has
//! compiled, by [`compiled_over_f64`]. For the same reason the parts of a large working memory are [`Opaque`].

use std::any::{Any, type_name};
use std::fmt;
use std::marker::PhantomData;

/// Calls a function that is generic over the data `P` of a model and a scalar `T`; where both are `f64`, the code of it that the library has compiled:
/// `compiled_over_f64!([P, T] function, state: &State, u: &[f64] => State as State<T>)`, with the types of arguments and result over `f64`, and that of the
/// result over `T`.
macro_rules! compiled_over_f64 {
    ([$P:ty, $T:ty] $function:path, $($value:ident: $type:ty),* => $own:ty as $out:ty) => {{
        #[allow(clippy::use_self, reason = "an item in a function cannot name the type around it")]
        // In a `const` block, so that the other branch is not compiled.
        let out = if const { <$P as $crate::Scalar>::IS_F64 && <$T as $crate::Scalar>::IS_F64 } {
            // An item has no type parameters of the function around it.
            #[inline(never)]
            fn compiled($($value: $type),*) -> $own {
                $function($($value),*)
            }
            let own = compiled($($crate::scalar::same(castaway::cast!($value, $type))),*);
            $crate::scalar::same(castaway::cast!(own, $out))
        } else {
            $function($($value),*)
        };
        out
    }};
    ([$P:ty, $T:ty] $function:path, $($value:ident: $type:ty),*) => {
        $crate::scalar::compiled_over_f64!([$P, $T] $function, $($value: $type),* => () as ())
    };
}
pub(crate) use compiled_over_f64;

/// A value whose type is known to be the one that it was cast to.
#[inline(always)]
pub(crate) fn same<A, B>(cast: Result<A, B>) -> A {
    // Types of num-dual without derivatives are `f64`, or wrap it.
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
