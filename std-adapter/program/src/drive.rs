//! Steps a world through the frames of a source.

use crate::setup::{Engine, fits_u16};
use crate::source::Source;
use crate::stopwatch::{StageTimes, Stopwatch};
use anyhow::{Context, Result, anyhow};
use std::time::{Duration, Instant};
use trisap::{Boxes, Config, Error, Executor, Index, Kernels, OwnedWorld, Pair, Reason, Rejected, Stats};

/// A frame that was stepped.
pub(crate) struct Frame<'a> {
    pub(crate) number: u32,
    pub(crate) boxes: Boxes<'a>,
    /// Time of the step, the intake of the boxes included.
    pub(crate) time: Duration,
    pub(crate) stages: StageTimes,
    pub(crate) stats: Stats,
    /// Pairs of fat mode whose boxes do not overlap.
    pub(crate) surplus: u64,
    pub(crate) rejected: Option<Rejected>,
    pub(crate) coarse: bool,
    pub(crate) pairs: PairLists<'a>,
}

/// Pairs in indices of either width.
#[derive(Clone, Copy)]
pub(crate) struct PairLists<'a> {
    pub(crate) all: &'a dyn Pairs,
    pub(crate) found: &'a dyn Pairs,
    pub(crate) lost: &'a dyn Pairs,
}

pub(crate) trait Pairs {
    /// In ascending order.
    fn sorted(&self) -> Vec<Pair>;
}

impl<I: Index> Pairs for &[Pair<I>] {
    fn sorted(&self) -> Vec<Pair> {
        let mut pairs: Vec<Pair> = self.iter().map(|pair| pair.map(Index::slot)).collect();
        pairs.sort_unstable();
        pairs
    }
}

/// What looks at the frames.
pub(crate) trait Visitor {
    /// Another pass begins: the first one, or the pair buffer was too small in the last.
    fn start(&mut self);
    /// Looks at a frame; `false` ends the pass.
    fn visit(&mut self, frame: &Frame<'_>) -> Result<bool>;
}

/// Steps through all frames, with a pair buffer that is made larger as often as needed. Gives the configuration that
/// sufficed.
pub(crate) fn drive(
    source: &mut Source,
    mut config: Config,
    engine: &Engine,
    visitor: &mut dyn Visitor,
) -> Result<Config> {
    loop {
        visitor.start();
        let pass = if fits_u16(source.objects()) { pass::<u16> } else { pass::<u32> };
        let pass = |executor: &dyn Executor| pass(source, &config, engine.kernels, executor, visitor);
        let Some(needed) = engine.with_executor(pass)? else {
            return Ok(config);
        };
        // A later frame may need a little more.
        let roomy = needed.saturating_add(needed / 4);
        config.capacity.pairs = u32::try_from(roomy).map_err(|_| anyhow!("{needed} pairs are too many"))?;
        source.rewind()?;
    }
}

/// Steps through all frames. A number tells for how many pairs there should have been room.
fn pass<I: Index>(
    source: &mut Source,
    config: &Config,
    kernels: Kernels,
    executor: &dyn Executor,
    visitor: &mut dyn Visitor,
) -> Result<Option<u64>> {
    let mut owned = OwnedWorld::<I>::with_index(config)
        .with_context(|| format!("no world for {} objects", source.objects()))?;
    let mut world = owned.world();
    let mut number = 0;
    while let Some(boxes) = source.next_frame()? {
        if number == 0 {
            world.insert_many(boxes).context("frame 0")?;
        }
        let start = Instant::now();
        let stopwatch = Stopwatch::new(executor);
        let step = world.set_kernels(kernels).on(&stopwatch).step_over(boxes);
        let (time, stages) = (start.elapsed(), stopwatch.times());
        let step = match step {
            // The surplus of margins should fit, too: steps are cheaper then.
            Ok(step) if step.stats().reason == Reason::NoRoomForSurplus => {
                return Ok(Some(2 * u64::from(config.capacity.pairs.max(1))));
            }
            Ok(step) => step,
            Err(Error::PairsFull { needed, .. }) => return Ok(Some(needed)),
            Err(error) => return Err(error).with_context(|| format!("frame {number}")),
        };
        let frame = Frame {
            number,
            boxes,
            time,
            stages,
            stats: step.stats(),
            surplus: if config.mode == trisap::Mode::Fat { step.surplus() } else { 0 },
            rejected: step.rejected(),
            coarse: step.is_coarse(),
            pairs: PairLists { all: &step.pairs(), found: &step.found(), lost: &step.lost() },
        };
        if !visitor.visit(&frame)? {
            break;
        }
        number += 1;
    }
    Ok(None)
}
