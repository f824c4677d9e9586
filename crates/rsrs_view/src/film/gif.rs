//! Frames as an animated GIF.

use ::gif::{DisposalMethod, Encoder, Frame, Repeat};

use super::frames::{FilmError, Frames};

/// Levels of red, green and blue.
const LEVELS: u16 = 6;
/// Greys besides: letters and outlines are grey at their edges.
const GREYS: u16 = 40;

/// Puts all frames into a GIF that repeats for ever.
pub fn encode(
    frames: &Frames,
    frames_per_s: u32,
    show: &dyn Fn(usize) -> bool,
) -> Result<Option<Vec<u8>>, FilmError> {
    let side = |side_px: u32| u16::try_from(side_px).map_err(|error| FilmError::encode(&error));
    let (width_px, height_px) = (side(frames.size_px.0)?, side(frames.size_px.1)?);
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width_px, height_px, &palette())
        .map_err(|error| FilmError::encode(&error))?;
    encoder.set_repeat(Repeat::Infinite).map_err(|error| FilmError::encode(&error))?;
    let mut shown: Option<Vec<u8>> = None;
    for frame in 0..frames.n {
        let indices: Vec<u8> = frames.pixels(frame)?.chunks_exact(4).map(index_of).collect();
        let changed = Changed::since(shown.as_deref(), &indices, usize::from(width_px));
        let delay = delay(frame, frames_per_s);
        encoder
            .write_frame(&changed.frame(&indices, usize::from(width_px), delay))
            .map_err(|error| FilmError::encode(&error))?;
        shown = Some(indices);
        if !show(frame + 1) {
            return Ok(None);
        }
    }
    drop(encoder);
    Ok(Some(bytes))
}

/// How long a frame is shown, in hundredths of a second: all together are as long as they should be.
fn delay(frame: usize, frames_per_s: u32) -> u16 {
    let until = |frame: usize| 100 * frame / frames_per_s as usize;
    u16::try_from(until(frame + 1) - until(frame)).unwrap_or(u16::MAX)
}

/// The rectangle of a frame in which something has changed.
struct Changed {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
}

impl Changed {
    fn since(before: Option<&[u8]>, now: &[u8], width: usize) -> Self {
        let height = now.len() / width;
        let Some(before) = before else { return Self { left: 0, top: 0, width, height } };
        let differs = |index: &usize| before[*index] != now[*index];
        let places = (0..now.len()).filter(differs).map(|index| (index % width, index / width));
        let bounds = places.fold(None, |bounds: Option<[usize; 4]>, (x, y)| {
            let [left, top, right, bottom] = bounds.unwrap_or([x, y, x, y]);
            Some([left.min(x), top.min(y), right.max(x), bottom.max(y)])
        });
        // A frame has at least one pixel.
        let [left, top, right, bottom] = bounds.unwrap_or([0; 4]);
        Self { left, top, width: right - left + 1, height: bottom - top + 1 }
    }

    fn frame(&self, indices: &[u8], width: usize, delay: u16) -> Frame<'static> {
        let row = |y: usize| &indices[y * width + self.left..y * width + self.left + self.width];
        let buffer: Vec<u8> =
            (self.top..self.top + self.height).flat_map(|y| row(y).iter().copied()).collect();
        let side = |pixels: usize| u16::try_from(pixels).unwrap_or(u16::MAX);
        Frame {
            delay,
            dispose: DisposalMethod::Keep,
            left: side(self.left),
            top: side(self.top),
            width: side(self.width),
            height: side(self.height),
            buffer: buffer.into(),
            ..Frame::default()
        }
    }
}

/// Red, green and blue of all colours.
fn palette() -> Vec<u8> {
    let level = |number: u16| byte(number * 255 / (LEVELS - 1));
    let mut colours = Vec::new();
    for red in 0..LEVELS {
        for green in 0..LEVELS {
            for blue in 0..LEVELS {
                colours.extend([level(red), level(green), level(blue)]);
            }
        }
    }
    for grey in 0..GREYS {
        colours.extend([byte(grey * 255 / (GREYS - 1)); 3]);
    }
    colours
}

/// The colour of a pixel: a grey where it is nearly one, else the nearest level of each channel.
fn index_of(pixel: &[u8]) -> u8 {
    let [red, green, blue] = [pixel[0], pixel[1], pixel[2]].map(u16::from);
    let (least, most) = (red.min(green).min(blue), red.max(green).max(blue));
    if most - least < 12 {
        return byte(LEVELS.pow(3) + rounded(green, GREYS));
    }
    let [red, green, blue] = [red, green, blue].map(|channel| rounded(channel, LEVELS));
    byte((red * LEVELS + green) * LEVELS + blue)
}

/// The nearest of some levels.
fn rounded(channel: u16, levels: u16) -> u16 {
    (channel * (levels - 1) + 127) / 255
}

fn byte(number: u16) -> u8 {
    u8::try_from(number)
        .expect("a colour has at most 256 levels, and there are at most 256 colours")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_near_those_of_the_picture() {
        let palette = palette();
        for (pixel, most_off) in [
            ([255, 255, 255, 255], 0),
            ([0, 0, 0, 255], 0),
            ([0x1a, 0x1a, 0x1a, 255], 4),
            ([0, 0x72, 0xb2, 255], 26),
            ([0xc1, 0x12, 0x1f, 255], 32),
        ] {
            let index = usize::from(index_of(&pixel));
            let colour = &palette[3 * index..3 * index + 3];
            let off = colour.iter().zip(pixel).map(|(one, other)| one.abs_diff(other)).max();
            assert!(off <= Some(most_off), "{pixel:?} {colour:?}");
        }
    }

    #[test]
    fn only_what_changes_is_kept() {
        let before = [0, 0, 0, 0, 0, 0, 0, 0, 0];
        let now = [0, 0, 0, 0, 1, 1, 0, 0, 0];

        let changed = Changed::since(Some(&before), &now, 3);
        let same = Changed::since(Some(&now), &now, 3);

        assert_eq!((changed.left, changed.top, changed.width, changed.height), (1, 1, 2, 1));
        assert_eq!(changed.frame(&now, 3, 5).buffer.as_ref(), [1, 1]);
        assert_eq!((same.width, same.height), (1, 1));
    }

    #[test]
    fn a_second_has_as_many_frames_as_it_should() {
        let total = |rate: u32| (0..rate as usize).map(|frame| delay(frame, rate)).sum::<u16>();

        assert_eq!((total(20), total(30), total(7)), (100, 100, 100));
    }
}
