//! The frames of a film.

use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::out_of_range::OutOfRange;

use super::Film;
use crate::floor::{
    CAPTION_PX, Field, LOST, PAGE_PX, PoseNotFinite, TAIL, around_things, around_walls,
    check_poses, places, robot, scale_bar, short, tags, things, walls,
};
use crate::header::{MARGIN_PX, header};
use crate::palette::{INK, QUIET_INK};
use crate::raster::{RasterError, parse, pixmap};
use crate::svg::{Element, line_of_text};
use crate::text::{Weight, width_px};
use crate::theme::Theme;
use crate::track::{self, Point};

/// Size of the time, in pixels.
const CLOCK_PX: f64 = 17.0;

/// Why there is no film.
#[derive(Debug, thiserror::Error)]
pub enum FilmError {
    /// There is nothing to show.
    #[error("the trajectory has no samples, expected 1 or more")]
    Empty,
    /// A pose is nowhere.
    #[error(transparent)]
    PoseNotFinite(#[from] PoseNotFinite),
    /// A number of the film is out of range.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
    /// A frame cannot be drawn.
    #[error(transparent)]
    Raster(#[from] RasterError),
    /// The frames cannot be put into one file.
    #[error("the encoder of the film: {0}")]
    Encode(String),
}

impl FilmError {
    pub(super) fn encode(error: &impl ToString) -> Self {
        Self::Encode(error.to_string())
    }
}

/// The frames of a film, drawn one at a time.
pub struct Frames<'a> {
    film: &'a Film<'a>,
    field: Field,
    header: Vec<Element>,
    height_px: f64,
    /// Width and height in pixels of the film.
    pub size_px: (u32, u32),
    /// How many there are.
    pub n: usize,
}

impl<'a> Frames<'a> {
    pub fn new(film: &'a Film<'a>) -> Result<Self, FilmError> {
        check(film)?;
        let room_px = PAGE_PX - 2.0 * MARGIN_PX;
        let (header, header_px) = header(Theme::Screen, &film.title, &[""; 0], MARGIN_PX, room_px);
        let robots_m = places(&film.trajectory.poses);
        let mut drawn_m: Vec<Point> =
            robots_m.chain(around_things(film.world, film.trajectory)).collect();
        drawn_m.extend(around_walls((film.walls_m, film.world), &drawn_m));
        let field = Field::around(drawn_m.into_iter(), film.radius_m, header_px + 6.0);
        let height_px = field.top_px + field.height_px + 3.0 * CAPTION_PX + 10.0;
        let scale = f64::from(film.width_px) / PAGE_PX;
        let size_px = (film.width_px, (scale * height_px).ceil().max(1.0) as u32);
        Ok(Self { film, field, header, height_px, size_px, n: film.n_frames() })
    }

    /// Pixels of a frame, as red, green, blue and opacity.
    pub fn pixels(&self, frame: usize) -> Result<Vec<u8>, FilmError> {
        let tree = parse(&self.svg(frame))?;
        Ok(pixmap(&tree, self.size_px)?.take())
    }

    /// A frame as SVG.
    pub fn svg(&self, frame: usize) -> String {
        let Film { trajectory, radius_m, speed, frames_per_s, tail_s, lost, .. } = *self.film;
        let time_s = frame as f64 * speed / f64::from(frames_per_s);
        let sample = sample_at(trajectory, time_s);
        let first = sample_at(trajectory, time_s - tail_s);
        let robots = trajectory.poses_at(sample).iter().enumerate().map(|(index, pose)| {
            let stroke = if lost.contains(&index) { LOST } else { INK };
            let class = self.film.classes.get(index).copied();
            robot(&self.field, *pose, radius_m, (stroke, class))
        });
        let bottom_px = self.height_px - 10.0;
        let before = self.film.captions.partition_point(|(from_s, _)| *from_s <= time_s + 1e-9);
        let caption = before.checked_sub(1).map(|last| &self.film.captions[last].1);
        let clock = format!("{time_s:.0} s");
        let caption_px = MARGIN_PX + width_px(&clock, CLOCK_PX, Weight::Bold) + 12.0;
        let clock = line_of_text(MARGIN_PX, bottom_px, &clock).bold(CLOCK_PX, INK);
        let caption = caption.map(|caption| {
            line_of_text(caption_px, bottom_px, caption).lettered(CAPTION_PX, QUIET_INK)
        });
        let names: Vec<String> =
            self.film.names.iter().map(|name| short(name).to_owned()).collect();
        let tags = tags(&self.field, trajectory.poses_at(sample), &names, radius_m);
        let things = |world| things(&self.field, world, trajectory.objects_at(sample));
        let world = self.film.world.into_iter().flat_map(things);
        let walls = walls(&self.field, self.film.walls_m, self.film.world);
        Element::picture(PAGE_PX, self.height_px, &self.film.title)
            .children(self.header.iter().cloned())
            .children(walls)
            .children(world)
            .children((0..trajectory.n_robots).map(|robot| self.tail(robot, first..sample + 1)))
            .children(robots)
            .children(tags)
            .children(scale_bar(&self.field, bottom_px))
            .child(clock)
            .children(caption)
            .to_string()
    }

    /// The way that a robot came.
    fn tail(&self, robot: usize, samples: std::ops::Range<usize>) -> Element {
        let points: Vec<Point> = samples
            .map(|sample| self.film.trajectory.poses_at(sample)[robot])
            .map(|pose| self.field.point(pose.x_m, pose.y_m))
            .collect();
        Element::path(&track::path(&track::simplified(&points, 0.3)))
            .outlined(TAIL, 1.4)
            .with("stroke-opacity", "0.55")
    }
}

/// The last sample at a time or before, in seconds from the start.
fn sample_at(trajectory: &Trajectory, time_s: f64) -> usize {
    let sample = (time_s.max(0.0) / trajectory.period_s + 1e-9).floor() as usize;
    sample.min(trajectory.n_samples() - 1)
}

fn check(film: &Film) -> Result<(), FilmError> {
    let positive = "a positive number";
    for (name, found, is_right, expected) in [
        ("the body's radius in m", film.radius_m, film.radius_m > 0.0, positive),
        ("the speed of the film", film.speed, film.speed > 0.0, positive),
        ("the period in s", film.trajectory.period_s, film.trajectory.period_s > 0.0, positive),
        ("the tail in s", film.tail_s, film.tail_s >= 0.0, "a number from 0"),
        (
            "frames per second",
            f64::from(film.frames_per_s),
            (1..=50).contains(&film.frames_per_s),
            "1 to 50",
        ),
        (
            "the width in px",
            f64::from(film.width_px),
            (64..=2048).contains(&film.width_px),
            "64 to 2048",
        ),
    ] {
        if !(found.is_finite() && is_right) {
            let expected = expected.into();
            return Err(OutOfRange { name, found, expected }.into());
        }
    }
    let trajectory = film.trajectory;
    if trajectory.n_samples() == 0 {
        return Err(FilmError::Empty);
    }
    Ok(check_poses(trajectory)?)
}

/// Puts all frames into an animated PNG.
pub fn apng(
    frames: &Frames,
    frames_per_s: u32,
    show: &dyn Fn(usize) -> bool,
) -> Result<Option<Vec<u8>>, FilmError> {
    let (width_px, height_px) = frames.size_px;
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width_px, height_px);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced);
    let n_frames = u32::try_from(frames.n).map_err(|error| FilmError::encode(&error))?;
    encoder.set_animated(n_frames, 0).map_err(|error| FilmError::encode(&error))?;
    let rate = u16::try_from(frames_per_s).map_err(|error| FilmError::encode(&error))?;
    encoder.set_frame_delay(1, rate).map_err(|error| FilmError::encode(&error))?;
    let mut writer = encoder.write_header().map_err(|error| FilmError::encode(&error))?;
    for frame in 0..frames.n {
        let pixels = frames.pixels(frame)?;
        writer.write_image_data(&pixels).map_err(|error| FilmError::encode(&error))?;
        if !show(frame + 1) {
            return Ok(None);
        }
    }
    writer.finish().map_err(|error| FilmError::encode(&error))?;
    Ok(Some(bytes))
}
