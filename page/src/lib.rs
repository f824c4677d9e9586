//! What the page calls: numbers go in and out as they are, texts through one buffer.
//!
//! The page asks for room with [`text`], writes JSON there, and calls; what is answered is a number, or the
//! length of a text at [`answer`]. A text that begins with `!` is a refusal in words. A wasm instance has one
//! thread, and each worker of the page has an instance of its own.

#![expect(unsafe_code, reason = "a name that is not mangled counts as unsafe")]

mod live;
mod scene;
mod yaml;

use std::cell::RefCell;

use rsrs_core::judge::counts::PhaseCounts;
use rsrs_sim::batch::Batch;
use rsrs_sim::draw::Seed;

use live::Live;
use scene::{Refusal, Scene};

#[derive(Default)]
struct Page {
    text: Vec<u8>,
    live: Option<Live>,
    batch: Option<Batch>,
}

thread_local! {
    static PAGE: RefCell<Page> = RefCell::default();
}

fn with<R>(work: impl FnOnce(&mut Page) -> R) -> R {
    PAGE.with_borrow_mut(work)
}

impl Page {
    fn scene(&self) -> Result<Scene, Refusal> {
        let text = std::str::from_utf8(&self.text).map_err(|error| error.to_string())?;
        Scene::parse(text)
    }

    fn answer(&mut self, answer: Result<String, Refusal>) -> usize {
        self.text = answer.unwrap_or_else(|refusal| format!("!{refusal}")).into_bytes();
        self.text.len()
    }
}

/// Room for a text of so many bytes; where it is.
#[unsafe(no_mangle)]
pub extern "C" fn text(n_bytes: usize) -> *mut u8 {
    with(|page| {
        page.text.resize(n_bytes, 0);
        page.text.as_mut_ptr()
    })
}

/// Where the last answer is.
#[unsafe(no_mangle)]
pub extern "C" fn answer() -> *const u8 {
    with(|page| page.text.as_ptr())
}

/// What is known of the scene in the text.
#[unsafe(no_mangle)]
pub extern "C" fn describe() -> usize {
    with(|page| {
        let description = page.scene().and_then(|scene| scene.describe());
        page.answer(description.map(|it| it.to_string()))
    })
}

/// The scene in the text as a sweep file.
#[unsafe(no_mangle)]
pub extern "C" fn sweep_file() -> usize {
    with(|page| {
        let file = page.scene().and_then(|scene| scene.sweep_file());
        page.answer(file)
    })
}

/// Places the robots of the scene in the text; the answer is empty, or why they cannot be placed. Then the
/// swarm is the one before.
#[unsafe(no_mangle)]
pub extern "C" fn open(replicate: u64) -> usize {
    with(|page| {
        let live = page.scene().and_then(|scene| {
            Live::new(scene.conditions()?, Seed { seed: scene.seed(), replicate })
        });
        let answer = live.map(|live| page.live = Some(live));
        page.answer(answer.map(|()| String::new()))
    })
}

/// Makes so many steps, and gives the place of the frame; see [`live::Live`].
#[unsafe(no_mangle)]
pub extern "C" fn step(n_steps: u32) -> *const f32 {
    with(|page| {
        page.live.as_mut().map_or(std::ptr::null(), |live| {
            live.step(n_steps);
            live.frame().as_ptr()
        })
    })
}

/// Names the state of the swarm.
#[unsafe(no_mangle)]
pub extern "C" fn digest() -> u64 {
    with(|page| page.live.as_ref().map_or(0, Live::digest))
}

/// Steps that the swarm has made.
#[unsafe(no_mangle)]
#[expect(clippy::cast_possible_truncation, reason = "nobody watches for 2³² steps")]
pub extern "C" fn n_steps() -> u32 {
    with(|page| page.live.as_ref().map_or(0, |live| live.n_steps() as u32))
}

/// What the judge states of the swarm now.
#[unsafe(no_mangle)]
pub extern "C" fn judge() -> usize {
    with(|page| {
        let judgement = page.live.as_ref().map(Live::judge).unwrap_or_default();
        page.answer(Ok(judgement.to_string()))
    })
}

/// How many of some replicates of the cell of the scene in the text end in each phase.
#[unsafe(no_mangle)]
pub extern "C" fn count(from: u64, to: u64) -> usize {
    with(|page| {
        let counts = page.scene().and_then(|scene| {
            let conditions = scene.conditions()?;
            let batch = page.batch.get_or_insert_default();
            let verdicts = batch.judge(&conditions, scene.seed(), from..to, scene.duration_s());
            let verdicts = verdicts.map_err(|error| error.to_string())?;
            let counts = PhaseCounts::new(verdicts.iter().map(|verdict| verdict.phase));
            serde_json::to_string(&counts).map_err(|error| error.to_string())
        });
        page.answer(counts)
    })
}
