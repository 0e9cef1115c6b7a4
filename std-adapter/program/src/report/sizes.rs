//! All scenes at all sizes on all kernels: what several sections are made of.

use super::as_printed;
use super::clip::Clip;
use super::lab::{Lab, exact};
use super::measure::{Contender, Measured, copy_milliseconds, in_turns_with};
use super::result::Verdict;
use anyhow::{Context, Result};
use trisap::Kernels;
use trisap::scene::{Kind, Objects};

/// A scene at one size.
pub(super) struct Size {
    pub(super) kind: Kind,
    pub(super) objects: Objects,
    pub(super) count: u32,
    /// On each of the kernels, in the order of [`Kernels::all`].
    pub(super) measured: Vec<Measured>,
    /// The paper's method, in turns with these.
    pub(super) as_printed: Measured,
    /// The time in which the machine's memory can be read and written as much as a step has to at least.
    pub(super) limit: f64,
}

impl Size {
    /// On the best kernels.
    pub(super) fn best(&self) -> &Measured {
        &self.measured[self.measured.len() - 1]
    }
}

/// The bytes of a box as it is read, and of a pair as it is written.
const BOX_BYTES: u64 = 24;
const PAIR_BYTES: u64 = 8;

pub(super) fn sizes(lab: &Lab) -> Result<Vec<Size>> {
    let sizes_of = |objects| match objects {
        Objects::Cubes => &lab.plan.sizes,
        Objects::Assorted => &lab.plan.assorted_sizes,
    };
    lab.expect(Kind::ALL.len() * (lab.plan.sizes.len() + lab.plan.assorted_sizes.len()));
    let mut sizes = Vec::new();
    for objects in Objects::ALL {
        for kind in Kind::ALL {
            for &count in sizes_of(objects) {
                lab.next(format!("{}, {}, {count} objects", kind.name(), objects.name()));
                let clip = lab.scene(kind, objects, count)?;
                sizes.push(size(lab, kind, objects, &clip)?);
            }
        }
    }
    Ok(sizes)
}

fn size(lab: &Lab, kind: Kind, objects: Objects, clip: &Clip) -> Result<Size> {
    let contender =
        |kernels: Kernels| Contender { name: kernels.name().into(), clip, config: exact(clip), kernels };
    let contenders: Vec<_> = Kernels::all().map(contender).collect();
    let (measured, others) = in_turns_with(&contenders, vec![as_printed::start(clip)], lab.plan.budget)?;
    let as_printed = others.into_iter().next().context("the paper's method was not measured")?;
    let count = clip.objects();
    let pairs = measured[0].sum(|stats| stats.pairs) / measured[0].stats.len() as f64;
    let bytes = u64::from(count) * BOX_BYTES + pairs as u64 * PAIR_BYTES;
    Ok(Size {
        kind,
        objects,
        count,
        measured,
        as_printed,
        limit: copy_milliseconds(bytes, lab.plan.budget / 4),
    })
}

/// Brownian cubes of a middle size, which stand for all where there is one number.
pub(super) fn middle(sizes: &[Size]) -> Option<&Size> {
    let of = sizes.iter().filter(|size| size.kind == Kind::Brownian && size.objects == Objects::Cubes);
    of.filter(|size| size.count <= MIDDLE).max_by_key(|size| size.count)
}

const MIDDLE: u32 = 16_000;

/// What the checks of all of them say.
pub(super) fn verdict(sizes: &[Size]) -> Verdict {
    let mut sum = Verdict::default();
    sizes.iter().flat_map(|size| &size.measured).for_each(|measured| sum.add(measured.verdict));
    sum
}
