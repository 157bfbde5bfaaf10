use dualbody::{Model, Simulator, State, dynamics};
use std::time::Instant;
fn median(mut f: impl FnMut()) -> f64 {
    for _ in 0..20 {
        f();
    }
    let mut t: Vec<f64> = (0..301)
        .map(|_| {
            let s = Instant::now();
            for _ in 0..20 {
                f();
            }
            s.elapsed().as_secs_f64() / 20.0
        })
        .collect();
    t.sort_by(f64::total_cmp);
    t[150] * 1e6
}
fn main() {
    for name in ["cartpole", "panda", "quadruped", "humanoid"] {
        let Ok(model) = Model::from_urdf_file(format!("assets/{name}.urdf")) else {
            println!("no {name}");
            continue;
        };
        let simulator = Simulator::new(model.clone()).with_time_step(0.01);
        let q = model.neutral();
        let v = vec![0.1; model.nv()];
        let state = State::new(q.as_slice(), &v);
        let u = vec![0.0; simulator.nu()];
        let tau = vec![0.0; model.nv()];
        println!(
            "{name:10} step {:8.2} linearize {:8.2} fd {:8.2} id {:8.2} M {:8.2} dfd {:8.2} did {:8.2}",
            median(|| {
                std::hint::black_box(simulator.step(&state, &u));
            }),
            median(|| {
                std::hint::black_box(simulator.linearize(&state, &u));
            }),
            median(|| {
                std::hint::black_box(dynamics::forward_dynamics(&model, q.as_slice(), &v, &tau));
            }),
            median(|| {
                std::hint::black_box(dynamics::inverse_dynamics(&model, q.as_slice(), &v, &tau));
            }),
            median(|| {
                std::hint::black_box(dynamics::mass_matrix(&model, q.as_slice()));
            }),
            median(|| {
                std::hint::black_box(dynamics::forward_dynamics_derivatives(
                    &model,
                    q.as_slice(),
                    &v,
                    &tau,
                ));
            }),
            median(|| {
                std::hint::black_box(dynamics::inverse_dynamics_derivatives(
                    &model,
                    q.as_slice(),
                    &v,
                    &tau,
                ));
            })
        );
    }
}
