//! A run as a film: robots from above with the ways that they came, as an animated GIF or PNG.
//!
//! Frames are drawn as SVG and turned into pixels like every other picture. A GIF has the colours of a
//! fixed palette, so the same film has the same bytes on every machine, and of each frame what has
//! changed since the last one.

mod frames;
mod gif;

use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::world::WorldFile;

pub use frames::FilmError;
use frames::Frames;

/// A run, and how it is shown.
#[derive(Clone, Debug)]
pub struct Film<'a> {
    /// What every robot did.
    pub trajectory: &'a Trajectory,
    /// Radius of a robot's body, in metres; positive.
    pub radius_m: f64,
    /// The title; any text.
    pub title: String,
    /// What is stated below from a time on, in seconds from the start; any texts, ascending in time.
    pub captions: &'a [(f64, String)],
    /// How many seconds of the run pass in one of the film; positive.
    pub speed: f64,
    /// Frames in a second; from 1 to 50.
    pub frames_per_s: u32,
    /// For how long the way that a robot came is shown, in seconds of the run.
    pub tail_s: f64,
    /// Width of the film, in pixels; from 64 to 2048.
    pub width_px: u32,
    /// Robots that did not take part to the end, by their index, to be drawn in red.
    pub lost: &'a [usize],
    /// Names of the robots, in the order of their indices; none if they are not shown.
    pub names: &'a [String],
    /// Distance of the walls from the origin, in metres, where there are some.
    pub walls_m: Option<f64>,
    /// What is there besides robots, where that is known.
    pub world: Option<&'a WorldFile>,
    /// The class of each robot; none if there are none.
    pub classes: &'a [usize],
}

/// Kinds of film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// An animated GIF.
    Gif,
    /// An animated PNG.
    Apng,
}

/// Makes the file of a film.
///
/// After each frame `show` gets the number of frames that are done. Once it returns false, the film
/// is called off, and there is no file.
pub fn film(
    film: &Film,
    kind: Kind,
    show: &dyn Fn(usize) -> bool,
) -> Result<Option<Vec<u8>>, FilmError> {
    let frames = Frames::new(film)?;
    match kind {
        Kind::Gif => gif::encode(&frames, film.frames_per_s, show),
        Kind::Apng => frames::apng(&frames, film.frames_per_s, show),
    }
}

/// One frame of a film, as SVG, by its number from 0; one beyond the end shows the end.
pub fn frame_svg(film: &Film, frame: usize) -> Result<String, FilmError> {
    Ok(Frames::new(film)?.svg(frame))
}

impl Film<'_> {
    /// How many frames there are.
    pub fn n_frames(&self) -> usize {
        let step_s = self.speed / f64::from(self.frames_per_s);
        let n_steps = (self.trajectory.duration_s() / step_s).ceil();
        n_steps.max(1.0) as usize
    }
}
