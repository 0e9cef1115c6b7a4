//! Recorded simulations for the report: made before anything is measured, and kept.

use super::clip::Clip;
use super::lab::Lab;
use crate::record::simulated::{Output, write};
use crate::split;
use anyhow::{Context, Result};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use trisap::recording::Recording;
use trisap::scene::{Kind, Objects, Setup};

/// With more boxes than this half of the frames are recorded, which saves a gigabyte.
const ALL_FRAMES: u32 = 256_000;

/// The most bodies that the report simulates: more would take longer than all that is measured.
pub(super) const MOST_BODIES: u32 = 8000;

/// A simulation and what is to be recorded of it.
struct Job {
    /// Of the bodies, before they are split.
    setup: Setup,
    outputs: Vec<Output>,
}

impl Lab {
    /// The recording of a scene, once it has been made.
    pub(super) fn recorded(&self, setup: Setup) -> Result<Clip> {
        let path = self.file(&setup)?;
        let recording = Recording::open(&path).with_context(|| path.display().to_string())?;
        Ok(Clip::recorded(&recording))
    }

    /// Makes the recordings that are not there yet, on all threads.
    pub(super) fn record_all(&self) -> Result<()> {
        fs::create_dir_all(&self.recordings).with_context(|| self.recordings.display().to_string())?;
        let jobs = self.jobs()?;
        self.expect(jobs.len());
        jobs.into_par_iter().with_max_len(1).try_for_each(|job| self.record(&job))
    }

    /// One simulation for all sizes that its bodies can be split into, the longest first.
    fn jobs(&self) -> Result<Vec<Job>> {
        let mut jobs: BTreeMap<u32, Vec<Job>> = BTreeMap::new();
        for objects in Objects::ALL {
            let sizes = match objects {
                Objects::Cubes => &self.plan.sizes,
                Objects::Assorted => &self.plan.assorted_sizes,
            };
            for kind in Kind::ALL {
                let mut families: BTreeMap<u32, Vec<Output>> = BTreeMap::new();
                for &count in sizes.iter().chain([&self.plan.objects]) {
                    let (bodies, splits) = split::bodies(count, MOST_BODIES)?;
                    let path = self.file(&self.setup(kind, objects, count))?;
                    let family = families.entry(bodies).or_default();
                    if !path.exists() && family.iter().all(|output| output.path != path) {
                        family.push(Output { path, splits, frames: self.frames(count) });
                    }
                }
                for (bodies, outputs) in families.into_iter().filter(|(_, outputs)| !outputs.is_empty()) {
                    let job = Job { setup: self.setup(kind, objects, bodies), outputs };
                    jobs.entry(bodies).or_default().push(job);
                }
            }
        }
        Ok(jobs.into_values().rev().flatten().collect())
    }

    fn record(&self, job: &Job) -> Result<()> {
        // Under another name until they are whole.
        let unfinished = |path: &Path| path.with_extension("unfinished");
        let outputs: Vec<_> =
            job.outputs.iter().map(|output| Output { path: unfinished(&output.path), ..*output }).collect();
        write(&job.setup, self.plan.skip, &outputs, &|| {})?;
        for Output { path, .. } in &job.outputs {
            fs::rename(unfinished(path), path).with_context(|| path.display().to_string())?;
        }
        let Setup { kind, objects, count, .. } = job.setup;
        self.next(format!("simulating ({count} {} of {} are done)", objects.name(), kind.name()));
        Ok(())
    }

    fn file(&self, setup: &Setup) -> Result<PathBuf> {
        let (bodies, _) = split::bodies(setup.count, MOST_BODIES)?;
        let [kind, objects] = [setup.kind.name(), setup.objects.name()].map(str::to_lowercase);
        let (skip, frames) = (self.plan.skip, self.frames(setup.count));
        let name = format!("{kind}_{objects}_{}_of_{bodies}_{skip}_{frames}.aabbs", setup.count);
        Ok(self.recordings.join(name))
    }

    fn frames(&self, count: u32) -> u32 {
        if count > ALL_FRAMES { self.plan.frames.div_ceil(2).max(2) } else { self.plan.frames }
    }
}
