//! The table of all arrays of a world. A line here and the use of the array is all that a new one needs: its
//! bytes, its place in the slab, what it is in a new world, copies, snapshots and the figure in
//! `ARCHITECTURE.md` follow.

/// Calls another macro with the table. A line has the name of an array, its type, its items and how many
/// there are; and then what is in it where nothing has been written: `new` the value that all items have in a
/// new world, or `used` how many items mean something between two steps, the first ones. `saved` arrays are
/// in snapshots, by another name, with so many items or as many as there are.
///
/// `s` are the [`Sizes`](super::layout::Sizes), `state` is the [`State`](super::state::State), `n` the
/// numbers of a snapshot. Here are arrays by slot, if nothing else is said.
macro_rules! sections {
    ($then:ident) => {
        $then! { |s, state, n| {
            /// How many objects have had the slot.
            generations: &'m mut [u32] = [u32; s.objects], new 0, saved generations [n.slots];
            /// The swept box has changed since the last complete step (the paper's dynamic objects).
            moved: SlotSet<'m> = [u32; SlotSet::len(s.objects)], new 0, saved moved [n.words];
            /// The same of the objects that the tree has had as they are since then, so that queries need not
            /// know of it: the next step counts them as moved.
            settled: SlotSet<'m> = [u32; SlotSet::len(s.objects)], new 0, saved settled [n.words];
            /// One bit a slot: the caller has put the object to rest.
            resting: &'m mut [u32] = [u32; bits::words(s.objects)], new 0, saved resting [n.words];
            /// With a tree and events or fat boxes: the swept box, the reported box or the filter has
            /// changed since the last complete step.
            changed: SlotSet<'m> = [u32; SlotSet::len(s.changed())], new 0, saved changed [n.words];
            /// With events and a tree: `before` may be out of date, since the slot changed before the last
            /// complete step.
            outdated: SlotSet<'m> = [u32; SlotSet::len(s.by_object(s.keeps_boxes()))], new 0;
            /// With a tree, one bit a slot: the object is active, so its pairs are not parked.
            active: &'m mut [u32] = [u32; bits::words(if_so(TREE, s.tree))], new 0;
            /// Without a tree, unless every two boxes are tested: by ascending minimum on the swept axis, words
            /// with a [`slot`](crate::memory::state::slot).
            list: &'m mut [i32] = [i32; s.list], used state.lists.listed as usize;
            /// With events and without a tree: a bit for each two slots, set for the pairs of the last complete
            /// result.
            met: &'m mut [u32] = [u32; s.met()], new 0;
            /// With a tree: scratch memory of a step, a byte for each object or more.
            spare: &'m mut [I] = [I; s.spare::<I>()], used 0;
            /// The leaf that holds the object's record, or [`Index::LARGE`], or [`Index::NONE`].
            home: &'m mut [I] = [I; if_so(TREE, s.tree)], new I::NONE;
            /// The position of the record in its leaf, or in the list of large objects.
            place: &'m mut [I] = [I; if_so(TREE, s.tree)], used state.objects.slots as usize;
            }

            /// The boxes of all slots.
            boxes: BoxParts ['m] {
                /// The box whose overlaps a result has: as given last; in a fat world what was so with its
                /// margin when it left that last. A free slot has an empty one, which holds the next free slot.
                now: &'m mut [KeyBox] = [KeyBox; s.objects], used state.objects.slots as usize, saved now [n.slots];
                /// Of disabled objects: the low bits of a side, for which an empty box has no room.
                cut: &'m mut [u16] = [u16; s.objects], new 0, saved cut [n.slots];
                /// In a fat world with margins: the box as given last, of enabled objects.
                given: &'m mut [KeyBox] = [KeyBox; s.by_object(reports_margins(&s.config))], used state.objects.slots as usize, saved given [n.slots];
                /// In an exact world with margins, or with predicted boxes: the fat box (erratum E5).
                fat: &'m mut [KeyBox] = [KeyBox; if_so(TREE, s.fat)], used state.objects.slots as usize;
                /// With margins: the length that the box is grown by (erratum E2).
                margins: &'m mut [f32] = [f32; s.by_object(MARGINS && s.config.margin.is_some())], used state.objects.slots as usize, saved margins [n.slots];
                /// With events and a tree: the box that the last complete step reported, if the object
                /// has [changed](Parts::changed) since; empty if it is new. If it has not changed, this
                /// is its reported box, unless it is [outdated](Parts::outdated). Not kept in steps in which it
                /// is [unknown](super::state::PairState::before_unknown).
                before: &'m mut [KeyBox] = [KeyBox; s.by_object(s.keeps_boxes())], used state.objects.slots as usize;
                + /// Whether `now` is swept though there are fat boxes, while these are left unused. They then mean
                /// nothing.
                tight: bool = state.step.margins_in > 0;
            }

            /// With filters: whom the objects meet.
            filters: FilterParts ['m] {
                of: &'m mut [Filter] = [Filter; s.by_object(FILTERS && s.config.filters)], used state.objects.slots as usize,
                    saved filters [n.slots];
                /// One bit for each class that a class meets.
                classes: &'m mut [u32] = [u32; if_so(FILTERS && s.config.filters, CLASSES)], new u32::MAX, saved classes [usize::MAX];
                /// The filter may answer differently since the last complete step.
                changed: SlotSet<'m> = [u32; SlotSet::len(s.by_object(FILTERS && s.config.filters))], new 0, saved refiltered [n.words];
            }

            /// With values: the caller's number for each object.
            values: ValueParts ['m] {
                /// A free slot keeps the value of the object that had it.
                of: &'m mut [u64] = [u64; s.by_object(VALUES && s.config.values)], used state.objects.slots as usize, saved values [n.slots];
                /// With events: the values of the objects in [`FormerParts::generations`].
                former: &'m mut [u64] = [u64; s.by_object(VALUES && EVENTS && s.config.values && s.config.events)], used state.objects.slots as usize;
            }

            /// Which slots new objects have got since the complete step before; with events also who had
            /// them, so that lost pairs can be named.
            former: FormerParts ['m] {
                /// With events, of these slots: the generation of the former object.
                generations: &'m mut [u32] = [u32; s.by_object(EVENTS && s.config.events)], used state.objects.slots as usize;
                /// These slots.
                reused: SlotSet<'m> = [u32; SlotSet::len(s.objects)], new 0, saved reused [n.words];
            }

            /// The KD-tree.
            tree: TreeParts ['m] {
                /// The records of all leaves, one leaf after another, each with some room.
                records: &'m mut [Record] = [Record; s.records()], used s.records();
                /// The straddlers of all leaves, one leaf after another; behind them the boxes of the nodes
                /// over the large objects, and their list.
                straddlers: &'m mut [Straddler] = [Straddler; if_so(TREE, s.straddlers)],
                    used state.tree.large_list() + state.tree.large as usize;
                /// By node.
                splits: &'m mut [Split] = [Split; 2 * if_so(TREE, s.whole_leaves)], used 2 * s.whole_leaves;
                /// By half of the number of two nodes: the node above them.
                parents: &'m mut [u32] = [u32; if_so(TREE, s.whole_leaves)], used s.whole_leaves;
                /// By leaf of a full step: its node.
                tops: &'m mut [u32] = [u32; if_so(TREE, s.whole_leaves)], used s.whole_leaves;
                /// By leaf, while it is divided: the planes between its sub-leaves, numbered as in a heap
                /// from one on.
                planes: &'m mut [i32] = [i32; if_so(TREE, s.leaves)], used s.leaves;
                /// By leaf of a full step.
                cells: &'m mut [Cell] = [Cell; if_so(TREE, s.whole_leaves)], used s.whole_leaves;
                /// By leaf of a full step. Its sub-leaves share it.
                frames: &'m mut [Frame] = [Frame; if_so(TREE, s.whole_leaves)], used s.whole_leaves;
                /// By leaf of a full step: its count when no plane could divide it, or zero.
                stuck: &'m mut [u32] = [u32; if_so(TREE, s.whole_leaves)], used s.whole_leaves;
                /// By leaf of a full step. Its sub-leaves have none.
                straddling: &'m mut [Straddling] = [Straddling; if_so(TREE, s.whole_leaves)], used s.whole_leaves;
                /// By leaf.
                leaves: &'m mut [Leaf] = [Leaf; if_so(TREE, s.leaves)], new Leaf::default();
                /// By leaf, while leaves are divided: a box around its members, as a record in their frame.
                /// Else it means nothing.
                bounds: &'m mut [Record] = [Record; if_so(TREE, s.leaves)], used s.leaves;
                /// By node: a box around its members. There is no node zero.
                boxes: &'m mut [KeyBox] = [KeyBox; 2 * if_so(TREE, s.whole_leaves)], new KeyBox::NOTHING;
                /// In a fill: a row of counts for each block of slots, see
                /// [`histogram_row`](crate::memory::limits::histogram_row). Then: where the movers of each
                /// leaf end.
                histogram: &'m mut [u32] = [u32; s.histogram()], used 0;
            }

            /// The pairs, and all that a sweep writes to.
            output: OutputParts ['m, I] {
                /// The overlaps of swept boxes: see `PairState::swept`. Some may stand at the end.
                pairs: &'m mut [Pair<I>] = [Pair<I>; s.pairs],
                    used if state.pairs.surplus_parked > 0 { s.pairs } else { state.pairs.swept as usize };
                /// With events: the pairs of the last complete step, in a step with few movers without the
                /// parked ones. After a step the lost pairs come first. This buffer and `pairs` change
                /// places, so nothing is copied: see
                /// [`PairState::swapped`](super::state::PairState::swapped).
                previous: &'m mut [Pair<I>] = [Pair<I>; if_so(EVENTS, s.previous)], used state.pairs.previous as usize;
                /// With workers: chunks of pairs in the order in which they were found.
                staged: &'m mut [Pair<I>] = [Pair<I>; if_so(TREE, s.staged.saturating_mul(CHUNK))], used 0;
                /// The block, the position and the length of each chunk.
                chunks: &'m mut [[u32; 3]] = [[u32; 3]; if_so(TREE, s.staged)], used 0;
                /// The workers' scratch, in equal areas.
                scratch: &'m mut [Record] = [Record; if_so(TREE, s.workers * scratch::records::<I>(s.bucket))], used 0;
            }
        }
    };
}

pub(crate) use sections;
