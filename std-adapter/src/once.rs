//! The pairs of boxes that are there once: no world to keep, no room to guess.

use crate::owned::OwnedWorld;
use core::iter::FusedIterator;
use core::slice;
use trisap_core::{Aabb, Boxes, Capacity, Config, Error, Executor, Filter, Id, Serial};

/// Room for pairs that is set aside for each object. Where there are fewer the rest is address space alone, as nobody writes to it.
const PAIRS_PER_OBJECT: u32 = 16;
/// Boxes that are asked for at a time.
const CHUNK: usize = 256;
/// The classes of two sides.
const A: u32 = 0;
const B: u32 = 1;

/// What has a box: boxes in `f32` or `f64` (minimum x, y, z, maximum x, y, z), and whatever you say.
pub trait Bounded {
    /// The box.
    fn aabb(&self) -> Aabb;
}

impl Bounded for Aabb {
    fn aabb(&self) -> Aabb {
        *self
    }
}

impl Bounded for [f32; 6] {
    fn aabb(&self) -> Aabb {
        let [a, b, c, d, e, f] = *self;
        Aabb::new([a, b, c], [d, e, f])
    }
}

/// Rounded outward: see [`Aabb::from_f64`], which also takes an origin.
impl Bounded for [f64; 6] {
    fn aabb(&self) -> Aabb {
        let [a, b, c, d, e, f] = *self;
        Aabb::from_f64([a, b, c], [d, e, f], [0.0; 3])
    }
}

impl<T: Bounded + ?Sized> Bounded for &T {
    fn aabb(&self) -> Aabb {
        (**self).aabb()
    }
}

/// All pairs of boxes that overlap, each once, by their positions, the lower one first; in no order, but the same for the same
/// boxes. Nothing has to be set up. Whoever asks often keeps a [`Scratch`], which also takes workers. O(n log n + pairs).
///
/// ```
/// use trisap::Aabb;
///
/// let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// assert_eq!(trisap::pairs(&[cube(0.0), cube(5.0), cube(0.5)])?, [[0, 2]]);
///
/// // Whatever has a box, and boxes in `f64`, rounded outward.
/// let spheres = [([0.0f64; 3], 1.0), ([0.0, 0.0, 1.5], 0.5), ([3.0; 3], 0.1)];
/// let boxes = spheres.iter().map(|&([x, y, z], r)| [x - r, y - r, z - r, x + r, y + r, z + r]);
/// assert_eq!(trisap::pairs(boxes)?, [[0, 1]]);
/// # Ok::<(), trisap::Error>(())
/// ```
///
/// # Errors
/// [`Error::BadBox`] names the first box with NaN or a minimum above its maximum; [`Error::CapacityTooLarge`] for more than
/// 2^27 boxes, [`Error::NoMemory`], and [`Error::PairsFull`] for more than 2^32 pairs.
pub fn pairs<T>(boxes: T) -> Result<Vec<[u32; 2]>, Error>
where
    T: IntoIterator<Item: Bounded, IntoIter: ExactSizeIterator>,
{
    Scratch::new().pairs(boxes).map(|pairs| pairs.to_vec())
}

/// All pairs of a box of `a` and a box of `b` that overlap, by their positions in each. Boxes of one side are not compared with
/// each other. Else as [`pairs`].
///
/// ```
/// use trisap::Aabb;
///
/// let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// let (walls, balls) = ([cube(0.0), cube(0.5)], [cube(9.0), cube(-1.0)]);
/// assert_eq!(trisap::pairs_between(&walls, &balls)?, [[0, 1]]);
/// # Ok::<(), trisap::Error>(())
/// ```
///
/// # Errors
/// Those of [`pairs`]; boxes of `b` are counted on from those of `a`.
pub fn pairs_between<T, U>(a: T, b: U) -> Result<Vec<[u32; 2]>, Error>
where
    T: IntoIterator<Item: Bounded, IntoIter: ExactSizeIterator>,
    U: IntoIterator<Item: Bounded, IntoIter: ExactSizeIterator>,
{
    Scratch::new().pairs_between(a, b).map(|pairs| pairs.to_vec())
}

/// Memory for [`pairs`] and [`pairs_between`], to use again. It keeps what the largest question took.
///
/// ```
/// use trisap::{Aabb, Rayon, Scratch};
///
/// let boxes: Vec<_> = (0..5000).map(|x| Aabb::new([x as f32, 0.0, 0.0], [x as f32 + 1.0; 3])).collect();
/// let mut scratch = Scratch::new();
/// for half in boxes.chunks(2500) {
///     for [a, b] in scratch.pairs(half)? {
///         assert_eq!(a + 1, b);
///     }
/// }
/// // On all cores.
/// assert_eq!(scratch.on(&Rayon::global()).pairs(&boxes)?.len(), 4999);
/// # Ok::<(), trisap::Error>(())
/// ```
#[derive(Debug, Default)]
pub struct Scratch {
    world: Option<OwnedWorld>,
    /// The most pairs so far.
    most: u32,
}

impl Scratch {
    /// No memory yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// As the function [`pairs`], without a copy of the pairs.
    ///
    /// # Errors
    /// Those of the function.
    pub fn pairs<T>(&mut self, boxes: T) -> Result<Pairs<'_>, Error>
    where
        T: IntoIterator<Item: Bounded, IntoIter: ExactSizeIterator>,
    {
        self.on(&Serial).pairs(boxes)
    }

    /// As the function [`pairs_between`], without a copy of the pairs.
    ///
    /// # Errors
    /// Those of the function.
    pub fn pairs_between<T, U>(&mut self, a: T, b: U) -> Result<Pairs<'_>, Error>
    where
        T: IntoIterator<Item: Bounded, IntoIter: ExactSizeIterator>,
        U: IntoIterator<Item: Bounded, IntoIter: ExactSizeIterator>,
    {
        self.on(&Serial).pairs_between(a, b)
    }

    /// The same on the workers of an executor, which pays from some thousand boxes on.
    pub fn on<'s>(&'s mut self, executor: &'s dyn Executor) -> ScratchOn<'s> {
        ScratchOn { scratch: self, executor }
    }
}

/// A [`Scratch`] and an executor: made by [`Scratch::on`].
#[must_use = "does nothing until it is asked"]
pub struct ScratchOn<'s> {
    scratch: &'s mut Scratch,
    executor: &'s dyn Executor,
}

impl<'s> ScratchOn<'s> {
    /// See [`Scratch::pairs`].
    ///
    /// # Errors
    /// Those of the function [`pairs`].
    pub fn pairs<T>(self, boxes: T) -> Result<Pairs<'s>, Error>
    where
        T: IntoIterator<Item: Bounded, IntoIter: ExactSizeIterator>,
    {
        let boxes = boxes.into_iter();
        let config = self.config(boxes.len());
        self.find(config, &mut [(0, &mut boxes.map(|item| item.aabb()))])
    }

    /// See [`Scratch::pairs_between`].
    ///
    /// # Errors
    /// Those of the function [`pairs_between`].
    pub fn pairs_between<T, U>(self, a: T, b: U) -> Result<Pairs<'s>, Error>
    where
        T: IntoIterator<Item: Bounded, IntoIter: ExactSizeIterator>,
        U: IntoIterator<Item: Bounded, IntoIter: ExactSizeIterator>,
    {
        let (a, b) = (a.into_iter(), b.into_iter());
        let (first, config) = (a.len(), self.config(a.len().saturating_add(b.len())).with_filters());
        let (mut a, mut b) = (a.map(|item| item.aabb()), b.map(|item| item.aabb()));
        let pairs = self.find(config, &mut [(A, &mut a), (B, &mut b)])?;
        Ok(Pairs { first: first as u32, ..pairs })
    }

    fn config(&self, objects: usize) -> Config {
        let objects = u32::try_from(objects).unwrap_or(u32::MAX);
        let pairs = objects.saturating_mul(PAIRS_PER_OBJECT).max(self.scratch.most);
        let capacity = Capacity::for_objects(objects).with_leaf_refs(objects).with_pairs(pairs);
        let config = Config::new(capacity).without_predicted_boxes();
        config.with_workers(self.executor.workers().clamp(1, 32))
    }

    /// The pairs of boxes, each side with its class.
    fn find(
        self,
        config: Config,
        sides: &mut [(u32, &mut dyn Iterator<Item = Aabb>)],
    ) -> Result<Pairs<'s>, Error> {
        let Self { scratch, executor } = self;
        let used = scratch.world.take().map(OwnedWorld::into_memory);
        let owned = scratch.world.insert(OwnedWorld::reserved(used, &config)?);
        let mut world = owned.world();
        if config.filters {
            let mut meets = [0; 32];
            (meets[A as usize], meets[B as usize]) = (1 << B, 1 << A);
            world.set_classes(&meets)?;
        }
        let (mut chunk, mut ids) = (Vec::with_capacity(CHUNK), Vec::<Id>::new());
        for (class, boxes) in sides {
            loop {
                chunk.clear();
                chunk.extend(boxes.by_ref().take(CHUNK));
                if chunk.is_empty() {
                    break;
                }
                let before = world.len();
                ids.clear();
                ids.extend(world.insert_many(Boxes::new(&chunk)).map_err(|error| match error {
                    Error::BadBox { index } => Error::BadBox { index: before + index },
                    error => error,
                })?);
                for &id in ids.iter().filter(|_| *class == B) {
                    world.set_filter(id, Filter::class(B))?;
                }
            }
        }
        // A dense heap takes a second look, with room that is known then.
        match world.on(executor).step().map(drop) {
            Err(Error::PairsFull { needed, .. }) if needed <= u64::from(u32::MAX) => {
                let capacity = config.capacity.with_pairs(needed as u32);
                owned.move_to(&config.with_capacity(capacity))?;
                owned.world().on(executor).step().map(drop)
            }
            step => step,
        }?;
        let pairs = owned.as_world().pairs();
        scratch.most = scratch.most.max(pairs.len() as u32);
        Ok(Pairs { pairs: pairs.iter(), first: 0 })
    }
}

/// The pairs that were found: an iterator of positions.
#[derive(Clone, Debug)]
pub struct Pairs<'s> {
    pairs: slice::Iter<'s, [u32; 2]>,
    /// The second position counts from this one on.
    first: u32,
}

impl Pairs<'_> {
    /// A copy of those that are left.
    #[must_use]
    pub fn to_vec(&self) -> Vec<[u32; 2]> {
        self.pairs.as_slice().iter().map(|&[a, b]| [a, b - self.first]).collect()
    }
}

impl Iterator for Pairs<'_> {
    type Item = [u32; 2];

    fn next(&mut self) -> Option<[u32; 2]> {
        self.pairs.next().map(|&[a, b]| [a, b - self.first])
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        self.pairs.size_hint()
    }
}

impl ExactSizeIterator for Pairs<'_> {}
impl FusedIterator for Pairs<'_> {}

#[cfg(test)]
mod tests;
