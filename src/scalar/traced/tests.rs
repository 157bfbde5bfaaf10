//! Rules, order, memory and bad use of graphs.

use std::panic::{AssertUnwindSafe, catch_unwind};

use super::{Graph, Operation, Port, Traced, trace};
use crate::scalar::{Dual, Scalar, Zero};

/// A graph of one function of three numbers.
fn of(f: impl Fn(Traced, Traced, Traced) -> Traced) -> Graph {
    trace(|t| {
        let x = t.input(Port::vector("x", 3));
        t.output(Port::number("y"), [&f(x[0], x[1], x[2])]);
    })
}

/// Number of operations of a function of three numbers.
fn operations(f: impl Fn(Traced, Traced, Traced) -> Traced) -> usize {
    of(f).counts().operations()
}

fn value(graph: &Graph, x: [f64; 3]) -> f64 {
    graph.evaluate(&x).expect("no conditions")[0]
}

#[test]
fn what_is_known_is_folded() {
    let nothing: [fn(Traced, Traced, Traced) -> Traced; 9] = [
        |a, _, _| a + 0.0,
        |a, _, _| a * 1.0,
        |a, b, _| a * 0.0 + b,
        |a, _, _| a - a,
        |a, _, _| a / a,
        |a, _, _| -(-a),
        |a, b, _| a.select_lt(b, a, a),
        |a, _, _| a.mul_add(Traced::from(0.0), Traced::from(3.0)),
        |_, b, c| Traced::from(1.0).select_lt(Traced::from(2.0), b, c),
    ];
    for (k, f) in nothing.into_iter().enumerate() {
        assert_eq!(operations(f), 0, "{k}");
    }
    // Functions of constants, and products of them.
    assert_eq!(
        operations(|a, _, _| a + Traced::from(0.3).sin_cos().0.exp() * 2.0),
        1
    );
    // Quotients by powers of two are products, others stay.
    let half = of(|a, _, _| a / 2.0);
    assert!(
        half.nodes()
            .iter()
            .any(|node| matches!(node, Operation::Mul(..))),
        "{half}"
    );
    let third = of(|a, _, _| a / 3.0);
    assert!(
        third
            .nodes()
            .iter()
            .any(|node| matches!(node, Operation::Div(..))),
        "{third}"
    );
}

#[test]
fn an_expression_is_recorded_once_whatever_its_order_and_sign() {
    let twice: [fn(Traced, Traced, Traced) -> Traced; 6] = [
        |a, b, c| (a + b) * c / ((b + a) * 5.0 + c) - c,
        |a, b, c| (a * b).exp() + (b * a).exp() * c,
        |a, b, c| (-a * b).exp() + (a * -b).exp() * c,
        |a, b, c| (a - b) * c + (b - a) * b,
        |a, b, c| (a * -2.0).exp() + (-(a * 2.0)).exp() * c + b,
        |a, b, c| (-a).sin_cos().0 * b + a.sin_cos().0 * c,
    ];
    // Each shared part counts once.
    let expected = [6, 4, 5, 4, 6, 4];
    for (k, f) in twice.into_iter().enumerate() {
        let graph = of(f);
        let count = graph.counts().operations();
        assert_eq!(count, expected[k], "{k}: {graph}");
    }
}

#[test]
fn rules_keep_the_value() {
    let functions: [fn(Traced, Traced, Traced) -> Traced; 8] = [
        |a, b, c| (-a).mul_add(b, -c) + a.mul_add(-b, c) * c.mul_add(a, -b),
        |a, b, c| (a - b) / (-c) + (b - a) * c - (-a - b) * (-c + a),
        |a, b, c| a * b + a.mul_add(b, c) - a.mul_add(-b, -c),
        |a, b, c| a.select_lt(b, a.select_lt(b, c, a), a.select_lt(b, b, -c)),
        |a, b, c| a.abs().max(b).min(c * 2.0).clamp(-0.5, 0.7) + a.tanh(),
        |a, b, c| (-a).sin_cos().1 * b.sin_cos().0 - (-b).sin_cos().0 / c,
        |a, b, c| (a / 4.0 - b / -3.0) * -2.5 - c * -1.0,
        |a, b, c| a.powi(5) + b.atan2(c) * (a * a + 1.0).ln() - (b * b).sqrt().exp(),
    ];
    for (k, f) in functions.into_iter().enumerate() {
        let graph = of(f);
        for x in [[0.3, -0.7, 1.9], [-1.2, 0.4, -0.6], [0.5, 0.25, 2.0]] {
            let [a, b, c] = x.map(Traced::from);
            let expected = f(a, b, c).constant_value().expect("constants fold");
            let own = value(&graph, x);
            assert!(
                (own - expected).abs() < 1e-14,
                "{k} at {x:?}: {own}, not {expected}"
            );
        }
    }
}

#[test]
fn what_no_output_depends_on_is_left_out() {
    let graph = trace(|t| {
        let x = t.input(Port::vector("x", 2));
        let _ = (x[0] * 3.0).exp();
        t.output(Port::number("y"), [&(x[1] + 1.0)]);
    });
    let counts = graph.counts();
    assert_eq!(
        (counts.operations(), counts.constants, counts.inputs),
        (1, 1, 2)
    );
    assert_eq!(
        graph.to_string(),
        "%0 = 1.0\n%1 = x[0]\n%2 = x[1]\n%3 = Add %2 %0\ny[0] = %3\n"
    );
}

// A sum of products, recorded breadth first: all products would wait at once.
#[test]
fn few_results_are_alive_at_once() {
    const N: usize = 100;
    let graph = trace(|t| {
        let x = t.input(Port::vector("x", N));
        let products: Vec<_> = x.iter().map(|&x| (x * x).exp()).collect();
        let sum = products.iter().fold(Traced::zero(), |sum, &x| sum + x);
        t.output(Port::number("y"), [&sum]);
    });
    assert!(graph.live_values() <= 3, "{}", graph.live_values());
    let x: Vec<f64> = (0..N).map(|k| (k as f64).sin()).collect();
    let expected: f64 = x.iter().map(|x| (x * x).exp()).sum();
    assert!((graph.evaluate(&x).expect("no conditions")[0] - expected).abs() < 1e-12);
}

// Sine and cosine are found together, and the angle is divided by before the cosine is asked for.
#[test]
fn angle_is_kept_as_long_as_it_is_used() {
    let graph = trace(|t| {
        let x = t.input(Port::vector("x", 1));
        let angle = x[0] * x[0] + 1.0;
        let (sin, cos) = angle.sin_cos();
        t.output(Port::vector("y", 2), &[sin / angle, cos]);
    });
    let angle: f64 = 1.25;
    let found = graph.evaluate(&[0.5]).expect("no conditions");
    assert_eq!(found, [angle.sin() / angle, angle.cos()]);
}

/// yₖ = sin xₖ times its neighbours: a Jacobian of three diagonals.
fn banded(n: usize) -> Graph {
    trace(|t| {
        let x = t.input(Port::vector("x", n));
        let y = (0..n).map(|k| {
            let after = if k + 1 < n {
                x[k + 1]
            } else {
                Traced::from(2.0)
            };
            let before = if k > 0 { x[k - 1] } else { Traced::from(3.0) };
            x[k].sin_cos().0 * after + before
        });
        t.output(Port::vector("y", n), &y.collect::<Vec<_>>());
    })
}

#[test]
fn colours_of_a_band_are_as_many_as_it_is_wide() {
    let graph = banded(20);
    let all: Vec<usize> = (0..20).collect();
    let sparsity = super::sparsity::Sparsity::of(&graph, &all, &all);
    assert_eq!(sparsity.input_colours(20).len(), 3);
    assert_eq!(sparsity.output_colours(20).len(), 3);
}

/// Jacobian of a graph at a point by dual numbers, column after column.
fn by_duals(graph: &Graph, x: &[f64]) -> Vec<f64> {
    let column = |k: usize| {
        let moved = x.iter().enumerate();
        let moved: Vec<Dual<f64, 1>> = moved
            .map(|(i, &x)| Dual::new(x, [if i == k { 1.0 } else { 0.0 }]))
            .collect();
        graph.evaluate(&moved).expect("no conditions")
    };
    let columns = (0..x.len()).flat_map(column);
    columns.map(|y| y.eps[0]).collect()
}

#[test]
fn jacobians_by_both_sweeps_equal_dual_numbers() {
    // Wide: forward has as many colours as inputs; reverse, of a sum of all, one.
    let wide = trace(|t| {
        let x = t.input(Port::vector("x", 6));
        let product = x
            .iter()
            .fold(Traced::from(1.0), |product, &x| product * (x + 2.0));
        let other = (x[0] / x[1]).atan2(x[2]) + x[3].select_lt(x[4], x[5].tanh(), x[5].sqrt());
        t.output(Port::number("y"), [&(product + other)]);
    });
    let tall = trace(|t| {
        let x = t.input(Port::number("x"))[0];
        let (s, c) = x.sin_cos();
        let y = [
            s,
            c * x,
            x.exp(),
            x.ln(),
            x.sqrt(),
            (x * 0.3).asin(),
            (x * 0.3).acos(),
            x.powi(3),
        ];
        t.output(Port::vector("y", 8), &y);
    });
    for graph in [banded(7), wide, tall] {
        let slopes = graph.jacobian(&["y"], &["x"]).expect("ports");
        let x: Vec<f64> = (0..graph.n_inputs())
            .map(|k| 0.4 + 0.1 * k as f64)
            .collect();
        let own = slopes.evaluate(&x).expect("no conditions");
        let exact = by_duals(&graph, &x);
        assert_eq!(own.len(), exact.len());
        for (own, exact) in own.iter().zip(exact) {
            assert!(
                (own - exact).abs() < 1e-12 * exact.abs().max(1.0),
                "{own}, not {exact}"
            );
        }
    }
}

#[test]
fn the_adjoint_of_every_operation_equals_its_dual_number() {
    let functions: [fn(Traced, Traced, Traced) -> Traced; 8] = [
        |a, b, c| a.mul_add(b, c) * (a * b - c) / (-a).mul_add(c, b),
        |a, b, c| a.mul_add(b, -c).exp() - a / b + c,
        |a, b, c| (a * 0.5).asin() * (b * 0.5).acos() - c.tanh(),
        |a, b, c| a.atan2(b) + (a * b * c).abs().sqrt(),
        |a, b, c| a.select_lt(b, a * c, b * c) + b.select_lt(a, c, -c),
        |a, b, c| a.sin_cos().0 * b.sin_cos().1 - (a - c).sin_cos().1,
        |a, b, c| (a * a + b * b).ln() * -c,
        |a, b, c| a.tan() + b.powi(-2) * c.max(a),
    ];
    for (k, f) in functions.into_iter().enumerate() {
        let graph = of(f);
        let gradient = graph.gradient("y", &["x"]).expect("ports");
        for x in [[0.3, 0.7, 0.9], [0.8, -0.4, 0.6]] {
            let own = gradient.evaluate(&x).expect("no conditions");
            for (own, exact) in own.iter().zip(by_duals(&graph, &x)) {
                assert!(
                    (own - exact).abs() < 1e-12 * exact.abs().max(1.0),
                    "{k}: {own}, not {exact}"
                );
            }
        }
    }
}

#[test]
fn conditions_are_kept_through_derivatives() {
    let graph = trace(|t| {
        let x = t.input(Port::number("x"))[0];
        assert!((x * x).is_at_most(4.0, "x is small"));
        assert!((x * x).is_at_most(4.0, "x is small"));
        t.output(Port::number("y"), [&x.exp()]);
    });
    for graph in [graph.gradient("y", &["x"]).expect("ports"), graph] {
        assert_eq!(graph.conditions().len(), 1);
        assert!(graph.evaluate(&[1.9]).is_ok());
        let error = graph.evaluate(&[2.1]).expect_err("large");
        assert_eq!((error.index, &error.condition[..]), (0, "x is small"));
    }
}

/// Message with which some work panics.
fn panic_of(work: impl FnOnce()) -> String {
    let cause = catch_unwind(AssertUnwindSafe(work)).expect_err("a panic");
    let text = cause.downcast_ref::<String>().cloned();
    text.or_else(|| cause.downcast_ref::<&str>().map(|&text| text.to_owned()))
        .unwrap_or_default()
}

#[test]
fn values_and_numbers_of_other_traces_are_refused() {
    let line = line!() + 1;
    let text = panic_of(|| drop(of(|a, _, _| Traced::from(a.value(0)))));
    assert!(text.contains(&format!("{}:{line}:", file!())), "{text}");
    let mut kept = Traced::zero();
    of(|a, _, _| a)
        .evaluate(&[1.0, 2.0, 3.0])
        .expect("no conditions");
    trace(|t| kept = t.input(Port::number("x"))[0]);
    assert!(
        panic_of(|| {
            let _ = kept + 1.0;
        })
        .contains("after its trace")
    );
    assert!(
        panic_of(|| {
            let _ = of(|a, _, _| a + kept);
        })
        .contains("another trace")
    );
    // One trace within another, of its own numbers.
    let outer = of(|a, b, _| {
        let inner = of(|x, y, _| x * y + 1.0);
        assert_eq!(inner.counts().operations(), 2);
        a + b
    });
    assert_eq!(value(&outer, [1.0, 2.0, 0.0]), 3.0);
    let twice = |t: &mut super::Tracer| (0..2).for_each(|_| drop(t.input(Port::number("x"))));
    assert!(panic_of(|| drop(trace(twice))).contains("two inputs"));
    let graph = of(|a, _, _| a);
    assert!(panic_of(|| drop(graph.evaluate(&[1.0]))).contains("inputs"));
    assert!(graph.jacobian(&["y"], &["z"]).is_err());
}
