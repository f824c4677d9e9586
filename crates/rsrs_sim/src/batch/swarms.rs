//! The state of many worlds, a lane each, and its steps.

use std::sync::Arc;

use rsrs_core::conditions::Conditions;
use rsrs_core::judge::number::{Mask, Number};
use rsrs_core::robot::controller::ControllerParameters;

use super::advance::{Drift, LaneRules, NoisyTraits, NominalStep};
use super::rows::{RowStep, Rows};
use super::sense::{Body, Cone, LaneContact, LaneView, Polygon, SensedNeighbours, sense};
use crate::draw::RunKey;
use crate::field_of_view::FieldOfView;
use crate::placement::{self, PlacementError};
use crate::robots::{Robots, WorldParameters};
use crate::vector::simd::{Simd, Work};
use crate::world;

/// Replicates of one cell, a lane each. Spare lanes repeat the last replicate.
pub struct Swarms<S: Simd> {
    simd: S,
    n_robots: usize,
    step: u64,
    rules: LaneRules<S>,
    view: ViewInLanes<S>,
    contact: LaneContact<S::F>,
    nominal_steps: Vec<NominalStep<S>>,
    noisy_traits: Vec<NoisyTraits<S>>,
    drifts: Vec<Drift<S::F>>,
    /// A ring of `latency + 1` rows.
    detections: Vec<S::M>,
    latency_steps: u64,
    seen: Vec<S::M>,
    ahead: Vec<S::M>,
    behind: Vec<S::M>,
}

#[derive(Clone)]
enum ViewInLanes<S: Simd> {
    Cone(Cone<S::F>),
    Polygon(Arc<Polygon<S::F>>),
}

/// Who decides on commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CommandedBy {
    /// The controller of the conditions.
    Controller,
    /// Somebody outside, who may command anything.
    Outside,
}

impl<S: Simd> Swarms<S> {
    /// Places the robots of one to `LANES` replicates, in row 0.
    pub fn new(
        simd: S,
        conditions: &Conditions,
        runs: &[RunKey],
        rows: &mut Rows<S::F>,
    ) -> Result<Self, PlacementError> {
        Self::placed((simd, CommandedBy::Controller), conditions, runs, rows.at_mut(0))
    }

    /// Places the robots of every replicate, in `bodies`, whoever decides on commands.
    pub fn placed(
        (simd, commanded_by): (S, CommandedBy),
        conditions: &Conditions,
        runs: &[RunKey],
        bodies: &mut [Body<S::F>],
    ) -> Result<Self, PlacementError> {
        let worlds = runs
            .iter()
            .map(|run| Ok(Robots::new(conditions, *run, &placement::place(conditions, *run)?)))
            .collect::<Result<Vec<Robots>, PlacementError>>()?;
        let world = |lane: usize| &worlds[lane.min(worlds.len() - 1)];
        let n_robots = conditions.robots;
        for (robot, body) in bodies.iter_mut().enumerate() {
            *body = Body {
                x_m: simd.singles(|lane| world(lane).x_m[robot]),
                y_m: simd.singles(|lane| world(lane).y_m[robot]),
                cosine: simd.singles(|lane| world(lane).cosine[robot]),
                sine: simd.singles(|lane| world(lane).sine[robot]),
            };
        }
        let rules = WorldParameters::new(conditions);
        // Who is commanded from outside may have any controller, and follows none.
        let standing = ControllerParameters::mirrored(0.0, 0.0);
        let controller = conditions.controller.parameters().unwrap_or(standing);
        let nominal_step = |robot: usize| NominalStep::new(simd, &rules, controller, robot, world);
        let noisy_traits = |robot: usize| NoisyTraits::new(simd, robot, world);
        let zero = simd.single(0.0);
        let still = Drift { gust_m_s: (zero, zero), yaw_rate_rad_s: zero };
        let latency_steps = u64::from(conditions.robot.latency_steps);
        let lane_rules = LaneRules::new(simd, &rules, controller);
        let is_tabulated =
            commanded_by == CommandedBy::Controller && lane_rules.is_plain() && latency_steps == 0;
        let n_whims = if is_tabulated { 0 } else { n_robots };
        Ok(Self {
            simd,
            n_robots,
            step: 0,
            rules: lane_rules,
            view: ViewInLanes::new(simd, &rules.view),
            contact: LaneContact::new(simd, rules.contact),
            nominal_steps: (0..n_robots).map(nominal_step).collect(),
            noisy_traits: (0..n_whims).map(noisy_traits).collect(),
            drifts: vec![still; n_whims],
            detections: vec![simd.no(); (latency_steps as usize + 1) * n_robots],
            latency_steps,
            seen: vec![simd.no(); n_robots],
            ahead: vec![simd.no(); n_robots],
            behind: vec![simd.no(); n_robots],
        })
    }

    /// Makes steps, each from its row to the next.
    pub fn run(&mut self, rows: &mut Rows<S::F>, n_steps: u64) {
        // So that the view can be borrowed beside the rest.
        match self.view.clone() {
            ViewInLanes::Cone(cone) => self.run_with(cone, rows, n_steps),
            ViewInLanes::Polygon(polygon) => self.run_with(&*polygon, rows, n_steps),
        }
    }

    fn run_with<V: LaneView<S>>(&mut self, view: V, rows: &mut Rows<S::F>, n_steps: u64) {
        let simd = self.simd;
        if self.noisy_traits.is_empty() {
            simd.vectorize(Steps::<S, V, true> { swarms: self, view, rows, count: n_steps });
        } else {
            simd.vectorize(Steps::<S, V, false> { swarms: self, view, rows, count: n_steps });
        }
    }

    /// Names the state of one lane, as [`world::World::digest`] does.
    pub fn digest(&self, rows: &Rows<S::F>, lane: usize) -> u64 {
        self.digest_of(rows.at(self.step), lane)
    }

    /// The same of bodies that the caller keeps.
    pub fn digest_of(&self, bodies: &[Body<S::F>], lane: usize) -> u64 {
        let column = |number: fn(&Body<S::F>) -> S::F| bodies.iter().map(number);
        let poses = column(|body| body.x_m)
            .chain(column(|body| body.y_m))
            .chain(column(|body| body.cosine))
            .chain(column(|body| body.sine));
        let (has_gusts, has_lag) = self.rules.has_drift();
        let column = |is_there: bool, number: fn(&Drift<S::F>) -> S::F| {
            self.drifts.iter().filter(move |_| is_there).map(number)
        };
        let hidden = column(has_gusts, |drift| drift.gust_m_s.0)
            .chain(column(has_gusts, |drift| drift.gust_m_s.1))
            .chain(column(has_lag, |drift| drift.yaw_rate_rad_s));
        let numbers = poses.chain(hidden).map(|number| number.lane(lane));
        let under_way = (1..=self.latency_steps)
            .flat_map(|age| &self.detections[self.detection_row(self.step + age)])
            .map(|detected| detected.bits() >> lane & 1 == 1);
        world::digest(self.step, numbers, under_way)
    }

    fn detection_row(&self, step: u64) -> std::ops::Range<usize> {
        let row = (step % (self.latency_steps + 1)) as usize;
        row * self.n_robots..(row + 1) * self.n_robots
    }

    /// One step. A robot moves as soon as it has looked at all others: they are seen where they
    /// were, as the next state has a row of its own.
    #[inline(always)]
    fn step<V: LaneView<S>, const PLAIN: bool>(&mut self, view: V, rows: &mut Rows<S::F>) {
        let n_robots = self.n_robots;
        let (from, to, kept) = rows.step(self.step);
        let (from, to) = (&from[..n_robots], &mut to[..n_robots]);
        let mut robot = 0;
        while robot + 2 <= n_robots {
            self.step_some::<V, PLAIN, 2>(view, robot, (from, to, kept));
            robot += 2;
        }
        if robot < n_robots {
            self.step_some::<V, PLAIN, 1>(view, robot, (from, to, kept));
        }
        self.step += 1;
    }

    #[inline(always)]
    fn step_some<V: LaneView<S>, const PLAIN: bool, const SOME: usize>(
        &mut self,
        view: V,
        first: usize,
        (from, to, kept): RowStep<'_, S::F>,
    ) {
        let simd = self.simd;
        let made = self.detection_row(self.step).start;
        let arriving = self.detection_row(self.step + 1).start;
        let counter = simd.word(self.step as u32);
        let n_robots = from.len();
        let Self {
            rules,
            contact,
            nominal_steps,
            noisy_traits,
            drifts,
            detections,
            seen,
            ahead,
            behind,
            ..
        } = self;
        let mut found = SensedNeighbours {
            seen: &mut seen[..n_robots],
            ahead: &mut ahead[..n_robots],
            behind: &mut behind[..n_robots],
        };
        let sees = sense::<S, V, SOME>(simd, view, *contact, first, from, &mut found);
        let robots = first..first + SOME;
        let nominal_steps = &nominal_steps[robots.clone()];
        for ((robot, nominal_step), sees) in robots.zip(nominal_steps).zip(sees) {
            let detected = nominal_step.detects(simd, rules, sees, counter);
            let answered = if PLAIN {
                detected
            } else {
                detections[made + robot] = detected;
                detections[arriving + robot]
            };
            if let Some(kept) = kept.get_mut(robot) {
                *kept = answered;
            }
            let is_blocked =
                rules.is_blocked(simd, answered, (found.ahead[robot], found.behind[robot]));
            let found_out = (answered, is_blocked);
            to[robot] = if PLAIN {
                nominal_step.step(simd, rules, &from[robot], found_out)
            } else {
                let noisy_traits = (&noisy_traits[robot], &mut drifts[robot]);
                nominal_step.step_of_trait(
                    (simd, rules, counter),
                    noisy_traits,
                    &from[robot],
                    found_out,
                )
            };
            found.seen[robot] = simd.no();
            (found.ahead[robot], found.behind[robot]) = (simd.no(), simd.no());
        }
    }
}

impl<S: Simd> Swarms<S> {
    /// Senses for all robots in all worlds, and gives which detections arrive; shape `[n_robots]` each.
    pub fn sense(&mut self, bodies: &[Body<S::F>], arrived: &mut [S::M]) {
        let simd = self.simd;
        match self.view.clone() {
            ViewInLanes::Cone(view) => {
                simd.vectorize(Sensing { swarms: self, view, bodies, arrived });
            }
            ViewInLanes::Polygon(polygon) => {
                let view = &*polygon;
                simd.vectorize(Sensing { swarms: self, view, bodies, arrived });
            }
        }
    }

    /// Moves all robots in all worlds, which were sensed, by commands of speed and turning rate; shape
    /// `[n_robots]` each.
    pub fn advance(&mut self, bodies: &mut [Body<S::F>], commands: &[(S::F, S::F)]) {
        let simd = self.simd;
        simd.vectorize(Advancing { swarms: self, bodies, commands });
        self.step += 1;
    }

    #[inline(always)]
    fn sense_some<V: LaneView<S>, const SOME: usize>(
        &mut self,
        view: V,
        first: usize,
        bodies: &[Body<S::F>],
        arrived: &mut [S::M],
    ) {
        let simd = self.simd;
        let made = self.detection_row(self.step).start;
        let arriving = self.detection_row(self.step + 1).start;
        let counter = simd.word(self.step as u32);
        let Self { rules, contact, nominal_steps, detections, seen, ahead, behind, .. } = self;
        let mut found = SensedNeighbours { seen, ahead, behind };
        let sees = sense::<S, V, SOME>(simd, view, *contact, first, bodies, &mut found);
        let robots = first..first + SOME;
        for ((robot, nominal_step), sees) in robots.clone().zip(&nominal_steps[robots]).zip(sees) {
            detections[made + robot] = nominal_step.detects(simd, rules, sees, counter);
            arrived[robot] = detections[arriving + robot];
            found.seen[robot] = simd.no();
        }
    }
}

/// Sensing, as work for a vector unit.
struct Sensing<'a, S: Simd, V> {
    swarms: &'a mut Swarms<S>,
    view: V,
    bodies: &'a [Body<S::F>],
    arrived: &'a mut [S::M],
}

impl<S: Simd, V: LaneView<S>> Work for Sensing<'_, S, V> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n_robots = self.bodies.len();
        let mut robot = 0;
        while robot + 2 <= n_robots {
            self.swarms.sense_some::<V, 2>(self.view, robot, self.bodies, self.arrived);
            robot += 2;
        }
        if robot < n_robots {
            self.swarms.sense_some::<V, 1>(self.view, robot, self.bodies, self.arrived);
        }
    }
}

/// Moving by commands from outside, as work for a vector unit.
struct Advancing<'a, S: Simd> {
    swarms: &'a mut Swarms<S>,
    bodies: &'a mut [Body<S::F>],
    commands: &'a [(S::F, S::F)],
}

impl<S: Simd> Work for Advancing<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Swarms { simd, step, rules, noisy_traits, drifts, ahead, behind, .. } = self.swarms;
        let simd = *simd;
        let counter = simd.word(*step as u32);
        let (one, zero) = (simd.single(1.0), simd.single(0.0));
        for (robot, (body, command)) in self.bodies.iter_mut().zip(self.commands).enumerate() {
            // Who drives backward is blocked by who is behind.
            let is_ahead = S::F::select(ahead[robot], one, zero);
            let is_behind = S::F::select(behind[robot], one, zero);
            let blocked = S::F::select(command.0.lt(zero), is_behind, is_ahead).gt(zero);
            let motion = (*command, None, blocked);
            let traits = (&noisy_traits[robot], &mut drifts[robot]);
            *body = traits.0.step((simd, rules, counter), traits.1, body, motion);
            (ahead[robot], behind[robot]) = (simd.no(), simd.no());
        }
    }
}

impl<S: Simd> ViewInLanes<S> {
    fn new(simd: S, view: &FieldOfView) -> Self {
        match view {
            FieldOfView::Cone(cone) => Self::Cone(Cone::new(simd, *cone)),
            FieldOfView::Polygon(polygon) => Self::Polygon(Arc::new(Polygon::new(simd, polygon))),
        }
    }
}

/// Steps, as work for a vector unit.
struct Steps<'a, S: Simd, V, const PLAIN: bool> {
    swarms: &'a mut Swarms<S>,
    view: V,
    rows: &'a mut Rows<S::F>,
    count: u64,
}

impl<S: Simd, V: LaneView<S>, const PLAIN: bool> Work for Steps<'_, S, V, PLAIN> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for _ in 0..self.count {
            self.swarms.step::<V, PLAIN>(self.view, self.rows);
        }
    }
}
