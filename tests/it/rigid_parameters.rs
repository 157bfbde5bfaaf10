//! Derivatives of a step in the numbers of rigid laws and of the ground, against finite differences.

use dualbody::autodiff::{VectorFunction, jacobian};
use dualbody::contact::{
    ContactLaw, Impedance, Reference, RelaxedRigid, Rigid, Sigmoid, Smoothing, Terrain,
};
use dualbody::{Cast, Scalar, Simulator, State};
use nalgebra::{DMatrix, DVector};

use crate::common::asset;
use crate::common::ground::{free, hills, on, waves};

/// A law from its numbers.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// Friction, restitution, recovery time.
    Rigid,
    /// Friction, time constant, damping ratio, impedance, ratio of impedances.
    Relaxed,
    /// Friction, stiffness, damping, impedance, ratio of impedances.
    Direct,
}

impl Kind {
    fn numbers(self) -> &'static [f64] {
        match self {
            Self::Rigid => &[0.5, 0.3, 0.02],
            Self::Relaxed => &[0.5, 0.02, 0.9, 0.8, 0.95, 1e-3, 0.5, 2.0, 1.5],
            Self::Direct => &[0.5, 2500.0, 90.0, 0.8, 0.95, 1e-3, 0.2, 2.5, 1.5],
        }
    }

    fn law<T: Scalar>(self, x: &[T]) -> ContactLaw<T> {
        let relaxed = |reference| {
            ContactLaw::RelaxedRigid(RelaxedRigid {
                friction: x[0],
                reference,
                impedance: Impedance {
                    least: x[3],
                    largest: x[4],
                    width: x[5],
                    sigmoid: Sigmoid::new(x[6], x[7]),
                },
                friction_impedance_ratio: x[8],
            })
        };
        match self {
            Self::Rigid => ContactLaw::Rigid(Rigid {
                friction: x[0],
                restitution: x[1],
                recovery_time: x[2],
            }),
            Self::Relaxed => relaxed(Reference::TimeConstant {
                time_constant: x[1],
                damping_ratio: x[2],
            }),
            Self::Direct => relaxed(Reference::Direct {
                stiffness: x[1],
                damping: x[2],
            }),
        }
    }
}

/// The velocity after a step as a function of the numbers of law and ground, each beside its own size.
struct InNumbers {
    kind: Kind,
    simulator: Simulator,
    state: State,
    at: Vec<f64>,
}

impl InNumbers {
    fn new(kind: Kind, simulator: &Simulator, state: State) -> Self {
        let mut at = kind.numbers().to_vec();
        at.extend(
            simulator
                .contacts()
                .expect("contacts")
                .terrain()
                .parameters(),
        );
        Self {
            kind,
            simulator: simulator.clone(),
            state,
            at,
        }
    }

    /// By how much a number is moved: its size, or a metre where it has none.
    fn size(&self, k: usize) -> f64 {
        if k < self.kind.numbers().len() {
            self.at[k]
        } else {
            1.0
        }
    }

    /// By differences to one side.
    fn difference(&self, k: usize, by: f64) -> DVector<f64> {
        let mut x = vec![0.0; self.at.len()];
        let (mut moved, mut here) = (vec![0.0; self.n_outputs()], vec![0.0; self.n_outputs()]);
        self.eval(&x, &mut here);
        x[k] = by;
        self.eval(&x, &mut moved);
        (DVector::from_vec(moved) - DVector::from_vec(here)) / by
    }

    fn differences(&self, by: f64) -> DMatrix<f64> {
        let columns: Vec<_> = (0..self.at.len())
            .map(|k| 0.5 * (self.difference(k, by) + self.difference(k, -by)))
            .collect();
        DMatrix::from_columns(&columns)
    }

    fn derivatives(&self) -> DMatrix<f64> {
        jacobian(self, &vec![0.0; self.at.len()])
    }
}

impl VectorFunction for InNumbers {
    fn n_outputs(&self) -> usize {
        self.state.v.len()
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let moved = |(k, &x): (usize, &T)| x * self.size(k) + self.at[k];
        let numbers: Vec<T> = x.iter().enumerate().map(moved).collect();
        let (of_law, of_ground) = numbers.split_at(self.kind.numbers().len());
        let own = self.simulator.contacts().expect("contacts");
        let ground = own.terrain().with_parameters(of_ground);
        let contacts = own.with_laws(&vec![self.kind.law(of_law); own.points().len()]);
        let simulator: Simulator<T> = self.simulator.cast();
        let simulator = simulator.with_contacts(contacts.with_terrain(ground));
        let next = simulator.step(&self.state.cast(), &[]);
        y.copy_from_slice(next.v.as_slice());
    }
}

/// A box flat in or over the ground at the origin, by a gap.
fn flat(simulator: &Simulator, gap: f64, v: [f64; 6]) -> State {
    let terrain = simulator.contacts().expect("contacts").terrain();
    let ground = terrain.surface(&0.0, &0.0);
    let (n, angle) = (ground.normal(), -ground.slope[0].atan());
    let p = n * (0.06 + gap);
    free(simulator, [p.x, p.y, p.z + ground.height], angle, v)
}

/// Makes a state on a corner. On a flat side, the law of impacts at four corners at once can hold for just one slope
/// of the ground, and the velocity is nonsmooth there.
fn on_a_corner(simulator: &Simulator, gap: f64, v: [f64; 6]) -> State {
    let turn = nalgebra::UnitQuaternion::from_euler_angles(0.3, 0.2, 0.1);
    let mut state = simulator.neutral_state();
    state.q.as_mut_slice()[3..].copy_from_slice(&[turn.w, turn.i, turn.j, turn.k]);
    state.v.copy_from_slice(&v);
    let report = simulator.contact_report(&state, &[]);
    let depths = report
        .points
        .iter()
        .map(|point| point.depth / point.normal.z);
    state.q[2] += depths.fold(f64::NEG_INFINITY, f64::max) + gap;
    state
}

/// In every mode, also at rest exactly.
fn moments(simulator: &Simulator) -> Vec<(&'static str, State)> {
    vec![
        (
            "flight",
            flat(simulator, 0.5, [1.0, 0.4, -0.1, 0.2, 0.1, 0.5]),
        ),
        ("still", flat(simulator, -3e-4, [0.0; 6])),
        (
            "sticking",
            flat(simulator, -3e-4, [1e-3, 0.0, 0.0, 0.0, 0.0, 1e-3]),
        ),
        (
            "sliding",
            flat(simulator, -3e-4, [1.0, 0.4, 0.0, 0.0, 0.0, 0.0]),
        ),
        (
            "impact",
            on_a_corner(simulator, -3e-4, [0.4, 0.1, -1.0, 0.2, 0.1, 0.5]),
        ),
        (
            "landing",
            on_a_corner(simulator, 2e-4, [0.3, 0.1, -1.0, 0.2, 0.1, 0.5]),
        ),
    ]
}

const KINDS: [Kind; 3] = [Kind::Rigid, Kind::Relaxed, Kind::Direct];

fn robot(model: &str, terrain: &Terrain, kind: Kind) -> Simulator {
    on(asset(model), terrain.clone(), kind.law(kind.numbers()))
}

#[track_caller]
fn assert_equals_differences(f: &InNumbers, what: &str) {
    let (exact, numeric) = (f.derivatives(), f.differences(1e-6));
    let error = (&exact - &numeric).amax() / numeric.amax().max(1e-9);
    assert!(
        error < 1e-5,
        "{:?} {what}: {error:e} {exact} {numeric}",
        f.kind
    );
}

#[test]
fn derivatives_in_numbers_of_rigid_laws_and_ground_equal_finite_differences() {
    for kind in KINDS {
        for terrain in [Terrain::incline(0.05), hills(), waves()] {
            let simulator = robot("box.urdf", &terrain, kind);
            for (name, state) in moments(&simulator) {
                let f = InNumbers::new(kind, &simulator, state);
                assert_equals_differences(&f, &format!("{terrain:?} {name}"));
            }
        }
    }
}

#[test]
fn derivatives_in_numbers_of_smoothed_laws_equal_finite_differences() {
    for kind in KINDS {
        let simulator = robot("box.urdf", &Terrain::incline(0.05), kind);
        let contacts = simulator.contacts().expect("contacts").clone();
        let simulator = simulator.with_contacts(contacts.with_smoothing(Smoothing::new(0.1)));
        for gap in [0.01, -3e-4] {
            let state = on_a_corner(&simulator, gap, [0.4, 0.1, -1.0, 0.2, 0.1, 0.5]);
            let f = InNumbers::new(kind, &simulator, state);
            assert_equals_differences(&f, &format!("smoothed at {gap}"));
            // The height of the ground.
            let of_ground = f.derivatives().column(kind.numbers().len()).amax();
            assert!(of_ground > 1e-5, "{kind:?} at {gap}: {of_ground:e}");
        }
    }
}

// A ball that touches just so: each derivative is the one to the left or to the right, or, at rest on the surface, the
// mean of both. Relaxed contact jumps there, to a force in the ground from none above it, and has the derivatives of
// free flight.
#[test]
fn derivatives_in_numbers_are_one_sided_or_their_mean_where_a_ball_touches() {
    for kind in KINDS {
        let simulator = robot("sphere.urdf", &Terrain::flat(0.0), kind);
        let jumps = !matches!(kind, Kind::Rigid);
        for (v, w) in [(0.0, 0.0), (0.0, 0.5), (-1.0, 0.5), (1.0, 0.0)] {
            let state = free(&simulator, [0.0, 0.0, 0.1], 0.0, [w, 0.0, v, 0.0, 0.0, 0.0]);
            let f = InNumbers::new(kind, &simulator, state);
            let exact = f.derivatives();
            assert!(exact.iter().all(|x| x.is_finite()), "{kind:?}: {exact}");
            assert!(!jumps || exact.amax() == 0.0, "{kind:?}: {exact}");
            for k in (0..exact.ncols()).filter(|_| !jumps) {
                let [left, right] = [-1e-8, 1e-8].map(|by| f.difference(k, by));
                let mean = (&left + &right) * 0.5;
                let off = |rule: &DVector<f64>| (exact.column(k) - rule).amax();
                let at_rest = v == 0.0;
                let side = off(&left).min(off(&right));
                let off = if at_rest { side.min(off(&mean)) } else { side };
                let error = off / left.amax().max(1.0);
                assert!(
                    error < 1e-5,
                    "{kind:?} ({v}, {w}) {k}: {left} {right} {exact}"
                );
            }
        }
    }
}

// In a step, a ball that slides at w loses μ g Δt of its speed; one that lands at v comes back at e (v + ½ g Δt), as velocities are those of half a step ago.
#[test]
fn derivatives_in_friction_and_restitution_equal_their_closed_forms() {
    let simulator = robot("sphere.urdf", &Terrain::flat(0.0), Kind::Rigid);
    let of = |v: [f64; 6], k: usize, row: usize| {
        let state = free(&simulator, [0.0, 0.0, 0.1 - 1e-9], 0.0, v);
        let f = InNumbers::new(Kind::Rigid, &simulator, state);
        f.derivatives()[(row, k)] / f.size(k)
    };
    let slope = of([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0, 0);
    assert!((slope + 9.81e-3).abs() < 1e-6, "{slope}");
    let slope = of([0.0, 0.0, -2.0, 0.0, 0.0, 0.0], 1, 2);
    assert!((slope - 2.0 - 0.5 * 9.81e-3).abs() < 1e-7, "{slope}");
}

// Redundant corners, which part at once or hold at once: finite.
#[test]
fn derivatives_in_numbers_are_finite_where_a_box_touches() {
    for kind in KINDS {
        let simulator = robot("box.urdf", &Terrain::flat(0.0), kind);
        for v in [
            [0.0; 6],
            [0.3, 0.0, 0.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, -1.0, 0.2, 0.1, 0.3],
        ] {
            let state = flat(&simulator, 0.0, v);
            let exact = InNumbers::new(kind, &simulator, state).derivatives();
            assert!(
                exact.iter().all(|x| x.is_finite()),
                "{kind:?} {v:?}: {exact}"
            );
            assert!(exact.amax() < 1e4, "{kind:?} {v:?}: {exact}");
        }
    }
}
