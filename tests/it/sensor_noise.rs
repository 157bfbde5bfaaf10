//! Imperfections of sensors against their settings: deviations, walks, steps, rates, delays, seeds.

use dualbody::model::samples;
use dualbody::sim::{NoisySensors, Sensor, SensorNoise, Sensors};

/// Time step, s.
const DT: f64 = 1e-3;

/// An encoder and a centre of mass: four numbers.
fn sensors() -> Sensors {
    let model = samples::pendulum();
    let pivot = model.find_joint("pivot").expect("a joint");
    let all = [
        ("encoder", Sensor::JointPosition(pivot)),
        ("com", Sensor::CenterOfMass),
    ];
    Sensors::new(&model, all)
}

fn noisy(noise: SensorNoise, seed: u64) -> NoisySensors {
    let of = NoisySensors::new(&sensors(), DT, seed);
    of.with_noise("encoder", noise).expect("a sensor")
}

/// Readings of an encoder of `exact(step)`, step after step.
fn readings(mut of: NoisySensors, steps: usize, exact: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut out = [0.0; 4];
    let read = |k: usize| {
        of.sample_into(&[exact(k), 1.0, 2.0, 3.0], &mut out);
        assert_eq!(out[1..], [1.0, 2.0, 3.0], "other sensors are exact");
        out[0]
    };
    (0..steps).map(read).collect()
}

fn deviation(x: &[f64]) -> f64 {
    let n = x.len() as f64;
    let mean = x.iter().sum::<f64>() / n;
    (x.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n).sqrt()
}

#[test]
fn sensors_without_imperfections_read_what_is_there() {
    let y = readings(noisy(SensorNoise::default(), 3), 5, |k| k as f64);
    assert_eq!(y, [0.0, 1.0, 2.0, 3.0, 4.0]);
}

#[test]
fn white_noise_has_its_deviation_and_no_memory() {
    let noise = SensorNoise {
        white: 0.2,
        ..SensorNoise::default()
    };
    let y = readings(noisy(noise, 1), 20_000, |_| 5.0);
    assert!((deviation(&y) - 0.2).abs() < 0.005, "{}", deviation(&y));
    let products: f64 = y.windows(2).map(|y| (y[0] - 5.0) * (y[1] - 5.0)).sum();
    assert!((products / 20_000.0).abs() < 0.002, "{products}");
}

#[test]
fn biases_of_many_seeds_have_their_deviation_and_walk_with_the_root_of_time() {
    let noise = SensorNoise {
        bias: 0.5,
        bias_walk: 2.0,
        ..SensorNoise::default()
    };
    let (mut starts, mut walks) = (Vec::new(), Vec::new());
    for seed in 0..2_000 {
        let y = readings(noisy(noise, seed), 251, |_| 0.0);
        starts.push(y[0]);
        walks.push(y[250] - y[0]);
    }
    assert!(
        (deviation(&starts) - 0.5).abs() < 0.03,
        "{}",
        deviation(&starts)
    );
    // 2 √0.25 s
    assert!(
        (deviation(&walks) - 1.0).abs() < 0.06,
        "{}",
        deviation(&walks)
    );
}

#[test]
fn samples_are_rounded_and_bounded() {
    let noise = SensorNoise {
        resolution: 0.25,
        limit: 1.0,
        ..SensorNoise::default()
    };
    let y = readings(noisy(noise, 1), 6, |k| [0.3, 0.4, -0.3, 0.99, 7.0, -7.0][k]);
    assert_eq!(y, [0.25, 0.5, -0.25, 1.0, 1.0, -1.0]);
}

#[test]
fn samples_are_taken_at_their_rate_and_read_late() {
    let slow = SensorNoise {
        period: 3.0 * DT,
        ..SensorNoise::default()
    };
    let y = readings(noisy(slow, 1), 8, |k| k as f64);
    assert_eq!(y, [0.0, 0.0, 0.0, 3.0, 3.0, 3.0, 6.0, 6.0]);
    let late = SensorNoise {
        delay: 2.0 * DT,
        ..SensorNoise::default()
    };
    let y = readings(noisy(late, 1), 5, |k| k as f64);
    assert_eq!(y, [0.0, 0.0, 0.0, 1.0, 2.0]);
    // 2.5 steps: a sample every second and every third one, 400 in 1,000
    let odd = SensorNoise {
        period: 2.5 * DT,
        ..SensorNoise::default()
    };
    let y = readings(noisy(odd, 1), 1_000, |k| k as f64);
    let changes = y.windows(2).filter(|y| y[0] != y[1]).count();
    assert_eq!(changes, 399);
}

#[test]
fn seeds_alone_decide_what_is_read() {
    let noise = SensorNoise {
        white: 0.1,
        bias: 0.1,
        bias_walk: 0.1,
        ..SensorNoise::default()
    };
    let first = readings(noisy(noise, 8), 20, |_| 0.0);
    assert_eq!(readings(noisy(noise, 8), 20, |_| 0.0), first);
    assert_ne!(readings(noisy(noise, 9), 20, |_| 0.0), first);
    let mut again = noisy(noise, 9);
    again.sample_into(&[0.0; 4], &mut [0.0; 4]);
    again.reset(8);
    assert_eq!(
        readings(again, 20, |_| 0.0),
        first,
        "a reset state is a new one"
    );
    // Sensors of one state have noise of their own.
    let both = noisy(noise, 8).with_noise("com", noise).expect("a sensor");
    let mut both = both;
    let mut y = [0.0; 4];
    both.sample_into(&[0.0; 4], &mut y);
    assert_eq!(y[0], first[0], "whatever other sensors there are");
    assert!(y[0] != y[1] && y[1] != y[2] && y[2] != y[3]);
}

#[test]
fn sensors_that_are_not_there_are_named() {
    let of = NoisySensors::new(&sensors(), DT, 0);
    let error = of
        .with_noise("gyro", SensorNoise::default())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("sensor \"gyro\"") && error.contains("encoder"),
        "{error}"
    );
}

#[test]
#[should_panic(expected = "white noise of a sensor is -1")]
fn negative_deviations_are_refused() {
    let _ = noisy(
        SensorNoise {
            white: -1.0,
            ..SensorNoise::default()
        },
        0,
    );
}
