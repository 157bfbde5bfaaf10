//! Plain numbers and the types of num-dual.

use num_dual::{DualNum, DualNumCopy};

use super::{Over, Scalar, is_f64, sin_cos, sin_cos_one_by_one, tanh_by_exp};

impl<D: DualNumCopy<Primitive = f64>> Scalar for D {
    const ORDER: usize = D::NDERIV;
    const IS_VALUES: bool = true;
    const IS_F64: bool = D::NDERIV == 0;

    #[inline]
    fn value(&self, lane: usize) -> f64 {
        assert_eq!(lane, 0, "there is one lane");
        self.re()
    }

    #[inline]
    fn sqrt(self) -> Self {
        DualNum::sqrt(&self)
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        if !is_f64::<D>() {
            return DualNum::sin_cos(&self);
        }
        let ([sin], [cos]) = sin_cos::sin_cos([self.re()]);
        (Self::constant(sin), Self::constant(cos))
    }

    #[inline]
    fn sin_cos_each(x: &[Self], out: &mut [(Self, Self)]) {
        if !is_f64::<D>() {
            return sin_cos_one_by_one(x, out);
        }
        let apply = |_: &Self, sin, cos| (Self::constant(sin), Self::constant(cos));
        sin_cos::sin_cos_each(x, out, Self::re, apply);
    }

    #[inline]
    fn exp(self) -> Self {
        DualNum::exp(&self)
    }

    #[inline]
    fn ln(self) -> Self {
        DualNum::ln(&self)
    }

    #[inline]
    fn atan2(self, x: Self) -> Self {
        let value = self.re().atan2(x.re());
        if is_f64::<D>() {
            return Self::constant(value);
        }
        // num-dual differentiates atan(y / x), which is not finite at x = 0. The quotient of the smaller by the larger
        // always is; only its derivatives are used, the value comes from the library function.
        let angle = if self.re().abs() <= x.re().abs() {
            (self / x).atan()
        } else {
            -(x / self).atan()
        };
        angle + (value - angle.re())
    }

    #[inline]
    fn asin(self) -> Self {
        DualNum::asin(&self)
    }

    #[inline]
    fn acos(self) -> Self {
        DualNum::acos(&self)
    }

    // num-dual divides sinh by cosh, which overflow. Of the quotient that does not, only the derivatives are used.
    #[inline]
    fn tanh(self) -> Self {
        let value = self.re().tanh();
        if is_f64::<D>() {
            return Self::constant(value);
        }
        let tanh = tanh_by_exp(self);
        tanh + (value - tanh.re())
    }

    // Of the types here, only plain numbers have an instruction; on a target without it the call would go to a slow
    // library function.
    #[inline]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        if is_f64::<D>() && cfg!(target_feature = "fma") {
            DualNum::mul_add(&self, factor, term)
        } else {
            self * factor + term
        }
    }

    #[inline]
    fn mul_add_real(self, factor: f64, term: Self) -> Self {
        if is_f64::<D>() {
            Scalar::mul_add(self, Self::constant(factor), term)
        } else {
            self * factor + term
        }
    }

    #[inline]
    fn scale_add<T: Over<Self>>(self, x: T, term: T) -> T {
        if is_f64::<D>() {
            x.mul_add_real(self.re(), term)
        } else {
            x * self + term
        }
    }

    #[inline]
    fn select_lt(self, other: Self, a: Self, b: Self) -> Self {
        if self.re() < other.re() { a } else { b }
    }
}

crate::differentiable! {
    [D: DualNumCopy<Primitive = f64>] num_dual::Dual<D>;
    [D: DualNumCopy<Primitive = f64>] num_dual::Dual2<D>;
    [D: DualNumCopy<Primitive = f64>] num_dual::Dual3<D>;
    [D: DualNumCopy<Primitive = f64>] num_dual::HyperDual<D>;
    [D: DualNumCopy<Primitive = f64>] num_dual::HyperHyperDual<D>;
    [D: DualNumCopy<Primitive = f64>, const N: usize] num_dual::DualSVec<D, N>;
}
