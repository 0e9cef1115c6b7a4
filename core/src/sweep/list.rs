//! Sweeps a small world straight from one of its sorted lists: one bucket, no tree, no sort.

use super::{Sink, bucket};
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::scratch::Scratch;
use crate::simd::{Phase, Simd};
use crate::tree::Frame;

/// See the module.
pub(crate) struct SweepList<'p, 's, 'b, I> {
    /// The slots by ascending minimum on `axis`.
    pub(crate) order: &'b [I],
    pub(crate) axis: usize,
    pub(crate) frame: Frame,
    pub(crate) boxes: &'b [KeyBox],
    pub(crate) scratch: &'p mut Scratch<'s, I>,
    pub(crate) sink: &'p mut dyn Sink<I>,
}

impl<I: Index> Phase for SweepList<'_, '_, '_, I> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        bucket::sweep_listed(
            simd,
            self.order,
            &self.frame,
            self.axis,
            &mut self.scratch.leaf_scratch,
            self.boxes,
            self.sink,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::key::key;
    use crate::id::Pair;
    use crate::memory::scratch;
    use crate::simd::kernels::Kernels;
    use crate::tree::Record;
    use proptest::prelude::*;
    use std::vec;
    use std::vec::Vec;

    struct Pairs(Vec<Pair<u16>>);

    impl Sink<u16> for Pairs {
        fn take(&mut self, pairs: &mut [Pair<u16>]) {
            self.0.extend_from_slice(pairs);
        }
    }

    /// Boxes with corners on a grid, so that sides are shared, or off it: from none to a few passes of rows, from hardly any
    /// neighbours to all of them.
    fn boxes() -> impl Strategy<Value = Vec<KeyBox>> {
        let count = prop_oneof![0usize..5, 60usize..70, 250usize..262, 500usize..700];
        let kind = (4u16..200, 1u16..40, prop_oneof![Just(1.0f32), Just(0.37)]);
        let corner = [any::<u16>(), any::<u16>(), any::<u16>()];
        (count, kind).prop_flat_map(move |(count, (side, edge, step))| {
            prop::collection::vec((corner, corner), count).prop_map(move |corners| {
                let bounds = |(low, size): ([u16; 3], [u16; 3])| {
                    let min = low.map(|x| x % side);
                    let max = [0, 1, 2].map(|k| min[k] + size[k] % edge);
                    let keys = |corner: [u16; 3]| corner.map(|x| key(f32::from(x) * step));
                    KeyBox { min: keys(min), max: keys(max) }
                };
                corners.into_iter().map(bounds).collect()
            })
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        #[test]
        fn all_levels_find_each_pair_once_in_one_order(
            boxes in boxes(),
            axis in 0usize..3,
            bucket in prop_oneof![Just(128usize), Just(704), Just(2048)],
        ) {
            let bucket = bucket.max(boxes.len().next_multiple_of(64));
            let mut order: Vec<u16> = (0..boxes.len() as u16).collect();
            order.sort_by_key(|slot| boxes[usize::from(*slot)].min[axis]);
            // Steps enough that all boxes are inside.
            let twice = |[x, y, z]: [f32; 3]| [x, y, z, x, y, z, 0.0, 0.0];
            let frame = Frame { origin: [0.0; 8], scale: twice([200.0; 3]) };
            let mut lists = Kernels::all().map(|kernels| {
                let mut area = vec![Record::default(); scratch::records::<u16>(bucket)];
                let mut scratch = Scratch::carve(&mut area, bucket);
                let mut sink = Pairs(Vec::new());
                let (order, boxes) = (&order, &boxes);
                let scratch = &mut scratch;
                kernels.run_wide(SweepList { order, axis, frame, boxes, scratch, sink: &mut sink });
                sink.0
            });
            let mut pairs = lists.next().unwrap_or_default();
            for list in lists {
                prop_assert_eq!(&list, &pairs);
            }
            pairs.sort_unstable();
            let mut expected = crate::sweep::small::tests::overlaps(&boxes);
            expected.sort_unstable();
            prop_assert_eq!(pairs, expected);
        }
    }
}
