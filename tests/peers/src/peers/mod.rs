//! The peers, each in its own file, behind one small trait.

use crate::recording::Padded;

mod obvhs;
mod paper;
mod parry;
mod physx;
mod rapier;
#[cfg_attr(
    not(any(feature = "embree", feature = "cgal", feature = "bullet", feature = "jolt", feature = "box3d")),
    expect(dead_code, reason = "no C++ peer is built")
)]
mod shim;
mod sweep;

/// A broad phase that is fed with the boxes of one frame after the other.
pub(crate) trait Peer {
    /// Puts the boxes where the peer's caller would have them. Not timed.
    fn prepare(&mut self, boxes: &[Padded]);
    /// One frame. Timed.
    fn frame(&mut self);
    /// What the last frame found. Not timed.
    fn output(&mut self) -> Output<'_>;
}

/// What a frame found.
pub(crate) enum Output<'a> {
    /// All pairs.
    Pairs(&'a [[u32; 2]]),
    /// The changes since the last frame.
    Events { found: &'a [[u32; 2]], lost: &'a [[u32; 2]] },
}

/// What a peer is started with.
pub(crate) struct Setting<'a> {
    /// The boxes of the first frame, which it has not seen yet.
    pub(crate) boxes: &'a [Padded],
    /// Who may have another box in later frames: all, or some in ascending order.
    pub(crate) movers: &'a [u32],
    pub(crate) threads: u32,
}

impl Setting<'_> {
    /// Whether only some may have another box.
    pub(crate) fn is_crowd(&self) -> bool {
        self.movers.len() < self.boxes.len()
    }
}

/// Starts a peer.
pub(crate) type Start = fn(&Setting) -> Box<dyn Peer>;

/// What a peer tells that is handed the boxes of few alone.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Crowd {
    /// It cannot be: it goes over all boxes in every frame.
    Unsuited,
    /// All pairs, or what changed.
    All,
    /// The pairs of those whose boxes came.
    OfMovers,
}

/// A peer by name, and how to start it or why it cannot be started.
pub(crate) struct Entry {
    pub(crate) name: &'static str,
    /// How it is configured, in a few words.
    pub(crate) setup: &'static str,
    /// Whether it tells found and lost pairs.
    pub(crate) events: bool,
    /// Whether it tells a superset of the overlaps; the exact test is then made outside the timing.
    pub(crate) fat: bool,
    /// Whether it can use a second thread.
    pub(crate) parallel: bool,
    pub(crate) crowd: Crowd,
    pub(crate) start: Result<Start, &'static str>,
}

/// The threads of the peers that run on rayon.
struct Pool {
    #[cfg(feature = "parallel")]
    pool: rayon::ThreadPool,
}

impl Pool {
    /// Whether more than one thread can be had.
    const PARALLEL: bool = cfg!(feature = "parallel");

    fn new(threads: u32) -> Self {
        assert!(threads == 1 || Self::PARALLEL, "built without the feature `parallel`");
        Self {
            #[cfg(feature = "parallel")]
            pool: rayon::ThreadPoolBuilder::new()
                .num_threads(threads as usize)
                .build()
                .expect("threads can be had"),
        }
    }

    fn run(&self, work: impl FnOnce() + Send) {
        #[cfg(feature = "parallel")]
        self.pool.install(work);
        #[cfg(not(feature = "parallel"))]
        work();
    }
}

/// Every peer, those that could not be built included.
pub(crate) fn all() -> Vec<Entry> {
    vec![
        physx::entry(),
        parry::refit(),
        parry::rebuild(),
        obvhs::rebuild(),
        obvhs::avian(),
        rapier::entry(),
        shim::embree(),
        shim::cgal(),
        shim::bullet(),
        shim::jolt(),
        shim::box3d(),
        sweep::entry(),
        paper::entry(),
    ]
}
