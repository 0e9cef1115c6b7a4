// trisap for C++17 and later: a thin cover over trisap.h that owns memory and gives views of results. Nothing throws.
//
//     trisap::World world;
//     if (world.init(trisap::config(8'000)) != TRISAP_STATUS_OK) { ... }
//     auto jobs = trisap::jobs(pool.size(), [&](std::uint32_t count, trisap::Task task) { pool.run(count, task); });
//     for (auto [a, b] : world.step_over(trisap::boxes(bounds), jobs).pairs) { ... }

#ifndef TRISAP_HPP
#define TRISAP_HPP

#include "trisap.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

#if __cplusplus >= 202002L
#include <ranges>
#endif

namespace trisap {

using Aabb = trisap_aabb;
using Boxes = trisap_boxes;
using Cast = trisap_cast;
using Config = trisap_config;
using Contact = trisap_contact;
using Filter = trisap_filter;
using Hit = trisap_hit;
using Id = trisap_id;
using Leaf = trisap_leaf;
using Pair = trisap_pair;
using Plane = trisap_plane;
using Region = trisap_region;
using Stats = trisap_stats;
using Status = trisap_status;
using IdPair = trisap_id_pair;
using ValuePair = trisap_value_pair;

/// The id of no object.
inline constexpr Id null_id = TRISAP_NULL_ID;

/// The index under which an object stands in pairs and in the boxes of `World::step_over`.
[[nodiscard]] inline std::uint32_t slot(Id id) noexcept { return trisap_id_slot(id); }

/// The text of a status.
[[nodiscard]] inline const char *text(Status status) noexcept { return trisap_status_text(status); }

/// Whether the linked library speaks the ABI of this header.
[[nodiscard]] inline bool abi_matches() noexcept { return trisap_abi_version() == TRISAP_ABI_VERSION; }

/// A configuration for so many objects with the proportions that suit most scenes.
[[nodiscard]] inline Config config(std::uint32_t objects) noexcept { return trisap_default_config(objects); }

/// The least box in `float` that holds a box in `double`, seen from `origin`: rounded outward, so that no pair is lost.
[[nodiscard]] inline Aabb aabb_from_f64(const double (&min)[3], const double (&max)[3],
                                        const double (&origin)[3]) noexcept {
    return trisap_aabb_from_f64(min, max, origin);
}

/// The least box that holds a box in fixed point: integers of which each counts 2^-fraction_bits.
[[nodiscard]] inline Aabb aabb_from_fixed(const std::int32_t (&min)[3], const std::int32_t (&max)[3],
                                          std::uint32_t fraction_bits) noexcept {
    return trisap_aabb_from_fixed(min, max, fraction_bits);
}

/// What a new object has: in all groups, meets all groups, class 0.
[[nodiscard]] inline Filter filter() noexcept { return trisap_default_filter(); }

/// Class 0, with a group and a mask.
[[nodiscard]] inline Filter groups(std::uint32_t group, std::uint32_t mask) noexcept { return {group, mask, 0}; }

/// Of a class, in all groups, meets all groups.
[[nodiscard]] inline Filter object_class(std::uint32_t object_class) noexcept {
    Filter filter = trisap_default_filter();
    filter.object_class = object_class;
    return filter;
}

/// A box to look in.
[[nodiscard]] inline Region region(const Aabb &aabb) noexcept { return trisap_region_aabb(&aabb); }

/// A point to look at, of three numbers.
[[nodiscard]] inline Region point(const float *position) noexcept { return trisap_region_point(position); }

/// A ball to look in; its centre is three numbers.
[[nodiscard]] inline Region sphere(const float *center, float radius) noexcept {
    return trisap_region_sphere(center, radius);
}

/// A ray: `origin + t * direction` for `t` from zero to `distance`; both are three numbers.
[[nodiscard]] inline Cast ray(const float *origin, const float *direction,
                              float distance = std::numeric_limits<float>::infinity()) noexcept {
    return trisap_cast_ray(origin, direction, distance);
}

/// A box that moves by `direction`, which is three numbers.
[[nodiscard]] inline Cast swept(const Aabb &start, const float *direction) noexcept {
    return trisap_cast_swept(&start, direction);
}

/// A view of items that stand one after another, as `std::span` is where there is one.
template <class T> class View {
public:
    using value_type = std::remove_cv_t<T>;

    constexpr View() noexcept = default;
    constexpr View(T *first, std::size_t count) noexcept : first_(first), count_(count) {}

    /// Of an array, a vector, a `std::array`, a `std::span`: of all that has `data()` and `size()`, with items of this very type: those
    /// of a class derived from it are longer.
    template <class Items, class Item = std::remove_pointer_t<decltype(std::declval<Items &>().data())>,
              class = std::enable_if_t<!std::is_same_v<std::decay_t<Items>, View> && std::is_convertible_v<Item (*)[], T (*)[]>>>
    constexpr View(Items &&items) noexcept : first_(items.data()), count_(items.size()) {}

    template <std::size_t N> constexpr View(T (&items)[N]) noexcept : first_(items), count_(N) {}

    [[nodiscard]] constexpr T *data() const noexcept { return first_; }
    [[nodiscard]] constexpr std::size_t size() const noexcept { return count_; }
    [[nodiscard]] constexpr bool empty() const noexcept { return count_ == 0; }
    [[nodiscard]] constexpr T *begin() const noexcept { return first_; }
    [[nodiscard]] constexpr T *end() const noexcept { return first_ + count_; }
    [[nodiscard]] constexpr T &operator[](std::size_t index) const noexcept { return first_[index]; }

private:
    T *first_ = nullptr;
    std::size_t count_ = 0;
};

/// A view of boxes that stand one after another.
[[nodiscard]] inline Boxes boxes(View<const Aabb> boxes) noexcept {
    return trisap_default_boxes(boxes.data(), boxes.size());
}

/// A view of boxes inside `count` items of any type: three floats from `min` and three from `max`, members of the first
/// item, with the minimum before the maximum. There has to be a first item: for arrays that may be empty, and where the corners are
/// members of the item itself, name the members.
///
///     trisap::boxes_in(bodies.data(), bodies.size(), bodies[0].bounds.min, bodies[0].bounds.max)
template <class Item>
[[nodiscard]] Boxes boxes_in(const Item *items, std::size_t count, const float *min, const float *max) noexcept {
    Boxes view = trisap_default_boxes(nullptr, count);
    view.first = items == nullptr ? nullptr : min;
    view.stride = sizeof(Item);
    // A maximum before the minimum becomes too far away, which is refused.
    view.max_offset = static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(max) -
                                                 reinterpret_cast<std::uintptr_t>(min));
    return view;
}

namespace detail {

/// What this header refuses itself is reported as what the library refuses.
inline Status refuse(Status status, std::uint64_t about = 0) noexcept {
    trisap_refuse(status, about);
    return status;
}

/// The first of the floats that a corner is made of: of an array of them, or of a struct that begins with three.
template <class Corner> [[nodiscard]] const float *floats(const Corner &corner) noexcept {
    if constexpr (std::is_array_v<Corner>) {
        static_assert(std::is_same_v<std::remove_cv_t<std::remove_extent_t<Corner>>, float> && std::extent_v<Corner> >= 3);
        return corner;
    } else {
        static_assert(std::is_standard_layout_v<Corner> && sizeof(Corner) >= 3 * sizeof(float));
        return reinterpret_cast<const float *>(std::addressof(corner));
    }
}

} // namespace detail

/// A view of boxes inside items that stand one after another, also of none: their corners are two members, each an array of at
/// least three floats or a struct that begins with three.
///
///     trisap::boxes_in(bodies, &Body::min, &Body::max)
template <class Items, class Item, class Min, class Max>
[[nodiscard]] Boxes boxes_in(const Items &items, Min Item::*min, Max Item::*max) noexcept {
    if (items.size() == 0) {
        return trisap_default_boxes(nullptr, 0);
    }
    // Of the items' own type, which may inherit the members.
    const auto *first = items.data();
    return boxes_in(first, items.size(), detail::floats(first->*min), detail::floats(first->*max));
}

/// Ids inside items of any type: see `ids_in`.
struct Ids {
    const Id *first;
    std::size_t stride;
    std::size_t count;
};

/// A view of ids inside items that stand one after another, also of none.
///
///     world.update(trisap::ids_in(bodies, &Body::id), trisap::boxes_in(bodies, &Body::min, &Body::max))
template <class Items, class Item, class Member> [[nodiscard]] Ids ids_in(const Items &items, Member Item::*id) noexcept {
    static_assert(std::is_same_v<std::remove_cv_t<Member>, Id>);
    return {items.size() == 0 ? nullptr : std::addressof(items.data()->*id), sizeof(*items.data()), items.size()};
}

/// A value, and whether it was to be had: the world may have been busy. Turns into the value, which is nothing then.
template <class T> struct Known {
    Status status;
    T value;
    constexpr operator T() const noexcept { return value; }
};

/// The first hit of a cast; its id is null where the cast met nothing, and after a refusal, which `status` tells.
struct FirstHit : Hit {
    Status status;
};

/// A piece of a step's work, for the caller's job system to call, any number of times and from any thread, before the
/// callable that was given it returns.
class Task {
public:
    Task(void (*run)(void *), void *task, const char *name) noexcept : run_(run), task_(task), name_(name) {}

    void operator()() const noexcept { run_(task_); }

    /// A text for profilers.
    [[nodiscard]] const char *name() const noexcept { return name_; }

    /// For job systems that take a function and its argument.
    [[nodiscard]] void (*function() const noexcept)(void *) { return run_; }
    [[nodiscard]] void *argument() const noexcept { return task_; }

private:
    void (*run_)(void *);
    void *task_;
    const char *name_;
};

/// A job system: see `jobs`.
template <class ForkJoin> class Jobs {
public:
    Jobs(std::uint32_t workers, ForkJoin fork_join) noexcept : workers_(workers), fork_join_(std::move(fork_join)) {}

    /// For the C functions. Good for as long as this object stays where it is.
    [[nodiscard]] trisap_jobs c() noexcept {
        trisap_jobs jobs = trisap_default_jobs();
        jobs.worker_count = workers_;
        jobs.user = std::addressof(fork_join_);
        jobs.fork_join = &call;
        return jobs;
    }

private:
    // An exception of the callable ends the program here: it must not cross the library.
    static void call(void *user, void (*run)(void *), void *task, std::uint32_t count, const char *name) noexcept {
        (*static_cast<ForkJoin *>(user))(count, Task(run, task, name));
    }

    std::uint32_t workers_;
    ForkJoin fork_join_;
};

/// A job system of `workers` workers, the calling thread included. `fork_join(count, task)` calls `task()` `count` times,
/// one of them on the calling thread if it can, and returns when all these calls have returned. What it may do instead,
/// and what it must not do: see `trisap_jobs::fork_join`.
template <class ForkJoin> [[nodiscard]] Jobs<std::decay_t<ForkJoin>> jobs(std::uint32_t workers, ForkJoin &&fork_join) {
    static_assert(std::is_invocable_v<std::decay_t<ForkJoin> &, std::uint32_t, Task>);
    return {workers, std::forward<ForkJoin>(fork_join)};
}

/// What a step has found. The views are good until the next step or load of the world, also after objects have come, moved
/// and gone.
struct Step {
    /// `TRISAP_STATUS_OK`; or `TRISAP_STATUS_PAIRS_FULL`, with the pairs that fitted; or another refusal, with nothing. Where a world that
    /// grows finds no room for its pairs, the status says why, and the rest is as after `TRISAP_STATUS_PAIRS_FULL`: the step has happened.
    Status status;
    /// The overlapping pairs by slot, each once, `a < b`.
    View<const Pair> pairs;
    /// With events: pairs that are new.
    View<const Pair> found;
    /// With events: pairs that are gone.
    View<const Pair> lost;
    /// Objects that have kept their boxes because the new ones were refused.
    std::uint32_t rejected;
    /// The first of them.
    Id first_rejected;
    /// Pairs that there are; more than `pairs` has after `TRISAP_STATUS_PAIRS_FULL`.
    std::uint64_t pairs_needed;

    [[nodiscard]] explicit operator bool() const noexcept { return status == TRISAP_STATUS_OK; }
};

/// What a query has found, in the room that it was given.
template <class T> struct Answers {
    /// `TRISAP_STATUS_OK`; or `TRISAP_STATUS_OUTPUT_FULL`, with some of the answers; or another refusal, with nothing.
    Status status;
    /// The answers that are there.
    View<const T> items;
    /// Answers that there are; more than `items` has after `TRISAP_STATUS_OUTPUT_FULL`.
    std::size_t needed;

    [[nodiscard]] explicit operator bool() const noexcept { return status == TRISAP_STATUS_OK; }
    [[nodiscard]] std::size_t size() const noexcept { return items.size(); }
    [[nodiscard]] const T *begin() const noexcept { return items.begin(); }
    [[nodiscard]] const T *end() const noexcept { return items.end(); }
    [[nodiscard]] const T &operator[](std::size_t index) const noexcept { return items[index]; }
};

/// A normal that points outward, and the distance of a plane along it: for `within`.
struct HalfSpace {
    double numbers[4];
};

/// Queries between two steps, about all objects (`World`) or about some (`World::among`).
template <class Self> class Queries {
public:
    /// The objects whose boxes overlap a region, by ascending slot.
    [[nodiscard]] Answers<Id> overlaps(const Region &region, View<Id> room) const noexcept {
        const Choice of = choice();
        std::size_t count = 0;
        const Status status =
            trisap_world_overlaps(of.world, &region, of.condition, of.user, room.data(), room.size(), &count);
        return answers(status, room, count);
    }

    /// The objects on the inner side of planes, by ascending slot: what is in a frustum. Planes of four numbers: see `trisap_world_within`.
    [[nodiscard]] Answers<Id> within(View<const HalfSpace> planes, View<Id> room) const noexcept {
        const Choice of = choice();
        std::size_t count = 0;
        const double *first = planes.empty() ? nullptr : planes.data()->numbers;
        const Status status = trisap_world_within(of.world, first, planes.size(), of.condition, of.user, room.data(),
                                                  room.size(), &count);
        return answers(status, room, count);
    }

    /// The nearest objects to each of some points, three numbers each. `hits` is shared out equally; a share ends with null ids where
    /// there are fewer.
    [[nodiscard]] Status nearest_many(View<const float> points, View<Hit> hits) const noexcept {
        return nearest_many_with(points, hits, nullptr);
    }

    /// The same with the help of a job system.
    template <class ForkJoin>
    [[nodiscard]] Status nearest_many(View<const float> points, View<Hit> hits, Jobs<ForkJoin> &jobs) const noexcept {
        const trisap_jobs c = jobs.c();
        return nearest_many_with(points, hits, &c);
    }

    /// Overlaps of many regions at once, one after another in `ids`: see `trisap_world_overlaps_many`. As many ends as
    /// regions.
    [[nodiscard]] Status overlaps_many(View<const Region> regions, View<Id> ids, View<std::size_t> ends) const noexcept {
        return overlaps_many_with(regions, ids, ends, nullptr);
    }

    /// The same with the help of a job system.
    template <class ForkJoin>
    [[nodiscard]] Status overlaps_many(View<const Region> regions, View<Id> ids, View<std::size_t> ends,
                                       Jobs<ForkJoin> &jobs) const noexcept {
        const trisap_jobs c = jobs.c();
        return overlaps_many_with(regions, ids, ends, &c);
    }

    /// The first object that a cast meets, or the null id.
    [[nodiscard]] FirstHit first_hit(const Cast &cast) const noexcept {
        const Choice of = choice();
        Hit hit = {null_id, 0.0};
        const Status status = trisap_world_first_hit(of.world, &cast, of.condition, of.user, &hit);
        return {hit, status};
    }

    /// The first hits of many casts at once, as many as casts; null ids where a cast meets nothing.
    [[nodiscard]] Status first_hits(View<const Cast> casts, View<Hit> hits) const noexcept {
        return first_hits_with(casts, hits, nullptr);
    }

    /// The same with the help of a job system.
    template <class ForkJoin>
    [[nodiscard]] Status first_hits(View<const Cast> casts, View<Hit> hits, Jobs<ForkJoin> &jobs) const noexcept {
        const trisap_jobs c = jobs.c();
        return first_hits_with(casts, hits, &c);
    }

    /// The objects that a cast meets, the nearest first.
    [[nodiscard]] Answers<Hit> hits(const Cast &cast, View<Hit> room) const noexcept {
        const Choice of = choice();
        std::size_t count = 0;
        const Status status =
            trisap_world_hits(of.world, &cast, of.condition, of.user, room.data(), room.size(), &count);
        return answers(status, room, count);
    }

    /// The objects whose boxes are nearest to a point of three numbers, as many as there is room for, the nearest first.
    [[nodiscard]] Answers<Hit> nearest(const float *position, View<Hit> room) const noexcept {
        const Choice of = choice();
        std::size_t count = 0;
        const Status status =
            trisap_world_nearest(of.world, position, of.condition, of.user, room.data(), room.size(), &count);
        return answers(status, room, count);
    }

protected:
    /// What is asked; all may answer where there is no condition.
    struct Choice {
        const trisap_world *world;
        trisap_condition condition;
        void *user;
    };

    template <class T>
    [[nodiscard]] static Answers<T> answers(Status status, View<T> room, std::size_t count) noexcept {
        return {status, {room.data(), count < room.size() ? count : room.size()}, count};
    }

private:
    [[nodiscard]] Choice choice() const noexcept { return static_cast<const Self *>(this)->choice(); }

    [[nodiscard]] Status nearest_many_with(View<const float> points, View<Hit> hits, const trisap_jobs *jobs) const noexcept {
        const Choice of = choice();
        const std::size_t count = points.size() / 3;
        const std::size_t room = count == 0 ? 0 : hits.size() / count;
        return trisap_world_nearest_many(of.world, points.data(), 3 * sizeof(float), count, of.condition, of.user, jobs,
                                         hits.data(), room);
    }

    [[nodiscard]] Status overlaps_many_with(View<const Region> regions, View<Id> ids, View<std::size_t> ends,
                                            const trisap_jobs *jobs) const noexcept {
        if (ends.size() < regions.size()) {
            return detail::refuse(TRISAP_STATUS_INVALID_ARGUMENT);
        }
        const Choice of = choice();
        return trisap_world_overlaps_many(of.world, regions.data(), sizeof(Region), regions.size(), of.condition, of.user,
                                          jobs, ids.data(), ids.size(), ends.data());
    }

    [[nodiscard]] Status first_hits_with(View<const Cast> casts, View<Hit> hits, const trisap_jobs *jobs) const noexcept {
        if (hits.size() < casts.size()) {
            return detail::refuse(TRISAP_STATUS_INVALID_ARGUMENT);
        }
        const Choice of = choice();
        return trisap_world_first_hits(of.world, casts.data(), sizeof(Cast), casts.size(), of.condition, of.user, jobs,
                                       hits.data());
    }
};

/// Queries about the objects that fulfil a condition: see `World::among`. Good for as long as the world stays where it is, also where it
/// has grown or is made anew.
template <class Condition> class Among : public Queries<Among<Condition>> {
public:
    Among(const trisap_world *const *world, Condition condition) noexcept : world_(world), condition_(std::move(condition)) {}

private:
    friend class Queries<Among>;

    [[nodiscard]] typename Queries<Among>::Choice choice() const noexcept {
        const auto call = [](void *user, trisap_id id) noexcept -> std::uint32_t {
            return (*static_cast<const Condition *>(user))(id) ? 1 : 0;
        };
        return {*world_, call, const_cast<Condition *>(std::addressof(condition_))};
    }

    const trisap_world *const *world_;
    Condition condition_;
};

/// Where worlds have their memory from; by default from `operator new`. What it allocates is aligned to `align`, and null says that
/// there is none.
struct Allocator {
    void *(*allocate)(void *user, std::size_t bytes, std::size_t align) noexcept = [](void *, std::size_t bytes,
                                                                                      std::size_t align) noexcept {
        return ::operator new(bytes, std::align_val_t(align), std::nothrow);
    };
    void (*free)(void *user, void *memory, std::size_t bytes, std::size_t align) noexcept =
        [](void *, void *memory, std::size_t, std::size_t align) noexcept {
            ::operator delete(memory, std::align_val_t(align));
        };
    /// Handed to both.
    void *user = nullptr;
};

namespace detail {

struct Free {
    Free() noexcept : bytes(0) {}
    Free(const Allocator &from, std::size_t room) noexcept : allocator(from), bytes(room) {}
    Allocator allocator;
    std::size_t bytes;
    void operator()(void *memory) const noexcept { allocator.free(allocator.user, memory, bytes, trisap_world_align()); }
};
using Memory = std::unique_ptr<void, Free>;

/// Memory for a world, or for contacts; null where there is none.
[[nodiscard]] inline Memory allocate(const Allocator &from, std::size_t bytes) noexcept {
    return Memory(from.allocate(from.user, bytes, trisap_world_align()), Free(from, bytes));
}

} // namespace detail

/// All pairs of boxes that are there once, into a vector of `Pair`: of `a`, or of a box of `a` and a box of `b` where `b` is not null.
/// Nothing has to be set up: see `trisap_pairs`.
template <class Vector>
[[nodiscard]] Status pairs(const Boxes &a, Vector &found, const Boxes *b = nullptr, const trisap_jobs *jobs = nullptr,
                           const Allocator &allocator = Allocator()) {
    detail::Memory memory;
    std::size_t bytes = 0, count = 0;
    const Pair *first = nullptr;
    for (;;) {
        const Status status = trisap_pairs(&a, b, jobs, memory.get(), &bytes, &first, &count);
        if (status != TRISAP_STATUS_MEMORY_TOO_SMALL) {
            found.assign(first, first + (status == TRISAP_STATUS_OK ? count : 0));
            return status;
        }
        memory.reset();
        memory = detail::allocate(allocator, bytes);
        if (memory == nullptr) {
            return detail::refuse(TRISAP_STATUS_MEMORY_TOO_SMALL);
        }
    }
}

/// Whom an object belongs to, up to three numbers of yours: parts have their body, bullets who has shot them, a vertex, an edge or a
/// triangle its vertices. Those that share one make no pair in
/// `world.step_with_rule([&](auto a, auto b) { return are_apart(owners[a], owners[b]); })`.
struct Owned {
    static constexpr std::uint32_t nobody = 0xffffffff;
    std::uint32_t by[3] = {nobody, nobody, nobody};

    /// Whether two have no owner in common.
    [[nodiscard]] friend bool are_apart(const Owned &a, const Owned &b) noexcept {
        bool share = false;
        for (const std::uint32_t owner : a.by) {
            share |= (owner != nobody) & ((owner == b.by[0]) | (owner == b.by[1]) | (owner == b.by[2]));
        }
        return !share;
    }
};

/// A world with memory of its own. Moves, but does not copy. Before `init`, every call is refused.
///
/// Any number of threads may call what is `const` at once; what is not is refused as busy meanwhile, and the other way round.
class World : public Queries<World> {
public:
    World() noexcept = default;

    /// A world whose memory comes from elsewhere.
    explicit World(const Allocator &allocator) noexcept : allocator_(allocator) {}

    /// Makes an empty world, in place of what there was; after another status than OK that is as it was. The only allocation, unless
    /// the world grows, or is made for one worker and gets a job system of more in its first step.
    [[nodiscard]] Status init(const Config &config) noexcept {
        const Status status = place(trisap_world_size(&config), [&](void *memory, std::size_t bytes, trisap_world **world) {
            return trisap_world_init(memory, bytes, &config, world);
        });
        has_stepped_ = has_stepped_ && status != TRISAP_STATUS_OK;
        return status;
    }

    /// Goes on as the world of which these bytes are a copy, in place of what there was: see `trisap_world_open`.
    [[nodiscard]] Status open(View<const std::byte> copy) noexcept {
        const Status status = place(copy.size(), [&](void *memory, std::size_t bytes, trisap_world **world) {
            if (!copy.empty()) {
                std::memcpy(memory, copy.data(), copy.size());
            }
            return trisap_world_open(memory, bytes, world);
        });
        has_stepped_ = has_stepped_ || status == TRISAP_STATUS_OK;
        return status;
    }

    /// Becomes a copy of another world, byte for byte, in the memory that there is if that is as long: the way to go
    /// back to a frame. Not while a call changes the other world.
    [[nodiscard]] Status copy_from(const World &other) noexcept {
        Config config = trisap_default_config(0);
        if (const Status status = trisap_world_config(other.world_, &config); status != TRISAP_STATUS_OK || &other == this) {
            return status;
        }
        const std::size_t bytes = trisap_world_bytes(other.world_);
        if (world_ == nullptr || bytes != trisap_world_bytes(world_)) {
            return open({static_cast<const std::byte *>(other.memory_.get()), bytes});
        }
        if (const Status status = tell_growing(); status != TRISAP_STATUS_OK) {
            return status;
        }
        const Status status = renew([&] {
            std::memcpy(memory_.get(), other.memory_.get(), bytes);
            return trisap_world_open(memory_.get(), bytes, &world_);
        });
        static_cast<void>(tell_growing());
        return status;
    }

    /// Moves the world to memory of its own for another configuration: larger, or smaller where all fits. Ids and events go on: see
    /// `trisap_world_move`. After another status than OK the world is as it was. Views of the last result stay good until the next
    /// step or load, and so long the memory that the step was in is kept.
    [[nodiscard]] Status move_to(const Config &config) noexcept {
        return place(
            trisap_world_size(&config),
            [&](void *memory, std::size_t bytes, trisap_world **world) {
                return trisap_world_move(world_, memory, bytes, &config, world);
            },
            true);
    }

    /// The same, with room for so many objects and pairs, and references as they suit most scenes.
    [[nodiscard]] Status move_to(std::uint32_t objects, std::uint32_t pairs) noexcept {
        Config config = this->config();
        config.objects = objects;
        config.leaf_refs = trisap_default_config(objects).leaf_refs;
        config.pairs = pairs;
        return move_to(config);
    }

    /// Whether the world moves by itself to twice the room where objects or pairs do not fit, also those of a snapshot. Off at first.
    /// What such a world can mend is not reported (see `trisap_set_report`), and views of results stay good as after `move_to`. With room
    /// for more than 256 objects it is not lean any more.
    void set_growing(bool growing) noexcept {
        growing_ = growing;
        static_cast<void>(tell_growing());
    }

    /// What the world is made for, grown or not.
    [[nodiscard]] Config config() const noexcept {
        Config config = trisap_default_config(0);
        // Of a world that has not been made, the configuration for no objects.
        static_cast<void>(trisap_world_config(world_, &config) == TRISAP_STATUS_OK);
        return config;
    }

    /// Adds an object; null where it was refused, for the reason that is written to `status`, if that is given.
    [[nodiscard]] Id insert(const Aabb &aabb, Status *status = nullptr) noexcept {
        Id id = null_id;
        const Status outcome = grow_and([&] { return trisap_world_insert(world_, &aabb, &id); });
        if (status != nullptr) {
            *status = outcome;
        }
        return id;
    }

    /// The same in a slot that the caller names, which has to be free.
    [[nodiscard]] Id insert_at(std::uint32_t slot, const Aabb &aabb, Status *status = nullptr) noexcept {
        Id id = null_id;
        const Status outcome = grow_and([&] { return trisap_world_insert_at(world_, slot, &aabb, &id); });
        if (status != nullptr) {
            *status = outcome;
        }
        return id;
    }

    /// The same with a filter, for which the world needs `Config::filters`.
    [[nodiscard]] Id insert(const Aabb &aabb, const Filter &filter, Status *status = nullptr) noexcept {
        return insert_with(aabb, &filter, nullptr, nullptr, status);
    }

    /// The same with a filter and a value, for which the world needs `Config::values`, too.
    template <class Value, class = std::enable_if_t<std::is_convertible_v<Value, std::uint64_t>>>
    [[nodiscard]] Id insert(const Aabb &aabb, const Filter &filter, Value value, Status *status = nullptr) noexcept {
        const auto number = static_cast<std::uint64_t>(value);
        return insert_with(aabb, &filter, &number, nullptr, status);
    }

    /// The same with a value alone.
    [[nodiscard]] Id insert_value(const Aabb &aabb, std::uint64_t value, Status *status = nullptr) noexcept {
        return insert_with(aabb, nullptr, &value, nullptr, status);
    }

    /// The same with a filter, a value and a margin of its own, each of which may be null.
    [[nodiscard]] Id insert_with(const Aabb &aabb, const Filter *filter, const std::uint64_t *value, const float *margin,
                                 Status *status = nullptr) noexcept {
        Id id = null_id;
        const Status outcome = grow_and([&] { return trisap_world_insert_with(world_, &aabb, filter, value, margin, &id); });
        if (status != nullptr) {
            *status = outcome;
        }
        return id;
    }

    /// Adds objects, all or none. There must be room for as many ids as boxes.
    [[nodiscard]] Status insert(const Boxes &boxes, View<Id> ids) noexcept {
        if (ids.size() < boxes.count) {
            return detail::refuse(TRISAP_STATUS_INVALID_ARGUMENT);
        }
        return grow_and([&] { return trisap_world_insert_many(world_, &boxes, ids.data()); });
    }

    /// Gives an object another box.
    [[nodiscard]] Status update(Id id, const Aabb &aabb) noexcept { return trisap_world_update(world_, id, &aabb); }

    /// Gives objects other boxes, all or none; as many boxes as ids.
    [[nodiscard]] Status update(View<const Id> ids, const Boxes &boxes) noexcept {
        if (ids.size() != boxes.count) {
            return detail::refuse(TRISAP_STATUS_INVALID_ARGUMENT);
        }
        return trisap_world_update_many(world_, ids.data(), &boxes);
    }

    /// The same with ids that stand inside of your own items.
    [[nodiscard]] Status update(const Ids &ids, const Boxes &boxes) noexcept {
        if (ids.count != boxes.count) {
            return detail::refuse(TRISAP_STATUS_INVALID_ARGUMENT);
        }
        return trisap_world_update_strided(world_, ids.first, ids.stride, &boxes);
    }

    /// Removes an object.
    [[nodiscard]] Status remove(Id id) noexcept { return trisap_world_remove(world_, id); }

    /// Removes objects, all or none.
    [[nodiscard]] Status remove(View<const Id> ids) noexcept {
        return trisap_world_remove_many(world_, ids.data(), ids.size());
    }

    /// Sets how far an object may move before it counts as moved.
    [[nodiscard]] Status set_margin(Id id, float length) noexcept {
        return trisap_world_set_margin(world_, id, length);
    }

    /// Sets whom an object meets. Needs `Config::filters`.
    [[nodiscard]] Status set_filter(Id id, const Filter &filter) noexcept {
        return trisap_world_set_filter(world_, id, &filter);
    }

    /// Sets whom objects meet, all or none; all the same.
    [[nodiscard]] Status set_filter(View<const Id> ids, const Filter &filter) noexcept {
        return trisap_world_set_filter_many(world_, ids.data(), &filter, 0, ids.size());
    }

    /// Sets whom objects meet, all or none; as many filters as ids.
    [[nodiscard]] Status set_filter(View<const Id> ids, View<const Filter> filters) noexcept {
        if (ids.size() != filters.size()) {
            return detail::refuse(TRISAP_STATUS_INVALID_ARGUMENT);
        }
        return trisap_world_set_filter_many(world_, ids.data(), filters.data(), sizeof(Filter), ids.size());
    }

    /// Writes whom an object meets to `filter`.
    [[nodiscard]] Status filter(Id id, Filter &filter) const noexcept {
        return trisap_world_filter(world_, id, &filter);
    }

    /// Sets which classes meet: bit `b` of `meets[a]` and bit `a` of `meets[b]`.
    [[nodiscard]] Status set_classes(const std::uint32_t (&meets)[TRISAP_CLASSES]) noexcept {
        return trisap_world_set_classes(world_, meets);
    }

    /// Has the next step ask about all pairs of an object again, for a rule that has changed its mind.
    [[nodiscard]] Status refilter(Id id) noexcept { return trisap_world_refilter(world_, id); }

    /// Puts objects to rest, all or none: steps do not look at their boxes until they are updated or woken.
    [[nodiscard]] Status set_resting(View<const Id> ids) noexcept {
        return trisap_world_set_resting(world_, ids.data(), ids.size());
    }

    /// Puts one object to rest.
    [[nodiscard]] Status set_resting(Id id) noexcept { return trisap_world_set_resting(world_, &id, 1); }

    /// Has steps look at the box of an object again.
    [[nodiscard]] Status wake(Id id) noexcept { return trisap_world_wake(world_, &id, 1); }

    /// Has steps look at the boxes of objects again, all or none.
    [[nodiscard]] Status wake(View<const Id> ids) noexcept {
        return trisap_world_wake(world_, ids.data(), ids.size());
    }

    /// Disables objects or enables them again, all or none: see `trisap_world_set_enabled`.
    [[nodiscard]] Status set_enabled(View<const Id> ids, bool enabled) noexcept {
        return trisap_world_set_enabled(world_, ids.data(), ids.size(), enabled ? 1 : 0);
    }

    /// The same for one.
    [[nodiscard]] Status set_enabled(Id id, bool enabled) noexcept { return trisap_world_set_enabled(world_, &id, 1, enabled ? 1 : 0); }

    /// Whether an object is enabled.
    [[nodiscard]] bool is_enabled(Id id) const noexcept { return trisap_world_is_enabled(world_, id) != 0; }

    /// Writes pairs of the last step by id, `TRISAP_PAIRS_ALL`, `TRISAP_PAIRS_FOUND` or `TRISAP_PAIRS_LOST`, to `pairs`, and how many
    /// there are to `count`. To be asked before objects come or go: see `trisap_world_pair_ids`.
    [[nodiscard]] Status pair_ids(std::uint32_t what, View<trisap_id_pair> pairs, std::size_t &count) const noexcept {
        return trisap_world_pair_ids(world_, what, pairs.data(), pairs.size(), &count);
    }

    /// Gives an object a value. Needs `Config::values`.
    [[nodiscard]] Status set_value(Id id, std::uint64_t value) noexcept {
        return trisap_world_set_value(world_, id, value);
    }

    /// Gives objects values, all or none; as many values as ids.
    [[nodiscard]] Status set_value(View<const Id> ids, View<const std::uint64_t> values) noexcept {
        if (ids.size() != values.size()) {
            return detail::refuse(TRISAP_STATUS_INVALID_ARGUMENT);
        }
        return trisap_world_set_value_many(world_, ids.data(), values.data(), sizeof(std::uint64_t), ids.size());
    }

    /// Writes the value of an object to `value`.
    [[nodiscard]] Status value(Id id, std::uint64_t &value) const noexcept {
        return trisap_world_value(world_, id, &value);
    }

    /// Writes the values of objects, as many as ids, to `values`: of those that `overlaps` has found, for instance.
    [[nodiscard]] Status values(View<const Id> ids, View<std::uint64_t> values) const noexcept {
        return values_of(ids.data(), sizeof(Id), ids.size(), values);
    }

    /// The same of the objects of hits.
    [[nodiscard]] Status values(View<const Hit> hits, View<std::uint64_t> values) const noexcept {
        return values_of(hits.empty() ? nullptr : &hits.data()->id, sizeof(Hit), hits.size(), values);
    }

    /// Writes pairs of the last step by value, as `pair_ids` does by id.
    [[nodiscard]] Answers<ValuePair> pair_values(std::uint32_t what, View<ValuePair> room) const noexcept {
        std::size_t count = 0;
        const Status status = trisap_world_pair_values(world_, what, room.data(), room.size(), &count);
        return answers(status, room, count);
    }

    /// The pairs of the last step of which at least one object does not rest.
    [[nodiscard]] Answers<Pair> awake_pairs(View<Pair> room) const noexcept {
        std::size_t count = 0;
        const Status status = trisap_world_awake_pairs(world_, room.data(), room.size(), &count);
        return answers(status, room, count);
    }

    [[nodiscard]] bool is_resting(Id id) const noexcept { return trisap_world_is_resting(world_, id) != 0; }

    /// Whether an object lives. Another status than OK means that nobody knows.
    [[nodiscard]] Known<bool> contains(Id id) const noexcept {
        const Status status = trisap_world_contains(world_, id);
        return {status == TRISAP_STATUS_STALE_ID ? TRISAP_STATUS_OK : status, status == TRISAP_STATUS_OK};
    }

    /// The object that lives in `slot`, or null.
    [[nodiscard]] Known<Id> id_at(std::uint32_t slot) const noexcept {
        Id id = null_id;
        const Status status = trisap_world_find(world_, slot, &id);
        return {status, id};
    }

    /// Writes the box of an object to `aabb`.
    [[nodiscard]] Status aabb(Id id, Aabb &aabb) const noexcept { return trisap_world_aabb(world_, id, &aabb); }

    /// Writes the boxes of objects, as many as ids, to `aabbs`.
    [[nodiscard]] Status aabbs(View<const Id> ids, View<Aabb> aabbs) const noexcept {
        return this->aabbs(Ids{ids.data(), sizeof(Id), ids.size()}, aabbs);
    }

    /// The same with ids that stand inside of your own items.
    [[nodiscard]] Status aabbs(const Ids &ids, View<Aabb> aabbs) const noexcept {
        if (aabbs.size() < ids.count) {
            return detail::refuse(TRISAP_STATUS_INVALID_ARGUMENT);
        }
        return trisap_world_aabbs(world_, ids.first, ids.stride, ids.count, aabbs.data());
    }

    /// Living objects.
    [[nodiscard]] Known<std::uint32_t> size() const noexcept {
        std::uint32_t count = 0;
        const Status status = trisap_world_count(world_, &count);
        return {status, count};
    }

    /// Finds all overlapping pairs, on the calling thread.
    [[nodiscard]] Step step() noexcept { return step_with(nullptr); }

    /// The same with the help of a job system.
    template <class ForkJoin> [[nodiscard]] Step step(Jobs<ForkJoin> &jobs) noexcept {
        const trisap_jobs c = jobs.c();
        return step_with(&c);
    }

    /// Finds all overlapping pairs after giving every object the box that stands at its slot.
    [[nodiscard]] Step step_over(const Boxes &boxes) noexcept { return step_over_with(boxes, nullptr); }

    /// The same with the help of a job system.
    template <class ForkJoin> [[nodiscard]] Step step_over(const Boxes &boxes, Jobs<ForkJoin> &jobs) noexcept {
        const trisap_jobs c = jobs.c();
        return step_over_with(boxes, &c);
    }

    /// As `step`, with a rule that decides about the pairs that the filters let through: `rule(a, b)` is true if the objects
    /// in two slots, the lower one first, make a pair. See `trisap_rule`.
    template <class Rule> [[nodiscard]] Step step_with_rule(Rule &&rule) noexcept {
        return step_with_rule_and(nullptr, rule, nullptr);
    }

    /// The same with the help of a job system, whose workers call the rule all at once.
    template <class Rule, class ForkJoin> [[nodiscard]] Step step_with_rule(Rule &&rule, Jobs<ForkJoin> &jobs) noexcept {
        const trisap_jobs c = jobs.c();
        return step_with_rule_and(nullptr, rule, &c);
    }

    /// As `step_over`, with a rule.
    template <class Rule> [[nodiscard]] Step step_over_with_rule(const Boxes &boxes, Rule &&rule) noexcept {
        return step_with_rule_and(&boxes, rule, nullptr);
    }

    /// The same with the help of a job system.
    template <class Rule, class ForkJoin>
    [[nodiscard]] Step step_over_with_rule(const Boxes &boxes, Rule &&rule, Jobs<ForkJoin> &jobs) noexcept {
        const trisap_jobs c = jobs.c();
        return step_with_rule_and(&boxes, rule, &c);
    }

    /// Brings the tree up to date for queries, without a look for pairs: see `trisap_world_refresh`.
    [[nodiscard]] Status refresh() noexcept { return trisap_world_refresh(world_, nullptr); }

    /// The same with the help of a job system.
    template <class ForkJoin> [[nodiscard]] Status refresh(Jobs<ForkJoin> &jobs) noexcept {
        const trisap_jobs c = jobs.c();
        follow(&c);
        return trisap_world_refresh(world_, &c);
    }

    /// The result of the last step once more, after `load` for instance.
    [[nodiscard]] Step result() noexcept {
        trisap_result result = trisap_default_result();
        const Status status = trisap_world_result(stepped(), &result);
        return view(status, result);
    }

    /// Visits the objects whose boxes are inside a part of space of your own or across its border, each once. `side(aabb)` is less than
    /// 0 for a box outside, more than 0 inside, else 0: see `trisap_side`. A visitor that returns false ends it.
    template <class Side, class Visit> [[nodiscard]] Status visit_within(Side &&side, Visit &&visit) const noexcept {
        const auto ask = [](void *user, const trisap_aabb *aabb) noexcept -> std::int32_t {
            return static_cast<Reference<Side> *>(user)->callable(*aabb);
        };
        Reference<Side> sides{side};
        Reference<Visit> reference{visit};
        return trisap_world_visit_within(world_, ask, &sides, goes_on<Visit>, &reference);
    }

    /// Visits the objects whose boxes overlap a region: `visit(id)` returns nothing, or false to end the visit. It may look at this
    /// world; what changes it is refused as busy.
    template <class Visit> [[nodiscard]] Status visit_overlaps(const Region &region, Visit &&visit) const noexcept {
        Reference<Visit> reference{visit};
        return trisap_world_visit_overlaps(world_, &region, goes_on<Visit>, &reference);
    }

    /// Visits the objects that a cast meets: `visit(hit)` returns how far to look on, or nothing to see everything. It may
    /// look at this world; what changes it is refused as busy.
    template <class Visit> [[nodiscard]] Status visit_hits(const Cast &cast, Visit &&visit) const noexcept {
        Reference<Visit> reference{visit};
        return trisap_world_visit_hits(world_, &cast, far_of<Visit>, &reference);
    }

    /// Visits the objects that are at most so far from a point of three numbers, nearer leaves of the tree first: `visit(hit)` returns
    /// how far to look on. Infinity refuses an object; the distance of the shape in the box finds the nearest shape.
    template <class Visit>
    [[nodiscard]] Status visit_nearest(const float *position, double distance, Visit &&visit) const noexcept {
        Reference<Visit> reference{visit};
        return trisap_world_visit_nearest(world_, position, distance, far_of<Visit>, &reference);
    }

    /// Asks queries as if only objects were there that fulfil a condition: `condition(id)` is true if the object may answer. It has to
    /// say the same of the same object, may look at the world, and is called by the workers of a batch all at once.
    ///
    ///     world.among([&](trisap::Id id) { return id != own; }).first_hit(trisap::ray(eye, direction))
    template <class Condition>
    [[nodiscard]] Among<std::decay_t<Condition>> among(Condition &&condition) const noexcept {
        static_assert(std::is_invocable_r_v<bool, const std::decay_t<Condition> &, Id>);
        return {std::addressof(world_), std::forward<Condition>(condition)};
    }

    /// Whether an object meets what has this filter, by groups and classes: for conditions of queries.
    [[nodiscard]] bool meets(Id id, const Filter &filter) const noexcept {
        return trisap_world_meets(world_, id, &filter) != 0;
    }

    /// Moves the origin to a point: subtracts it from all boxes. `rounded` tells how many objects had to be rounded outward.
    [[nodiscard]] Status shift_origin(const double (&by)[3], std::uint32_t *rounded = nullptr) noexcept {
        return trisap_world_shift_origin(world_, by, rounded);
    }

    /// The bytes of a snapshot of the world as it is now.
    [[nodiscard]] std::size_t snapshot_size() const noexcept { return trisap_world_snapshot_size(world_); }

    /// Writes a snapshot of the world to the front of `room`; the answer is its bytes.
    [[nodiscard]] Answers<std::byte> save(View<std::byte> room) const noexcept {
        std::size_t count = 0;
        const Status status = trisap_world_save(world_, room.data(), room.size(), &count);
        return {status, {room.data(), status == TRISAP_STATUS_OK ? count : 0}, count};
    }

    /// Replaces the world by the one that a snapshot was taken of. Room and workers may differ: see `trisap_world_load`.
    [[nodiscard]] Status load(View<const std::byte> snapshot) noexcept {
        return renew([&] { return trisap_world_load(world_, snapshot.data(), snapshot.size()); }, TRISAP_STATUS_OK);
    }

    /// Puts the last result into an order that depends on its pairs alone: see `trisap_world_sort_results`. Its views
    /// are those of `result` then.
    [[nodiscard]] Status sort_results() noexcept {
        trisap_result result = trisap_default_result();
        const Status status = trisap_world_sort_results(world_, &result);
        return status == TRISAP_STATUS_OK && stepped() != world_ ? trisap_world_sort_results(stepped(), &result) : status;
    }

    /// The leaves of the tree, from left to right, for a debug view.
    [[nodiscard]] Answers<Leaf> leaves(View<Leaf> room) const noexcept {
        std::size_t count = 0;
        const Status status = trisap_world_leaves(world_, room.data(), room.size(), &count);
        return answers(status, room, count);
    }

    /// The planes of the tree, from the root down.
    [[nodiscard]] Answers<Plane> planes(View<Plane> room) const noexcept {
        std::size_t count = 0;
        const Status status = trisap_world_planes(world_, room.data(), room.size(), &count);
        return answers(status, room, count);
    }

    /// The objects that live in the list of large objects.
    [[nodiscard]] Answers<Id> large(View<Id> room) const noexcept {
        std::size_t count = 0;
        const Status status = trisap_world_large(world_, room.data(), room.size(), &count);
        return answers(status, room, count);
    }

    /// What the last step did.
    [[nodiscard]] Stats stats() const noexcept {
        Stats stats = trisap_default_stats();
        // Of a world that has not been made, the statistics of no step.
        static_cast<void>(trisap_world_stats(world_, &stats) == TRISAP_STATUS_OK);
        return stats;
    }

    /// Whether floats are too coarse for some box at its place: see `trisap_world_is_coarse`.
    [[nodiscard]] bool is_coarse() const noexcept { return trisap_world_is_coarse(world_) != 0; }

    /// What the status of the last refused call was about: see `trisap_status`.
    [[nodiscard]] std::uint64_t error_detail() const noexcept { return trisap_world_error_detail(world_); }

    /// Checks every invariant of the world. O(n log n).
    [[nodiscard]] Status validate() const noexcept { return trisap_world_validate(world_); }

    /// For the C functions; null before `init`. Where the world has moved since a step, `result` does not know of steps and loads by C.
    [[nodiscard]] trisap_world *c() noexcept { return world_; }

    World(World &&other) noexcept
        : allocator_(other.allocator_), memory_(std::move(other.memory_)), kept_(std::move(other.kept_)),
          world_(std::exchange(other.world_, nullptr)), growing_(other.growing_), has_stepped_(other.has_stepped_) {}

    World &operator=(World &&other) noexcept {
        allocator_ = other.allocator_;
        memory_ = std::move(other.memory_);
        kept_ = std::move(other.kept_);
        world_ = std::exchange(other.world_, nullptr);
        growing_ = other.growing_;
        has_stepped_ = other.has_stepped_;
        return *this;
    }

private:
    friend class Queries<World>;

    [[nodiscard]] Choice choice() const noexcept { return {world_, nullptr, nullptr}; }

    using Memory = detail::Memory;

    /// Has `make` make the world in new memory, which takes the place of the old one if it can. Views of the last result may go on.
    template <class Make> [[nodiscard]] Status place(std::size_t bytes, Make make, bool goes_on = false) noexcept {
        // A call inside would go on in memory that is not there any more.
        if (tell_growing() == TRISAP_STATUS_BUSY) {
            return TRISAP_STATUS_BUSY;
        }
        // For an impossible configuration as much as the library looks at, to say what is wrong.
        const std::size_t room = bytes == 0 ? trisap_world_align() : bytes;
        Memory memory = detail::allocate(allocator_, room);
        if (memory == nullptr) {
            return detail::refuse(TRISAP_STATUS_MEMORY_TOO_SMALL, room);
        }
        trisap_world *world = nullptr;
        const Status status = make(memory.get(), room, &world);
        if (status == TRISAP_STATUS_OK) {
            if (goes_on && kept_ == nullptr) {
                kept_ = std::move(memory_);
            } else if (!goes_on) {
                kept_ = Memory();
            }
            memory_ = std::move(memory);
            world_ = world;
            static_cast<void>(tell_growing());
        }
        return status;
    }

    /// Tells the world, if there is one; so it also says whether a call is inside.
    [[nodiscard]] Status tell_growing() noexcept {
        return world_ == nullptr ? TRISAP_STATUS_OK : trisap_world_set_growing(world_, growing_ ? 1 : 0);
    }

    /// The world in the memory that the last step was in: all views are of that, also where it has moved since, any number of times.
    [[nodiscard]] trisap_world *stepped() const noexcept {
        return kept_ == nullptr ? world_ : static_cast<trisap_world *>(kept_.get());
    }

    /// A step or load, after which the results before it are gone; of a step also where its pairs do not fit.
    template <class Call> [[nodiscard]] Status renew(Call call, Status partly = TRISAP_STATUS_PAIRS_FULL) noexcept {
        return grow_and([&] {
            const Status status = call();
            if (status == TRISAP_STATUS_OK || status == partly) {
                kept_ = Memory();
                has_stepped_ = true;
            }
            return status;
        });
    }

    /// Makes a world of one worker ready for those of a job system, before its first step: later that would change the order of pairs.
    /// Where there is no memory for that, it stays as it is.
    void follow(const trisap_jobs *jobs) noexcept {
        if (jobs == nullptr || jobs->worker_count <= 1 || has_stepped_) {
            return;
        }
        Config more = config();
        if (more.workers == 1 && world_ != nullptr) {
            more.workers = jobs->worker_count < 32 ? jobs->worker_count : 32;
            static_cast<void>(move_to(more));
        }
    }

    /// Calls, and once more after each growth where something did not fit.
    template <class Call> [[nodiscard]] Status grow_and(Call call) noexcept {
        Status status = call();
        while (growing_ && (status == TRISAP_STATUS_OBJECTS_FULL || status == TRISAP_STATUS_PAIRS_FULL)) {
            const std::uint64_t needed = error_detail();
            Config larger = config();
            const auto grown = [&](std::uint32_t had) {
                const std::uint64_t wanted = needed > 2ull * had ? needed : 2ull * had;
                return static_cast<std::uint32_t>(wanted < UINT32_MAX ? wanted : UINT32_MAX);
            };
            if (status == TRISAP_STATUS_PAIRS_FULL) {
                larger.pairs = grown(larger.pairs);
            } else {
                const Config usual = trisap_default_config(grown(larger.objects));
                larger.objects = usual.objects;
                larger.lean = larger.objects <= lean_objects ? larger.lean : 0;
                larger.leaf_refs = usual.leaf_refs > larger.leaf_refs ? usual.leaf_refs : larger.leaf_refs;
                larger.pairs = usual.pairs > larger.pairs ? usual.pairs : larger.pairs;
            }
            if (const Status moved = move_to(larger); moved != TRISAP_STATUS_OK) {
                return moved;
            }
            status = call();
        }
        return status;
    }

    /// A callable as the C functions hand it on, also a constant one and a plain function.
    template <class Callable> struct Reference {
        std::remove_reference_t<Callable> &callable;
    };

    template <class Visit> static std::uint32_t goes_on(void *user, trisap_id id) noexcept {
        auto &visitor = static_cast<Reference<Visit> *>(user)->callable;
        if constexpr (std::is_void_v<decltype(visitor(id))>) {
            visitor(id);
            return 1;
        } else {
            return visitor(id) ? 1 : 0;
        }
    }

    /// How far a visitor wants to look on; all the way where it does not say.
    template <class Visit> static double far_of(void *user, trisap_hit hit) noexcept {
        auto &visitor = static_cast<Reference<Visit> *>(user)->callable;
        if constexpr (std::is_void_v<decltype(visitor(hit))>) {
            visitor(hit);
            return std::numeric_limits<double>::infinity();
        } else {
            return visitor(hit);
        }
    }

    [[nodiscard]] Status values_of(const Id *first, std::size_t stride, std::size_t count,
                                   View<std::uint64_t> values) const noexcept {
        if (values.size() < count) {
            return detail::refuse(TRISAP_STATUS_INVALID_ARGUMENT);
        }
        return trisap_world_values(world_, first, stride, count, values.data());
    }

    [[nodiscard]] Step step_with(const trisap_jobs *jobs) noexcept {
        trisap_result result = trisap_default_result();
        follow(jobs);
        const Status status = renew([&] { return trisap_world_step(world_, jobs, &result); });
        return view(status, result);
    }

    [[nodiscard]] Step step_over_with(const Boxes &boxes, const trisap_jobs *jobs) noexcept {
        trisap_result result = trisap_default_result();
        follow(jobs);
        const Status status = renew([&] { return trisap_world_step_over(world_, &boxes, jobs, &result); });
        return view(status, result);
    }

    /// `boxes` may be null.
    template <class Rule>
    [[nodiscard]] Step step_with_rule_and(const Boxes *boxes, Rule &rule, const trisap_jobs *jobs) noexcept {
        static_assert(std::is_invocable_r_v<bool, Rule &, std::uint32_t, std::uint32_t>);
        const auto call = [](void *user, std::uint32_t a, std::uint32_t b) noexcept -> std::uint32_t {
            return static_cast<Reference<Rule> *>(user)->callable(a, b) ? 1 : 0;
        };
        Reference<Rule> reference{rule};
        trisap_result result = trisap_default_result();
        follow(jobs);
        const Status status =
            renew([&] { return trisap_world_step_with_rule(world_, boxes, call, &reference, jobs, &result); });
        return view(status, result);
    }

    [[nodiscard]] static Step view(Status status, const trisap_result &result) noexcept {
        return {status,
                {result.pairs, result.pair_count},
                {result.found, result.found_count},
                {result.lost, result.lost_count},
                result.rejected_count,
                result.first_rejected,
                result.pairs_needed};
    }

    /// More cannot be in a lean world.
    static constexpr std::uint32_t lean_objects = 256;

    Allocator allocator_;
    Memory memory_;
    /// That of the last step, if the world has moved since.
    Memory kept_;
    trisap_world *world_ = nullptr;
    bool growing_ = false, has_stepped_ = false;
};

/// A number for each pair, from the step that finds it to the step that loses it: what is kept for a pair (a manifold, a sound,
/// damage) stands in a vector at that place. See `trisap_contacts`. Beside a world with events; grows by itself; moves, but does not
/// copy (`copy_from` does). One thread at a time may call, also what is `const`.
class Contacts {
public:
    /// No pair has this number.
    static constexpr std::uint32_t none = TRISAP_NO_CONTACT;

    Contacts() noexcept = default;

    /// Contacts whose memory comes from elsewhere.
    explicit Contacts(const Allocator &allocator) noexcept : allocator_(allocator) {}

    /// Takes back the numbers of the lost pairs of a step and tells each as `ended(pair, contact)`, then gives the found ones numbers
    /// and tells each as `began(pair, contact)`. Of each step, also of those in which nothing seems to happen.
    ///
    /// Errors: `TRISAP_STATUS_MEMORY_TOO_SMALL`; `TRISAP_STATUS_INVALID_ARGUMENT` for a found pair of one slot, or of one that no world
    /// has. Nothing is told or changed then.
    template <class Ended, class Began>
    [[nodiscard]] Status update(const Step &step, Ended &&ended, Began &&began) noexcept {
        return update(step.lost, step.found, ended, began);
    }

    /// The same of any pairs: in a world that has some already all of them are found.
    template <class Ended, class Began>
    [[nodiscard]] Status update(View<const Pair> lost, View<const Pair> found, Ended &&ended, Began &&began) noexcept {
        std::uint32_t slots = objects_;
        for (const Pair &pair : found) {
            const std::uint32_t last = pair.a < pair.b ? pair.b : pair.a;
            // All that the call below may refuse, which comes after `ended`.
            if (pair.a == pair.b || last == UINT32_MAX) {
                return detail::refuse(TRISAP_STATUS_INVALID_ARGUMENT);
            }
            slots = last >= slots ? last + 1 : slots;
        }
        const std::size_t pairs = size() + found.size();
        if (contacts_ == nullptr || slots > objects_ || pairs > room_) {
            const auto more = [](std::uint64_t needed, std::uint64_t had) {
                const std::uint64_t room = needed > had ? (needed > 2 * had ? needed : 2 * had) : had;
                return static_cast<std::uint32_t>(room < UINT32_MAX ? room : UINT32_MAX);
            };
            if (const Status status = move_to(more(slots, objects_), more(pairs, room_)); status != TRISAP_STATUS_OK) {
                return status;
            }
        }
        for (const Pair &pair : lost) {
            if (const std::uint32_t contact = get(pair.a, pair.b); contact != none) {
                ended(pair, contact);
            }
        }
        const Status status = trisap_contacts_update(contacts_, lost.data(), lost.size(), nullptr, found.data(),
                                                     found.size(), nullptr, nullptr);
        if (status == TRISAP_STATUS_OK) {
            for (const Pair &pair : found) {
                began(pair, get(pair.a, pair.b));
            }
        }
        return status;
    }

    /// The number of a pair of slots, in any order, or `none`.
    [[nodiscard]] std::uint32_t get(std::uint32_t a, std::uint32_t b) const noexcept {
        return contacts_ == nullptr ? none : trisap_contacts_get(contacts_, a, b);
    }

    /// The contacts of an object.
    [[nodiscard]] Answers<Contact> of(std::uint32_t slot, View<Contact> room) const noexcept {
        std::size_t count = 0;
        const Status status = contacts_ == nullptr
                                  ? TRISAP_STATUS_OK
                                  : trisap_contacts_of(contacts_, slot, room.data(), room.size(), &count);
        return {status, {room.data(), count < room.size() ? count : room.size()}, count};
    }

    /// Takes back all numbers of an object, for those who cannot wait for the lost pairs of the next step.
    void remove_all(std::uint32_t slot) noexcept {
        if (contacts_ != nullptr) {
            static_cast<void>(trisap_contacts_remove_all(contacts_, slot));
        }
    }

    /// How many pairs have a number.
    [[nodiscard]] std::size_t size() const noexcept { return contacts_ == nullptr ? 0 : trisap_contacts_count(contacts_); }

    /// Becomes a copy, in the memory that there is if that is as long: to go back to a frame with a copy of the world.
    [[nodiscard]] Status copy_from(const Contacts &other) noexcept {
        if (other.contacts_ == nullptr) {
            memory_ = detail::Memory();
            contacts_ = nullptr;
            objects_ = room_ = 0;
            return TRISAP_STATUS_OK;
        }
        const std::size_t bytes = trisap_contacts_size(other.objects_, other.room_);
        if (contacts_ == nullptr || objects_ != other.objects_ || room_ != other.room_) {
            detail::Memory memory = detail::allocate(allocator_, bytes);
            if (memory == nullptr) {
                return detail::refuse(TRISAP_STATUS_MEMORY_TOO_SMALL, bytes);
            }
            memory_ = std::move(memory);
        }
        std::memcpy(memory_.get(), other.contacts_, bytes);
        contacts_ = static_cast<trisap_contacts *>(memory_.get());
        objects_ = other.objects_;
        room_ = other.room_;
        return TRISAP_STATUS_OK;
    }

    /// For the C functions; null before the first update.
    [[nodiscard]] trisap_contacts *c() noexcept { return contacts_; }

    Contacts(Contacts &&other) noexcept
        : allocator_(other.allocator_), memory_(std::move(other.memory_)), contacts_(std::exchange(other.contacts_, nullptr)),
          objects_(std::exchange(other.objects_, 0)), room_(std::exchange(other.room_, 0)) {}

    Contacts &operator=(Contacts &&other) noexcept {
        allocator_ = other.allocator_;
        memory_ = std::move(other.memory_);
        contacts_ = std::exchange(other.contacts_, nullptr);
        objects_ = std::exchange(other.objects_, 0);
        room_ = std::exchange(other.room_, 0);
        return *this;
    }

private:
    [[nodiscard]] Status move_to(std::uint32_t objects, std::uint32_t pairs) noexcept {
        const std::size_t bytes = trisap_contacts_size(objects, pairs);
        detail::Memory memory = detail::allocate(allocator_, bytes);
        if (memory == nullptr) {
            return detail::refuse(TRISAP_STATUS_MEMORY_TOO_SMALL, bytes);
        }
        trisap_contacts *moved = nullptr;
        const Status status = contacts_ == nullptr
                                  ? trisap_contacts_init(memory.get(), bytes, objects, pairs, &moved)
                                  : trisap_contacts_move(contacts_, memory.get(), bytes, objects, pairs, &moved);
        if (status == TRISAP_STATUS_OK) {
            memory_ = std::move(memory);
            contacts_ = moved;
            objects_ = objects;
            room_ = pairs;
        }
        return status;
    }

    Allocator allocator_;
    detail::Memory memory_;
    trisap_contacts *contacts_ = nullptr;
    std::uint32_t objects_ = 0, room_ = 0;
};

} // namespace trisap

#if __cplusplus >= 202002L
template <class T> inline constexpr bool std::ranges::enable_borrowed_range<trisap::View<T>> = true;
template <class T> inline constexpr bool std::ranges::enable_view<trisap::View<T>> = true;
#endif

#endif // TRISAP_HPP
