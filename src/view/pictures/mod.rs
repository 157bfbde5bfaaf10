//! Pictures and animations of recordings, rendered on the CPU, without browser and GPU.
//!
//! | file | content |
//! |---|---|
//! | `surface` | triangles of the shapes |
//! | `arrows` | forces as arrows |
//! | `stage` | objects in the picture and their poses |
//! | `eye` | the camera |
//! | `raster` | triangles to samples |
//! | `draw` | samples to pixels: light, floor, shadow |
//! | `animation` | sequences of pictures as a GIF |
//!
//! Pictures use the camera, colours, light, floor and shadow of the HTML viewer. Traces, frames and constraints are in the viewer only.

mod animation;
mod arrows;
mod draw;
mod eye;
mod raster;
mod stage;
mod surface;

use std::path::Path;

use super::files::write;
use super::png;
use super::recording::Recording;
use crate::error::RecordingError;
use crate::sim::State;
use animation::Animation;
use arrows::arrows;
use draw::Drawing;
use eye::Eye;
use stage::{Poses, Stage, StagePiece};

/// Most pixels of a picture: more than any screen has, and 100 MB while it is drawn.
const MAX_PIXELS: u64 = 1 << 22;

/// Most pictures of an animation: an hour at 25 a second.
const MAX_FRAMES: f64 = 90_000.0;

/// Size of pictures, and pace of animations.
///
/// # Examples
/// ```
/// use dualbody::{State, model::samples, view::{PictureOptions, Recording}};
///
/// let mut recording = Recording::new(&samples::pendulum());
/// recording.push(0.0, &State::new(&[0.5], &[0.0]), &[]);
/// let picture = recording.picture(0.0, PictureOptions { width: 64, height: 48, ..PictureOptions::default() });
/// assert_eq!(picture.pixels.len(), 64 * 48 * 3);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureOptions {
    /// Width, pixels; 640 by default.
    pub width: u32,
    /// Height, pixels; 480 by default.
    pub height: u32,
    /// Pictures per second of the animation; 25 by default. Browsers show rates above 50 slower.
    pub rate: f64,
    /// Seconds of motion per second of the animation; 1 by default, less for slow motion.
    pub speed: f64,
}

impl Default for PictureOptions {
    /// 640 × 480 pixels, 25 pictures a second, in real time.
    fn default() -> Self {
        Self {
            width: 640,
            height: 480,
            rate: 25.0,
            speed: 1.0,
        }
    }
}

impl PictureOptions {
    /// # Panics
    /// If a picture has no pixel or too many, or rate or speed are not positive.
    fn check(&self) {
        let Self {
            width,
            height,
            rate,
            speed,
        } = *self;
        let pixels = u64::from(width) * u64::from(height);
        assert!(
            (1..=MAX_PIXELS).contains(&pixels) && width.max(height) <= u32::from(u16::MAX),
            "a picture of {width} × {height} pixels: 1 to {MAX_PIXELS} are drawn"
        );
        for (name, x) in [("rate", rate), ("speed", speed)] {
            assert!(
                x > 0.0 && x.is_finite(),
                "the {name} {x} of an animation is not positive and finite"
            );
        }
    }
}

/// Picture: rows of pixels from the top, each red, green, blue.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Bytes, `3 · width · height`.
    pub pixels: Vec<u8>,
}

impl Picture {
    /// The picture as a PNG file.
    pub fn to_png(&self) -> Vec<u8> {
        png::encode(self.width, self.height, &self.pixels)
    }
}

/// Draws robots in arbitrary states, for pictures while a simulation runs.
///
/// Meshes are read once; a picture of the quadruped at 640 × 480 takes about 30 ms.
///
/// # Examples
/// ```
/// use dualbody::{State, model::samples, view::{PictureOptions, Pictures, Recording}};
///
/// let recording = Recording::new(&samples::pendulum());
/// let options = PictureOptions { width: 64, height: 48, ..PictureOptions::default() };
/// let pictures = Pictures::new(&recording, options);
/// let hanging = pictures.of(&[&State::new(&[0.0], &[0.0])]);
/// let turned = pictures.of(&[&State::new(&[1.0], &[0.0])]);
/// assert_ne!(hanging, turned);
/// ```
#[derive(Debug)]
pub struct Pictures {
    stage: Stage,
    eye: Eye,
    options: PictureOptions,
    warnings: Vec<String>,
}

impl Pictures {
    /// Uses the robots of a recording, its scene objects, and its camera; without a camera, the whole recorded motion is in the picture.
    ///
    /// # Panics
    /// If a picture has no pixel or more than four million, or rate or speed are not positive.
    pub fn new(recording: &Recording, options: PictureOptions) -> Self {
        options.check();
        let (stage, warnings) = Stage::new(recording);
        let eye = match recording.camera {
            Some(camera) => Eye::new(camera),
            None => Eye::around(stage.bounds(), options),
        };
        Self {
            stage,
            eye,
            options,
            warnings,
        }
    }

    /// Draws the robots in these states, one per robot; a state that is not finite is drawn at the neutral configuration.
    ///
    /// # Panics
    /// If there is not one state for each robot, or one has the wrong length.
    pub fn of(&self, states: &[&State]) -> Picture {
        let configurations: Vec<&[f64]> = states.iter().map(|state| state.q.as_slice()).collect();
        let poses = self.stage.poses(&configurations);
        self.draw(&[], &poses)
    }

    /// Remarks on meshes that cannot be shown.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    fn draw(&self, more: &[StagePiece], poses: &Poses) -> Picture {
        Drawing::new(&self.eye, self.options).draw(&self.stage, more, poses)
    }

    /// The picture of a recording at a time, between its moments interpolated.
    fn of_recording(&self, recording: &Recording, time: f64) -> Picture {
        let tracks = recording.robots.iter();
        let configurations: Vec<_> = tracks
            .map(|track| stage::configuration(recording, track, time))
            .collect();
        let slices: Vec<&[f64]> = configurations.iter().map(|q| q.as_slice()).collect();
        let poses = self.stage.poses(&slices);
        self.draw(&arrows(&self.stage, recording, &poses, time), &poses)
    }
}

impl Recording {
    /// Draws the robots at a time, s; before the first and after the last recorded time the nearest one. An empty recording shows the neutral configuration.
    ///
    /// # Panics
    /// If the time is NaN, a picture has no pixel or more than four million.
    pub fn picture(&self, time: f64, options: PictureOptions) -> Picture {
        assert!(!time.is_nan(), "the time of a picture is not a number");
        Pictures::new(self, options).of_recording(self, time)
    }

    /// Writes the [picture](Self::picture) at a time as PNG. Creates the folder.
    ///
    /// # Errors
    /// If the file cannot be written.
    ///
    /// # Panics
    /// As [`picture`](Self::picture).
    pub fn save_png(
        &self,
        path: impl AsRef<Path>,
        time: f64,
        options: PictureOptions,
    ) -> Result<(), RecordingError> {
        write(path.as_ref(), self.picture(time, options).to_png())
    }

    /// Writes the motion as a repeating GIF animation, which browsers, notebooks and code hosts play without a player or codec. Creates the folder.
    ///
    /// It has 255 colours and times in multiples of 10 ms: rates of 25 and 50 pictures per second are exact.
    ///
    /// # Errors
    /// If the file cannot be written.
    ///
    /// # Panics
    /// As [`picture`](Self::picture); if rate or speed are not positive, or there would be more than 90,000 pictures.
    ///
    /// # Examples
    /// ```no_run
    /// use dualbody::{Simulator, State, model::samples, view::{PictureOptions, Recording}};
    ///
    /// let simulator = Simulator::new(samples::cartpole()).with_time_step(0.01);
    /// let rollout = simulator.rollout(&State::new(&[0.0, 0.5], &[0.0; 2]), 300, |_, _, _| {});
    /// let recording = Recording::of_simulation(&simulator, &rollout);
    /// recording.save_gif("out/cartpole.gif", PictureOptions::default())?;
    /// # Ok::<(), dualbody::RecordingError>(())
    /// ```
    pub fn save_gif(
        &self,
        path: impl AsRef<Path>,
        options: PictureOptions,
    ) -> Result<(), RecordingError> {
        write(path.as_ref(), self.to_gif(options))
    }

    /// The animation of [`save_gif`](Self::save_gif).
    ///
    /// # Panics
    /// As [`save_gif`](Self::save_gif).
    pub fn to_gif(&self, options: PictureOptions) -> Vec<u8> {
        let pictures = Pictures::new(self, options);
        let (start, end) = (
            self.times.first().copied().unwrap_or(0.0),
            self.times.last().copied().unwrap_or(0.0),
        );
        let animation = Animation::of_rate(options.rate);
        let interval = animation.seconds() * options.speed;
        let frames = ((end - start) / interval).floor() + 1.0;
        assert!(
            frames <= MAX_FRAMES,
            "{frames:.0} pictures in an animation, more than {MAX_FRAMES}"
        );
        let picture = |k: usize| pictures.of_recording(self, start + interval * k as f64);
        animation.encode(frames as usize, &picture)
    }
}
