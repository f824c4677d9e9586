//! A fleet that runs, on the screen.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rsrs_fleet::observation::{Condition, SwarmOrder};
use rsrs_operate::watch::live::LiveFleet;
use rsrs_operate::watch::stop::{StandingStop, StopUnderWay};
use rsrs_pipeline::error::in_one_line;
use rsrs_render::stop::{StopSummary, UNDER_WAY, in_short, not_possible, not_published};
use rsrs_ros::ros_args::OtherMiddleware;
use rsrs_ros::session::SessionOptions;

use super::keys::{Request, scrolled};
use super::look::{BannerKind, Look};
use super::terminal::Screen;
use super::view::{Banner, View};

/// How often the screen is drawn.
pub(super) const FRAME: Duration = Duration::from_millis(100);
/// How often order parameters are computed: those of a minute and a hundred robots take a while.
const ORDER_PERIOD: Duration = Duration::from_millis(500);

/// Which fleet is watched.
pub struct Fleet {
    /// Where it is.
    pub network: SessionOptions,
    /// The same as who may stop it, or why nobody may from here.
    pub stop: Result<SessionOptions, String>,
    /// Robots that should be there; none, if all that publish are shown.
    pub robots: Vec<String>,
    /// Where it is, in words.
    pub place: String,
    /// Why there may be robots that are not found.
    pub other_middleware: Option<OtherMiddleware>,
}

impl Fleet {
    fn standing_stop(&self) -> anyhow::Result<Option<StandingStop>> {
        self.stop.as_ref().ok().map(|network| StandingStop::start(network.clone())).transpose()
    }
}

/// Shows a fleet until a person has seen enough or this program is interrupted, and tells what came
/// of the last stop, if there was one.
///
/// If the network or the terminal cannot be used any more, a stop that is under way is waited for.
pub fn view(
    fleet: &Fleet,
    look: Look,
    interrupted: &AtomicBool,
) -> anyhow::Result<Option<StopResult>> {
    let mut viewer = Viewer {
        live: LiveFleet::join(fleet.network.clone(), fleet.robots.clone())?,
        standing: fleet.standing_stop()?,
        fleet,
        look,
        stop: None,
        outcome: None,
        order: None,
        first_row: 0,
        shows_help: false,
    };
    let shown = Screen::open().and_then(|mut screen| viewer.run(&mut screen, interrupted));
    // Whoever has asked for a stop gets it, whatever became of the screen.
    if let Some(stop) = viewer.stop.take() {
        viewer.outcome = Some(StopResult::new(stop.wait()));
    }
    let outcome = viewer.outcome;
    let stop_left = viewer.standing.map_or(Ok(()), StandingStop::leave);
    let left = viewer.live.leave();
    shown.and(stop_left).and(left).map(|()| outcome)
}

/// What came of a stop.
#[derive(Clone, Debug)]
pub struct StopResult {
    pub text: String,
    /// Whether every robot has acknowledged.
    pub is_acknowledged: bool,
}

impl StopResult {
    fn new(summary: anyhow::Result<StopSummary>) -> Self {
        match summary {
            Ok(summary) => Self { text: in_short(&summary), is_acknowledged: summary.acknowledged },
            Err(error) => {
                Self { is_acknowledged: false, text: not_published(&in_one_line(&error)) }
            }
        }
    }
}

struct Viewer<'a> {
    live: LiveFleet,
    fleet: &'a Fleet,
    look: Look,
    /// None while a stop is under way, or if nobody may stop from here.
    standing: Option<StandingStop>,
    stop: Option<StopUnderWay>,
    outcome: Option<StopResult>,
    /// Order parameters, and when they were computed.
    order: Option<(Instant, Option<SwarmOrder>)>,
    first_row: usize,
    shows_help: bool,
}

impl Viewer<'_> {
    fn run(&mut self, screen: &mut Screen, interrupted: &AtomicBool) -> anyhow::Result<()> {
        let mut shown = Instant::now();
        let mut n_rows = self.show(screen)?;
        while !interrupted.load(Ordering::Relaxed) {
            match screen.wait(FRAME.saturating_sub(shown.elapsed()))? {
                Some(Request::Quit) if !self.shows_help => return Ok(()),
                Some(request) => self.take(request, n_rows),
                None => {}
            }
            self.live.update()?;
            if self.stop.as_ref().is_some_and(StopUnderWay::is_over) {
                let stop = self.stop.take();
                self.outcome = stop.map(|stop| StopResult::new(stop.wait()));
                // Another one: who stays announced as the publisher of a stop holds it after a release.
                self.standing = self.fleet.standing_stop()?;
            }
            n_rows = self.show(screen)?;
            shown = Instant::now();
        }
        Ok(())
    }

    fn take(&mut self, request: Request, n_rows: usize) {
        // A stop is never kept from anybody by what lies over the screen.
        if request == Request::Stop {
            self.stop_all();
            return;
        }
        self.shows_help = request == Request::Help && !self.shows_help;
        let n_robots = self.live.observation().n_robots();
        self.first_row = scrolled(self.first_row, request, (n_rows, n_robots));
    }

    fn stop_all(&mut self) {
        if self.stop.is_some() {
            return;
        }
        if let Err(reason) = &self.fleet.stop {
            let text = not_possible(reason);
            self.outcome = Some(StopResult { text, is_acknowledged: false });
        }
        let robots = self.live.observation().robots();
        let robots = robots.map(|(name, _)| name.to_owned()).collect();
        self.stop = self.standing.take().map(|standing| standing.order(robots));
    }

    /// What keeps robots from being found, while none is.
    fn why_nobody(&self) -> Option<Banner> {
        let is_nobody = self
            .live
            .observation()
            .robots()
            .all(|(_, robot)| robot.condition(self.live.now()) == Condition::Silent);
        let other = self.fleet.other_middleware.as_ref().filter(|_| is_nobody)?;
        Some(Banner { text: other.in_short(), kind: BannerKind::Alarm })
    }

    fn show(&mut self, screen: &mut Screen) -> anyhow::Result<usize> {
        let is_old = |at: &Instant| at.elapsed() >= ORDER_PERIOD;
        if self.order.as_ref().is_none_or(|(at, _)| is_old(at)) {
            self.order = Some((Instant::now(), self.live.observation().order()));
        }
        let banner = if self.stop.is_some() {
            Some(Banner { text: UNDER_WAY.to_owned(), kind: BannerKind::Alarm })
        } else {
            let outcome = self.outcome.as_ref();
            let outcome = outcome.map(|outcome| Banner {
                text: outcome.text.clone(),
                kind: if outcome.is_acknowledged { BannerKind::Done } else { BannerKind::Alarm },
            });
            let faults = || Banner::of_faults(self.live.observation(), self.live.now());
            outcome.or_else(|| self.why_nobody()).or_else(faults)
        };
        screen.show(&View {
            observation: self.live.observation(),
            now: self.live.now(),
            order: self.order.and_then(|(_, order)| order),
            place: &self.fleet.place,
            timeline: None,
            banner,
            first_row: self.first_row,
            shows_help: self.shows_help,
            look: self.look,
        })
    }
}
