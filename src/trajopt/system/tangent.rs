//! Derivatives of a system by dual numbers, in the tangent spaces of its states: first ones for all its maps, second
//! ones of the step.

use nalgebra::DMatrix;
#[cfg(feature = "second-order")]
use num_dual::HyperDual64;

use super::{Sizes, System};
use crate::autodiff::{CHUNK, Dual, TangentPoint};
use crate::linearize::Linearization;
use crate::scalar::lift_into;
use crate::trajopt::scratch::Scratch;

/// Memory for the Jacobians of step and rate.
struct TangentScratch {
    point: TangentPoint<Dual<f64, CHUNK>>,
    next: Vec<f64>,
    /// f(x, u) and f at the moved state.
    lifted: [Vec<Dual<f64, CHUNK>>; 2],
    dy: Vec<Dual<f64, CHUNK>>,
    /// (A, B) side by side.
    out: DMatrix<f64>,
    /// Memory of the system itself.
    own: Scratch,
}

impl TangentScratch {
    fn new<S: System>(system: &S) -> Self {
        let (nx, ndx, nu) = (system.nx(), system.ndx(), system.nu());
        Self {
            point: TangentPoint::new(nx, ndx, nu),
            next: vec![0.0; nx],
            lifted: std::array::from_fn(|_| vec![Dual::from(0.0); nx]),
            dy: vec![Dual::from(0.0); ndx],
            out: DMatrix::zeros(ndx, ndx + nu),
            own: Scratch::new(),
        }
    }

    fn write_to(&self, out: &mut Linearization) {
        let ndx = out.a.nrows();
        out.a.copy_from(&self.out.columns(0, ndx));
        out.b.copy_from(&self.out.columns(ndx, out.b.ncols()));
    }
}

/// Makes the memory for [`linearize_step`] and [`linearize_rate`].
pub(in crate::trajopt) fn prepare<S: System>(system: &S, scratch: &mut Scratch) {
    scratch.get(|| TangentScratch::new(system));
}

/// Jacobians of  (δx, δu) ↦ f(x ⊕ δx, u + δu) ⊖ f(x, u).
pub(in crate::trajopt) fn linearize_step<S: System>(
    system: &S,
    x: &[f64],
    u: &[f64],
    scratch: &mut Scratch,
    out: &mut Linearization,
) {
    let memory = scratch.get(|| TangentScratch::new(system));
    let own = &mut memory.own;
    system.step(x, u, own, memory.next.as_mut_slice());
    let [base, next] = &mut memory.lifted;
    lift_into(&memory.next, base);
    memory.point.set(x, u);
    memory.point.jacobian_into(
        |x, dx, out| system.integrate(x, dx, out),
        |x, u, dy| {
            system.step(x, u, own, next);
            system.difference(base, next, dy);
        },
        &mut memory.dy,
        &mut memory.out,
    );
    memory.write_to(out);
}

/// Jacobians of a step or a rate of the right size.
pub(in crate::trajopt) fn zero_linearization(sizes: &dyn Sizes) -> Linearization {
    let (ndx, nu) = (sizes.ndx(), sizes.nu());
    Linearization {
        a: DMatrix::zeros(ndx, ndx),
        b: DMatrix::zeros(ndx, nu),
    }
}

/// Memory for [`vjp`].
struct TransposedScratch(Linearization);

/// Aᵀ λ and Bᵀ λ from the Jacobians that the system has.
pub(in crate::trajopt) fn vjp<S: System>(
    system: &S,
    x: &[f64],
    u: &[f64],
    lambda: &[f64],
    scratch: &mut Scratch,
    dx: &mut [f64],
    du: &mut [f64],
) {
    let make = || TransposedScratch(zero_linearization(system));
    let none = Linearization {
        a: DMatrix::zeros(0, 0),
        b: DMatrix::zeros(0, 0),
    };
    // The system has its own memory beside it.
    let mut step = std::mem::replace(&mut scratch.get(make).0, none);
    system.linearize(x, u, scratch, &mut step);
    for (out, m) in [(dx, &step.a), (du, &step.b)] {
        for (out, column) in out.iter_mut().zip(m.column_iter()) {
            *out = column.iter().zip(lambda).map(|(x, l)| x * l).sum();
        }
    }
    scratch.get(make).0 = step;
}

/// Jacobians of  (δx, δu) ↦ ẋ(x ⊕ δx, u + δu).
pub(in crate::trajopt) fn linearize_rate<S: System>(
    system: &S,
    x: &[f64],
    u: &[f64],
    scratch: &mut Scratch,
    out: &mut Linearization,
) {
    let memory = scratch.get(|| TangentScratch::new(system));
    memory.point.set(x, u);
    memory.point.jacobian_into(
        |x, dx, out| system.integrate(x, dx, out),
        |x, u, rate| system.rate(x, u, &mut memory.own, rate),
        &mut memory.dy,
        &mut memory.out,
    );
    memory.write_to(out);
}

/// Adds the Hessian of  λᵀ (f(x ⊕ δx, u + δu) ⊖ f(x, u))  to the upper triangle of `hessian`, n × n by columns.
/// Allocates.
///
/// * `lambda` – weights of the tangent of x⁺, length `ndx`
#[cfg(feature = "second-order")]
pub(in crate::trajopt) fn add_step_hessian<S: System>(
    system: &S,
    x: &[f64],
    u: &[f64],
    lambda: &[f64],
    hessian: &mut [f64],
) {
    let (ndx, nx) = (system.ndx(), system.nx());
    let zero = HyperDual64::from(0.0);
    let (mut next, mut scratch) = (vec![0.0; nx], Scratch::new());
    system.step(x, u, &mut scratch, next.as_mut_slice());
    let mut end = vec![zero; nx];
    lift_into(&next, &mut end);
    let n = ndx + u.len();
    let mut point = TangentPoint::new(nx, ndx, u.len());
    point.set(x, u);
    let (mut reached, mut dy) = (end.clone(), vec![zero; ndx]);
    for i in 0..n {
        for j in 0..=i {
            let integrate = |x: &[_], dx: &[_], out: &mut [_]| system.integrate(x, dx, out);
            point.in_pair([j, i], integrate, |x, u| {
                system.step(x, u, &mut scratch, &mut reached);
                system.difference(&end, &reached, &mut dy);
            });
            let terms = dy.iter().zip(lambda).map(|(dy, l)| dy.eps1eps2 * l);
            hessian[i * n + j] += terms.sum::<f64>();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Scalar;

    /// x⁺ = (x₀ x₁ + u, x₁² u),  ẋ = (x₁ u, x₀²): its functions count their calls in scratch.
    struct Bent;

    impl System for Bent {
        fn nx(&self) -> usize {
            2
        }
        fn nu(&self) -> usize {
            1
        }
        fn step<T: Scalar>(&self, x: &[T], u: &[T], scratch: &mut Scratch, next: &mut [T]) {
            *scratch.get(|| 0_usize) += 1;
            next[0] = x[0] * x[1] + u[0];
            next[1] = x[1] * x[1] * u[0];
        }
        fn rate<T: Scalar>(&self, x: &[T], u: &[T], _: &mut Scratch, rate: &mut [T]) {
            (rate[0], rate[1]) = (x[1] * u[0], x[0] * x[0]);
        }
    }

    const X: [f64; 2] = [0.7, -1.5];
    const U: [f64; 1] = [2.0];

    #[test]
    fn jacobians_of_step_and_rate_equal_closed_forms() {
        let (mut scratch, mut out) = (Scratch::new(), zero_linearization(&Bent));
        System::linearize(&Bent, &X, &U, &mut scratch, &mut out);
        // ∂(x₀ x₁ + u, x₁² u)
        assert_eq!(out.a.as_slice(), &[-1.5, 0.0, 0.7, -6.0]);
        assert_eq!(out.b.as_slice(), &[1.0, 2.25]);
        System::linearize_rate(&Bent, &X, &U, &mut scratch, &mut out);
        // ∂(x₁ u, x₀²)
        assert_eq!(out.a.as_slice(), &[0.0, 1.4, 2.0, 0.0]);
        assert_eq!(out.b.as_slice(), &[-1.5, 0.0]);
    }

    #[test]
    fn memory_of_the_system_lasts_from_one_jacobian_to_the_next() {
        let (mut scratch, mut out) = (Scratch::new(), zero_linearization(&Bent));
        for calls in [2, 4] {
            System::linearize(&Bent, &X, &U, &mut scratch, &mut out);
            let memory = scratch.get(|| TangentScratch::new(&Bent));
            // Once on plain numbers, once on dual ones: three directions are one chunk.
            assert_eq!(*memory.own.get(|| 0_usize), calls);
        }
    }

    #[cfg(feature = "second-order")]
    #[test]
    fn hessian_of_a_weighted_step_equals_its_closed_form() {
        let (lambda, mut hessian) = ([3.0, 5.0], vec![1.0; 9]);
        add_step_hessian(&Bent, &X, &U, &lambda, &mut hessian);
        // 3 (x₀ x₁ + u) + 5 x₁² u: ∂₀∂₁ = 3, ∂₁∂₁ = 10 u, ∂₁∂ᵤ = 10 x₁, added to what was there
        let upper = [
            hessian[0], hessian[3], hessian[4], hessian[6], hessian[7], hessian[8],
        ];
        assert_eq!(upper, [1.0, 4.0, 21.0, 1.0, -14.0, 1.0]);
    }
}
