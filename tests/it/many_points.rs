//! Rigid contact with many points: as with the few that matter, and bounded.

use dualbody::cone::Status;
use dualbody::contact::{
    ContactLaw, ContactPoint, Contacts, Feature, RelaxedRigid, Rigid, SolverOptions, Terrain,
};
use dualbody::{Simulator, State};
use nalgebra::{Vector3, vector};

use crate::common::asset;
use crate::common::ground::{energy, free, run};

/// Half the sides of the box of `box.urdf`, m.
const HALF: [f64; 3] = [0.18, 0.12, 0.06];

fn law() -> ContactLaw {
    ContactLaw::Rigid(Rigid::default())
}

/// The box with the points that `keep` leaves of a grid of 15 × 13 on its bottom, and with `limit` points to start a
/// step with.
fn on_grid(keep: impl Fn(usize, usize) -> bool, limit: usize) -> Simulator {
    on_grid_under(law(), keep, limit)
}

fn on_grid_under(law: ContactLaw, keep: impl Fn(usize, usize) -> bool, limit: usize) -> Simulator {
    let model = asset("box.urdf");
    let all = Contacts::new(&model, Terrain::flat(0.0), law);
    let corner = all.points()[0];
    let mut contacts = all.with_selection(|_| false);
    for i in 0..15 {
        for j in 0..13 {
            if keep(i, j) {
                let along = |k: usize, n: usize, half: f64| half * (k as f64 / n as f64 - 1.0);
                let center = vector![along(i, 7, HALF[0]), along(j, 6, HALF[1]), -HALF[2]];
                let point = ContactPoint {
                    center,
                    feature: Feature::Corner,
                    ..corner
                };
                contacts = contacts.with_point(point, law);
            }
        }
    }
    let options = SolverOptions {
        points_per_link: limit,
        ..SolverOptions::default()
    };
    Simulator::new(model)
        .with_contacts(contacts.with_solver_options(options))
        .with_time_step(2e-3)
}

fn is_corner(i: usize, j: usize) -> bool {
    i.is_multiple_of(14) && j.is_multiple_of(12)
}

fn total_force(simulator: &Simulator, state: &State) -> Vector3<f64> {
    let forces = simulator.contact_report(state, &[]).forces;
    forces.iter().fold(Vector3::zeros(), |sum, f| sum + f)
}

// The corners of a flat bottom decide its motion, whichever points of it the solver starts with: dropped on an edge,
// and sliding without turning, where friction does not depend on which points carry. There is one exception: a point that
// would come down within the step stops, so inner points stop a box that rocks where the corners, one edge of which is
// on its way up, let that edge close its gap of 5 µm. Hence the bound.
#[test]
fn grid_of_points_moves_as_its_corners_do() {
    let corners = on_grid(is_corner, 4);
    assert_eq!(corners.contacts().expect("ground").points().len(), 4);
    for limit in [1, 3, 4, 16] {
        let grid = on_grid(|_, _| true, limit);
        assert_eq!(grid.contacts().expect("ground").points().len(), 195);
        for (name, angle, v) in [
            ("dropped on an edge", 0.3, [0.0; 6]),
            ("slides", 0.0, [1.0, 0.3, 0.0, 0.0, 0.0, 0.0]),
        ] {
            let height = if angle == 0.0 { HALF[2] } else { 0.2 };
            let start = free(&corners, [0.0, 0.0, height], angle, v);
            let (expected, actual) = (run(&corners, &start, 1.0), run(&grid, &start, 1.0));
            let error = (&expected.q - &actual.q).amax();
            assert!(
                error < 4e-6,
                "{name}, {limit} points to start with: {error:e}"
            );
            let weight = total_force(&grid, &actual);
            assert!((weight - vector![0.0, 0.0, 9.81]).amax() < 1e-6, "{weight}");
        }
    }
}

// No point that was left out goes into the ground, and the forces obey the laws.
#[test]
fn points_that_are_left_out_do_not_sink() {
    for (acceptable, worst) in [(0.0, Status::Converged), (1e-6, Status::Acceptable)] {
        let simulator = on_grid(|_, _| true, 2);
        let contacts = simulator.contacts().expect("ground").clone();
        let options = SolverOptions {
            acceptable,
            ..contacts.solver_options()
        };
        let contacts = contacts.with_solver_options(options);
        nothing_sinks(&simulator.with_contacts(contacts), worst);
    }
}

fn nothing_sinks(simulator: &Simulator, worst: Status) {
    let start = free(
        simulator,
        [0.0, 0.0, 0.25],
        0.4,
        [0.5, 0.2, 0.0, 2.0, 1.0, 3.0],
    );
    let states = simulator.rollout(&start, 600, |_, _, _| {}).states;
    let initial = energy(simulator.model(), &start);
    for (k, state) in states.iter().enumerate() {
        let report = simulator.contact_report(state, &[]);
        let status = report.certificate.status;
        assert!(status <= worst, "step {k}: {status:?}");
        let deepest = report.points.iter().map(|p| p.depth).fold(0.0, f64::max);
        // Velocities of points obey the law to first order; the remainder is ½ ω² r Δt² per step at 3 rad/s, undone in
        // 20 ms.
        assert!(deepest < 1e-3, "step {k}: {deepest}");
    }
    let last = states.last().expect("states");
    assert!(last.v.amax() < 1e-6 && energy(simulator.model(), last) < initial);
}

// As many iterations as are allowed, and a status that reports the limit.
#[test]
fn limit_of_iterations_is_kept_and_reported() {
    let simulator = on_grid(is_corner, 4);
    let start = free(
        &simulator,
        [0.0, 0.0, HALF[2]],
        0.0,
        [1.0, 0.3, -2.0, 0.5, 0.5, 4.0],
    );
    let with = |iterations| {
        let contacts = simulator.contacts().expect("ground").clone();
        let options = SolverOptions {
            iterations,
            ..contacts.solver_options()
        };
        simulator
            .clone()
            .with_contacts(contacts.with_solver_options(options))
    };
    let enough = with(200).contact_report(&start, &[]).certificate;
    assert_eq!(enough.status, Status::Converged);
    assert!(enough.iterations > 1, "{enough:?}");
    let few = with(1).contact_report(&start, &[]).certificate;
    assert_eq!(few.status, Status::IterationLimit);
    assert!(few.iterations <= 1, "{few:?}");
    assert!(with(1).step(&start, &[]).is_finite());
}

// The limit holds with fewer points than carry the box, and the status reports it.
#[test]
fn limit_of_points_is_kept_and_reported() {
    let relaxed = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    for law in [law(), relaxed] {
        let simulator = on_grid_under(law, |_, _| true, 4);
        let contacts = simulator.contacts().expect("ground").clone();
        let options = SolverOptions {
            points: 1,
            ..contacts.solver_options()
        };
        let simulator = simulator
            .clone()
            .with_contacts(contacts.with_solver_options(options));
        let start = free(&simulator, [0.0, 0.0, HALF[2] - 1e-3], 0.0, [0.0; 6]);
        let report = simulator.contact_report(&start, &[]);
        let carrying = report.forces.iter().filter(|f| f.amax() > 0.0);
        assert_eq!(carrying.count(), 1, "{law:?}");
        let status = report.certificate.status;
        assert_eq!(status, Status::IterationLimit, "{law:?}");
    }
}

#[test]
#[should_panic(expected = "points_per_link is 0, expected at least 1")]
fn no_points_per_link_are_refused() {
    let _ = on_grid(is_corner, 0);
}
