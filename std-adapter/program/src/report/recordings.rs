//! Recorded simulations for the report: made when they are asked for first, and kept.

use super::clip::Clip;
use super::lab::Lab;
use crate::record::simulated::{Output, write};
use crate::split;
use anyhow::{Context, Result};
use std::fs;
use std::path::PathBuf;
use trisap::Boxes;
use trisap::recording::Recording;
use trisap::scene::{Objects, Setup};

/// With more boxes than this half of the frames are recorded, which saves a gigabyte.
const ALL_FRAMES: u32 = 256_000;

impl Lab {
    /// The recording of a scene.
    pub(super) fn recorded(&self, setup: Setup) -> Result<Clip> {
        let path = self.file(&setup);
        if !path.exists() {
            self.record(&setup)?;
        }
        let recording = Recording::open(&path).with_context(|| path.display().to_string())?;
        let boxes = |frame| {
            let boxes = Boxes::padded(frame);
            (0..boxes.len()).filter_map(|at| boxes.get(at)).collect()
        };
        Ok(Clip::new(recording.frames().map(boxes).collect()))
    }

    fn file(&self, setup: &Setup) -> PathBuf {
        let [kind, objects] = [setup.kind.name(), setup.objects.name()].map(str::to_lowercase);
        let (skip, frames) = (self.plan.skip, self.frames(setup.count));
        self.recordings.join(format!("{kind}_{objects}_{}_{skip}_{frames}.aabbs", setup.count))
    }

    fn frames(&self, count: u32) -> u32 {
        if count > ALL_FRAMES { self.plan.frames.div_ceil(2).max(2) } else { self.plan.frames }
    }

    /// Simulates the bodies of a scene and records all sizes that they can be split into and that will be asked for.
    fn record(&self, setup: &Setup) -> Result<()> {
        fs::create_dir_all(&self.recordings).with_context(|| self.recordings.display().to_string())?;
        let (bodies, _) = split::bodies(setup.count)?;
        let sizes = match setup.objects {
            Objects::Cubes => &self.plan.sizes,
            Objects::Assorted => &self.plan.assorted_sizes,
        };
        let mut sizes: Vec<u32> = sizes.iter().copied().chain([self.plan.objects]).collect();
        sizes.sort_unstable();
        sizes.dedup();
        let mut outputs = Vec::new();
        let mut finished = Vec::new();
        for count in sizes {
            let (same, splits) = split::bodies(count)?;
            let path = self.file(&Setup { count, ..*setup });
            if same == bodies && !path.exists() {
                // Under another name until it is whole.
                let unfinished = path.with_extension("unfinished");
                outputs.push(Output { path: unfinished.clone(), splits, frames: self.frames(count) });
                finished.push((unfinished, path));
            }
        }
        let message = self.bar.message();
        let total = self.plan.skip + self.plan.frames;
        let frame = std::cell::Cell::new(0);
        write(&Setup { count: bodies, ..*setup }, self.plan.skip, &outputs, &|| {
            frame.set(frame.get() + 1);
            self.bar
                .set_message(format!("{message}: simulating {bodies} bodies, {} of {total}", frame.get()));
        })?;
        for (unfinished, path) in finished {
            fs::rename(&unfinished, &path).with_context(|| path.display().to_string())?;
        }
        self.bar.set_message(message);
        Ok(())
    }
}
