// What trisap.hpp promises: types, moves, views, refusals.

#include "check.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <trisap.hpp>

#if __cplusplus >= 202002L
#include <algorithm>
#include <ranges>
#include <span>
static_assert(std::ranges::contiguous_range<trisap::View<const trisap::Pair>>);
static_assert(std::ranges::view<trisap::View<const trisap::Pair>>);
#endif

static_assert(!std::is_copy_constructible_v<trisap::World> && !std::is_copy_assignable_v<trisap::World>);
static_assert(std::is_nothrow_move_constructible_v<trisap::World>);
static_assert(std::is_nothrow_move_assignable_v<trisap::World>);
static_assert(std::is_nothrow_default_constructible_v<trisap::World>);
static_assert(noexcept(std::declval<trisap::World &>().step()));
static_assert(noexcept(trisap_world_len(nullptr)));
static_assert(noexcept(std::declval<trisap::World &>().step_with_rule(std::declval<bool (&)(unsigned, unsigned)>())));
static_assert(noexcept(std::declval<const trisap::World &>().overlaps({}, {})));

// The allocation that the wrapper makes, so that it can fail.
static int allocations_left = 1000;

void *operator new(std::size_t bytes, std::align_val_t align, const std::nothrow_t &) noexcept {
    return allocations_left-- > 0 ? std::aligned_alloc(static_cast<std::size_t>(align), bytes) : nullptr;
}

void operator delete(void *memory, std::align_val_t) noexcept { std::free(memory); }

static trisap::Aabb cube(float x) { return {{x, 0.0f, 0.0f}, {x + 1.0f, 1.0f, 1.0f}}; }

static void moves() {
    trisap::World first;
    CHECK_OK(first.init(trisap::config(4)));
    const trisap::Id id = first.insert(cube(0.0f));
    CHECK(id != trisap::null_id && trisap::slot(id) == 0);
    trisap::World second(std::move(first));
    CHECK(second.contains(id) && second.size() == 1);
    CHECK(first.c() == nullptr && first.size() == 0); // NOLINT: what is left is empty
    CHECK_STATUS(first.update(id, cube(1.0f)), TRISAP_STATUS_NULL_POINTER);
    first = std::move(second);
    CHECK(first.contains(id) && !second.contains(id)); // NOLINT
    // A new beginning.
    CHECK_OK(first.init(trisap::config(8)));
    CHECK(!first.contains(id) && first.size() == 0);
    std::vector<trisap::World> worlds;
    worlds.push_back(std::move(first));
    worlds.emplace_back();
    CHECK(worlds[0].insert(cube(2.0f)) != trisap::null_id);
}

static void refusals() {
    trisap::World none;
    CHECK_STATUS(none.step().status, TRISAP_STATUS_NULL_POINTER);
    CHECK(!none.step() && none.step().pairs.empty());
    CHECK(none.stats().objects == 0 && none.error_detail() == 0);
    trisap::Config config = trisap::config(2);
    config.workers = 0;
    CHECK_STATUS(none.init(config), TRISAP_STATUS_CAPACITY_TOO_LARGE);
    config = trisap::config(2);
    config.mode = 7;
    CHECK_STATUS(none.init(config), TRISAP_STATUS_INVALID_ARGUMENT);
    CHECK(none.c() == nullptr);
    // No memory to be had.
    allocations_left = 0;
    CHECK_STATUS(none.init(trisap::config(2)), TRISAP_STATUS_MEMORY_TOO_SMALL);
    CHECK(none.c() == nullptr);
    // One piece is enough for ever.
    allocations_left = 1;
    CHECK_OK(none.init(trisap::config(2)));
    CHECK(none.insert(cube(0.0f)) != trisap::null_id && none.step());
    allocations_left = 1000;

    trisap::World world;
    CHECK_OK(world.init(trisap::config(2)));
    trisap::Status why = TRISAP_STATUS_OK;
    CHECK(world.insert(cube(std::nanf("")), &why) == trisap::null_id && why == TRISAP_STATUS_BAD_BOX);
    trisap::Status full = TRISAP_STATUS_OK;
    CHECK(world.insert_at(2, cube(0.0f), &full) == trisap::null_id && full == TRISAP_STATUS_OBJECTS_FULL);
    const std::array<trisap::Aabb, 2> two = {cube(0.0f), cube(1.0f)};
    std::array<trisap::Id, 1> one = {};
    CHECK_STATUS(world.insert(trisap::boxes(two), one), TRISAP_STATUS_INVALID_ARGUMENT);
    CHECK_STATUS(world.update(trisap::View<const trisap::Id>(one), trisap::boxes(two)), TRISAP_STATUS_INVALID_ARGUMENT);
    CHECK(std::string(trisap::text(why)).find("NaN") != std::string::npos);
}

struct Body {
    char name = 'b';
    double mass = 1.0;
    struct {
        float low[3], padding, high[3];
    } bounds = {};
};

static void views() {
    std::vector<Body> bodies(3);
    for (std::size_t i = 0; i < 3; i++) {
        const trisap::Aabb aabb = cube(0.5f * static_cast<float>(i));
        std::memcpy(bodies[i].bounds.low, aabb.min, sizeof aabb.min);
        std::memcpy(bodies[i].bounds.high, aabb.max, sizeof aabb.max);
    }
    const trisap::Boxes boxes =
        trisap::boxes_in(bodies.data(), bodies.size(), bodies[0].bounds.low, bodies[0].bounds.high);
    CHECK(boxes.stride == sizeof(Body) && boxes.max_offset == 16);
    trisap::World world;
    trisap::Config config = trisap::config(3);
    config.events = 1;
    CHECK_OK(world.init(config));
    trisap::Id ids[3] = {};
    CHECK_OK(world.insert(boxes, ids));
    // The corners the wrong way round.
    const trisap::Boxes wrong =
        trisap::boxes_in(bodies.data(), bodies.size(), bodies[0].bounds.high, bodies[0].bounds.low);
    CHECK_STATUS(world.step_over(wrong).status, TRISAP_STATUS_INVALID_ARGUMENT);

    const trisap::Step step = world.step_over(boxes);
    CHECK(step && step.pairs.size() == 3 && step.found.size() == 3 && step.lost.empty());
    std::uint32_t sum = 0;
    for (const auto &[a, b] : step.pairs) {
        CHECK(a < b);
        sum += a + b;
    }
    CHECK(sum == 6);
#if __cplusplus >= 202002L
    const std::span<const trisap::Pair> span = step.pairs;
    CHECK(span.size() == 3 && span.data() == step.pairs.data());
    CHECK(std::ranges::count_if(step.pairs, [](const trisap::Pair &pair) { return pair.b == 2; }) == 2);
    const std::span<const trisap::Id> id_span = ids;
    CHECK_OK(world.update(id_span, boxes));
#endif
    bodies[2].bounds.low[0] = 50.0f; // above its maximum
    const trisap::Step partly = world.step_over(boxes);
    CHECK(partly && partly.rejected == 1 && partly.first_rejected == ids[2] && partly.pairs.size() == 3);
    trisap::Aabb aabb = {};
    CHECK_OK(world.aabb(ids[1], aabb));
    CHECK(aabb.min[0] == 0.5f && world.id_at(1) == ids[1]);
    CHECK_STATUS(world.set_margin(ids[1], 0.5f), TRISAP_STATUS_NO_MARGINS);
    CHECK(world.stats().pairs == 3 && !world.is_coarse());
    CHECK_OK(world.remove(ids[0]));
    CHECK_OK(world.remove({ids + 1, 2}));
    CHECK(world.size() == 0 && world.step().lost.size() == 3);
    CHECK_OK(world.validate());
}

static bool odd_sum(std::uint32_t a, std::uint32_t b) { return (a + b) % 2 == 1; }

static bool has_even_slot(trisap::Id id) { return trisap::slot(id) % 2 == 0; }

/// Callables of every kind, and nothing of theirs is allocated.
/// Memory from the caller, who sees what is taken and given back, and may refuse.
struct Arena {
    std::size_t taken = 0, held = 0;
    int left = 1000;
};

static trisap::Allocator allocator_of(Arena &arena) {
    trisap::Allocator allocator;
    allocator.allocate = [](void *user, std::size_t bytes, std::size_t align) noexcept -> void * {
        Arena &its = *static_cast<Arena *>(user);
        its.taken += its.left > 0 ? bytes : 0;
        its.held += its.left > 0 ? bytes : 0;
        return its.left-- > 0 ? std::aligned_alloc(align, (bytes + align - 1) / align * align) : nullptr;
    };
    allocator.free = [](void *user, void *memory, std::size_t bytes, std::size_t) noexcept {
        static_cast<Arena *>(user)->held -= bytes;
        std::free(memory);
    };
    allocator.user = &arena;
    return allocator;
}

/// A world that begins with room for two objects, and is given forty, all in one place.
static void growing() {
    Arena arena;
    const int before = allocations_left;
    {
        trisap::World world(allocator_of(arena));
        trisap::Config config = trisap::config(2);
        config.events = 1;
        CHECK_OK(world.init(config));
        CHECK(world.config().objects == 2 && trisap::World().config().objects == 0);
        trisap::Status status = TRISAP_STATUS_OK;
        const trisap::Id first = world.insert(cube(0.0f)), second = world.insert(cube(0.5f));
        CHECK(world.insert(cube(0.0f), &status) == trisap::null_id && status == TRISAP_STATUS_OBJECTS_FULL);
        CHECK(world.step().found.size() == 1);
        world.set_growing(true);
        std::vector<trisap::Id> ids(38);
        const std::vector<trisap::Aabb> boxes(38, cube(0.25f));
        CHECK_OK(world.insert(trisap::boxes(boxes), ids));
        CHECK(world.size() == 40 && world.contains(first) && world.contains(second));
        const trisap::Step step = world.step();
        CHECK(step && step.pairs.size() == 40 * 39 / 2 && step.found.size() == 40 * 39 / 2 - 1 && step.lost.empty());
        CHECK(world.config().pairs >= 40 * 39 / 2 && world.config().events == 1);
        CHECK_OK(world.validate());

        // A copy of its bytes goes on in a world of its own.
        std::vector<std::byte> copy(trisap_world_bytes(world.c()));
        std::memcpy(copy.data(), world.c(), copy.size());
        trisap::World opened;
        CHECK_OK(opened.open(copy));
        CHECK(opened.size() == 40 && opened.result().pairs.size() == 40 * 39 / 2);
        CHECK_STATUS(opened.open(trisap::View<const std::byte>(copy.data(), 64)), TRISAP_STATUS_MEMORY_TOO_SMALL);
        CHECK(opened.size() == 40);

        // Where there is no memory, all stays as it was.
        arena.left = 0;
        while (world.size() < world.config().objects) {
            CHECK(world.insert(cube(90.0f)) != trisap::null_id);
        }
        const std::uint32_t size = world.size();
        CHECK(world.insert(cube(0.0f), &status) == trisap::null_id && status == TRISAP_STATUS_MEMORY_TOO_SMALL);
        CHECK(world.size() == size && world.contains(first));
        trisap::World moved(std::move(world));
        CHECK(moved.contains(first));
    }
    CHECK(arena.taken > 0 && arena.held == 0);
    // Only what was opened came from elsewhere.
    CHECK(before - allocations_left == 2);
}

/// Views of one step after growth and growth, without a step in between.
static void views_outlive_growth() {
    for (const bool moved_before : {false, true}) {
        trisap::World world;
        trisap::Config config = trisap::config(4);
        config.events = 1;
        CHECK_OK(world.init(config));
        world.set_growing(true);
        const auto grow = [&] {
            for (const std::uint32_t had = world.config().objects; world.config().objects == had;) {
                CHECK(world.insert(cube(0.0f)) != trisap::null_id);
            }
        };
        const trisap::Id later = world.insert(cube(50.0f));
        for (const float x : {0.0f, 1.0f, 0.5f}) {
            CHECK(world.insert(cube(x)) != trisap::null_id);
        }
        CHECK(world.step().pairs.size() == 3);
        CHECK_OK(world.update(later, cube(0.25f)));
        const trisap::Step step = world.step();
        if (moved_before) {
            grow();
        }
        const trisap::Step again = world.result();
        grow();
        const trisap::Step third = world.result();
        CHECK_OK(world.sort_results());
        const trisap::Step sorted = world.result();
        grow();
        const trisap::Step last = world.result();
        for (const trisap::Step &told : {step, again, third, sorted, last}) {
            const trisap::Pair expected[] = {{1, 2}, {1, 3}, {2, 3}, {0, 1}, {0, 2}, {0, 3}};
            CHECK_OK(told.status);
            CHECK(told.pairs.size() == 6 && told.found.size() == 3 && told.lost.empty());
            for (std::size_t i = 0; i < 6; i++) {
                const trisap::Pair &pair = i < 3 ? told.pairs[i] : told.found[i - 3];
                CHECK(pair.a == expected[i].a && pair.b == expected[i].b);
            }
        }
        // A load that is refused changes nothing, and the next step has no other memory.
        const std::byte none[64] = {};
        CHECK_STATUS(world.load(none), TRISAP_STATUS_BAD_SNAPSHOT);
        CHECK(step.pairs[0].a == 1);
        CHECK(world.step().pairs.size() == world.result().pairs.size() && world.result().pairs.size() > 6);
        CHECK_OK(world.validate());
    }
    // A snapshot with too many pairs, and a step with too many and no memory for them.
    Arena arena;
    trisap::World many, few(allocator_of(arena));
    trisap::Config config = trisap::config(8);
    CHECK_OK(many.init(config));
    for (int i = 0; i < 8; i++) {
        CHECK(many.insert(cube(0.0f)) != trisap::null_id);
    }
    CHECK(many.step().pairs.size() == 28);
    std::vector<std::byte> room(many.snapshot_size());
    CHECK(many.save(room));
    config.pairs = 2;
    CHECK_OK(few.init(config));
    CHECK(few.insert(cube(0.0f)) != trisap::null_id && few.insert(cube(0.0f)) != trisap::null_id);
    const trisap::Step one = few.step();
    CHECK_OK(few.move_to(config));
    CHECK_STATUS(few.load(room), TRISAP_STATUS_PAIRS_FULL);
    CHECK(one.pairs.size() == 1 && one.pairs[0].b == 1);
    CHECK(few.insert(cube(0.0f)) != trisap::null_id && few.insert(cube(0.0f)) != trisap::null_id);
    few.set_growing(true);
    arena.left = 0;
    CHECK_STATUS(few.step().status, TRISAP_STATUS_MEMORY_TOO_SMALL);
    CHECK(few.result().pairs.size() == 2);
}

/// A lean world that grows is lean as long as it can be.
static void lean_growth() {
    trisap::World world;
    trisap::Config config = trisap::config(100);
    config.lean = 1;
    CHECK_OK(world.init(config));
    world.set_growing(true);
    for (std::uint32_t i = 0; i < 300; i++) {
        CHECK(world.insert(cube(2.0f * static_cast<float>(i))) != trisap::null_id);
        CHECK(world.config().lean == (i < 200 ? 1 : 0));
    }
    CHECK(world.step() && world.size() == 300);
    CHECK_OK(world.validate());
}

static void callables() {
    trisap::World world;
    trisap::Config config = trisap::config(8);
    config.filters = 1;
    allocations_left = 1;
    CHECK_OK(world.init(config));
    trisap::Id ids[8] = {};
    const std::array<trisap::Aabb, 8> boxes = {cube(0), cube(0), cube(0), cube(0), cube(9), cube(9), cube(9), cube(9)};
    CHECK_OK(world.insert(trisap::boxes(boxes), ids));
    CHECK(world.step_with_rule(odd_sum).pairs.size() == 8);
    struct Counting {
        int asked = 0;
        bool operator()(std::uint32_t, std::uint32_t) { return ++asked > 0; }
    } counting;
    CHECK_OK(world.set_filter(ids, trisap::filter()));
    for (const trisap::Id id : ids) {
        CHECK_OK(world.refilter(id));
    }
    CHECK(world.step_over_with_rule(trisap::boxes(boxes), counting).pairs.size() == 12 && counting.asked == 12);
    auto jobs = trisap::jobs(2, [](std::uint32_t, trisap::Task) {});
    CHECK(world.step_over_with_rule(trisap::boxes(boxes), counting, jobs).pairs.size() == 12);
    CHECK(world.step_with_rule(counting, jobs).pairs.size() == 12);

    const auto ignore = [](trisap::Id) {};
    CHECK_OK(world.visit_overlaps(trisap::region(cube(0)), ignore));
    int visits = 0;
    CHECK_OK(world.visit_overlaps(trisap::region(cube(0)), [&](trisap::Id) { return ++visits < 2; }));
    CHECK(visits == 2);
    const float left[3] = {-1.0f, 0.5f, 0.5f}, right[3] = {1.0f, 0.0f, 0.0f};
    const trisap::Cast ray = trisap::ray(left, right);
    visits = 0;
    CHECK_OK(world.visit_hits(ray, [&](const trisap::Hit &) { visits++; }));
    CHECK(visits == 8);
    CHECK(world.first_hit(trisap::ray(left, right, 0.5f)).id == trisap::null_id);
    CHECK(world.first_hit(ray).id == ids[0] && world.first_hit(trisap::swept(cube(-3), right)).id == trisap::null_id);

    const trisap::FirstHit refused = world.first_hit(trisap::ray(nullptr, right));
    CHECK(refused.id == trisap::null_id && refused.status == TRISAP_STATUS_BAD_QUERY);
    std::array<trisap::Hit, 1> one = {};
    const std::array<trisap::Cast, 2> two = {ray, ray};
    CHECK_STATUS(world.first_hits(two, one), TRISAP_STATUS_INVALID_ARGUMENT);
    const std::array<trisap::Region, 1> regions = {trisap::point(left)};
    CHECK_STATUS(world.overlaps_many(regions, {}, {}), TRISAP_STATUS_INVALID_ARGUMENT);
    CHECK(world.hits(ray, one).status == TRISAP_STATUS_OUTPUT_FULL && world.hits(ray, one).needed == 8);
    CHECK(world.nearest(left, one).size() == 1);
    CHECK_OK(world.nearest_many(trisap::View<const float>(left, 3), one));
    CHECK(one[0].id == world.nearest(left, one)[0].id);
    const std::array<trisap::HalfSpace, 1> half = {{{{1.0, 0.0, 0.0, 1.0}}}};
    std::array<trisap::Id, 8> inside = {};
    CHECK(world.within(half, inside).size() == 4);
    visits = 0;
    const auto beyond = [](const trisap::Aabb &aabb) { return aabb.min[0] > 1.0F ? -1 : 0; };
    CHECK_OK(world.visit_within(beyond, [&](trisap::Id id) { visits += inside[trisap::slot(id)] == id ? 1 : 100; }));
    CHECK(visits == 4);
    visits = 0;
    CHECK_OK(world.visit_nearest(left, 1e9, [&](const trisap::Hit &) { visits++; }));
    CHECK(visits == 8);
    CHECK_OK(world.visit_nearest(left, 1e9, [&](const trisap::Hit &) { return visits--, -1.0; }));
    CHECK(visits == 7);
    CHECK_STATUS(world.set_filter(ids, trisap::View<const trisap::Filter>()), TRISAP_STATUS_INVALID_ARGUMENT);

    // Groups and classes.
    CHECK_OK(world.set_filter(ids[0], trisap::groups(1, 2)));
    CHECK_OK(world.set_filter(ids[1], trisap::object_class(3)));
    trisap::Filter filter = {};
    CHECK_OK(world.filter(ids[1], filter));
    CHECK(filter.object_class == 3 && filter.mask == 0xffffffff);
    std::uint32_t meets[TRISAP_CLASSES] = {1};
    CHECK_OK(world.set_classes(meets));
    CHECK(world.step_with_rule(counting).pairs.size() == 9);
    CHECK_OK(world.set_filter(ids[2], trisap::groups(4, 1)));
    CHECK(world.step_with_rule(counting).pairs.size() == 8);

    // Resting, snapshots.
    CHECK_OK(world.set_resting(ids));
    CHECK(world.is_resting(ids[7]));
    CHECK_OK(world.wake({ids + 7, 1}));
    CHECK(!world.is_resting(ids[7]));
    std::vector<std::byte> room(world.snapshot_size() + 10);
    const trisap::Answers<std::byte> saved = world.save(room);
    CHECK(saved && saved.size() + 10 == room.size() && saved.needed == saved.size());
    CHECK_OK(world.remove(ids));
    CHECK_STATUS(world.load(room), TRISAP_STATUS_OK);
    CHECK(world.size() == 8 && world.result().pairs.size() == 8);
    room[30] ^= std::byte(1);
    CHECK_STATUS(world.load(saved.items), TRISAP_STATUS_BAD_SNAPSHOT);
    CHECK(world.leaves({}) && world.planes({}) && world.large({}));
    const double low[3] = {0.1, 0.1, 0.1}, high[3] = {0.2, 0.2, 0.2}, origin[3] = {};
    CHECK(trisap::aabb_from_f64(low, high, origin).min[0] <= 0.1);

    trisap::World none;
    CHECK_STATUS(none.step_with_rule(odd_sum).status, TRISAP_STATUS_NULL_POINTER);
    CHECK(none.overlaps(regions[0], ids).status == TRISAP_STATUS_NULL_POINTER && none.snapshot_size() == 0);
    allocations_left = 1000;

    // Copies, in new memory and in memory that is there.
    trisap::World kept;
    for (int round = 0; round < 2; round++) {
        CHECK_OK(kept.copy_from(world));
        CHECK_OK(world.remove(ids));
        CHECK(world.size() == 0 && kept.size() == 8);
        CHECK_OK(world.copy_from(kept));
        CHECK(world.size() == 8 && world.result().pairs.size() == 8);
    }
    CHECK_OK(world.sort_results());
    CHECK(world.result().pairs[0].a == 0 && world.result().pairs.size() == 8);
    CHECK_STATUS(kept.copy_from(trisap::World()), TRISAP_STATUS_NULL_POINTER);
}

/// Values, and queries that leave objects out.
static void values() {
    trisap::World world;
    trisap::Config config = trisap::config(8);
    config.filters = config.events = config.values = 1;
    CHECK_OK(world.init(config));
    trisap::Id ids[4] = {};
    const std::array<trisap::Aabb, 4> boxes = {cube(0), cube(0.5f), cube(1.25f), cube(9)};
    CHECK_OK(world.insert(trisap::boxes(boxes), ids));
    CHECK_OK(world.set_value(ids[0], 70));
    const std::array<std::uint64_t, 3> more = {71, 72, 73};
    CHECK_OK(world.set_value({ids + 1, 3}, more));
    CHECK_STATUS(world.set_value(ids, more), TRISAP_STATUS_INVALID_ARGUMENT);
    std::uint64_t value = 0;
    CHECK_OK(world.value(ids[3], value));
    CHECK(value == 73 && world.config().values == 1);
    CHECK(world.step());
    std::array<trisap::ValuePair, 4> pairs = {};
    CHECK(world.pair_values(TRISAP_PAIRS_FOUND, pairs).size() == 2);
    CHECK_OK(world.remove(ids[0]));
    CHECK(world.insert(cube(20)) != trisap::null_id && world.step());
    const trisap::Answers<trisap::ValuePair> lost = world.pair_values(TRISAP_PAIRS_LOST, pairs);
    CHECK(lost && lost.size() == 1 && lost[0].a == 70 && lost[0].b == 71);

    // Of what queries have found.
    std::array<trisap::Hit, 8> hits = {};
    std::array<trisap::Id, 8> found = {};
    std::array<std::uint64_t, 8> told = {};
    const float left[3] = {-1.0f, 0.5f, 0.5f}, right[3] = {1.0f, 0.0f, 0.0f};
    const trisap::Cast ray = trisap::ray(left, right);
    CHECK_OK(world.values(world.hits(ray, hits).items, told));
    CHECK(told[0] == 71 && told[1] == 72 && told[2] == 73 && told[3] == 0);
    CHECK_OK(world.values(world.overlaps(trisap::region(cube(1)), found).items, told));
    CHECK(told[0] == 71 && told[1] == 72);
    CHECK_STATUS(world.values(trisap::View<const trisap::Id>(ids), {}), TRISAP_STATUS_INVALID_ARGUMENT);
    CHECK_STATUS(world.values(trisap::View<const trisap::Id>(ids), told), TRISAP_STATUS_STALE_ID);
    CHECK(world.error_detail() == ids[0]);

    // Without one's own, and by filters.
    CHECK_OK(world.set_filter(ids[2], trisap::groups(4, 0xffffffff)));
    const auto others = [&](trisap::Id id) { return id != ids[1]; };
    CHECK(world.first_hit(ray).id == ids[1] && world.among(others).first_hit(ray).id == ids[2]);
    CHECK(world.among(others).nearest(left, hits).size() == 3 && hits[0].id == ids[2]);
    CHECK(world.among(others).hits(ray, hits).size() == 3 && hits[0].id == ids[2]);
    const trisap::Filter all_but_four = trisap::groups(0xffffffff, ~4u);
    CHECK(world.meets(ids[1], all_but_four) && !world.meets(ids[2], all_but_four));
    const auto meets = [&](trisap::Id id) { return world.meets(id, all_but_four); };
    const auto seen = world.among(meets).overlaps(trisap::region(cube(1)), found);
    CHECK(seen && seen.size() == 1 && seen[0] == ids[1]);
    const trisap::Cast rays[] = {ray, ray};
    CHECK_OK(world.among(others).first_hits(rays, hits));
    CHECK(hits[0].id == ids[2] && hits[1].id == ids[2]);
    auto jobs = trisap::jobs(2, [](std::uint32_t, trisap::Task task) { task(); });
    const trisap::Region regions[] = {trisap::region(cube(1)), trisap::region(cube(1.5f))};
    std::size_t ends[2] = {};
    CHECK_OK(world.among(meets).overlaps_many(regions, found, ends, jobs));
    CHECK(ends[0] == 1 && ends[1] == 2 && found[0] == ids[1] && found[1] == ids[1]);
    CHECK_OK(world.among(has_even_slot).first_hits(rays, hits, jobs));
    CHECK(hits[0].id == ids[2]);
    CHECK_STATUS(world.among(others).first_hit(trisap::ray(nullptr, right)).status, TRISAP_STATUS_BAD_QUERY);

    // Pairs with one that is awake.
    std::array<trisap::Pair, 4> room = {};
    CHECK(world.awake_pairs(room).size() == 1);
    CHECK_OK(world.set_resting({ids + 1, 2}));
    CHECK(world.awake_pairs(room).size() == 0 && world.step().pairs.size() == 1);
    CHECK_OK(world.wake({ids + 1, 1}));
    CHECK(world.awake_pairs(room).size() == 1 && room[0].a == 1 && room[0].b == 2);
}

/// Each pair has a number from found to lost, also after going back, and in worlds that grow.
static void contacts() {
    Arena arena;
    {
        trisap::World world, kept;
        trisap::Config config = trisap::config(4);
        config.events = 1;
        CHECK_OK(world.init(config));
        world.set_growing(true);
        trisap::Contacts contacts(allocator_of(arena)), before(allocator_of(arena));
        std::vector<std::pair<trisap::Pair, int>> live; // by contact; how many steps it has lasted, -1 for none
        CHECK(contacts.size() == 0 && contacts.get(0, 1) == trisap::Contacts::none && contacts.c() == nullptr);
        const auto follow = [&] {
            const trisap::Step step = world.step();
            CHECK_OK(step.status);
            const auto ended = [&](trisap::Pair pair, std::uint32_t contact) {
                CHECK(live[contact].second > 0 && live[contact].first.a == pair.a && live[contact].first.b == pair.b);
                live[contact].second = -1;
            };
            const auto began = [&](trisap::Pair pair, std::uint32_t contact) {
                live.resize(contact < live.size() ? live.size() : contact + 1, {{}, -1});
                CHECK(live[contact].second == -1);
                live[contact] = {pair, 0};
            };
            CHECK_OK(contacts.update(step, ended, began));
            CHECK(contacts.size() == step.pairs.size());
            for (const trisap::Pair &pair : step.pairs) {
                const std::uint32_t contact = contacts.get(pair.b, pair.a);
                CHECK(contact < live.size() && live[contact].first.a == pair.a && live[contact].first.b == pair.b);
                live[contact].second += 1;
            }
        };
        std::vector<trisap::Id> ids;
        for (int frame = 0; frame < 60; ++frame) {
            ids.push_back(world.insert(cube(0.4f * static_cast<float>(frame % 23))));
            if (frame % 3 == 2) {
                const std::size_t at = static_cast<std::size_t>(frame * 7) % ids.size();
                CHECK_OK(world.remove(ids[at])); // its slot goes to the next one
                ids.erase(ids.begin() + static_cast<std::ptrdiff_t>(at));
            }
            follow();
            if (frame == 30) {
                CHECK_OK(kept.copy_from(world));
                CHECK_OK(before.copy_from(contacts));
            }
        }
        // What cannot have a number is found before anything is told.
        const std::size_t numbered = contacts.size();
        const auto never = [](trisap::Pair, std::uint32_t) { CHECK(false); };
        const trisap::Pair one_slot[] = {{900, 901}, {2, 2}}, no_slot[] = {{0xffffffff, 0}}, turned[] = {{5000, 0}};
        CHECK_STATUS(contacts.update(world.result().pairs, one_slot, never, never), TRISAP_STATUS_INVALID_ARGUMENT);
        CHECK_STATUS(contacts.update(world.result().pairs, no_slot, never, never), TRISAP_STATUS_INVALID_ARGUMENT);
        CHECK(contacts.size() == numbered);
        CHECK_OK(contacts.update({}, turned, never, [](trisap::Pair, std::uint32_t) {}));
        CHECK_OK(contacts.update(turned, {}, [](trisap::Pair, std::uint32_t) {}, never));
        std::vector<trisap::Contact> room(200);
        const std::uint32_t slot = trisap::slot(ids[5]);
        const auto of = contacts.of(slot, room);
        CHECK(of.status == TRISAP_STATUS_OK && of.items.size() > 0);
        for (const trisap::Contact &contact : of.items) {
            CHECK(contacts.get(slot, contact.partner) == contact.contact);
        }
        CHECK(contacts.of(slot, {}).status == TRISAP_STATUS_OUTPUT_FULL);
        const std::size_t all = contacts.size(), some = of.items.size();
        contacts.remove_all(slot);
        CHECK(contacts.size() == all - some && contacts.of(slot, room).items.size() == 0);
        // Back, with the numbers of then.
        CHECK_OK(world.copy_from(kept));
        CHECK_OK(contacts.copy_from(before));
        CHECK(contacts.size() == world.result().pairs.size());
        // The words themselves, opened again, and spoilt.
        std::vector<std::uint32_t> words(trisap_contacts_size(4, 6) / 4);
        trisap_contacts *made = nullptr;
        CHECK_OK(trisap_contacts_init(words.data(), 4 * words.size(), 4, 6, &made));
        const trisap::Pair found[] = {{0, 1}, {1, 3}}, outside[] = {{2, 4}}, same[] = {{2, 2}};
        std::uint32_t numbers[2] = {}, ended[1] = {};
        std::uint64_t detail = 0;
        CHECK_OK(trisap_contacts_update(made, outside, 1, ended, found, 2, numbers, nullptr));
        CHECK(numbers[0] == 0 && numbers[1] == 1 && ended[0] == TRISAP_NO_CONTACT);
        CHECK_STATUS(trisap_contacts_update(made, found, 1, nullptr, outside, 1, nullptr, &detail), TRISAP_STATUS_OBJECTS_FULL);
        CHECK(detail == 5 && trisap_contacts_count(made) == 2);
        CHECK_STATUS(trisap_contacts_update(made, nullptr, 0, nullptr, same, 1, nullptr, nullptr),
                     TRISAP_STATUS_INVALID_ARGUMENT);
        std::vector<std::uint32_t> copy = words;
        CHECK_OK(trisap_contacts_open(copy.data(), 4 * copy.size(), &made));
        CHECK(trisap_contacts_get(made, 3, 1) == 1);
        copy[0] += 1;
        CHECK_STATUS(trisap_contacts_open(copy.data(), 4 * copy.size(), &made), TRISAP_STATUS_BAD_SNAPSHOT);
        CHECK_STATUS(trisap_contacts_open(nullptr, 4, &made), TRISAP_STATUS_NULL_POINTER);
        CHECK_STATUS(trisap_contacts_init(words.data(), 8, 4, 6, &made), TRISAP_STATUS_MEMORY_TOO_SMALL);
        CHECK(trisap_contacts_get(nullptr, 0, 1) == TRISAP_NO_CONTACT && trisap_contacts_count(nullptr) == 0);
        // Lost ones by their place, also between pairs that had no number, or come twice.
        CHECK_OK(trisap_contacts_open(words.data(), 4 * words.size(), &made));
        const trisap::Pair lost[] = {{0, 2}, {1, 3}, {1, 3}, {2, 3}, {0, 1}};
        std::uint32_t told[5] = {};
        CHECK_OK(trisap_contacts_update(made, lost, 5, told, nullptr, 0, nullptr, nullptr));
        CHECK(told[0] == TRISAP_NO_CONTACT && told[1] == 1 && told[2] == TRISAP_NO_CONTACT && told[3] == TRISAP_NO_CONTACT);
        CHECK(told[4] == 0 && trisap_contacts_count(made) == 0);
    }
    CHECK(arena.taken > 0 && arena.held == 0);
}

// Boxes that are there once, and owners.
static void once_and_owners() {
    std::vector<trisap::Aabb> near = {cube(0), cube(0), cube(5)};
    std::vector<trisap::Pair> once;
    CHECK_OK(trisap::pairs(trisap::boxes(near), once));
    CHECK(once.size() == 1 && once[0].a == 0 && once[0].b == 1);
    const trisap::Boxes others = trisap::boxes(near);
    CHECK_OK(trisap::pairs(trisap::boxes(near), once, &others));
    CHECK(once.size() == 5);
    near[1].min[0] = 9.0F;
    CHECK_STATUS(trisap::pairs(trisap::boxes(near), once), TRISAP_STATUS_BAD_BOX);
    CHECK(once.empty());
    const trisap::Owned body = {{7}}, part = {{8, 7}}, stranger;
    CHECK(!are_apart(body, part) && are_apart(body, stranger) && are_apart(stranger, stranger));
}

int main() {
    CHECK(trisap::abi_matches());
    moves();
    refusals();
    once_and_owners();
    views();
    growing();
    views_outlive_growth();
    lean_growth();
    callables();
    values();
    contacts();
    std::puts("wrapper: all checks passed");
    return 0;
}
