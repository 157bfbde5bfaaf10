//! Numbers on the device.

use std::fmt::Debug;

use cudarc::driver::{DeviceRepr, ValidAsZeroBits};
use dualbody::codegen::Precision;

/// The floating-point type of a kernel: `f64` or `f32`.
pub trait Real:
    Copy + Debug + Default + Send + Sync + DeviceRepr + ValidAsZeroBits + private::Sealed + 'static
{
    /// Its precision.
    const PRECISION: Precision;

    /// The nearest number of this precision.
    fn from_f64(x: f64) -> Self;

    /// The same number in double precision.
    fn to_f64(self) -> f64;
}

impl Real for f64 {
    const PRECISION: Precision = Precision::Double;

    fn from_f64(x: f64) -> Self {
        x
    }

    fn to_f64(self) -> f64 {
        self
    }
}

impl Real for f32 {
    const PRECISION: Precision = Precision::Single;

    fn from_f64(x: f64) -> Self {
        x as Self
    }

    fn to_f64(self) -> f64 {
        self.into()
    }
}

mod private {
    /// Only numbers that the text of kernels has the very type of.
    pub trait Sealed {}
    impl Sealed for f64 {}
    impl Sealed for f32 {}
}
