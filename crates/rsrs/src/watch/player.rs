//! A recorded fleet, on the screen.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use rsrs_fleet::observation::{Playback, SwarmOrder};

use super::keys::{Request, scrolled};
use super::look::{BannerKind, Look};
use super::terminal::Screen;
use super::view::{Banner, PlayState, Timeline, View};
use super::viewer::FRAME;

/// How far an arrow goes, in seconds.
const SKIP_S: f64 = 5.0;

/// Plays a recording, with the name of its bag and a note about it, until a person has seen enough
/// or this program is interrupted; at its end it stays there.
pub fn play(
    playback: Playback,
    (name, note): (&str, Option<String>),
    look: Look,
    interrupted: &AtomicBool,
) -> anyhow::Result<()> {
    let mut player =
        Player { playback, name, note, look, order: None, first_row: 0, shows_help: false };
    player.run(&mut Screen::open()?, interrupted)
}

struct Player<'a> {
    playback: Playback,
    name: &'a str,
    note: Option<String>,
    look: Look,
    /// Order parameters, and the frame that computed them.
    order: Option<SwarmOrder>,
    first_row: usize,
    shows_help: bool,
}

impl Player<'_> {
    fn run(&mut self, screen: &mut Screen, interrupted: &AtomicBool) -> anyhow::Result<()> {
        let mut played = Instant::now();
        let mut n_rows = self.show(screen)?;
        while !interrupted.load(Ordering::Relaxed) {
            let request = screen.wait(FRAME.saturating_sub(played.elapsed()))?;
            self.playback.advance(std::mem::replace(&mut played, Instant::now()).elapsed());
            match request {
                Some(Request::Quit) if !self.shows_help => return Ok(()),
                Some(request) => self.take(request, n_rows),
                None => {}
            }
            n_rows = self.show(screen)?;
        }
        Ok(())
    }

    fn take(&mut self, request: Request, n_rows: usize) {
        self.shows_help = request == Request::Help && !self.shows_help;
        match request {
            Request::Pause => self.playback.toggle_pause(),
            Request::Skip(steps) => self.playback.skip(f64::from(steps) * SKIP_S),
            Request::Faster => self.playback.play_faster(),
            Request::Slower => self.playback.play_slower(),
            Request::Begin => self.playback.seek(std::time::Duration::ZERO),
            Request::End => self.playback.seek(self.playback.duration()),
            Request::Rows(_) | Request::Screens(_) => {
                let room = (n_rows, self.playback.observation().n_robots());
                self.first_row = scrolled(self.first_row, request, room);
            }
            Request::Quit | Request::Stop | Request::Help | Request::Redraw => {}
        }
        self.note = None;
    }

    fn show(&mut self, screen: &mut Screen) -> anyhow::Result<usize> {
        self.order = self.playback.order();
        let state = if self.playback.is_over() {
            PlayState::Over
        } else if self.playback.is_paused() {
            PlayState::Paused
        } else {
            PlayState::Plays
        };
        let note = self.note.clone().map(|text| Banner { text, kind: BannerKind::Alarm });
        let faults = || Banner::of_faults(self.playback.observation(), self.playback.at());
        screen.show(&View {
            observation: self.playback.observation(),
            now: self.playback.at(),
            order: self.order,
            place: self.name,
            timeline: Some(Timeline {
                at: self.playback.at(),
                duration: self.playback.duration(),
                pace: self.playback.pace(),
                state,
            }),
            banner: note.or_else(faults),
            first_row: self.first_row,
            shows_help: self.shows_help,
            look: self.look,
        })
    }
}
