//! The KD-tree: the objects of all leaves, split from the sorted lists.

use crate::Aabb;
use crate::lists::Lists;
use std::ops::Range;

/// All leaves together have at most so many times as many boxes as there are objects (E11).
const MOST_COPIES: usize = 4;

/// An object in a node, or a copy of it: its minimum lies in another node, and it reaches into this one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Member(u32);

impl Member {
    const COPY: u32 = 1 << 31;

    pub(crate) const fn id(self) -> u32 {
        self.0 & !Self::COPY
    }

    const fn is_copy(self) -> bool {
        self.0 & Self::COPY != 0
    }

    const fn copy(self) -> Self {
        Self(self.0 | Self::COPY)
    }
}

/// A node of the level that is being split.
#[derive(Clone, Debug)]
struct Node {
    /// Its part of the level's lists, the same for each axis.
    members: Range<usize>,
    /// Its cell lies above these planes. `None` where there is no plane.
    low: [Option<f32>; 3],
    /// The axes of most dispersion of its parent and of its grandparent.
    ancestors: [usize; 2],
}

/// A node that is not split.
#[derive(Clone, Debug)]
pub(crate) struct Leaf {
    /// Its part of [`Tree::leaf_members`], in order on `axis`.
    pub(crate) members: Range<usize>,
    pub(crate) low: [Option<f32>; 3],
    /// The axis of the sweep.
    pub(crate) axis: usize,
}

/// Where a split takes a member: the left side, the right one, or as a straddler both.
#[derive(Clone, Copy, Debug, Default)]
struct Sides {
    left: bool,
    right: bool,
    /// Whether its minimum is on the left. If it goes right as well, that is a copy.
    starts_left: bool,
}

#[derive(Clone, Debug)]
pub(crate) struct Tree {
    most_in_leaf: usize,
    /// The axes in the order in which they take turns (E17). Found when the tree is made.
    order: Option<[usize; 3]>,
    level: Vec<Node>,
    /// The members of all nodes of the level, in order on each axis.
    members: [Vec<Member>; 3],
    next_level: Vec<Node>,
    next_members: [Vec<Member>; 3],
    /// By object, for the node that is being split.
    sides: Vec<Sides>,
    pub(crate) leaves: Vec<Leaf>,
    pub(crate) leaf_members: Vec<Member>,
}

impl Tree {
    pub(crate) fn new(objects: usize, most_in_leaf: usize) -> Self {
        Self {
            most_in_leaf,
            order: None,
            level: Vec::new(),
            members: Default::default(),
            next_level: Vec::new(),
            next_members: Default::default(),
            sides: vec![Sides::default(); objects],
            leaves: Vec::new(),
            leaf_members: Vec::new(),
        }
    }

    /// Goes through the tree once, from the top: planes follow the medians (E8), copies come and go, and leaves that are
    /// too large are split.
    pub(crate) fn update(&mut self, lists: &Lists, boxes: &[Aabb]) {
        self.leaves.clear();
        self.leaf_members.clear();
        for (axis, members) in self.members.iter_mut().enumerate() {
            members.clear();
            members.extend(lists.in_order(axis).map(Member));
        }
        let objects = boxes.len();
        let dispersion = dispersion(&self.members, &(0..objects), boxes);
        let order = *self.order.get_or_insert_with(|| {
            let mut axes = [0, 1, 2];
            axes.sort_by(|&a, &b| dispersion[b].total_cmp(&dispersion[a]));
            axes
        });
        let widest = widest(dispersion);
        self.level.clear();
        self.level.push(Node { members: 0..objects, low: [None; 3], ancestors: [widest; 2] });
        // Each level takes its axes from another place of the order.
        for depth in 0.. {
            if self.level.is_empty() {
                break;
            }
            let axes = [0, 1, 2].map(|turn| order[(depth + turn) % 3]);
            self.split_level(axes, boxes);
        }
    }

    /// Splits the nodes of a level, or makes leaves of them.
    fn split_level(&mut self, axes: [usize; 3], boxes: &[Aabb]) {
        self.next_level.clear();
        self.next_members.iter_mut().for_each(Vec::clear);
        // What the copies of all leaves can still come to.
        let entries = self.leaf_members.len() + self.members[0].len();
        let mut spare = (MOST_COPIES * boxes.len()).saturating_sub(entries);
        for at in 0..self.level.len() {
            let node = self.level[at].clone();
            let split =
                axes.into_iter().find_map(|axis| Some((axis, self.plane(&node, axis, boxes, spare)?)));
            match split {
                Some((axis, (plane, copies))) => {
                    spare -= copies;
                    self.split(&node, axis, plane, boxes);
                }
                None => self.keep(node),
            }
        }
        std::mem::swap(&mut self.level, &mut self.next_level);
        std::mem::swap(&mut self.members, &mut self.next_members);
    }

    /// The plane that splits a node on an axis, at the minimum of its median object, and how many copies that makes. The
    /// sides of all members are left in `sides`. `None` where the node is not to be split on this axis (E11).
    fn plane(&mut self, node: &Node, axis: usize, boxes: &[Aabb], spare: usize) -> Option<(f32, usize)> {
        let members = &self.members[axis][node.members.clone()];
        if members.len() <= self.most_in_leaf {
            return None;
        }
        // Of its own objects: most copies start below the cell.
        let own = || members.iter().filter(|member| !member.is_copy());
        let median = own().nth(own().count().checked_sub(1)? / 2)?;
        let plane = boxes[median.id() as usize].min[axis];
        let (mut left, mut right, mut own_right) = (0, 0, 0);
        for member in members {
            let aabb = &boxes[member.id() as usize];
            // Whoever starts on the plane belongs to the left. Straddlers go to both sides, static ones too (E7).
            let starts_left = aabb.min[axis] <= plane;
            let sides =
                Sides { left: starts_left, right: !starts_left || aabb.max[axis] > plane, starts_left };
            left += usize::from(sides.left);
            right += usize::from(sides.right);
            own_right += usize::from(!starts_left && !member.is_copy());
            self.sides[member.id() as usize] = sides;
        }
        let copies = left + right - members.len();
        let separates = own_right > 0 && left < members.len() && right < members.len();
        (separates && copies <= spare.min(members.len() / 2)).then_some((plane, copies))
    }

    /// Hands the members of a node to its children, in order on each axis.
    fn split(&mut self, node: &Node, axis: usize, plane: f32, boxes: &[Aabb]) {
        let start = self.next_members[0].len();
        let mut middle = start;
        for (from, to) in self.members.iter().zip(&mut self.next_members) {
            let members = &from[node.members.clone()];
            let sides = |member: Member| self.sides[member.id() as usize];
            append(to, members, |member| (member, sides(member).left));
            middle = to.len();
            append(to, members, |member| {
                let sides = sides(member);
                (if sides.starts_left { member.copy() } else { member }, sides.right)
            });
        }
        let end = self.next_members[0].len();
        let widest = widest(dispersion(&self.members, &node.members, boxes));
        let ancestors = [widest, node.ancestors[0]];
        self.next_level.push(Node { members: start..middle, low: node.low, ancestors });
        let mut low = node.low;
        low[axis] = Some(plane);
        self.next_level.push(Node { members: middle..end, low, ancestors });
    }

    /// Makes a leaf of a node.
    fn keep(&mut self, node: Node) {
        // E16: the root stands for the ancestors that a node does not have.
        let axis = node.ancestors[1];
        let start = self.leaf_members.len();
        self.leaf_members.extend_from_slice(&self.members[axis][node.members]);
        self.leaves.push(Leaf { members: start..self.leaf_members.len(), low: node.low, axis });
    }
}

/// Appends those members of which `pick` says so. That cannot be predicted: so each is written, and the next one over it if it
/// was not wanted.
fn append(to: &mut Vec<Member>, members: &[Member], pick: impl Fn(Member) -> (Member, bool)) {
    let mut end = to.len();
    to.resize(end + members.len(), Member(0));
    for &member in members {
        let (member, wanted) = pick(member);
        to[end] = member;
        end += usize::from(wanted);
    }
    to.truncate(end);
}

/// How far the minima of some members are spread on each axis.
fn dispersion(members: &[Vec<Member>; 3], range: &Range<usize>, boxes: &[Aabb]) -> [f32; 3] {
    std::array::from_fn(|axis| match &members[axis][range.clone()] {
        [first, .., last] => boxes[last.id() as usize].min[axis] - boxes[first.id() as usize].min[axis],
        _ => 0.0,
    })
}

fn widest(dispersion: [f32; 3]) -> usize {
    (0..3).fold(0, |widest, axis| if dispersion[axis] > dispersion[widest] { axis } else { widest })
}
