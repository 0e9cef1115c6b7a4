// Broad-phase collision detection: give it boxes each frame, it gives back every overlapping pair, exactly once.
//
// Generated from the crate trisap-ffi; the manual is ffi/README.md.
//
// What can be seen to be wrong is a status. The rest is the contract of every function:
//
// - A pointer that is not null points to memory of the type, or of the length, that the function says. Input is
//   initialised.
// - What its results point to may be read by any number of threads until the next step or load. Threads that change a world
//   while others are inside are refused as busy, and so are those that look at one that is being changed.
// - Ids are those of this world: the ids of another one are not told apart from them.
// - Nobody else writes to the memory of a world.
// - Callbacks return by no other way than returning: no exception, no longjmp.
//
// Any function that returns a status may refuse its arguments: TRISAP_STATUS_NULL_POINTER, _MISALIGNED, _OVERLAP,
// _INVALID_ARGUMENT for an array that no memory can hold, and _STRUCT_SIZE for a struct that begins with its size. Any that takes
// a world may refuse that: _NOT_A_WORLD, _BUSY, _CORRUPT. What a function says under "Errors" comes besides.
//
// Times are for n living objects.
//
// The order is that of use: a configuration, its size, a world, objects, filters, rest, steps and their results, contacts, queries, the tree
// to look at, other origins, other memory, snapshots.

#ifndef TRISAP_H
#define TRISAP_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
#define TRISAP_NOEXCEPT noexcept
#else
#define TRISAP_NOEXCEPT
#endif
#if defined(__cplusplus) && __cplusplus >= 201703L
#define TRISAP_NODISCARD [[nodiscard]]
#elif defined(__GNUC__)
#define TRISAP_NODISCARD __attribute__((warn_unused_result))
#else
#define TRISAP_NODISCARD
#endif

/// The version of the ABI that this header describes. Libraries with the same ABI version can take each other's place.
#define TRISAP_ABI_VERSION 7

/// Major version of the library that this header belongs to.
#define TRISAP_VERSION_MAJOR 0

/// Minor version of the library that this header belongs to.
#define TRISAP_VERSION_MINOR 1

/// Patch version of the library that this header belongs to.
#define TRISAP_VERSION_PATCH 0

/// Exactly the overlaps of the boxes as given: for `trisap_config::mode`.
#define TRISAP_MODE_EXACT 0

/// The overlaps of the boxes with their margins, a superset that changes less often: for `trisap_config::mode`.
#define TRISAP_MODE_FAT 1

/// Nothing had moved: the pairs stayed.
#define TRISAP_PATH_UNCHANGED 0

/// A world without a tree: every two boxes were tested, or from 33 objects on those along a sorted list.
#define TRISAP_PATH_LISTS 1

/// Few had moved: each mover was tested against the leaves that it reaches, the other pairs stayed.
#define TRISAP_PATH_MOVERS 2

/// Many had moved: all leaves were filled and swept.
#define TRISAP_PATH_FULL 3

/// As full, after new planes for the whole tree.
#define TRISAP_PATH_REBUILT 4

/// Many have moved, but most pairs stay: all leaves were filled and swept for the pairs of moved objects alone, and
/// the other pairs stay.
#define TRISAP_PATH_MOVERS_BY_LEAF 5

/// Unchanged: nothing had moved.
#define TRISAP_REASON_NO_MOVERS 0

/// Lists: the world is for up to 64 objects, or lean, and has no tree.
#define TRISAP_REASON_FEW_OBJECTS 1

/// Movers: few had moved: one object in 13, or fewer if objects have many pairs.
#define TRISAP_REASON_FEW_MOVERS 2

/// Full: more had moved.
#define TRISAP_REASON_MANY_MOVERS 3

/// Movers or full: a test has fixed it.
#define TRISAP_REASON_FIXED 4

/// Full or rebuilt: there were no leaves of a complete step to use again. So it is in the first step, after one with
/// too many pairs or few objects, and after a shift of the origin.
#define TRISAP_REASON_NOTHING_KEPT 5

/// Full or rebuilt: few had moved, but a leaf had no room for one of them.
#define TRISAP_REASON_NO_ROOM 6

/// Rebuilt: the tree had too many leaves or levels.
#define TRISAP_REASON_OUTGROWN 7

/// Rebuilt: three steps in a row had far more work than with new planes.
#define TRISAP_REASON_OUT_OF_BALANCE 8

/// Lists, full or rebuilt: a world had no room in its pair buffer for the overlaps of fat boxes,
/// and also found those of the boxes that it reports. With more room steps are cheaper.
#define TRISAP_REASON_NO_ROOM_FOR_SURPLUS 9

/// A reason that this version of the ABI has no name for.
#define TRISAP_REASON_OTHER UINT32_MAX

/// The classes that there can be.
#define TRISAP_CLASSES 32

/// All pairs of the last step: for `trisap_world_pair_ids`.
#define TRISAP_PAIRS_ALL 0

/// With events, pairs of the last step that the complete step before it did not have: for the same.
#define TRISAP_PAIRS_FOUND 1

/// With events, pairs of the complete step before the last one that the last one does not have: for the same.
#define TRISAP_PAIRS_LOST 2

/// No pair has this number.
#define TRISAP_NO_CONTACT UINT32_MAX

/// A box: for `trisap_region::kind`.
#define TRISAP_REGION_AABB 0

/// A ball: for `trisap_region::kind`.
#define TRISAP_REGION_SPHERE 1

/// The result of a call. After every status but `TRISAP_STATUS_OK` and `TRISAP_STATUS_PAIRS_FULL` the world is as it
/// was before the call.
enum trisap_status
#ifdef __cplusplus
  : int32_t
#endif // __cplusplus
 {
    /// Done.
    TRISAP_STATUS_OK = 0,
    /// A pointer is null that must not be.
    TRISAP_STATUS_NULL_POINTER = 1,
    /// A pointer is not aligned to its type, or the memory of a world not to `trisap_world_align()`.
    TRISAP_STATUS_MISALIGNED = 2,
    /// A `struct_size` is not that of this ABI: the struct was not made by its `trisap_default_...` function, or by
    /// that of another version.
    TRISAP_STATUS_STRUCT_SIZE = 3,
    /// An argument is out of its range.
    TRISAP_STATUS_INVALID_ARGUMENT = 4,
    /// An array reaches into the memory of the world.
    TRISAP_STATUS_OVERLAP = 5,
    /// The memory is shorter than `trisap_world_size()` says.
    TRISAP_STATUS_MEMORY_TOO_SMALL = 6,
    /// The memory holds no world of this ABI version.
    TRISAP_STATUS_NOT_A_WORLD = 7,
    /// The world is inside another call: one of another thread, or the step that has called the job system.
    TRISAP_STATUS_BUSY = 8,
    /// The capacity is beyond what the address space or the width of indices (2^27 objects) allows, or the number of
    /// workers is not 1 to 32. The detail is the most that there can be.
    TRISAP_STATUS_CAPACITY_TOO_LARGE = 9,
    /// A margin is negative, not finite, or its bounds are out of order.
    TRISAP_STATUS_BAD_MARGIN = 10,
    /// More objects than the capacity. The detail says how many would have to fit; for a world that moves and for a
    /// snapshot, slots that have been in use.
    TRISAP_STATUS_OBJECTS_FULL = 11,
    /// A box has NaN in it or a minimum above its maximum. The detail is its position in the batch.
    TRISAP_STATUS_BAD_BOX = 12,
    /// An id names no living object, or comes twice in a batch of removals. The detail is the id.
    TRISAP_STATUS_STALE_ID = 13,
    /// More pairs than the capacity. The step has happened, the result holds the pairs that fit, and the detail says
    /// how many there are. Found and lost pairs are empty; the next complete step tells them relative to the last
    /// complete one. If a world moves or a snapshot is loaded, nothing has happened.
    TRISAP_STATUS_PAIRS_FULL = 14,
    /// Something else has written to the memory of the world.
    TRISAP_STATUS_CORRUPT = 15,
    /// The world was made without `trisap_config::filters`.
    TRISAP_STATUS_NO_FILTERS = 16,
    /// A class is 32 or more. The detail is the class.
    TRISAP_STATUS_BAD_CLASS = 17,
    /// A query has NaN, or an infinity or a negative length where none is allowed, or is of no known kind. The detail
    /// is its position in the batch.
    TRISAP_STATUS_BAD_QUERY = 18,
    /// More answers than there is room for. The detail says how many there are; the room holds as many as fit.
    TRISAP_STATUS_OUTPUT_FULL = 19,
    /// The bytes are no snapshot of a world of this configuration, or have changed since it was taken.
    TRISAP_STATUS_BAD_SNAPSHOT = 20,
    /// The shift of the origin is not finite.
    TRISAP_STATUS_BAD_SHIFT = 21,
    /// Refused for a reason that this version of the ABI has no name for.
    TRISAP_STATUS_OTHER = 22,
    /// The world or the snapshot moves to a configuration that differs in what cannot change. The detail says in
    /// what: 1 mode, 2 whether there are margins, 3 events, 4 filters, 5 the width of slots, 6 values.
    TRISAP_STATUS_OTHER_CONFIG = 23,
    /// The world was made without `trisap_config::values`.
    TRISAP_STATUS_NO_VALUES = 24,
    /// The world was made without `trisap_config::has_margin`.
    TRISAP_STATUS_NO_MARGINS = 25,
    /// The slot already has an object. The detail is its id.
    TRISAP_STATUS_SLOT_TAKEN = 26,
};
#ifndef __cplusplus
typedef int32_t trisap_status;
#endif // __cplusplus

/// Small numbers for pairs, in the caller's memory: whoever keeps something for each pair (a manifold, a sound, damage)
/// keeps it in an array.
///
/// A pair has a number from the step that finds it to the step that loses it; then the number is given again. Contacts
/// stand beside a world with events. They hold no pointers: a copy of their memory, kept beside a copy or a snapshot of
/// the world, gives each pair the same number after going back. One thread at a time may call; there is nothing to free.
typedef struct trisap_contacts trisap_contacts;

/// A world, in the caller's memory. It holds no pointers: a copy of its memory, at any other address of the same
/// alignment, can be opened and goes on as the world would have.
///
/// One thread at a time may change it. Any number may look at it: functions that take it as `const`. Other calls are
/// refused as busy. There is nothing to free.
typedef struct trisap_world trisap_world;

/// An axis-aligned bounding box, closed on all sides: touching boxes overlap. Any unit of length. Infinite bounds are
/// allowed; NaN and a minimum above its maximum are refused.
typedef struct trisap_aabb {
    /// The lowest corner: x, y, z.
    float min[3];
    /// The highest corner: x, y, z.
    float max[3];
} trisap_aabb;

/// What a world is made for. Filled by `trisap_default_config`.
typedef struct trisap_config {
    /// The size of this struct in bytes.
    uint32_t struct_size;
    /// The most living objects. By default the number that the default function was given.
    uint32_t objects;
    /// The most boxes that reach beyond their leaf of the tree. If a scene has more, steps are slower. By default
    /// half of `objects`.
    uint32_t leaf_refs;
    /// The most pairs that a step can return. By default eight an object.
    uint32_t pairs;
    /// `TRISAP_MODE_EXACT` (the default) or `TRISAP_MODE_FAT`.
    uint32_t mode;
    /// 1 if steps tell found and lost pairs; costs memory for a second set of pairs and boxes. By default 0.
    uint32_t events;
    /// 1 if objects have a `trisap_filter`, which says whom they meet; costs 12 bytes an object. By default 0.
    uint32_t filters;
    /// The most workers of a step, 1 to 32, the calling thread included; each costs scratch memory. By default 1.
    uint32_t workers;
    /// 1 if a world for up to 256 objects does without a tree, vectors and scratch memory: for microcontrollers.
    /// Worlds for up to 64 objects always do. By default 0.
    uint32_t lean;
    /// 1 if boxes get a margin, inside which they move at hardly any cost for a step; pays where many objects rest or
    /// move little. By default 0.
    uint32_t has_margin;
    /// The margin as a share of the object's largest side. By default 0.
    float margin_per_extent;
    /// Lower bound of the margin, a length. By default 0.
    float margin_min;
    /// Upper bound of the margin, a length. By default the largest float.
    float margin_max;
    /// 1 if fat boxes stay in use however objects move. By default 0: all are made anew when that costs less than to search for
    /// the objects that leave theirs, and are left unused for some steps where they cost more than they spare. In a fat world it
    /// changes which pairs are told.
    uint32_t fixed_margins;
    /// 1 if objects have a value of 64 bits for the caller's use; costs 8 bytes an object, 16 with events. By default
    /// 0.
    uint32_t values;
    /// 1, the default, if swept boxes are predicted from the motion of each object and hold it for some steps: steps in which
    /// things lie, hang, roll or fly on cost little. Changes no pair; needs no margin; costs 24 bytes an object.
    uint32_t predicted_boxes;
} trisap_config;

/// Called with every refusal, on the thread that is refused, after the call has left the world and before it returns: a place for
/// an assertion, a breakpoint or a line in a log. `text` is good until it returns. Full buffers are among the refusals, but for those
/// of worlds that grow (see `trisap_world_set_growing`), and answers are not: `trisap_world_contains` is never reported.
///
/// If trisap finds a mistake of its own, it is called with `TRISAP_STATUS_OTHER` and a text that names the place in its source, and
/// then the program is aborted.
typedef void (*trisap_report)(void *user, trisap_status status, uint64_t detail, const char *text);

/// Boxes in the caller's memory. Each item has three floats of the minimum and three of the maximum at fixed places.
/// Filled by `trisap_default_boxes`.
typedef struct trisap_boxes {
    /// The size of this struct in bytes.
    uint32_t struct_size;
    /// Bytes from an item's minimum to its maximum, at least 12. By default 12; 16 if corners are padded to four
    /// floats.
    uint32_t max_offset;
    /// The minimum of the first item. Any alignment is right. May be null if `count` is zero.
    const void *first;
    /// Bytes from the minimum of an item to the minimum of the next one, at least `max_offset` + 12. By default 24.
    size_t stride;
    /// How many items there are.
    size_t count;
} trisap_boxes;

/// Names an object while it lives. Opaque except for its slot; never zero. The id of a removed object stays stale
/// when its slot is used again.
typedef uint64_t trisap_id;

/// Whom an object meets. Two objects make a pair if each one's mask has a group of the other, and their classes meet
/// (see `trisap_world_set_classes`). Filled by `trisap_default_filter`.
typedef struct trisap_filter {
    /// The groups that the object is in, one bit each. By default all.
    uint32_t group;
    /// The groups that it meets. By default all.
    uint32_t mask;
    /// Its class, below 32: static, kinematic, dynamic or sensor, for instance. By default 0.
    uint32_t object_class;
} trisap_filter;

/// Two overlapping objects by slot.
typedef struct trisap_pair {
    /// The lower slot.
    uint32_t a;
    /// The higher slot.
    uint32_t b;
} trisap_pair;

/// The caller's job system. Filled by `trisap_default_jobs`; used within the call that it is given to.
typedef struct trisap_jobs {
    /// The size of this struct in bytes.
    uint32_t struct_size;
    /// How many calls of `run` can run at once, the calling thread's own included. With 1, the default, `fork_join` is
    /// never called. Neither is it by the steps of a world whose `workers` are 1: those are for as many at most.
    uint32_t worker_count;
    /// Passed to `fork_join`.
    void *user;
    /// Calls `run(task)` `count` times, at the same time if possible, and returns when all these calls have returned.
    ///
    /// `count` is at least 2, and at most `worker_count`; in a step also at most the world's `workers`. The
    /// calling thread is idle until `fork_join` returns: let it make one of the calls. `name` is a text for profilers. Worlds of less than a few
    /// thousand objects never call, since a step takes less time than sharing it.
    ///
    /// Each call of `run` takes blocks of work until none are left, and the step makes a last call itself. So fewer
    /// calls, more calls, late calls, calls one after another, or none at all give the same result, byte for byte.
    /// `run` never blocks, locks, allocates or calls back, and needs less than 16 KiB of stack.
    ///
    /// Must return only when every call of `run` that has begun or may still begin has returned: `task` is on the
    /// stack of the step. Must order memory as mutexes, joined threads and release-acquire atomics do: what the
    /// calling thread did before comes before every call, and every call before the return. Must not call into the
    /// same world, which is refused as busy, and must not throw. May be null only if `worker_count` is 1.
    void (*fork_join)(void *user, void (*run)(void *task), void *task, uint32_t count, const char *name);
} trisap_jobs;

/// The result of a step. Made by `trisap_default_result`, filled by the step.
///
/// The arrays are in the memory of the world and stay as they are until its next step or `trisap_world_load`:
/// inserting, updating and removing do not touch them. Never null, also if they are empty.
typedef struct trisap_result {
    /// The size of this struct in bytes.
    uint32_t struct_size;
    /// `trisap_world_step_over`: how many objects have kept their boxes because the new ones had NaN in them or a
    /// minimum above its maximum. Unknown, and zero, after `TRISAP_STATUS_PAIRS_FULL`.
    uint32_t rejected_count;
    /// The one of them with the lowest slot, or `TRISAP_NULL_ID`.
    trisap_id first_rejected;
    /// The overlapping pairs, each once, the lower slot first. Their order means nothing, but the same calls give the
    /// same order.
    const struct trisap_pair *pairs;
    /// How many.
    size_t pair_count;
    /// With events: pairs of this step that the last complete step did not have. Other objects in the same slots are
    /// another pair.
    const struct trisap_pair *found;
    /// How many.
    size_t found_count;
    /// With events: pairs of the last complete step that this one does not have. The slot of a removed object may
    /// have a new object by now.
    const struct trisap_pair *lost;
    /// How many.
    size_t lost_count;
    /// How many pairs there are: `pair_count`, or more after `TRISAP_STATUS_PAIRS_FULL`.
    uint64_t pairs_needed;
} trisap_result;

/// A rule of the caller: returns not 0 if the objects in two slots, the lower one first, make a pair.
///
/// Called from any worker at any time during the step, from several at once, and only for boxes that overlap with what is
/// around them (margins, predicted boxes) and that the filters let through. Has to answer the same until one of the
/// objects is given to `trisap_world_refilter`, since pairs of resting objects are not asked about again. Must not call
/// into the same world, which is refused as busy.
typedef uint32_t (*trisap_rule)(void *user, uint32_t a, uint32_t b);

/// Two objects by id.
typedef struct trisap_id_pair {
    /// The object in the lower slot.
    trisap_id a;
    /// The object in the higher slot.
    trisap_id b;
} trisap_id_pair;

/// Two objects by value.
typedef struct trisap_value_pair {
    /// The value of the object in the lower slot.
    uint64_t a;
    /// The value of the object in the higher slot.
    uint64_t b;
} trisap_value_pair;

/// A contact of an object.
typedef struct trisap_contact {
    /// The number.
    uint32_t contact;
    /// The slot of the object's partner.
    uint32_t partner;
} trisap_contact;

/// What a step did and chose. All of it follows from counts, so equal calls give equal statistics on every machine.
/// Made by `trisap_default_stats`.
typedef struct trisap_stats {
    /// The size of this struct in bytes.
    uint32_t struct_size;
    /// How the pairs were found: one of `TRISAP_PATH_...`.
    uint32_t path;
    /// Living objects.
    uint32_t objects;
    /// Objects that were new or gone, or had left their margin (without margins: had another box).
    uint32_t moved;
    /// Leaves of the tree; 1 in a world without one.
    uint32_t leaves;
    /// Leaves that had members when all leaves were last filled. If they are far fewer than `leaves`, the planes do
    /// not fit the scene.
    uint32_t leaves_in_use;
    /// Members of the fullest leaf then. About 500 is usual. Far more means boxes that no plane can part, or a bad
    /// tree.
    uint32_t fullest_leaf;
    /// Large objects: far larger than the leaves that they reach, they are in a list of their own.
    uint32_t large;
    /// Objects whose leaves got new planes.
    uint32_t rebalanced;
    /// Why the pairs were found that way: one of `TRISAP_REASON_...`.
    uint32_t reason;
    /// 1 if leaves are divided into sub-leaves, for steps with few movers.
    uint32_t fine_leaves;
    /// 1 if the work was offered to the workers of the job system.
    uint32_t shared;
    /// How many boxes left their fat boxes since the last complete step, or are others where all fat boxes were
    /// made anew; in a fat world how many left their margins.
    uint32_t outran;
    /// Ghosts: boxes swept in leaves where they are not at home.
    uint64_t copies;
    /// Pairs of boxes that were tested on all axes.
    uint64_t candidates;
    /// Of these, pairs whose sides share a step of the grid, so that the boxes had to decide.
    uint64_t tied;
    /// Overlapping pairs.
    uint64_t pairs;
    /// Pairs that the last complete step did not have.
    uint64_t found;
    /// Pairs that only the last complete step had.
    uint64_t lost;
    /// Overlaps of fat boxes that the test of the boxes dropped.
    uint64_t surplus;
    /// Pairs of boxes in the same leaf that were not compared, since their filters do not meet.
    uint64_t spared;
} trisap_stats;

/// A closed part of space to look for objects: touching counts. Made by `trisap_region_aabb`, `trisap_region_point`
/// or `trisap_region_sphere`.
typedef struct trisap_region {
    /// One of `TRISAP_REGION_...`.
    uint32_t kind;
    /// The radius of a ball, zero or more. An infinite ball holds everything.
    float radius;
    /// The lowest corner of a box; the centre of a ball.
    float min[3];
    /// The highest corner of a box.
    float max[3];
} trisap_region;

/// A box, or a point, that moves along a line. Made by `trisap_cast_ray` or `trisap_cast_swept`.
typedef struct trisap_cast {
    /// Where it starts. For a ray, a box of one point. Finite.
    struct trisap_aabb start;
    /// How it moves in one unit of distance. Finite, of any length; zero tests the start alone.
    float direction[3];
    /// How far it moves, in units of `direction`. Zero or more; may be infinite.
    float distance;
} trisap_cast;

/// Which objects may answer a query; null stands for all. Called with an object that the query has found, and with
/// the query's `user`; returns not 0 if the object may answer. It has to say the same of the same object. It may look
/// at the world, for instance by `trisap_world_meets`; calls that change it are refused as busy. Batches with a job
/// system call it from several threads at once.
typedef uint32_t (*trisap_condition)(void *user, trisap_id id);

/// Called with an object; 0 ends the visit. Calls that change the same world are refused as busy.
typedef uint32_t (*trisap_visit_id)(void *user, trisap_id id);

/// An object that a cast meets, or that is near a point.
typedef struct trisap_hit {
    /// The object.
    trisap_id id;
    /// How far the cast gets before it touches the object's box, in units of its direction; zero if it starts inside.
    /// For the nearest objects: the distance.
    double distance;
} trisap_hit;

/// Called with a hit. Returns how far to look on: infinity to see all, the hit's distance to see only what is not
/// farther, less than zero to stop. Calls that change the same world are refused as busy.
typedef double (*trisap_visit_hit)(void *user, struct trisap_hit hit);

/// How a box lies to a part of space of the caller's own: less than 0 if it is outside, and so is each box inside it; more than 0 if it
/// is inside, and so is each box inside it; 0 if neither is certain: then it counts as touching. Asked about boxes of objects, and
/// about boxes around many. Calls that change the same world are refused as busy.
typedef int32_t (*trisap_side)(void *user, const struct trisap_aabb *aabb);

/// A leaf of the tree.
typedef struct trisap_leaf {
    /// The part of space whose minimum corners are at home in the leaf; infinite at the rim.
    struct trisap_aabb cell;
    /// The objects that were in it at the last step.
    uint32_t objects;
} trisap_leaf;

/// A plane of the tree.
typedef struct trisap_plane {
    /// The part of space that it divides; infinite at the rim.
    struct trisap_aabb cell;
    /// The axis that it divides: 0 for x, 1 for y, 2 for z.
    uint32_t axis;
    /// Its place on that axis.
    float position;
    /// How many planes are above it.
    uint32_t depth;
} trisap_plane;

/// The id of no object.
#define TRISAP_NULL_ID 0

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/// The ABI version of the linked library. If it differs from `TRISAP_ABI_VERSION`, call nothing else. O(1).
TRISAP_NODISCARD uint32_t trisap_abi_version(void) TRISAP_NOEXCEPT;

/// The version of the linked library, as "1.2.3". O(1).
TRISAP_NODISCARD const char *trisap_version(void) TRISAP_NOEXCEPT;

/// The instruction set that steps use on this CPU: "scalar", "avx2", or one of 128 bits: "sse4.1", "neon",
/// "simd128". Only the speed differs. O(1).
TRISAP_NODISCARD const char *trisap_instruction_set(void) TRISAP_NOEXCEPT;

/// The text of a status, in English and without a full stop. Never null, also for numbers that are no status. O(1).
TRISAP_NODISCARD
const char *trisap_status_text(int32_t status)
TRISAP_NOEXCEPT;

/// The least box in `f32` that holds a box in `f64`, seen from `origin`. Minima are rounded down and maxima up, so
/// boxes that overlap in `f64` overlap in `f32` too; nearest rounding would lose pairs far from the origin. All three
/// arguments are three numbers. O(1).
///
/// Keep `origin` near the objects: far from it precision is lost, never a pair. Add a margin of your own to the `f64`
/// box, so that the rounding comes after it.
///
/// If an argument is null, or a number is NaN, the result is a box that every function refuses.
TRISAP_NODISCARD
struct trisap_aabb trisap_aabb_from_f64(const double *min,
                                        const double *max,
                                        const double *origin)
TRISAP_NOEXCEPT;

/// The least box that holds a box in fixed point: integers that count `2^-fraction_bits` each. It takes integer
/// operations alone, and is exact where 24 significant bits suffice, rounded outward beyond. Both corners are three
/// numbers. O(1).
///
/// If an argument is null, or there are more than 126 fraction bits, the result is a box that every function refuses.
TRISAP_NODISCARD
struct trisap_aabb trisap_aabb_from_fixed(const int32_t *min,
                                          const int32_t *max,
                                          uint32_t fraction_bits)
TRISAP_NOEXCEPT;

/// A configuration for `objects` objects with the proportions that suit most scenes: exact pairs, no events, no
/// filters, no values, no margin, one worker. O(1).
TRISAP_NODISCARD
struct trisap_config trisap_default_config(uint32_t objects)
TRISAP_NOEXCEPT;

/// Sets a function that is called with every refusal of a call that returns a status, of all worlds. `user` is passed to
/// it; null ends the reports. Set it before other threads call trisap. O(1).
void trisap_set_report(trisap_report report,
                       void *user)
TRISAP_NOEXCEPT;

/// Has the function of `trisap_set_report` called as for a refusal of the library's own: for covers in other languages,
/// which refuse some things before they call. O(1).
void trisap_refuse(int32_t status,
                   uint64_t detail)
TRISAP_NOEXCEPT;

/// The bytes of memory that a world of this configuration needs. They grow linearly with objects, leaf references and
/// pairs. O(1).
///
/// 0 if there can be no such world: `trisap_world_init` says why.
TRISAP_NODISCARD
size_t trisap_world_size(const struct trisap_config *config)
TRISAP_NOEXCEPT;

/// The alignment of the memory of a world: 64 bytes. O(1).
TRISAP_NODISCARD size_t trisap_world_align(void) TRISAP_NOEXCEPT;

/// Makes an empty world in `memory` and writes where it is, which is `memory` itself, to `world`. O(bytes).
///
/// What was in the memory does not matter, so this also clears a world. Bytes beyond `trisap_world_size()` are not
/// touched. Nothing is allocated, now or later.
///
/// Errors: `TRISAP_STATUS_MEMORY_TOO_SMALL`, `TRISAP_STATUS_INVALID_ARGUMENT`, `TRISAP_STATUS_CAPACITY_TOO_LARGE`,
/// `TRISAP_STATUS_BAD_MARGIN`. Nothing is written then.
TRISAP_NODISCARD
trisap_status trisap_world_init(void *memory,
                                size_t bytes,
                                const struct trisap_config *config,
                                struct trisap_world **world)
TRISAP_NOEXCEPT;

/// What the status of the last refused call was about: see `trisap_status`. 0 for a null or busy world. O(1).
TRISAP_NODISCARD uint64_t trisap_world_error_detail(const struct trisap_world *world) TRISAP_NOEXCEPT;

/// Writes what the world was made for to `config`, which has to have its `struct_size`. O(1).
TRISAP_NODISCARD
trisap_status trisap_world_config(const struct trisap_world *world,
                                  struct trisap_config *config)
TRISAP_NOEXCEPT;

/// A view of boxes one after another. For others, point `first` to the first minimum and set `stride` and
/// `max_offset`. O(1).
TRISAP_NODISCARD
struct trisap_boxes trisap_default_boxes(const struct trisap_aabb *boxes,
                                         size_t count)
TRISAP_NOEXCEPT;

/// The index of an object in pairs and in the boxes of `trisap_world_step_over`. O(1).
TRISAP_NODISCARD uint32_t trisap_id_slot(trisap_id id) TRISAP_NOEXCEPT;

/// Adds an object and writes its id to `id`. Slots are given out in ascending order from 0 until an object is
/// removed. O(1).
///
/// Errors: `TRISAP_STATUS_BAD_BOX`, `TRISAP_STATUS_OBJECTS_FULL`.
TRISAP_NODISCARD
trisap_status trisap_world_insert(struct trisap_world *world,
                                  const struct trisap_aabb *aabb,
                                  trisap_id *id)
TRISAP_NOEXCEPT;

/// Adds an object in a slot that the caller names, so that worlds agree on slots, as those of a server and its clients.
/// O(free slots), and O(slots below) where it is the highest so far.
///
/// Errors: `TRISAP_STATUS_BAD_BOX`, `TRISAP_STATUS_SLOT_TAKEN`, `TRISAP_STATUS_OBJECTS_FULL`. The last one where there is
/// no such slot.
TRISAP_NODISCARD
trisap_status trisap_world_insert_at(struct trisap_world *world,
                                     uint32_t slot,
                                     const struct trisap_aabb *aabb,
                                     trisap_id *id)
TRISAP_NOEXCEPT;

/// Gives an object another box. O(1).
///
/// Errors: `TRISAP_STATUS_STALE_ID`, `TRISAP_STATUS_BAD_BOX`. The object keeps its box then.
TRISAP_NODISCARD
trisap_status trisap_world_update(struct trisap_world *world,
                                  trisap_id id,
                                  const struct trisap_aabb *aabb)
TRISAP_NOEXCEPT;

/// Removes an object. Its id becomes stale, and its pairs are lost at the next step. O(1).
///
/// Errors: `TRISAP_STATUS_STALE_ID`.
TRISAP_NODISCARD trisap_status trisap_world_remove(struct trisap_world *world, trisap_id id) TRISAP_NOEXCEPT;

/// Sets how far an object may move before it counts as moved, in place of the world's margin. It counts as moved
/// once. O(1).
///
/// Errors: `TRISAP_STATUS_STALE_ID`, `TRISAP_STATUS_NO_MARGINS`, `TRISAP_STATUS_BAD_MARGIN`.
TRISAP_NODISCARD
trisap_status trisap_world_set_margin(struct trisap_world *world,
                                      trisap_id id,
                                      float length)
TRISAP_NOEXCEPT;

/// Adds objects, all or none, and writes their ids to `ids`, as many as boxes. O(boxes).
///
/// Errors: `TRISAP_STATUS_BAD_BOX`, `TRISAP_STATUS_OBJECTS_FULL`, `TRISAP_STATUS_INVALID_ARGUMENT`. The last one is
/// about the stride. After the first two the ids are null.
TRISAP_NODISCARD
trisap_status trisap_world_insert_many(struct trisap_world *world,
                                       const struct trisap_boxes *boxes,
                                       trisap_id *ids)
TRISAP_NOEXCEPT;

/// Gives the objects of `ids` other boxes, all or none; as many as boxes. O(boxes).
///
/// Errors: `TRISAP_STATUS_STALE_ID`, `TRISAP_STATUS_BAD_BOX`, `TRISAP_STATUS_INVALID_ARGUMENT`. The last one is about
/// the stride.
TRISAP_NODISCARD
trisap_status trisap_world_update_many(struct trisap_world *world,
                                       const trisap_id *ids,
                                       const struct trisap_boxes *boxes)
TRISAP_NOEXCEPT;

/// As `trisap_world_update_many`, with ids that stand `stride` bytes behind each other: inside of the caller's own
/// items, as their boxes do. O(boxes).
TRISAP_NODISCARD
trisap_status trisap_world_update_strided(struct trisap_world *world,
                                          const trisap_id *ids,
                                          size_t stride,
                                          const struct trisap_boxes *boxes)
TRISAP_NOEXCEPT;

/// Removes objects, all or none. O(ids).
///
/// Errors: `TRISAP_STATUS_STALE_ID`. It is also the status of an id that comes twice.
TRISAP_NODISCARD
trisap_status trisap_world_remove_many(struct trisap_world *world,
                                       const trisap_id *ids,
                                       size_t count)
TRISAP_NOEXCEPT;

/// `TRISAP_STATUS_OK` if `id` names a living object, else `TRISAP_STATUS_STALE_ID`. O(1).
TRISAP_NODISCARD
trisap_status trisap_world_contains(const struct trisap_world *world,
                                    trisap_id id)
TRISAP_NOEXCEPT;

/// Writes the box of an object, as it was given last, to `aabb`. O(1).
///
/// Errors: `TRISAP_STATUS_STALE_ID`.
TRISAP_NODISCARD
trisap_status trisap_world_aabb(const struct trisap_world *world,
                                trisap_id id,
                                struct trisap_aabb *aabb)
TRISAP_NOEXCEPT;

/// Writes the boxes of `count` objects to `aabbs`, as `trisap_world_aabb` does of one. Their ids are `stride` bytes
/// behind each other. After a refusal some may be written. O(n).
///
/// Errors: `TRISAP_STATUS_STALE_ID`.
TRISAP_NODISCARD
trisap_status trisap_world_aabbs(const struct trisap_world *world,
                                 const trisap_id *ids,
                                 size_t stride,
                                 size_t count,
                                 struct trisap_aabb *aabbs)
TRISAP_NOEXCEPT;

/// The object that lives in `slot`, or `TRISAP_NULL_ID`, which is also the answer of a busy world and to misuse:
/// `trisap_world_find` tells them apart. O(1).
TRISAP_NODISCARD
trisap_id trisap_world_id_at(const struct trisap_world *world,
                             uint32_t slot)
TRISAP_NOEXCEPT;

/// As `trisap_world_id_at`, written to `id`. O(1).
TRISAP_NODISCARD
trisap_status trisap_world_find(const struct trisap_world *world,
                                uint32_t slot,
                                trisap_id *id)
TRISAP_NOEXCEPT;

/// Living objects, written to `count`. O(1).
TRISAP_NODISCARD
trisap_status trisap_world_count(const struct trisap_world *world,
                                 uint32_t *count)
TRISAP_NOEXCEPT;

/// 1 if floats are too coarse for some box at its place: a side is shorter than four steps of its coordinate. A box
/// without any side counts only if the world has not even steps enough to tell such boxes apart. The pairs are right for
/// the boxes as given, but the boxes may have lost their shape before; shift the origin. 0 also of a busy world and for
/// misuse. O(slots that have been in use): ask now and then.
TRISAP_NODISCARD
uint32_t trisap_world_is_coarse(const struct trisap_world *world)
TRISAP_NOEXCEPT;

/// Living objects; 0 also of a busy world and for misuse, which `trisap_world_count` tells apart. O(1).
TRISAP_NODISCARD uint32_t trisap_world_len(const struct trisap_world *world) TRISAP_NOEXCEPT;

/// The filter of a new object: in all groups, meets all groups, class 0. O(1).
TRISAP_NODISCARD struct trisap_filter trisap_default_filter(void) TRISAP_NOEXCEPT;

/// Adds an object with its filter, its value and its margin, each of which may be null, and writes its id to `id`. O(1).
///
/// Errors: those of `trisap_world_insert`; with a filter `TRISAP_STATUS_NO_FILTERS` and `TRISAP_STATUS_BAD_CLASS`, with
/// a value `TRISAP_STATUS_NO_VALUES`, with a margin `TRISAP_STATUS_NO_MARGINS` and `TRISAP_STATUS_BAD_MARGIN`. There is
/// no new object then.
TRISAP_NODISCARD
trisap_status trisap_world_insert_with(struct trisap_world *world,
                                       const struct trisap_aabb *aabb,
                                       const struct trisap_filter *filter,
                                       const uint64_t *value,
                                       const float *margin,
                                       trisap_id *id)
TRISAP_NOEXCEPT;

/// Sets whom an object meets. Its pairs follow at the next step. O(1).
///
/// Errors: `TRISAP_STATUS_STALE_ID`, `TRISAP_STATUS_NO_FILTERS`, `TRISAP_STATUS_BAD_CLASS`.
TRISAP_NODISCARD
trisap_status trisap_world_set_filter(struct trisap_world *world,
                                      trisap_id id,
                                      const struct trisap_filter *filter)
TRISAP_NOEXCEPT;

/// Sets whom objects meet, all or none: the filter of `ids[i]` begins `i * stride` bytes behind that of `ids[0]`. With
/// a stride of 0 all get the same one. O(ids).
///
/// Errors: `TRISAP_STATUS_STALE_ID`, `TRISAP_STATUS_NO_FILTERS`, `TRISAP_STATUS_BAD_CLASS`,
/// `TRISAP_STATUS_INVALID_ARGUMENT`. The last one is about a stride that is not 0 and shorter than a filter.
TRISAP_NODISCARD
trisap_status trisap_world_set_filter_many(struct trisap_world *world,
                                           const trisap_id *ids,
                                           const struct trisap_filter *filters,
                                           size_t stride,
                                           size_t count)
TRISAP_NOEXCEPT;

/// Writes whom an object meets to `filter`. O(1).
///
/// Errors: `TRISAP_STATUS_STALE_ID`, `TRISAP_STATUS_NO_FILTERS`.
TRISAP_NODISCARD
trisap_status trisap_world_filter(const struct trisap_world *world,
                                  trisap_id id,
                                  struct trisap_filter *filter)
TRISAP_NOEXCEPT;

/// Sets which classes meet, by `TRISAP_CLASSES` numbers. Two classes `a` and `b` meet if bit `b` of `meets[a]` and
/// bit `a` of `meets[b]` are set. At first all classes meet. The next step looks for all pairs anew. O(n).
///
/// Errors: `TRISAP_STATUS_NO_FILTERS`.
TRISAP_NODISCARD
trisap_status trisap_world_set_classes(struct trisap_world *world,
                                       const uint32_t *meets)
TRISAP_NOEXCEPT;

/// Makes the next step ask about all pairs of an object again, after a `trisap_rule` has changed its answer. O(1).
///
/// Errors: `TRISAP_STATUS_STALE_ID`, `TRISAP_STATUS_NO_FILTERS`.
TRISAP_NODISCARD
trisap_status trisap_world_refilter(struct trisap_world *world,
                                    trisap_id id)
TRISAP_NOEXCEPT;

/// Puts objects to rest, all or none. The next step parks their pairs with each other, and steps ignore their boxes
/// in `trisap_world_step_over`. `trisap_world_update` and `trisap_world_update_many` wake an object. O(ids).
///
/// Errors: `TRISAP_STATUS_STALE_ID`.
TRISAP_NODISCARD
trisap_status trisap_world_set_resting(struct trisap_world *world,
                                       const trisap_id *ids,
                                       size_t count)
TRISAP_NOEXCEPT;

/// Wakes objects, all or none: steps take their boxes from `trisap_world_step_over` again. O(ids).
///
/// Errors: `TRISAP_STATUS_STALE_ID`.
TRISAP_NODISCARD
trisap_status trisap_world_wake(struct trisap_world *world,
                                const trisap_id *ids,
                                size_t count)
TRISAP_NOEXCEPT;

/// Disables objects, or enables them again if `enabled` is not 0; all or none. A disabled object is in no pair and in no answer, and
/// costs a step nothing. It keeps its id, box, margin, filter and value, and can be given others; `trisap_world_step_over` does not
/// read its box. Its pairs are lost at the next step, and found at the next one after it is enabled. It counts as resting
/// until it is woken or gets another box, and is awake when it is enabled. O(ids).
///
/// Errors: `TRISAP_STATUS_STALE_ID`.
TRISAP_NODISCARD
trisap_status trisap_world_set_enabled(struct trisap_world *world,
                                       const trisap_id *ids,
                                       size_t count,
                                       uint32_t enabled)
TRISAP_NOEXCEPT;

/// 1 if the object is enabled, else 0; 0 for misuse and stale ids. O(1).
TRISAP_NODISCARD
uint32_t trisap_world_is_enabled(const struct trisap_world *world,
                                 trisap_id id)
TRISAP_NOEXCEPT;

/// Writes the pairs of the last step with at least one awake object to `pairs`, which has room for `room` of them,
/// and their number to `count`. An object is awake if it was not put to rest, or has been woken since. A narrow phase
/// that keeps the contacts of resting objects needs only these pairs. After `TRISAP_STATUS_OUTPUT_FULL` the room
/// holds as many as fit. O(pairs).
TRISAP_NODISCARD
trisap_status trisap_world_awake_pairs(const struct trisap_world *world,
                                       struct trisap_pair *pairs,
                                       size_t room,
                                       size_t *count)
TRISAP_NOEXCEPT;

/// 1 if the object was put to rest and has not been woken since, else 0; 0 for misuse and stale ids. O(1).
TRISAP_NODISCARD
uint32_t trisap_world_is_resting(const struct trisap_world *world,
                                 trisap_id id)
TRISAP_NOEXCEPT;

/// A job system of one worker, to be filled in. O(1).
TRISAP_NODISCARD struct trisap_jobs trisap_default_jobs(void) TRISAP_NOEXCEPT;

/// An empty result. O(1).
TRISAP_NODISCARD struct trisap_result trisap_default_result(void) TRISAP_NOEXCEPT;

/// Finds all overlapping pairs of the boxes as they are now, and writes them to `result`. `jobs` may be null: then
/// everything happens on the calling thread. Expected O(n + pairs) where objects move, O(movers + pairs) where few do.
///
/// Errors: `TRISAP_STATUS_PAIRS_FULL`, `TRISAP_STATUS_INVALID_ARGUMENT`. After the first one the step has happened, and
/// the result is filled, too. The second one is about a `worker_count` of 0.
TRISAP_NODISCARD
trisap_status trisap_world_step(struct trisap_world *world,
                                const struct trisap_jobs *jobs,
                                struct trisap_result *result)
TRISAP_NOEXCEPT;

/// As `trisap_world_step`, after giving every object the box at its slot in `boxes`, the caller's own array: one
/// pass, no copy, no ids. The fastest way if most objects move.
///
/// Boxes at slots without an object do not matter. Objects beyond the end of the boxes keep theirs, and so do those
/// whose new box is refused: see `trisap_result::rejected_count`.
///
/// Errors: those of `trisap_world_step`; `TRISAP_STATUS_INVALID_ARGUMENT` also for a stride or an offset that boxes
/// cannot have.
TRISAP_NODISCARD
trisap_status trisap_world_step_over(struct trisap_world *world,
                                     const struct trisap_boxes *boxes,
                                     const struct trisap_jobs *jobs,
                                     struct trisap_result *result)
TRISAP_NOEXCEPT;

/// Brings the tree up to date for queries, without a look for pairs: a world that is only asked needs no step, and `config.pairs`
/// can be 0. The pairs and events of the last step stay, and the next one has those that it would have had. Without this, queries
/// look one by one at the objects that have changed since the last step, and at all before the first. Does nothing in worlds
/// without a tree. `jobs` may be null. O(objects that have changed), or O(n) where these are many.
///
/// Errors: `TRISAP_STATUS_INVALID_ARGUMENT` for a `worker_count` of 0.
TRISAP_NODISCARD
trisap_status trisap_world_refresh(struct trisap_world *world,
                                   const struct trisap_jobs *jobs)
TRISAP_NOEXCEPT;

/// As `trisap_world_step_over`, or if `boxes` is null as `trisap_world_step`, with a rule that decides the pairs that
/// the filters let through; `user` is passed to it. If a world has a rule in one step, it should have the same in
/// all.
///
/// Errors: those of `trisap_world_step_over`, and `TRISAP_STATUS_NO_FILTERS`.
TRISAP_NODISCARD
trisap_status trisap_world_step_with_rule(struct trisap_world *world,
                                          const struct trisap_boxes *boxes,
                                          trisap_rule rule,
                                          void *user,
                                          const struct trisap_jobs *jobs,
                                          struct trisap_result *result)
TRISAP_NOEXCEPT;

/// Writes the result of the last step to `result` once more: after `trisap_world_open` or `trisap_world_load`, for
/// instance. `rejected_count` is zero. O(1).
TRISAP_NODISCARD
trisap_status trisap_world_result(struct trisap_world *world,
                                  struct trisap_result *result)
TRISAP_NOEXCEPT;

/// Puts the result of the last step into an order of its own, and writes it to `result`: the pairs that the complete step
/// before had in ascending order, behind them the found ones in ascending order; the lost ones ascend, too. So worlds
/// with the same objects in the same slots give the same bytes, whatever their room, their workers and their past are.
/// After `TRISAP_STATUS_PAIRS_FULL` nothing is sorted. O(pairs log pairs), in place; the next step with
/// few movers looks at all pairs once more.
TRISAP_NODISCARD
trisap_status trisap_world_sort_results(struct trisap_world *world,
                                        struct trisap_result *result)
TRISAP_NOEXCEPT;

/// Writes pairs of the last step by id to `pairs`, which has room for `room`, and how many there are to `count`; `what`
/// is one of `TRISAP_PAIRS_...`. O(pairs).
///
/// Ask after a step, before objects come or go. Then the pairs are in the order of `trisap_result`. Lost pairs have
/// the ids of the objects that were the pair, also if they are gone and others have their slots. Other pairs of
/// objects that were removed since the step are left out.
///
/// Errors: `TRISAP_STATUS_OUTPUT_FULL`, `TRISAP_STATUS_INVALID_ARGUMENT`. After the first one the number is right, and
/// the room holds as many as fit.
TRISAP_NODISCARD
trisap_status trisap_world_pair_ids(const struct trisap_world *world,
                                    uint32_t what,
                                    struct trisap_id_pair *pairs,
                                    size_t room,
                                    size_t *count)
TRISAP_NOEXCEPT;

/// Gives an object a value: an index, a pointer, an entity. A new object has 0. Needs `trisap_config::values`. O(1).
TRISAP_NODISCARD
trisap_status trisap_world_set_value(struct trisap_world *world,
                                     trisap_id id,
                                     uint64_t value)
TRISAP_NOEXCEPT;

/// Gives objects values, all or none: the value of `ids[i]` begins `i * stride` bytes behind that of `ids[0]`. O(n).
TRISAP_NODISCARD
trisap_status trisap_world_set_value_many(struct trisap_world *world,
                                          const trisap_id *ids,
                                          const uint64_t *values,
                                          size_t stride,
                                          size_t count)
TRISAP_NOEXCEPT;

/// Writes the value of an object to `value`. O(1).
TRISAP_NODISCARD
trisap_status trisap_world_value(const struct trisap_world *world,
                                 trisap_id id,
                                 uint64_t *value)
TRISAP_NOEXCEPT;

/// Writes the values of `count` objects to `values`. Their ids are `stride` bytes behind each other, as in the hits
/// of a query. After a refusal some may be written. O(n).
TRISAP_NODISCARD
trisap_status trisap_world_values(const struct trisap_world *world,
                                  const trisap_id *ids,
                                  size_t stride,
                                  size_t count,
                                  uint64_t *values)
TRISAP_NOEXCEPT;

/// Writes pairs of the last step by value to `pairs`, which has room for `room`, and how many there are to `count`:
/// as `trisap_world_pair_ids` does by id, and to be called at the same time. Lost pairs have the values that
/// the objects of the pair had last, also if these were set since the step. After `TRISAP_STATUS_OUTPUT_FULL` the room
/// holds as many as fit. O(pairs).
TRISAP_NODISCARD
trisap_status trisap_world_pair_values(const struct trisap_world *world,
                                       uint32_t what,
                                       struct trisap_value_pair *pairs,
                                       size_t room,
                                       size_t *count)
TRISAP_NOEXCEPT;

/// The bytes of memory for the contacts of a world of so many objects, if there are so many pairs at most: 4 an object and
/// 24 a pair. O(1).
TRISAP_NODISCARD
size_t trisap_contacts_size(uint32_t objects,
                            uint32_t contacts)
TRISAP_NOEXCEPT;

/// Makes room for contacts in `memory`, which starts on a multiple of 4 bytes, and writes where they are, which is `memory`
/// itself, to `made`. What was in the memory does not matter, so this also clears them. O(objects).
///
/// Errors: `TRISAP_STATUS_MEMORY_TOO_SMALL`. Nothing is written then.
TRISAP_NODISCARD
trisap_status trisap_contacts_init(void *memory,
                                   size_t bytes,
                                   uint32_t objects,
                                   uint32_t contacts,
                                   struct trisap_contacts **made)
TRISAP_NOEXCEPT;

/// Goes on with contacts in memory that is a copy of that of others, and writes where they are to `made`. All of it is checked:
/// O(bytes).
///
/// Errors: `TRISAP_STATUS_BAD_SNAPSHOT`, if these are not contacts.
TRISAP_NODISCARD
trisap_status trisap_contacts_open(void *memory,
                                   size_t bytes,
                                   struct trisap_contacts **made)
TRISAP_NOEXCEPT;

/// Writes the same contacts, with the same numbers, to other memory, with room for so many objects and pairs, and where they
/// are to `made`. The old ones stay as they are. O(bytes).
///
/// Errors: `TRISAP_STATUS_MEMORY_TOO_SMALL`; `TRISAP_STATUS_OBJECTS_FULL` or `TRISAP_STATUS_PAIRS_FULL`, if there is not room for what there is.
TRISAP_NODISCARD
trisap_status trisap_contacts_move(const struct trisap_contacts *contacts,
                                   void *memory,
                                   size_t bytes,
                                   uint32_t objects,
                                   uint32_t pairs,
                                   struct trisap_contacts **made)
TRISAP_NOEXCEPT;

/// Takes back the numbers of lost pairs, then gives the found ones numbers: those of a step, which may be used by their slots
/// alone. Writes the number of each lost pair to `ended` and that of each found one to `began`, as far as these are not null;
/// `TRISAP_NO_CONTACT` for a lost pair that had none. A world in which there are pairs already begins with all of them as found
/// ones. O(events), each times the partners of that object of the two which has fewer.
///
/// Errors: `TRISAP_STATUS_OBJECTS_FULL` or `TRISAP_STATUS_PAIRS_FULL`, whose `detail` (if it is not null) is how many would have to fit;
/// `TRISAP_STATUS_INVALID_ARGUMENT` for a pair of one slot. Nothing has changed then: with more room the same events fit. A lost
/// pair that was told twice may leave too little room: then some of the found ones have their numbers.
TRISAP_NODISCARD
trisap_status trisap_contacts_update(struct trisap_contacts *contacts,
                                     const struct trisap_pair *lost,
                                     size_t lost_count,
                                     uint32_t *ended,
                                     const struct trisap_pair *found,
                                     size_t found_count,
                                     uint32_t *began,
                                     uint64_t *detail)
TRISAP_NOEXCEPT;

/// The number of a pair of slots, in any order; `TRISAP_NO_CONTACT` if it has none, and for misuse. O(partners of that object of the
/// two which has fewer).
TRISAP_NODISCARD
uint32_t trisap_contacts_get(const struct trisap_contacts *contacts,
                             uint32_t a,
                             uint32_t b)
TRISAP_NOEXCEPT;

/// Writes the contacts of an object, those found last first, to `found`, which has room for `room`, and how many there are to
/// `count`. O(answers).
///
/// Errors: `TRISAP_STATUS_OUTPUT_FULL`. The number is right then, and the room holds as many as fit.
TRISAP_NODISCARD
trisap_status trisap_contacts_of(const struct trisap_contacts *contacts,
                                 uint32_t slot,
                                 struct trisap_contact *found,
                                 size_t room,
                                 size_t *count)
TRISAP_NOEXCEPT;

/// Takes back all numbers of an object: before it is removed, for those who cannot wait for the lost pairs of the next step. Ask
/// `trisap_contacts_of` which they are. O(answers).
TRISAP_NODISCARD
trisap_status trisap_contacts_remove_all(struct trisap_contacts *contacts,
                                         uint32_t slot)
TRISAP_NOEXCEPT;

/// How many pairs have a number; 0 for misuse. O(1).
TRISAP_NODISCARD size_t trisap_contacts_count(const struct trisap_contacts *contacts) TRISAP_NOEXCEPT;

/// Statistics of no step. O(1).
TRISAP_NODISCARD struct trisap_stats trisap_default_stats(void) TRISAP_NOEXCEPT;

/// Writes what the last step did to `stats`, which has to have its `struct_size`. O(1).
TRISAP_NODISCARD
trisap_status trisap_world_stats(const struct trisap_world *world,
                                 struct trisap_stats *stats)
TRISAP_NOEXCEPT;

/// Checks all invariants of the world, to find out if something else writes to its memory. O(n log n + pairs). A library
/// that was built without the feature `validate`, as the modules for the web are, does not have this function.
///
/// Errors: `TRISAP_STATUS_CORRUPT`. An invariant is broken.
TRISAP_NODISCARD
trisap_status trisap_world_validate(const struct trisap_world *world)
TRISAP_NOEXCEPT;

/// 1 if an object meets whatever has this filter, by groups and classes, else 0; 0 for misuse and stale ids. In a
/// world without filters objects are in all groups and meet all. O(1).
TRISAP_NODISCARD
uint32_t trisap_world_meets(const struct trisap_world *world,
                            trisap_id id,
                            const struct trisap_filter *filter)
TRISAP_NOEXCEPT;

/// A box to look in. For null a region that is refused. O(1).
TRISAP_NODISCARD struct trisap_region trisap_region_aabb(const struct trisap_aabb *aabb) TRISAP_NOEXCEPT;

/// A point to look at, of three numbers. For null a region that is refused. O(1).
TRISAP_NODISCARD struct trisap_region trisap_region_point(const float *position) TRISAP_NOEXCEPT;

/// A ball to look in; its centre is three numbers. For null a region that is refused. O(1).
TRISAP_NODISCARD struct trisap_region trisap_region_sphere(const float *center, float radius) TRISAP_NOEXCEPT;

/// A ray: `origin + t * direction` for `t` from zero to `distance`; both are three numbers. For null a cast that is
/// refused. O(1).
TRISAP_NODISCARD
struct trisap_cast trisap_cast_ray(const float *origin,
                                   const float *direction,
                                   float distance)
TRISAP_NOEXCEPT;

/// A box that moves by `direction`, which is three numbers. For null a cast that is refused. O(1).
TRISAP_NODISCARD
struct trisap_cast trisap_cast_swept(const struct trisap_aabb *start,
                                     const float *direction)
TRISAP_NOEXCEPT;

/// Writes the objects whose boxes overlap a region to `ids`, which has room for `room` of them, by ascending slot,
/// and their number to `count`. Expected O(log n + *a* log *a* + movers since the last step) for *a* answers; O(n) if
/// the last step had no tree.
///
/// Errors: `TRISAP_STATUS_BAD_QUERY`, `TRISAP_STATUS_OUTPUT_FULL`. After the second one the number is right, and `ids`
/// holds some of them.
TRISAP_NODISCARD
trisap_status trisap_world_overlaps(const struct trisap_world *world,
                                    const struct trisap_region *region,
                                    trisap_condition condition,
                                    void *user,
                                    trisap_id *ids,
                                    size_t room,
                                    size_t *count)
TRISAP_NOEXCEPT;

/// Visits the objects whose boxes overlap a region, each once, until the visitor ends it. The same calls give the
/// same order. `user` is passed to the visitor. Expected O(log n + answers + movers since the last step); O(n) if the
/// last step had no tree.
///
/// Errors: `TRISAP_STATUS_BAD_QUERY`.
TRISAP_NODISCARD
trisap_status trisap_world_visit_overlaps(const struct trisap_world *world,
                                          const struct trisap_region *region,
                                          trisap_visit_id visit,
                                          void *user)
TRISAP_NOEXCEPT;

/// Writes the first object that a cast meets to `hit`; of several at one distance the one with the lowest slot; if it
/// meets none, `TRISAP_NULL_ID`. Expected O(leaves on the way and their objects + movers since the last step); O(n)
/// if the last step had no tree.
///
/// Errors: `TRISAP_STATUS_BAD_QUERY`.
TRISAP_NODISCARD
trisap_status trisap_world_first_hit(const struct trisap_world *world,
                                     const struct trisap_cast *cast,
                                     trisap_condition condition,
                                     void *user,
                                     struct trisap_hit *hit)
TRISAP_NOEXCEPT;

/// Writes the objects that a cast meets to `hits`, which has room for `room` of them, the nearest first, equally near
/// ones by ascending slot, and their number to `count`. Expected as `trisap_world_first_hit`, and the sort of the hits.
///
/// Errors: `TRISAP_STATUS_BAD_QUERY`, `TRISAP_STATUS_OUTPUT_FULL`. After the second one the number is right, and `hits`
/// holds some of them.
TRISAP_NODISCARD
trisap_status trisap_world_hits(const struct trisap_world *world,
                                const struct trisap_cast *cast,
                                trisap_condition condition,
                                void *user,
                                struct trisap_hit *hits,
                                size_t room,
                                size_t *count)
TRISAP_NOEXCEPT;

/// Visits the objects that a cast meets, each once, nearer leaves of the tree before farther ones. `user` is handed to
/// the visitor. Expected as `trisap_world_first_hit`.
///
/// Errors: `TRISAP_STATUS_BAD_QUERY`.
TRISAP_NODISCARD
trisap_status trisap_world_visit_hits(const struct trisap_world *world,
                                      const struct trisap_cast *cast,
                                      trisap_visit_hit visit,
                                      void *user)
TRISAP_NOEXCEPT;

/// Visits the objects whose boxes are at most `distance` from a point of three numbers, each once, nearer leaves of the tree
/// before farther ones. `user` is handed to the visitor. A visitor that returns infinity for what it refuses, and for the rest the
/// distance of the shape in the box, has seen the nearest shape. Expected as `trisap_world_nearest`.
///
/// Errors: `TRISAP_STATUS_BAD_QUERY`, also where the distance is NaN or negative.
TRISAP_NODISCARD
trisap_status trisap_world_visit_nearest(const struct trisap_world *world,
                                         const float *position,
                                         double distance,
                                         trisap_visit_hit visit,
                                         void *user)
TRISAP_NOEXCEPT;

/// Writes the objects whose boxes are nearest to a point of three numbers to `hits`, as many as it has room for, the
/// nearest first, equally near ones by ascending slot, and their number to `count`: less than `room` only if there are
/// no more objects. Boxes at infinity come last. Squares of distances are compared, and two of them can have the same
/// root. Expected O(log n + room log room + movers since the last step); O(n log room) where the last step had no tree.
///
/// Errors: `TRISAP_STATUS_BAD_QUERY`.
TRISAP_NODISCARD
trisap_status trisap_world_nearest(const struct trisap_world *world,
                                   const float *position,
                                   trisap_condition condition,
                                   void *user,
                                   struct trisap_hit *hits,
                                   size_t room,
                                   size_t *count)
TRISAP_NOEXCEPT;

/// Writes the objects whose boxes are on the inner side of all of `plane_count` planes, or touch it, to `ids`, which has room for `room`
/// of them, by ascending slot, and their number to `count`: what is in a frustum, for instance. A plane is four numbers: a normal that
/// points outward, and its distance along that. A box is outside if it is wholly beyond one plane, so that near edges and corners some
/// boxes that are not quite inside count. Expected O(objects at the border + answers + movers since the last step).
///
/// Errors: `TRISAP_STATUS_OUTPUT_FULL`. The number is right then, and `ids` holds some of them.
TRISAP_NODISCARD
trisap_status trisap_world_within(const struct trisap_world *world,
                                  const double *planes,
                                  size_t plane_count,
                                  trisap_condition condition,
                                  void *user,
                                  trisap_id *ids,
                                  size_t room,
                                  size_t *count)
TRISAP_NOEXCEPT;

/// Visits the objects whose boxes are inside a part of space of the caller's own or across its border, each once, until the visitor
/// ends it: a capsule, an oriented box. `side_user` is passed to `side`, `user` to the visitor. Objects in nodes that are inside or
/// outside are not asked about. Expected as `trisap_world_within`.
TRISAP_NODISCARD
trisap_status trisap_world_visit_within(const struct trisap_world *world,
                                        trisap_side side,
                                        void *side_user,
                                        trisap_visit_id visit,
                                        void *user)
TRISAP_NOEXCEPT;

/// `trisap_world_first_hit` of each of `count` casts, the next one `stride` bytes behind the one before; as many hits.
/// `jobs` may be null. The time is that of the single queries, divided by the workers.
///
/// Errors: `TRISAP_STATUS_BAD_QUERY`, `TRISAP_STATUS_INVALID_ARGUMENT`. The second one is about a stride or a
/// `worker_count`. The hits, if anything was written to them, are null then.
TRISAP_NODISCARD
trisap_status trisap_world_first_hits(const struct trisap_world *world,
                                      const struct trisap_cast *casts,
                                      size_t stride,
                                      size_t count,
                                      trisap_condition condition,
                                      void *user,
                                      const struct trisap_jobs *jobs,
                                      struct trisap_hit *hits)
TRISAP_NOEXCEPT;

/// `trisap_world_nearest` of each of `count` points of three numbers, the next one `stride` bytes behind the one before. `hits` has
/// room for `room` hits for each: those of point `i` begin at `hits[i * room]`, and end with a null id where there are fewer. `jobs`
/// may be null. The time is that of the single queries, divided by the workers.
///
/// Errors: `TRISAP_STATUS_BAD_QUERY`, `TRISAP_STATUS_INVALID_ARGUMENT`. The hits, if anything was written to them, are null then.
TRISAP_NODISCARD
trisap_status trisap_world_nearest_many(const struct trisap_world *world,
                                        const float *points,
                                        size_t stride,
                                        size_t count,
                                        trisap_condition condition,
                                        void *user,
                                        const struct trisap_jobs *jobs,
                                        struct trisap_hit *hits,
                                        size_t room)
TRISAP_NOEXCEPT;

/// `trisap_world_overlaps` of each of `count` regions, the next one `stride` bytes behind the one before. `ids` has
/// room for `room` ids in all: first come those of the first region, then those of the second one, and so on.
/// `ends[i]` tells where the ids of region `i` end and those of the next region begin. `jobs` may be null. The time is
/// that of the single queries, divided by the workers; twice that if the objects of 32 regions take more than their
/// share of the room.
///
/// Errors: `TRISAP_STATUS_BAD_QUERY`, `TRISAP_STATUS_OUTPUT_FULL`, `TRISAP_STATUS_INVALID_ARGUMENT`. After the second
/// one the ends are right, some of the ids are there, and the detail says how much room all of them need. After the
/// other two the ids are null and the ends zero, if anything was written to them.
TRISAP_NODISCARD
trisap_status trisap_world_overlaps_many(const struct trisap_world *world,
                                         const struct trisap_region *regions,
                                         size_t stride,
                                         size_t count,
                                         trisap_condition condition,
                                         void *user,
                                         const struct trisap_jobs *jobs,
                                         trisap_id *ids,
                                         size_t room,
                                         size_t *ends)
TRISAP_NOEXCEPT;

/// Writes the leaves, from left to right, to `leaves`, which has room for `room` of them, and their number to `count`.
/// `trisap_stats` also counts empty ones that are nowhere. O(leaves).
///
/// Errors: `TRISAP_STATUS_OUTPUT_FULL`. After it the number is right, and the room holds as many as fit.
TRISAP_NODISCARD
trisap_status trisap_world_leaves(const struct trisap_world *world,
                                  struct trisap_leaf *leaves,
                                  size_t room,
                                  size_t *count)
TRISAP_NOEXCEPT;

/// Writes the planes, from the root down, to `planes`, which has room for `room` of them, and their number to `count`.
/// O(leaves log leaves).
///
/// Errors: `TRISAP_STATUS_OUTPUT_FULL`. After it the number is right, and the room holds as many as fit.
TRISAP_NODISCARD
trisap_status trisap_world_planes(const struct trisap_world *world,
                                  struct trisap_plane *planes,
                                  size_t room,
                                  size_t *count)
TRISAP_NOEXCEPT;

/// Writes the large objects, which are in no leaf, to `ids`, which has room for `room` of them, and their number to
/// `count`. O(large objects).
///
/// Errors: `TRISAP_STATUS_OUTPUT_FULL`. After it the number is right, and the room holds as many as fit.
TRISAP_NODISCARD
trisap_status trisap_world_large(const struct trisap_world *world,
                                 trisap_id *ids,
                                 size_t room,
                                 size_t *count)
TRISAP_NOEXCEPT;

/// Moves the origin to a point: subtracts the three numbers `by` from all boxes. Give boxes relative to the new
/// origin from then on. Pairs and events stay right. O(n), and the next step takes as long as the first one.
///
/// If a difference is no `float`, minima are rounded down and maxima up: no pair is lost, but boxes may come to
/// overlap. `rounded`, which may be null, tells how many objects had their boxes rounded; it is zero for shifts by
/// multiples of the finest step of all coordinates.
///
/// Errors: `TRISAP_STATUS_BAD_SHIFT`.
TRISAP_NODISCARD
trisap_status trisap_world_shift_origin(struct trisap_world *world,
                                        const double *by,
                                        uint32_t *rounded)
TRISAP_NOEXCEPT;

/// How many bytes of its memory the world takes: a copy for `trisap_world_open` needs these. 0 for misuse. O(1).
TRISAP_NODISCARD
size_t trisap_world_bytes(const struct trisap_world *world)
TRISAP_NOEXCEPT;

/// Whether full buffers of this world are to be reported: with 1, `TRISAP_STATUS_OBJECTS_FULL` and
/// `TRISAP_STATUS_PAIRS_FULL` are still the statuses, and the function of `trisap_set_report` is not called for them.
/// For those who move the world to more memory then, and call `trisap_refuse` where they cannot. A world that was moved
/// or opened reports everything again. O(1).
TRISAP_NODISCARD
trisap_status trisap_world_set_growing(struct trisap_world *world,
                                       uint32_t growing)
TRISAP_NOEXCEPT;

/// Opens the world in `memory`, a copy of the memory of another one, and writes where it is to `world`. O(1).
///
/// The way to go back, and for copies between programs of the same version on the same kind of machine: copy
/// `trisap_world_bytes(world)` bytes from where the world is to other memory of the same alignment, or back, and open it
/// there. Nothing of the world may run meanwhile. The copy goes on as the world would have, byte for byte. The bytes are
/// not checked; the snapshots of `trisap_world_save` are, and are smaller.
///
/// Errors: `TRISAP_STATUS_MEMORY_TOO_SMALL`, `TRISAP_STATUS_NOT_A_WORLD`.
TRISAP_NODISCARD
trisap_status trisap_world_open(void *memory,
                                size_t bytes,
                                struct trisap_world **world)
TRISAP_NOEXCEPT;

/// Moves a world to other memory and another configuration: larger, or smaller if all fits. Writes where it is, which
/// is `memory` itself, to `world`. The world `from` stays as it is and needs nothing more. O(bytes).
///
/// Everything goes on: ids, boxes, margins, filters, rest, and the last result, so the next step tells what is found
/// and lost since. After `TRISAP_STATUS_PAIRS_FULL` a world can move to where there is room for the pairs; a step
/// there tells events as if there had always been room. Capacities, workers and the margin of new objects may change.
/// The mode, events, filters, values and whether there are margins may not.
///
/// Errors: those of `trisap_world_init`, `TRISAP_STATUS_OTHER_CONFIG`, and `TRISAP_STATUS_OBJECTS_FULL` or
/// `TRISAP_STATUS_PAIRS_FULL` if the world does not fit; the detail of `from` then says how much would have to fit.
/// Nothing has been written to the memory then.
TRISAP_NODISCARD
trisap_status trisap_world_move(const struct trisap_world *from,
                                void *memory,
                                size_t bytes,
                                const struct trisap_config *config,
                                struct trisap_world **world)
TRISAP_NOEXCEPT;

/// The bytes of a snapshot of the world as it is now; 0 for misuse. O(n / 32).
TRISAP_NODISCARD size_t trisap_world_snapshot_size(const struct trisap_world *world) TRISAP_NOEXCEPT;

/// Writes a snapshot of the world to `snapshot`, which has room for `room` bytes, and its length to `bytes`. Any
/// alignment is right. O(n + pairs).
///
/// A snapshot holds no addresses and no scratch memory. It is much smaller than the world, and any world that has
/// room can load it, in any program of the same version, on any machine of the same byte order.
///
/// Errors: `TRISAP_STATUS_OUTPUT_FULL`. Only the length is written then.
TRISAP_NODISCARD
trisap_status trisap_world_save(const struct trisap_world *world,
                                void *snapshot,
                                size_t room,
                                size_t *bytes)
TRISAP_NOEXCEPT;

/// Replaces the world by that of a snapshot, in its own configuration, which may differ as for `trisap_world_move`. The
/// result of its last step comes with it: see `trisap_world_result`. Older results mean nothing any more. O(bytes).
///
/// The next step finds all pairs anew, and tells as events what has changed since the result that was saved. The order
/// of pairs may differ from that of the world that was saved; worlds that load the same snapshot go on alike, byte for
/// byte, if their configurations are the same. To go back within a program, a copy of the memory is faster: see
/// `trisap_world_open`.
///
/// The checksum notices damage, not intent. Forged bytes with a right checksum are refused, or they are a world: each
/// object and each pair of it can be, and the pairs of every step are those of its boxes. The saved result and what the
/// events of the first step compare with are as the bytes say.
///
/// Errors: `TRISAP_STATUS_BAD_SNAPSHOT`; `TRISAP_STATUS_CAPACITY_TOO_LARGE` or `TRISAP_STATUS_BAD_MARGIN` if this library
/// cannot make such a world; `TRISAP_STATUS_OTHER_CONFIG`, `TRISAP_STATUS_OBJECTS_FULL`, `TRISAP_STATUS_PAIRS_FULL`. The
/// world is as it was then.
TRISAP_NODISCARD
trisap_status trisap_world_load(struct trisap_world *world,
                                const void *snapshot,
                                size_t bytes)
TRISAP_NOEXCEPT;

/// All pairs of boxes that overlap, each once, in no order, but the same for the same boxes: of `a`, by their positions, the lower one
/// first; or, where `b` is not null, of a box of `a` and a box of `b`, by their positions in each. `jobs` may be null. O(n log n + pairs).
///
/// `memory` has `*bytes` bytes on a multiple of `trisap_world_align()`, in any state. While they do not suffice, or `memory` is null,
/// the status is `TRISAP_STATUS_MEMORY_TOO_SMALL`, `*bytes` says how many will do for all that is known by then, and nothing is
/// reported: two calls are enough, three where boxes have more than eight pairs each. The pairs stand in the memory, from `*pairs` on.
///
/// Errors: `TRISAP_STATUS_BAD_BOX`, with the position of the box in `*count`, where boxes of `b` count on from those of `a`; `TRISAP_STATUS_CAPACITY_TOO_LARGE` for more than
/// 2^27 boxes or 2^32 pairs.
TRISAP_NODISCARD
trisap_status trisap_pairs(const struct trisap_boxes *a,
                           const struct trisap_boxes *b,
                           const struct trisap_jobs *jobs,
                           void *memory,
                           size_t *bytes,
                           const struct trisap_pair **pairs,
                           size_t *count)
TRISAP_NOEXCEPT;

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* TRISAP_H */

// The library asserts the same on the other side of the border.
#ifdef __cplusplus
#define TRISAP_SIZE(type, size) static_assert(sizeof(type) == (size), #type)
#else
#define TRISAP_SIZE(type, size) _Static_assert(sizeof(type) == (size), #type)
#endif
TRISAP_SIZE(trisap_status, 4);
TRISAP_SIZE(trisap_aabb, 24);
TRISAP_SIZE(trisap_pair, 8);
TRISAP_SIZE(trisap_config, 64);
TRISAP_SIZE(trisap_boxes, 8 + 3 * sizeof(void *));
TRISAP_SIZE(trisap_jobs, 8 + 2 * sizeof(void *));
TRISAP_SIZE(trisap_result, 24 + 6 * sizeof(void *));
TRISAP_SIZE(trisap_stats, 120);
TRISAP_SIZE(trisap_filter, 12);
TRISAP_SIZE(trisap_value_pair, 16);
TRISAP_SIZE(trisap_contact, 8);
TRISAP_SIZE(trisap_region, 32);
TRISAP_SIZE(trisap_cast, 40);
TRISAP_SIZE(trisap_hit, 16);
TRISAP_SIZE(trisap_leaf, 28);
TRISAP_SIZE(trisap_plane, 36);
#undef TRISAP_SIZE
