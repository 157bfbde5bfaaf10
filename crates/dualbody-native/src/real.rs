//! Numbers of compiled functions.

use std::fmt::Debug;

use dualbody::codegen::Precision;

/// The floating-point type of a compiled function: `f64` or `f32`.
pub trait Real: Copy + Debug + Default + Send + Sync + private::Sealed + 'static {
    /// Its precision in C.
    const PRECISION: Precision;
}

impl Real for f64 {
    const PRECISION: Precision = Precision::Double;
}

impl Real for f32 {
    const PRECISION: Precision = Precision::Single;
}

mod private {
    /// Only numbers that C has the very type of.
    pub trait Sealed {}
    impl Sealed for f64 {}
    impl Sealed for f32 {}
}
