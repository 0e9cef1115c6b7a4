//! Random lives of worlds of any size and configuration; of small worlds there are many more in `sequences.rs`. After every operation the world validates itself and
//! agrees with the model, queries included; after every step so do pairs and events; and a second life with other
//! kernels, job systems and workers says the same, byte for byte.
//!
//! `TRISAP_EFFORT` multiplies the number of cases (1 where it is not set).

use proptest::prelude::*;
use trisap_core::{Aabb, Boxes, Capacity, Config, Error, Filter, Id, Index, Kernels, Margin, Mode, World};
use trisap_tests::checked::{Checked, Outcome, Saved};
use trisap_tests::effort;
use trisap_tests::forced::{Choice, Forced as _};
use trisap_tests::jobs::Jobs;
use trisap_tests::model::Model;
use trisap_tests::queries::Questions;
use trisap_tests::scenes::{Rng, at, shifted};
use trisap_tests::worlds::{Setup, Slab};

/// What the boxes of a case are like.
#[derive(Clone, Copy, Debug)]
enum Style {
    /// Small integers: contacts and equal keys everywhere.
    Lattice,
    /// Unit cubes anywhere.
    Uniform,
    /// Nine in ten in one place.
    Clustered,
    /// The same interval for all on this axis.
    Flat(usize),
    /// Over six orders of magnitude.
    Sizes,
    /// Now and then infinite, huge, denormal or negative zero.
    Odd,
}

impl Style {
    /// A box in a world for `objects`, which are sparse enough not to overlap all.
    fn place(self, objects: usize, rng: &mut Rng) -> Aabb {
        let side = 2.5 * (objects as f32).cbrt();
        match self {
            Self::Lattice => {
                let corner = [(); 3].map(|()| rng.below(side as usize + 1) as f32);
                at(corner, [(); 3].map(|()| rng.below(3) as f32))
            }
            Self::Uniform => at(rng.point(0.0, side), [1.0; 3]),
            Self::Clustered => {
                let reach = if rng.once_in(10) { 20.0 * side } else { side };
                at(rng.point(0.0, reach), rng.point(0.1, 1.0))
            }
            Self::Flat(axis) => {
                let mut corner = rng.point(0.0, (4.0 * objects as f32).sqrt());
                corner[axis] = 3.0;
                at(corner, [1.0; 3])
            }
            Self::Sizes => {
                let scale = (1_u32 << rng.below(21)) as f32 / 1024.0;
                at(rng.point(0.0, 300.0 * side), rng.point(0.5, 1.0).map(|share| share * scale))
            }
            Self::Odd => {
                let mut aabb = at(rng.point(0.0, side), [1.0; 3]);
                if rng.once_in(40) {
                    let axis = rng.below(3);
                    let ends =
                        [f32::NEG_INFINITY, f32::MIN, -0.0, 0.0, f32::from_bits(1), f32::MAX, f32::INFINITY];
                    let low = rng.below(ends.len());
                    aabb.min[axis] = ends[low];
                    aabb.max[axis] = ends[low + rng.below(ends.len() - low)];
                }
                aabb
            }
        }
    }
}

/// How an object moves.
#[derive(Clone, Copy, Debug)]
enum Motion {
    /// By less than the margins.
    Creep,
    /// By about its size.
    Move,
    /// To anywhere.
    Teleport,
    /// To where it touches another object.
    Touch,
    /// In place, to another size.
    Grow,
    /// Not at all.
    Rest,
}

impl Motion {
    fn apply(self, aabb: &Aabb, case: &Case, others: &Model, rng: &mut Rng) -> Aabb {
        let next = match self {
            Self::Creep => shifted(aabb, rng.point(-0.02, 0.02)),
            Self::Move => shifted(aabb, rng.point(-1.5, 1.5)),
            Self::Teleport => case.style.place(case.objects, rng),
            Self::Touch => {
                let slot = rng.below(others.boxes().len().max(1));
                let Some(Some(other)) = others.boxes().get(slot) else { return *aabb };
                let axis = rng.below(3);
                let (mut next, edge) = (*other, aabb.max[axis] - aabb.min[axis]);
                next.min[axis] = other.max[axis];
                next.max[axis] = next.min[axis] + edge;
                next
            }
            Self::Grow => Aabb::new(aabb.min, [0, 1, 2].map(|k| aabb.max[k] + rng.between(0.0, 0.5))),
            Self::Rest => *aabb,
        };
        // Arithmetic on infinite boxes can make NaN.
        if next.is_valid() { next } else { *aabb }
    }
}

/// Calls that must fail and change nothing.
#[derive(Clone, Copy, Debug)]
enum Fault {
    BadInsert,
    BadSet,
    BadBatch,
    StaleSet,
    StaleBatch,
    TwiceInBatch,
    BadMargin,
}

#[derive(Clone, Debug)]
enum Op {
    Insert,
    /// A share of the capacity, in thousandths, as in what follows.
    InsertMany(usize),
    Set(Motion),
    Update(usize, Motion),
    Remove,
    RemoveMany(usize),
    SetMargin(f32),
    /// The filter of an object, or of a share of them.
    SetFilter(usize),
    SetClasses,
    /// The rule changes its mind about a share of the objects.
    Refilter(usize),
    Rest(usize),
    Wake(usize),
    /// Takes a snapshot.
    Save,
    /// Goes back to one of the snapshots.
    Load,
    /// Many queries at once.
    Ask(usize),
    Step(usize),
    /// A step over a bounds array: the share that moves, and how; whether some boxes are bad; its length in
    /// thousandths of the slots.
    StepOver(usize, usize, Motion, bool, usize),
    Fail(Fault),
    /// Drops the world and opens it again.
    Reopen,
    /// Goes on in other memory, from a snapshot.
    Migrate,
}

#[derive(Clone, Debug)]
struct Case {
    style: Style,
    objects: usize,
    margin: Option<Margin>,
    mode: Mode,
    events: bool,
    filters: bool,
    /// Where there are filters, a rule too.
    rule: bool,
    /// Movers only, fine leaves, sharing, movers by leaf.
    choices: [Choice; 4],
    fixed_margins: bool,
    leaf_refs: usize,
    pairs: usize,
    /// The share of the objects that are there from the beginning, in thousandths.
    start: usize,
    seed: u64,
    ops: Vec<Op>,
}

impl Case {
    fn config(&self, workers: u32) -> Config {
        let [movers_only, fine_leaves, sharing, movers_by_leaf] = self.choices;
        let capacity = Capacity::for_objects(self.objects as u32);
        let capacity = capacity.with_leaf_refs(self.leaf_refs as u32).with_pairs(self.pairs as u32);
        let mut config = Config::new(capacity)
            .with_mode(self.mode)
            .with_workers(workers)
            .with_movers_only(movers_only)
            .with_fine_leaves(fine_leaves)
            .with_sharing(sharing)
            .with_movers_by_leaf(movers_by_leaf);
        config.margin = self.margin;
        config.events = self.events;
        config.filters = self.filters;
        config.lean = self.objects <= 256 && self.seed.is_multiple_of(2);
        config.fixed_margins = self.fixed_margins;
        config.predicted = (self.seed / 2).is_multiple_of(2);
        config
    }

    /// A share of the capacity.
    fn share(&self, thousandths: usize) -> usize {
        (self.objects * thousandths).div_ceil(1000)
    }
}

/// What goes on from one operation to the next beside the world.
struct Life {
    rng: Rng,
    /// Ids of objects that are no more.
    gone: Vec<Id>,
    /// Snapshots, and who was gone then.
    saves: Vec<(Saved, Vec<Id>)>,
    said: Vec<Result<Outcome, Error>>,
}

/// A life, on the setups that `choose` takes for the numbers in the steps, and all that was said in it.
fn live<I: Index>(case: &Case, workers: u32, choose: impl Fn(usize) -> Setup) -> Vec<Result<Outcome, Error>> {
    let config = case.config(workers);
    let mut slab = Slab::new::<I>(&config);
    let mut life = Life { rng: Rng::new(case.seed), gone: Vec::new(), saves: Vec::new(), said: Vec::new() };
    let mut model = {
        let mut checked = Checked::<I>::new(slab.world(&config));
        if case.rule && case.filters {
            checked.rule();
        }
        let boxes: Vec<Aabb> =
            (0..case.share(case.start)).map(|_| case.style.place(case.objects, &mut life.rng)).collect();
        checked.insert_many(&boxes);
        checked.into_model()
    };
    for ops in case.ops.split_inclusive(|op| matches!(op, Op::Reopen | Op::Migrate)) {
        let world = World::<I>::open(slab.bytes_mut()).expect("the world that is there");
        let mut checked = Checked::resume(world, model);
        for op in ops {
            apply(op, case, &mut checked, &mut life, &choose);
            // Whatever has been done, queries see it at once.
            let questions = Questions::about(checked.model(), 1, &mut life.rng);
            let setup = choose(life.rng.below(1 << 16));
            let (world, model) = checked.parts_mut();
            questions.ask(world, model, setup);
        }
        let snapshot = matches!(ops.last(), Some(Op::Migrate)).then(|| checked.save().0);
        model = checked.into_model();
        if let Some(snapshot) = snapshot {
            slab = Slab::new::<I>(&config);
            slab.world::<I>(&config).load(&snapshot).expect("a good snapshot");
        }
    }
    life.said
}

fn apply<I: Index>(
    op: &Op,
    case: &Case,
    world: &mut Checked<'_, I>,
    life: &mut Life,
    choose: &impl Fn(usize) -> Setup,
) {
    let Life { rng, gone, saves, said } = life;
    let ids = world.model().ids();
    let any = |rng: &mut Rng| (!ids.is_empty()).then(|| ids[rng.below(ids.len())]);
    let some = |thousandths: usize, rng: &mut Rng| -> Vec<Id> {
        ids.iter().copied().filter(|_| rng.below(1000) < thousandths).collect()
    };
    let aabb = |world: &Checked<'_, I>, id: Id| world.model().aabb(id.slot()).expect("alive");
    match op {
        Op::Insert | Op::InsertMany(_) => {
            let count = if let Op::InsertMany(share) = op { case.share(*share) } else { 1 };
            let boxes: Vec<Aabb> = (0..count).map(|_| case.style.place(case.objects, rng)).collect();
            if ids.len() + count > case.objects {
                let error = world.refuse(|world| world.insert_many(Boxes::new(&boxes)).map(drop));
                let needed = (ids.len() + count) as u64;
                assert_eq!(error, Error::ObjectsFull { needed, room: case.objects as u32 });
            } else if let Op::Insert = op {
                world.insert(boxes[0]);
            } else {
                world.insert_many(&boxes);
            }
        }
        Op::Set(motion) => {
            if let Some(id) = any(rng) {
                let next = motion.apply(&aabb(world, id), case, world.model(), rng);
                world.set(id, next);
            }
        }
        Op::Update(thousandths, motion) => {
            let movers = some(*thousandths, rng);
            let next = |id: &Id| motion.apply(&aabb(world, *id), case, world.model(), rng);
            let boxes: Vec<Aabb> = movers.iter().map(next).collect();
            world.update_many(&movers, &boxes);
        }
        Op::Remove => {
            if let Some(id) = any(rng) {
                world.remove(id);
                gone.push(id);
            }
        }
        Op::RemoveMany(thousandths) => {
            let mut leaving = some(*thousandths, rng);
            let third = leaving.len() / 3;
            leaving.rotate_left(third);
            world.remove_many(&leaving);
            gone.extend(leaving);
        }
        Op::SetMargin(length) => {
            if let Some(id) = any(rng) {
                world.set_margin(id, *length);
            }
        }
        Op::SetFilter(_) | Op::SetClasses | Op::Refilter(_) if !case.filters => {
            let id = any(rng);
            let error = world.refuse(|world| match id {
                Some(id) => world.set_filter(id, Filter::ALL),
                None => world.set_classes(&[0; 32]),
            });
            assert_eq!(error, Error::NoFilters);
        }
        Op::SetFilter(thousandths) => {
            for id in some(*thousandths, rng).into_iter().chain(any(rng)).take(50) {
                let bits = |rng: &mut Rng| if rng.once_in(2) { u32::MAX } else { 1 << rng.below(3) };
                world
                    .set_filter(id, Filter { group: bits(rng), mask: bits(rng), class: rng.below(3) as u32 });
            }
        }
        Op::SetClasses => {
            let mut meets = [u32::MAX; 32];
            meets[rng.below(3)] &= rng.bits() as u32;
            world.set_classes(&meets);
        }
        Op::Refilter(thousandths) => {
            for id in some(*thousandths, rng).into_iter().chain(any(rng)).take(50) {
                world.refilter(id, rng.below(3) as u32);
            }
        }
        Op::Rest(thousandths) => world.set_resting(&some(*thousandths, rng)),
        Op::Wake(thousandths) => world.wake(&some(*thousandths, rng)),
        Op::Save => saves.push((world.save(), gone.clone())),
        Op::Load => {
            if !saves.is_empty() {
                let (save, gone_then) = &saves[rng.below(saves.len())];
                world.load(save);
                gone.clone_from(gone_then);
            }
        }
        Op::Ask(number) => {
            let questions = Questions::about(world.model(), 12, rng);
            let (world, model) = world.parts_mut();
            questions.ask(world, model, choose(*number));
            questions.ask_batches(world, choose(*number));
        }
        Op::Step(number) => said.push(world.try_step(choose(*number))),
        Op::StepOver(number, thousandths, motion, some_bad, length) => {
            let slots = world.model().boxes().len();
            let mut place = |slot: usize| {
                let Some(Some(aabb)) = world.model().boxes().get(slot) else {
                    // Nobody's box: anything may stand there.
                    return Aabb::new([f32::NAN; 3], [f32::NAN; 3]);
                };
                if *some_bad && rng.once_in(9) {
                    return Aabb::new([1.0; 3], [f32::NAN, 2.0, 0.0]);
                }
                if rng.below(1000) < *thousandths {
                    motion.apply(aabb, case, world.model(), rng)
                } else {
                    *aabb
                }
            };
            let bounds: Vec<Aabb> = (0..slots * length / 1000).map(&mut place).collect();
            said.push(world.try_step_over(&bounds, choose(*number)));
        }
        Op::Fail(fault) => fail(*fault, case, world, &ids, gone, rng),
        // It ends a life.
        Op::Reopen | Op::Migrate => {}
    }
}

fn fail<I: Index>(
    fault: Fault,
    case: &Case,
    world: &mut Checked<'_, I>,
    ids: &[Id],
    gone: &[Id],
    rng: &mut Rng,
) {
    let good = case.style.place(case.objects, rng);
    let mut bad = good;
    bad.max[rng.below(3)] = f32::NAN;
    let alive = (!ids.is_empty()).then(|| ids[rng.below(ids.len())]);
    let stale = (!gone.is_empty()).then(|| gone[rng.below(gone.len())]);
    match (fault, alive, stale) {
        (Fault::BadInsert, ..) if ids.len() < case.objects => {
            assert_eq!(world.refuse(|w| w.insert(bad)), Error::BadBox { index: 0 });
        }
        (Fault::BadSet, Some(id), _) => {
            assert_eq!(world.refuse(|w| w.set_aabb(id, bad)), Error::BadBox { index: 0 });
        }
        (Fault::BadBatch, Some(id), _) => {
            let error = world.refuse(|w| w.update_many(&[id, id], Boxes::new(&[good, bad])));
            assert_eq!(error, Error::BadBox { index: 1 });
        }
        (Fault::StaleSet, _, Some(id)) => {
            assert_eq!(world.refuse(|w| w.set_aabb(id, good)), Error::StaleId { id });
        }
        (Fault::StaleBatch, Some(alive), Some(id)) => {
            assert_eq!(world.refuse(|w| w.remove_many(&[alive, id])), Error::StaleId { id });
        }
        (Fault::TwiceInBatch, Some(id), _) => {
            assert_eq!(world.refuse(|w| w.remove_many(&[id, id])), Error::StaleId { id });
        }
        (Fault::BadMargin, Some(id), _) => {
            assert_eq!(world.refuse(|w| w.set_margin(id, -1.0)), Error::BadMargin);
        }
        // There is nobody whom it could be done to.
        _ => {}
    }
}

/// The numbers in the steps choose among all setups; two lives differ in nothing else.
fn two_lives<I: Index>(case: &Case) {
    let one = live::<I>(case, 1, |_| Setup::REFERENCE);
    let kernels: Vec<Kernels> = Kernels::all().collect();
    let choose = |number: usize| Setup {
        kernels: kernels[number % kernels.len()],
        jobs: Jobs::ALL[number / kernels.len() % Jobs::ALL.len()],
    };
    let other = live::<I>(case, 4, choose);
    assert_eq!(one.len(), other.len());
    for (step, (one, other)) in one.iter().zip(&other).enumerate() {
        let stats = |said: &Result<Outcome, Error>| {
            said.as_ref().map(|outcome| outcome.stats).map_err(|error| *error)
        };
        assert_eq!(stats(one), stats(other), "step {step} on other kernels and workers");
        assert!(one == other, "step {step}: another order on other kernels and workers");
    }
}

fn style() -> impl Strategy<Value = Style> {
    prop_oneof![
        Just(Style::Lattice),
        Just(Style::Uniform),
        Just(Style::Clustered),
        (0_usize..3).prop_map(Style::Flat),
        Just(Style::Sizes),
        Just(Style::Odd),
    ]
}

fn motion() -> impl Strategy<Value = Motion> {
    use Motion::*;
    prop_oneof![3 => Just(Creep), 3 => Just(Move), 2 => Just(Teleport), 1 => Just(Touch), 1 => Just(Grow), 1 => Just(Rest)]
}

/// Few movers are one path and many are another, so both must be common.
fn thousandths() -> impl Strategy<Value = usize> {
    prop_oneof![0_usize..30, 0_usize..=1000, Just(1000)]
}

fn fault() -> impl Strategy<Value = Fault> {
    use Fault::*;
    prop::sample::select(vec![BadInsert, BadSet, BadBatch, StaleSet, StaleBatch, TwiceInBatch, BadMargin])
}

fn op() -> impl Strategy<Value = Op> {
    let length = prop_oneof![3 => Just(1000_usize), 1 => 0_usize..1300];
    let over = (any::<u16>(), thousandths(), motion(), prop::bool::weighted(0.2), length);
    prop_oneof![
        2 => Just(Op::Insert),
        2 => (0_usize..500).prop_map(Op::InsertMany),
        2 => motion().prop_map(Op::Set),
        3 => (thousandths(), motion()).prop_map(|(share, motion)| Op::Update(share, motion)),
        2 => Just(Op::Remove),
        1 => thousandths().prop_map(Op::RemoveMany),
        1 => prop_oneof![Just(0.0_f32), 0.0_f32..2.0].prop_map(Op::SetMargin),
        6 => any::<u16>().prop_map(|number| Op::Step(number.into())),
        5 => over.prop_map(|(number, share, motion, bad, length)| {
            Op::StepOver(number.into(), share, motion, bad, length)
        }),
        1 => thousandths().prop_map(Op::SetFilter),
        1 => Just(Op::SetClasses),
        1 => thousandths().prop_map(Op::Refilter),
        2 => thousandths().prop_map(Op::Rest),
        1 => thousandths().prop_map(Op::Wake),
        1 => Just(Op::Save),
        1 => Just(Op::Load),
        1 => any::<u16>().prop_map(|number| Op::Ask(number.into())),
        1 => fault().prop_map(Op::Fail),
        1 => Just(Op::Reopen),
        1 => Just(Op::Migrate),
    ]
}

fn margin() -> impl Strategy<Value = Option<Margin>> {
    let margin = prop_oneof![
        Just(Margin::length(0.0)),
        (0.0_f32..0.5).prop_map(Margin::length),
        (0.0_f32..0.2).prop_map(|per_extent| Margin { per_extent, min: 0.001, max: 1.0 }),
    ];
    prop::option::of(margin)
}

fn case(objects: impl Strategy<Value = usize>, ops: usize) -> impl Strategy<Value = Case> {
    let modes =
        (margin(), prop_oneof![2 => Just(Mode::Exact), 1 => Just(Mode::Fat)], prop::bool::weighted(0.8));
    let filters = (any::<bool>(), any::<bool>());
    let choice =
        || prop_oneof![2 => Just(Choice::Automatic), 1 => Just(Choice::Never), 1 => Just(Choice::Always)];
    let choices = ([choice(), choice(), choice(), choice()], any::<bool>());
    // Capacities in per cent of the objects: mostly enough, now and then not.
    let room = (
        prop_oneof![Just(0_usize), 0_usize..100, Just(50), Just(800)],
        prop_oneof![1 => 0_usize..300, 5 => Just(4000_usize)],
    );
    let life = (0_usize..=1000, any::<u64>(), prop::collection::vec(op(), 1..ops));
    let parts = (style(), objects, modes, filters, choices, room, life);
    parts.prop_map(|(style, objects, modes, (filters, rule), (choices, fixed_margins), room, life)| {
        let ((margin, mode, events), (leaf_refs, pairs), (start, seed, ops)) = (modes, room, life);
        let (leaf_refs, pairs) = (objects * leaf_refs / 100, objects * pairs / 100);
        Case {
            style,
            objects,
            margin,
            mode,
            events,
            filters,
            rule,
            choices,
            fixed_margins,
            leaf_refs,
            pairs,
            start,
            seed,
            ops,
        }
    })
}

/// No files are written on failure: what is printed is the whole case.
fn cases(count: u32) -> ProptestConfig {
    ProptestConfig { cases: count * effort(), failure_persistence: None, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(cases(60))]

    #[test]
    fn worlds_of_any_size_live_like_the_model(case in case(1_usize..=3000, 16)) {
        two_lives::<u32>(&case);
    }

    #[test]
    fn worlds_around_one_leaf_live_like_the_model(case in case(480_usize..700, 24)) {
        two_lives::<u16>(&case);
    }

    #[test]
    fn worlds_with_a_tree_live_like_the_model(case in case(1500_usize..=3000, 20)) {
        two_lives::<u16>(&case);
    }
}
