//! The derivatives along the tree over scalars other than plain numbers.

use dualbody::autodiff::Dual;
use dualbody::dynamics::{
    forward_dynamics_derivatives, inverse_dynamics_derivatives, inverse_dynamics_second_derivatives,
};
use dualbody::scalar::Differentiable;
use dualbody::sim::BATCH_WIDTH;
use dualbody::{Lanes, Model, Scalar};
use nalgebra::{DMatrix, DVector};
use num_dual::Dual64;

use crate::common::{FINITE_DIFFERENCE, Point, SAME_ALGEBRA, random_point, robots};

/// States side by side: as many as those of a batch, for which the physics is compiled anyway.
const STATES: usize = BATCH_WIDTH;

type Side = Lanes<STATES>;

fn side_by_side(vectors: &[DVector<f64>; STATES]) -> DVector<Side> {
    DVector::from_fn(vectors[0].len(), |k, _| {
        Lanes(std::array::from_fn(|lane| vectors[lane][k]))
    })
}

fn lane(m: &DMatrix<Side>, lane: usize) -> DMatrix<f64> {
    m.map(|x| x.0[lane])
}

#[track_caller]
fn assert_near(actual: &DMatrix<f64>, expected: &DMatrix<f64>, tolerance: f64, what: &str) {
    let error = (actual - expected).amax() / expected.amax().max(1.0);
    assert!(error <= tolerance, "{what} is off by {error:e}");
}

#[test]
fn derivatives_over_lanes_equal_those_of_each_state() {
    for model in robots() {
        let points: [Point; STATES] = std::array::from_fn(|seed| random_point(&model, seed as u64));
        let [q, v, w] = [
            side_by_side(&std::array::from_fn(|i| points[i].q.clone())),
            side_by_side(&std::array::from_fn(|i| points[i].v.clone())),
            side_by_side(&std::array::from_fn(|i| points[i].w.clone())),
        ];
        let (q, v, w) = (q.as_slice(), v.as_slice(), w.as_slice());
        let inverse = inverse_dynamics_derivatives(&model, q, v, w);
        let forward = forward_dynamics_derivatives(&model, q, v, w);
        for (i, Point { q, v, w }) in points.iter().enumerate() {
            let (q, v, w) = (q.as_slice(), v.as_slice(), w.as_slice());
            let own = inverse_dynamics_derivatives(&model, q, v, w);
            for (m, own) in [
                (&inverse.dq, own.dq),
                (&inverse.dv, own.dv),
                (&inverse.da, own.da),
            ] {
                assert_eq!(lane(m, i), own, "{}, state {i}", model.name());
            }
            // On plain numbers the tree is worked off in another order.
            let own = forward_dynamics_derivatives(&model, q, v, w);
            for (m, own) in [
                (&forward.dq, own.dq),
                (&forward.dv, own.dv),
                (&forward.dtau, own.dtau),
            ] {
                let what = format!("{}, state {i}: a derivative of v̇", model.name());
                assert_near(&lane(m, i), &own, 10.0 * SAME_ALGEBRA, &what);
            }
        }
    }
}

// δq is added where joints are vector spaces only: elsewhere the axes of the first derivatives turn with q.
#[test]
fn derivatives_over_duals_equal_second_derivatives() {
    for model in robots() {
        let (Point { q, v, w }, nv) = (random_point(&model, 3), model.nv());
        let flat = model.nq() == nv;
        let direction: Vec<f64> = (0..3 * nv)
            .map(|k| {
                if k < nv && !flat {
                    0.0
                } else {
                    (1.0 + k as f64).sin()
                }
            })
            .collect();
        let along = |x: &DVector<f64>, d: &[f64]| -> Vec<Dual<f64, 1>> {
            x.iter().zip(d).map(|(&x, &d)| Dual::new(x, [d])).collect()
        };
        let q_moved = if flat {
            along(&q, &direction[..nv])
        } else {
            q.iter().map(|&x| x.into()).collect()
        };
        let moved = inverse_dynamics_derivatives(
            &model,
            &q_moved,
            &along(&v, &direction[nv..2 * nv]),
            &along(&w, &direction[2 * nv..]),
        );
        let (q, v, w) = (q.as_slice(), v.as_slice(), w.as_slice());
        let second = inverse_dynamics_second_derivatives(&model, q, v, w);
        let direction = DVector::from_vec(direction);
        let products: Vec<_> = second.iter().map(|h| h * &direction).collect();
        let expected = DMatrix::from_fn(nv, 3 * nv, |i, j| products[i][j]);
        for (k, m) in [moved.dq, moved.dv, moved.da].iter().enumerate() {
            let expected = expected.columns(k * nv, nv).into_owned();
            let what = format!("{}: block {k} of ∂²τ", model.name());
            assert_near(&m.map(|x| x.eps[0]), &expected, SAME_ALGEBRA, &what);
        }
    }
}

/// The robot with every parameter changed by a share of itself.
fn changed<P: Scalar>(model: &Model, share: P) -> Model<P> {
    let parameters = model.parameters();
    let all: Vec<P> = parameters.iter().map(|&x| (share + 1.0) * x).collect();
    model.with_parameters(&all)
}

fn forward<P: Scalar + Differentiable>(model: &Model<P>, point: &Point) -> [DMatrix<P>; 3] {
    let lifted = |x: &DVector<f64>| x.map(P::constant);
    let (q, v, w) = (lifted(&point.q), lifted(&point.v), lifted(&point.w));
    let d = forward_dynamics_derivatives(model, q.as_slice(), v.as_slice(), w.as_slice());
    [d.dq, d.dv, d.dtau]
}

#[test]
fn derivatives_over_duals_change_with_parameters_as_differences_say() {
    const SMALL: f64 = 1e-5;
    for model in robots() {
        let point = random_point(&model, 5);
        let exact = forward(&changed(&model, Dual64::new(0.0, 1.0)), &point);
        let plus = forward(&changed(&model, SMALL), &point);
        let minus = forward(&changed(&model, -SMALL), &point);
        for k in 0..3 {
            let slope = (&plus[k] - &minus[k]) / (2.0 * SMALL);
            let exact = exact[k].map(|x| x.eps);
            let what = format!("{}: change of derivative {k} of v̇", model.name());
            assert_near(&exact, &slope, FINITE_DIFFERENCE, &what);
        }
    }
}
