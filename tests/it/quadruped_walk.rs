//! The quadruped of the example `quadruped_walk` walks by its policy: some of the robots, all of which the example lets walk.

#[path = "../../examples/quadruped_walk/leg.rs"]
mod leg;
#[path = "../../examples/quadruped_walk/policy.rs"]
mod policy;
#[path = "../../examples/common/quadruped.rs"]
mod quadruped;
#[path = "../../examples/quadruped_walk/task.rs"]
mod task;
#[path = "../../examples/quadruped_walk/walk.rs"]
mod walk;

const POLICY: &str = include_str!("../../examples/quadruped_walk/policy.txt");

#[test]
fn nine_of_ten_quadrupeds_walk_while_they_are_pushed() {
    let simulator = task::robot().expect("the quadruped");
    let numbers = policy::of_text(POLICY);
    let seeds: Vec<u64> = (0..12).collect();
    let mut all = task::Walk::episodes(&simulator, &seeds);
    let outcomes = walk::walk(&mut all, task::DURATION, |_| &numbers, |_, _| {});
    let walked = outcomes.iter().filter(|own| own.has_walked(task::DURATION));
    assert!(walked.count() >= 11, "{outcomes:?}");
}

/// Feet are where the joints put them.
#[test]
fn joints_of_a_leg_reach_the_place_of_its_foot() {
    for side in [1.0, -1.0] {
        for place in [[0.05, 0.1, -0.25], [-0.1, 0.02, -0.3], [0.0, 0.0838, -0.28]] {
            let foot = [place[0], side * place[1], place[2]];
            let [abduction, hip, knee] = leg::joints(side, foot);
            let x = -0.2 * (hip.sin() + (hip + knee).sin());
            let down = -0.2 * (hip.cos() + (hip + knee).cos());
            let (sin, cos) = abduction.sin_cos();
            let y = side * 0.0838 * cos - down * sin;
            let z = side * 0.0838 * sin + down * cos;
            for (own, wanted) in [x, y, z].iter().zip(foot) {
                assert!(
                    (own - wanted).abs() < 1e-12,
                    "{side} {place:?}: {x} {y} {z}"
                );
            }
        }
    }
}
