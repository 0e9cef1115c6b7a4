// Every misuse that can be seen is a status, and disturbs nothing: after each, the world's memory is byte for byte what it
// was, but for the header's note of what was wrong.

#include "check.h"
#include <math.h>
#include <string.h>
#include <trisap.h>

enum { OBJECTS = 20, CAPACITY = 24, PAIRS = 64, HEADER = 64 };

static trisap_world *world;
static trisap_id ids[OBJECTS];
static unsigned char *before;
static size_t bytes;

static trisap_aabb cube(float x) {
    const trisap_aabb aabb = {{x, 0.0f, 0.0f}, {x + 1.0f, 1.0f, 1.0f}};
    return aabb;
}

static void set_up(void) {
    trisap_config config = trisap_default_config(CAPACITY);
    config.pairs = PAIRS;
    config.events = 1;
    config.has_margin = 1;
    config.margin_per_extent = 0.1f;
    bytes = trisap_world_size(&config);
    void *memory = aligned_alloc(trisap_world_align(), bytes);
    before = malloc(bytes);
    CHECK(memory != NULL && before != NULL);
    CHECK_OK(trisap_world_init(memory, bytes, &config, &world));
    trisap_aabb aabbs[OBJECTS];
    for (int i = 0; i < OBJECTS; i++) {
        aabbs[i] = cube(0.75f * (float)i);
    }
    const trisap_boxes boxes = trisap_default_boxes(aabbs, OBJECTS);
    CHECK_OK(trisap_world_insert_many(world, &boxes, ids));
    trisap_result result = trisap_default_result();
    CHECK_OK(trisap_world_step(world, NULL, &result));
    CHECK(result.pair_count == OBJECTS - 1);
}

static void remember(void) { memcpy(before, world, bytes); }

static void check_undisturbed(void) {
    CHECK(memcmp((unsigned char *)world + HEADER, before + HEADER, bytes - HEADER) == 0);
}

// The call is refused with this status, and the world is as before.
#define REFUSED(call, status)                                                                                        \
    do {                                                                                                             \
        remember();                                                                                                  \
        CHECK_STATUS(call, status);                                                                                  \
        check_undisturbed();                                                                                         \
    } while (0)

static void worlds(void) {
    const trisap_aabb aabb = cube(0.0f);
    trisap_id id = 77;
    REFUSED(trisap_world_insert(NULL, &aabb, &id), TRISAP_STATUS_NULL_POINTER);
    trisap_world *askew = (trisap_world *)((unsigned char *)world + 8);
    REFUSED(trisap_world_insert(askew, &aabb, &id), TRISAP_STATUS_MISALIGNED);
    // Inside of the slab, where no header is.
    trisap_world *inside = (trisap_world *)((unsigned char *)world + HEADER);
    REFUSED(trisap_world_insert(inside, &aabb, &id), TRISAP_STATUS_NOT_A_WORLD);
    CHECK(id == 77);
    CHECK(trisap_world_len(NULL) == 0 && trisap_world_len(inside) == 0);
    CHECK(trisap_world_bytes(NULL) == 0 && trisap_world_error_detail(NULL) == 0);
    CHECK(trisap_world_id_at(NULL, 0) == TRISAP_NULL_ID);
    CHECK_STATUS(trisap_world_validate(NULL), TRISAP_STATUS_NULL_POINTER);
    CHECK_STATUS(trisap_world_remove_many(NULL, ids, 1), TRISAP_STATUS_NULL_POINTER);
}

static void configurations(void) {
    unsigned char *memory = aligned_alloc(64, 65536);
    CHECK(memory != NULL);
    memset(memory, 0xa5, 65536);
    trisap_world *made = NULL;
    const trisap_config good = trisap_default_config(8);
    const size_t needed = trisap_world_size(&good);
    CHECK(needed < 65536);

#define CONFIGURED(change, status)                                                                                   \
    do {                                                                                                             \
        trisap_config config = good;                                                                                 \
        config.change;                                                                                               \
        CHECK_STATUS(trisap_world_init(memory, 65536, &config, &made), status);                                      \
    } while (0)
    CONFIGURED(struct_size = 0, TRISAP_STATUS_STRUCT_SIZE);
    CONFIGURED(struct_size++, TRISAP_STATUS_STRUCT_SIZE);
    CONFIGURED(mode = 2, TRISAP_STATUS_INVALID_ARGUMENT);
    CONFIGURED(events = 2, TRISAP_STATUS_INVALID_ARGUMENT);
    CONFIGURED(filters = 2, TRISAP_STATUS_INVALID_ARGUMENT);
    CONFIGURED(has_margin = 2, TRISAP_STATUS_INVALID_ARGUMENT);
    CONFIGURED(fixed_margins = 2, TRISAP_STATUS_INVALID_ARGUMENT);
    CONFIGURED(workers = 0, TRISAP_STATUS_CAPACITY_TOO_LARGE);
    CONFIGURED(workers = 33, TRISAP_STATUS_CAPACITY_TOO_LARGE);
    CONFIGURED(objects = (1u << 27) + 1, TRISAP_STATUS_CAPACITY_TOO_LARGE);
    CONFIGURED(pairs = UINT32_MAX, TRISAP_STATUS_MEMORY_TOO_SMALL);
    CONFIGURED(has_margin = 1; config.margin_min = -1.0f, TRISAP_STATUS_BAD_MARGIN);
    CONFIGURED(has_margin = 1; config.margin_max = NAN, TRISAP_STATUS_BAD_MARGIN);
    CONFIGURED(has_margin = 1; config.margin_per_extent = INFINITY, TRISAP_STATUS_BAD_MARGIN);
#undef CONFIGURED
    CHECK(trisap_world_size(NULL) == 0);
    trisap_config impossible = good;
    impossible.workers = 0;
    CHECK(trisap_world_size(&impossible) == 0);

    CHECK_STATUS(trisap_world_init(NULL, needed, &good, &made), TRISAP_STATUS_NULL_POINTER);
    CHECK_STATUS(trisap_world_init(memory, needed, NULL, &made), TRISAP_STATUS_NULL_POINTER);
    CHECK_STATUS(trisap_world_init(memory, needed, &good, NULL), TRISAP_STATUS_NULL_POINTER);
    CHECK_STATUS(trisap_world_init(memory + 16, needed, &good, &made), TRISAP_STATUS_MISALIGNED);
    CHECK_STATUS(trisap_world_init(memory, needed - 1, &good, &made), TRISAP_STATUS_MEMORY_TOO_SMALL);
    CHECK_STATUS(trisap_world_init(memory, 0, &good, &made), TRISAP_STATUS_MEMORY_TOO_SMALL);
    CHECK_STATUS(trisap_world_init(memory, needed, &good, (trisap_world **)(void *)(memory + 128)),
                 TRISAP_STATUS_OVERLAP);
    CHECK_STATUS(trisap_world_open(memory, needed, &made), TRISAP_STATUS_NOT_A_WORLD);
    CHECK_STATUS(trisap_world_open(memory, 63, &made), TRISAP_STATUS_MEMORY_TOO_SMALL);
    CHECK_STATUS(trisap_world_open(NULL, needed, &made), TRISAP_STATUS_NULL_POINTER);
    // Nothing of all that was written anywhere.
    CHECK(made == NULL);
    for (size_t i = 0; i < 65536; i++) {
        CHECK(memory[i] == 0xa5);
    }

    CHECK_OK(trisap_world_init(memory, needed, &good, &made));
    CHECK(memory[needed] == 0xa5);
    trisap_world *found = NULL;
    CHECK_STATUS(trisap_world_open(memory, needed - 1, &found), TRISAP_STATUS_MEMORY_TOO_SMALL);
    CHECK_STATUS(trisap_world_open(memory, needed, NULL), TRISAP_STATUS_NULL_POINTER);
    CHECK(found == NULL);
    // Written to by others.
    memset(memory + HEADER, 0xff, 64);
    CHECK_STATUS(trisap_world_open(memory, needed, &found), TRISAP_STATUS_CORRUPT);
    CHECK_STATUS(trisap_world_validate(made), TRISAP_STATUS_CORRUPT);
    free(memory);
}

static void boxes(void) {
    trisap_id id = 77;
    trisap_aabb aabb = cube(0.0f);
    REFUSED(trisap_world_insert(world, NULL, &id), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_insert(world, &aabb, NULL), TRISAP_STATUS_NULL_POINTER);
    const trisap_aabb *askew = (const trisap_aabb *)(const void *)((const char *)&aabb + 2);
    REFUSED(trisap_world_insert(world, askew, &id), TRISAP_STATUS_MISALIGNED);
    REFUSED(trisap_world_insert(world, &aabb, (trisap_id *)(void *)world), TRISAP_STATUS_OVERLAP);
    const float bad[] = {NAN, 2.0f, INFINITY};
    for (int k = 0; k < 9; k++) {
        trisap_aabb broken = aabb;
        broken.min[k % 3] = bad[k / 3];
        REFUSED(trisap_world_insert(world, &broken, &id), TRISAP_STATUS_BAD_BOX);
        REFUSED(trisap_world_update(world, ids[5], &broken), TRISAP_STATUS_BAD_BOX);
        broken = aabb;
        broken.max[k % 3] = k < 3 ? NAN : -bad[k / 3];
        REFUSED(trisap_world_update(world, ids[5], &broken), TRISAP_STATUS_BAD_BOX);
    }
    CHECK(id == 77);

    trisap_aabb three[3] = {cube(0.0f), cube(1.0f), cube(2.0f)};
    trisap_boxes view = trisap_default_boxes(three, 3);
    trisap_id three_ids[3] = {1, 2, 3};
    three[2].max[1] = NAN;
    REFUSED(trisap_world_insert_many(world, &view, three_ids), TRISAP_STATUS_BAD_BOX);
    CHECK(trisap_world_error_detail(world) == 2);
    CHECK(three_ids[0] == TRISAP_NULL_ID && three_ids[2] == TRISAP_NULL_ID);
    REFUSED(trisap_world_update_many(world, ids, &view), TRISAP_STATUS_BAD_BOX);
    CHECK(trisap_world_error_detail(world) == 2);
    three[2] = cube(2.0f);

#define VIEWED(change, status)                                                                                       \
    do {                                                                                                             \
        trisap_boxes changed = view;                                                                                 \
        trisap_result result = trisap_default_result();                                                              \
        changed.change;                                                                                              \
        REFUSED(trisap_world_insert_many(world, &changed, three_ids), status);                                       \
        REFUSED(trisap_world_update_many(world, ids, &changed), status);                                             \
        REFUSED(trisap_world_step_over(world, &changed, NULL, &result), status);                                     \
        CHECK(result.pairs == NULL);                                                                                 \
    } while (0)
    three_ids[0] = 1;
    VIEWED(struct_size = 0, TRISAP_STATUS_STRUCT_SIZE);
    VIEWED(first = NULL, TRISAP_STATUS_NULL_POINTER);
    VIEWED(stride = 0, TRISAP_STATUS_INVALID_ARGUMENT);
    VIEWED(stride = 23, TRISAP_STATUS_INVALID_ARGUMENT);
    VIEWED(max_offset = 11, TRISAP_STATUS_INVALID_ARGUMENT);
    VIEWED(max_offset = 13, TRISAP_STATUS_INVALID_ARGUMENT);
    VIEWED(max_offset = UINT32_MAX, TRISAP_STATUS_INVALID_ARGUMENT);
    VIEWED(count = SIZE_MAX, TRISAP_STATUS_INVALID_ARGUMENT);
    VIEWED(count = SIZE_MAX / 24, TRISAP_STATUS_INVALID_ARGUMENT);
    VIEWED(first = world, TRISAP_STATUS_OVERLAP);
    VIEWED(first = (const char *)world - 60, TRISAP_STATUS_OVERLAP);
#undef VIEWED
    CHECK(three_ids[0] == 1);
    REFUSED(trisap_world_insert_many(world, NULL, three_ids), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_insert_many(world, &view, NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_insert_many(world, &view, (trisap_id *)(void *)world), TRISAP_STATUS_OVERLAP);
    trisap_id *askew_ids = (trisap_id *)(void *)((char *)three_ids + 4);
    REFUSED(trisap_world_insert_many(world, &view, askew_ids), TRISAP_STATUS_MISALIGNED);

    // One more than fits: none is added.
    trisap_aabb five[5];
    trisap_id five_ids[5];
    for (int i = 0; i < 5; i++) {
        five[i] = cube(0.0f);
    }
    view = trisap_default_boxes(five, 5);
    REFUSED(trisap_world_insert_many(world, &view, five_ids), TRISAP_STATUS_OBJECTS_FULL);
    CHECK(trisap_world_error_detail(world) == OBJECTS + 5);
    CHECK(trisap_world_len(world) == OBJECTS);
}

static void stale_ids(void) {
    const trisap_aabb aabb = cube(0.0f);
    trisap_aabb out = cube(9.0f);
    // Null, no generation, a slot beyond the capacity, a slot not yet used, another generation.
    const trisap_id bad[] = {TRISAP_NULL_ID, 5, ids[0] + 1000, ids[0] + OBJECTS, ids[0] + (1ull << 32), UINT64_MAX};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        REFUSED(trisap_world_update(world, bad[i], &aabb), TRISAP_STATUS_STALE_ID);
        CHECK(trisap_world_error_detail(world) == bad[i]);
        REFUSED(trisap_world_remove(world, bad[i]), TRISAP_STATUS_STALE_ID);
        REFUSED(trisap_world_set_margin(world, bad[i], 1.0f), TRISAP_STATUS_STALE_ID);
        REFUSED(trisap_world_contains(world, bad[i]), TRISAP_STATUS_STALE_ID);
        REFUSED(trisap_world_aabb(world, bad[i], &out), TRISAP_STATUS_STALE_ID);

        const trisap_aabb three[3] = {cube(0.0f), cube(1.0f), cube(2.0f)};
        const trisap_boxes view = trisap_default_boxes(three, 3);
        const trisap_id mixed[3] = {ids[0], ids[1], bad[i]};
        REFUSED(trisap_world_update_many(world, mixed, &view), TRISAP_STATUS_STALE_ID);
        CHECK(trisap_world_error_detail(world) == bad[i]);
        REFUSED(trisap_world_remove_many(world, mixed, 3), TRISAP_STATUS_STALE_ID);
        CHECK(trisap_world_error_detail(world) == bad[i]);
    }
    CHECK(out.min[0] == 9.0f);
    const trisap_id twice[3] = {ids[0], ids[1], ids[0]};
    REFUSED(trisap_world_remove_many(world, twice, 3), TRISAP_STATUS_STALE_ID);
    REFUSED(trisap_world_remove_many(world, NULL, 1), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_remove_many(world, ids, SIZE_MAX / 2), TRISAP_STATUS_INVALID_ARGUMENT);
    REFUSED(trisap_world_remove_many(world, (trisap_id *)(void *)world, 1), TRISAP_STATUS_OVERLAP);
    REFUSED(trisap_world_aabb(world, ids[0], NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_set_margin(world, ids[0], NAN), TRISAP_STATUS_BAD_MARGIN);
    REFUSED(trisap_world_set_margin(world, ids[0], -1.0f), TRISAP_STATUS_BAD_MARGIN);
    CHECK(trisap_world_id_at(world, UINT32_MAX) == TRISAP_NULL_ID);
}

// What does the work of several calls, or of one for many.
static void together(void) {
    const trisap_aabb aabb = cube(0.0f);
    trisap_aabb bad = aabb, out[2] = {cube(9.0f), cube(9.0f)};
    bad.max[1] = NAN;
    const trisap_filter filter = trisap_default_filter();
    const uint64_t value = 7;
    trisap_id id = 77;
    REFUSED(trisap_world_insert_with(world, NULL, NULL, NULL, NULL, &id), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_insert_with(world, &aabb, NULL, NULL, NULL, NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_insert_with(world, &bad, NULL, NULL, NULL, &id), TRISAP_STATUS_BAD_BOX);
    REFUSED(trisap_world_insert_with(world, &aabb, &filter, NULL, NULL, &id), TRISAP_STATUS_NO_FILTERS);
    REFUSED(trisap_world_insert_with(world, &aabb, NULL, &value, NULL, &id), TRISAP_STATUS_NO_VALUES);
    const float margin = -1.0f;
    REFUSED(trisap_world_insert_with(world, &aabb, NULL, NULL, &margin, &id), TRISAP_STATUS_BAD_MARGIN);
    REFUSED(trisap_world_insert_with(world, &aabb, (const trisap_filter *)(const void *)((const char *)&filter + 1), NULL, NULL, &id),
            TRISAP_STATUS_MISALIGNED);
    REFUSED(trisap_world_insert_with(world, &aabb, NULL, NULL, NULL, (trisap_id *)(void *)world), TRISAP_STATUS_OVERLAP);
    CHECK(id == 77);

    const trisap_aabb two[2] = {aabb, bad};
    const trisap_boxes boxes = trisap_default_boxes(two, 2);
    REFUSED(trisap_world_update_strided(world, ids, sizeof *ids, NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_update_strided(world, NULL, sizeof *ids, &boxes), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_update_strided(world, ids, 12, &boxes), TRISAP_STATUS_MISALIGNED);
    REFUSED(trisap_world_update_strided(world, ids, 4, &boxes), TRISAP_STATUS_INVALID_ARGUMENT);
    REFUSED(trisap_world_update_strided(world, ids, SIZE_MAX / 2 + 1, &boxes), TRISAP_STATUS_INVALID_ARGUMENT);
    REFUSED(trisap_world_update_strided(world, ids, sizeof *ids, &boxes), TRISAP_STATUS_BAD_BOX);
    CHECK(trisap_world_error_detail(world) == 1);
    const trisap_id stale[2] = {ids[0], ids[1] + (1ull << 32)};
    REFUSED(trisap_world_update_strided(world, stale, sizeof *stale, &boxes), TRISAP_STATUS_STALE_ID);
    CHECK(trisap_world_error_detail(world) == stale[1]);

    REFUSED(trisap_world_aabbs(world, NULL, sizeof *ids, 2, out), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_aabbs(world, ids, sizeof *ids, 2, NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_aabbs(world, ids, 12, 2, out), TRISAP_STATUS_MISALIGNED);
    REFUSED(trisap_world_aabbs(world, stale, sizeof *stale, 2, out), TRISAP_STATUS_STALE_ID);
    CHECK(out[1].min[0] == 9.0f);
    CHECK_OK(trisap_world_aabbs(world, ids, 2 * sizeof *ids, 2, out));
    CHECK(out[1].min[0] == 1.5f);
    CHECK_OK(trisap_world_aabbs(world, NULL, 0, 0, NULL));

    uint32_t count = 9;
    REFUSED(trisap_world_count(world, NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_count(NULL, &count), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_find(world, 0, NULL), TRISAP_STATUS_NULL_POINTER);
    CHECK(count == 9);
    CHECK_OK(trisap_world_count(world, &count));
    CHECK(count == OBJECTS);
    CHECK_OK(trisap_world_find(world, 1, &id));
    CHECK(id == ids[1]);
    CHECK_OK(trisap_world_find(world, UINT32_MAX, &id));
    CHECK(id == TRISAP_NULL_ID);
    CHECK_STATUS(trisap_world_set_growing(NULL, 1), TRISAP_STATUS_NULL_POINTER);
}

static void run_no_job(void *user, void (*run)(void *), void *task, uint32_t count, const char *name) {
    (void)user, (void)run, (void)task, (void)count, (void)name;
}

static void steps(void) {
    trisap_result result = trisap_default_result();
    REFUSED(trisap_world_step(world, NULL, NULL), TRISAP_STATUS_NULL_POINTER);
    result.struct_size = 4;
    REFUSED(trisap_world_step(world, NULL, &result), TRISAP_STATUS_STRUCT_SIZE);
    REFUSED(trisap_world_result(world, &result), TRISAP_STATUS_STRUCT_SIZE);
    trisap_stats stats = trisap_default_stats();
    stats.struct_size = 0;
    REFUSED(trisap_world_stats(world, &stats), TRISAP_STATUS_STRUCT_SIZE);
    REFUSED(trisap_world_stats(world, NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_config(world, NULL), TRISAP_STATUS_NULL_POINTER);
    result = trisap_default_result();
    trisap_result *askew = (trisap_result *)(void *)((char *)&result + 4);
    REFUSED(trisap_world_step(world, NULL, askew), TRISAP_STATUS_MISALIGNED);

    trisap_jobs jobs = trisap_default_jobs();
    jobs.worker_count = 4;
    REFUSED(trisap_world_step(world, &jobs, &result), TRISAP_STATUS_NULL_POINTER);
    jobs.fork_join = run_no_job;
    jobs.worker_count = 0;
    REFUSED(trisap_world_step(world, &jobs, &result), TRISAP_STATUS_INVALID_ARGUMENT);
    jobs.worker_count = 4;
    jobs.struct_size++;
    REFUSED(trisap_world_step(world, &jobs, &result), TRISAP_STATUS_STRUCT_SIZE);
    CHECK(result.pairs == NULL);
}

static uint32_t meet_all(void *user, uint32_t a, uint32_t b) {
    (void)user, (void)a, (void)b;
    return 1;
}

static uint32_t accept_all(void *user, trisap_id id) {
    (void)user, (void)id;
    return 1;
}

// In a world without values; and conditions.
static void no_values(void) {
    uint64_t value = 3;
    size_t count = 5;
    trisap_value_pair pair = {1, 2};
    REFUSED(trisap_world_set_value(world, ids[0], 1), TRISAP_STATUS_NO_VALUES);
    REFUSED(trisap_world_set_value_many(world, ids, &value, 0, 3), TRISAP_STATUS_NO_VALUES);
    REFUSED(trisap_world_value(world, ids[0], &value), TRISAP_STATUS_NO_VALUES);
    REFUSED(trisap_world_values(world, ids, sizeof *ids, 1, &value), TRISAP_STATUS_NO_VALUES);
    REFUSED(trisap_world_pair_values(world, TRISAP_PAIRS_ALL, &pair, 1, &count), TRISAP_STATUS_NO_VALUES);
    CHECK(value == 3 && count == 5 && pair.a == 1);
    REFUSED(trisap_world_set_value(world, TRISAP_NULL_ID, 1), TRISAP_STATUS_STALE_ID);
    REFUSED(trisap_world_set_value_many(world, NULL, &value, 0, 3), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_set_value_many(world, ids, &value, 4, 3), TRISAP_STATUS_INVALID_ARGUMENT);
    REFUSED(trisap_world_value(world, ids[0], NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_value(world, ids[0], (uint64_t *)(void *)world), TRISAP_STATUS_OVERLAP);
    REFUSED(trisap_world_values(world, ids, 12, 2, &value), TRISAP_STATUS_MISALIGNED);
    REFUSED(trisap_world_values(world, ids, sizeof *ids, 2, NULL), TRISAP_STATUS_NULL_POINTER);

    const float at[3] = {0.0f, 0.0f, 0.0f};
    trisap_hit hit;
    trisap_id id;
    REFUSED(trisap_world_overlaps(world, NULL, accept_all, NULL, &id, 1, &count), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_nearest(world, at, accept_all, NULL, &hit, 1, NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_first_hits(world, NULL, sizeof(trisap_cast), 1, accept_all, NULL, NULL, &hit),
            TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_awake_pairs(world, NULL, 1, &count), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_awake_pairs(world, NULL, 0, NULL), TRISAP_STATUS_NULL_POINTER);
}

// In a world without filters.
static void no_filters(void) {
    const trisap_filter all = trisap_default_filter();
    trisap_filter out = {1, 2, 3};
    const uint32_t meets[TRISAP_CLASSES] = {0};
    trisap_result result = trisap_default_result();
    REFUSED(trisap_world_set_filter(world, ids[0], &all), TRISAP_STATUS_NO_FILTERS);
    REFUSED(trisap_world_set_filter_many(world, ids, &all, 0, 3), TRISAP_STATUS_NO_FILTERS);
    REFUSED(trisap_world_filter(world, ids[0], &out), TRISAP_STATUS_NO_FILTERS);
    REFUSED(trisap_world_set_classes(world, meets), TRISAP_STATUS_NO_FILTERS);
    REFUSED(trisap_world_refilter(world, ids[0]), TRISAP_STATUS_NO_FILTERS);
    REFUSED(trisap_world_step_with_rule(world, NULL, meet_all, NULL, NULL, &result), TRISAP_STATUS_NO_FILTERS);
    CHECK(out.group == 1 && result.pairs == NULL);
}

// In one with filters, which takes the place of `world` here.
static void filters(void) {
    trisap_world *const other = world;
    unsigned char *const other_before = before;
    const size_t other_bytes = bytes;
    trisap_config config = trisap_default_config(CAPACITY);
    config.filters = 1;
    bytes = trisap_world_size(&config);
    void *memory = aligned_alloc(trisap_world_align(), bytes);
    before = malloc(bytes);
    CHECK(memory != NULL && before != NULL);
    CHECK_OK(trisap_world_init(memory, bytes, &config, &world));
    trisap_id three[3];
    for (int i = 0; i < 3; i++) {
        const trisap_aabb aabb = cube(0.0f);
        CHECK_OK(trisap_world_insert(world, &aabb, &three[i]));
    }

    trisap_filter good[3] = {trisap_default_filter(), trisap_default_filter(), trisap_default_filter()};
    trisap_filter bad = trisap_default_filter(), out = {1, 2, 3};
    bad.object_class = TRISAP_CLASSES;
    const size_t stride = sizeof good[0];
    REFUSED(trisap_world_set_filter(NULL, three[0], good), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_set_filter(world, three[0], NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_set_filter(world, 5, good), TRISAP_STATUS_STALE_ID);
    REFUSED(trisap_world_set_filter(world, three[0], &bad), TRISAP_STATUS_BAD_CLASS);
    CHECK(trisap_world_error_detail(world) == TRISAP_CLASSES);
    const trisap_filter *askew = (const trisap_filter *)(const void *)((const char *)good + 2);
    REFUSED(trisap_world_set_filter(world, three[0], askew), TRISAP_STATUS_MISALIGNED);

    // All or none: what is wrong stands at the end.
    good[0].mask = 0;
    good[2].object_class = UINT32_MAX;
    REFUSED(trisap_world_set_filter_many(world, three, good, stride, 3), TRISAP_STATUS_BAD_CLASS);
    CHECK(trisap_world_error_detail(world) == UINT32_MAX);
    good[2].object_class = 31;
    const trisap_id stale[3] = {three[0], three[1], three[2] + (1ull << 32)};
    REFUSED(trisap_world_set_filter_many(world, stale, good, stride, 3), TRISAP_STATUS_STALE_ID);
    CHECK(trisap_world_error_detail(world) == stale[2]);
    REFUSED(trisap_world_set_filter_many(world, three, NULL, stride, 3), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_set_filter_many(world, NULL, good, stride, 3), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_set_filter_many(world, three, good, 8, 3), TRISAP_STATUS_INVALID_ARGUMENT);
    REFUSED(trisap_world_set_filter_many(world, three, good, 14, 3), TRISAP_STATUS_MISALIGNED);
    REFUSED(trisap_world_set_filter_many(world, three, askew, stride, 3), TRISAP_STATUS_MISALIGNED);
    REFUSED(trisap_world_set_filter_many(world, three, good, SIZE_MAX - 3, 3), TRISAP_STATUS_INVALID_ARGUMENT);
    REFUSED(trisap_world_set_filter_many(world, three, (const trisap_filter *)(const void *)world, stride, 3),
            TRISAP_STATUS_OVERLAP);
    CHECK_OK(trisap_world_set_filter_many(world, three, good, stride, 3));
    CHECK_OK(trisap_world_set_filter_many(world, NULL, NULL, stride, 0));

    REFUSED(trisap_world_filter(world, three[2], NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_filter(world, 5, &out), TRISAP_STATUS_STALE_ID);
    REFUSED(trisap_world_filter(world, three[2], (trisap_filter *)(void *)world), TRISAP_STATUS_OVERLAP);
    CHECK(out.group == 1);
    CHECK_OK(trisap_world_filter(world, three[2], &out));
    CHECK(out.object_class == 31);
    REFUSED(trisap_world_set_classes(world, NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_set_classes(world, (const uint32_t *)(const void *)((const char *)good + 1)),
            TRISAP_STATUS_MISALIGNED);
    REFUSED(trisap_world_set_classes(world, (const uint32_t *)(const void *)world), TRISAP_STATUS_OVERLAP);
    REFUSED(trisap_world_refilter(world, stale[2]), TRISAP_STATUS_STALE_ID);

    trisap_result result = trisap_default_result();
    REFUSED(trisap_world_step_with_rule(world, NULL, NULL, NULL, NULL, &result), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_step_with_rule(world, NULL, meet_all, NULL, NULL, NULL), TRISAP_STATUS_NULL_POINTER);
    trisap_boxes view = trisap_default_boxes(NULL, 0);
    view.struct_size = 0;
    REFUSED(trisap_world_step_with_rule(world, &view, meet_all, NULL, NULL, &result), TRISAP_STATUS_STRUCT_SIZE);
    trisap_jobs jobs = trisap_default_jobs();
    jobs.worker_count = 0;
    REFUSED(trisap_world_step_with_rule(world, NULL, meet_all, NULL, &jobs, &result), TRISAP_STATUS_INVALID_ARGUMENT);
    CHECK(result.pairs == NULL);
    CHECK_OK(trisap_world_step_with_rule(world, NULL, meet_all, NULL, NULL, &result));
    CHECK(result.pair_count == 1);
    free(memory);
    free(before);
    world = other;
    before = other_before;
    bytes = other_bytes;
}

static uint32_t visit_none(void *user, trisap_id id) {
    (void)id;
    *(int *)user += 1;
    return 0;
}

static double visit_no_hit(void *user, trisap_hit hit) {
    (void)hit;
    *(int *)user += 1;
    return -1.0;
}

// A visitor that would change its world is refused, and the visit goes on. It may look.
static uint32_t meddle(void *user, trisap_id id) {
    const trisap_aabb aabb = cube(0.0f);
    trisap_result result = trisap_default_result();
    trisap_id out = 0;
    size_t count = 77;
    CHECK_STATUS(trisap_world_update(world, id, &aabb), TRISAP_STATUS_BUSY);
    CHECK_STATUS(trisap_world_remove(world, id), TRISAP_STATUS_BUSY);
    CHECK_STATUS(trisap_world_step(world, NULL, &result), TRISAP_STATUS_BUSY);
    CHECK_STATUS(trisap_world_set_resting(world, &id, 1), TRISAP_STATUS_BUSY);
    CHECK_STATUS(trisap_world_refresh(world, NULL), TRISAP_STATUS_BUSY);
    CHECK_STATUS(trisap_world_load(world, &id, 8), TRISAP_STATUS_BUSY);
    CHECK_OK(trisap_world_large(world, &out, 1, &count));
    CHECK(trisap_world_len(world) > 0 && trisap_world_snapshot_size(world) > 0 && count == 0);
    *(int *)user += 1;
    return 1;
}

static struct {
    int count;
    trisap_status status;
    uint64_t detail;
    uint32_t objects;
} reported;

static void note(void *user, trisap_status status, uint64_t detail, const char *text) {
    CHECK(user == &reported && text == trisap_status_text(status));
    reported.count++;
    reported.status = status;
    reported.detail = detail;
    // The call has left the world.
    reported.objects = trisap_world_len(world);
}

// Refusals are reported to a hook, and answers are not.
static void reports(trisap_id living, trisap_id gone) {
    trisap_set_report(note, &reported);
    const trisap_aabb aabb = cube(0.0f);
    CHECK_OK(trisap_world_contains(world, living));
    CHECK_STATUS(trisap_world_contains(world, gone), TRISAP_STATUS_STALE_ID);
    CHECK(reported.count == 0);
    CHECK_STATUS(trisap_world_update(world, gone, &aabb), TRISAP_STATUS_STALE_ID);
    CHECK(reported.count == 1 && reported.status == TRISAP_STATUS_STALE_ID && reported.detail == gone);
    CHECK(reported.objects > 0);
    CHECK_STATUS(trisap_world_init(NULL, 0, NULL, NULL), TRISAP_STATUS_NULL_POINTER);
    CHECK(reported.count == 2 && reported.status == TRISAP_STATUS_NULL_POINTER);
    // Full buffers of a world that somebody will move are not, and all else is.
    trisap_aabb many[CAPACITY];
    trisap_id many_ids[CAPACITY];
    for (int i = 0; i < CAPACITY; i++) {
        many[i] = aabb;
    }
    const trisap_boxes boxes = trisap_default_boxes(many, CAPACITY);
    CHECK_OK(trisap_world_set_growing(world, 1));
    CHECK_STATUS(trisap_world_insert_many(world, &boxes, many_ids), TRISAP_STATUS_OBJECTS_FULL);
    CHECK(reported.count == 2);
    CHECK_STATUS(trisap_world_update(world, gone, &aabb), TRISAP_STATUS_STALE_ID);
    CHECK(reported.count == 3);
    CHECK_OK(trisap_world_set_growing(world, 0));
    CHECK_STATUS(trisap_world_insert_many(world, &boxes, many_ids), TRISAP_STATUS_OBJECTS_FULL);
    CHECK(reported.count == 4 && reported.status == TRISAP_STATUS_OBJECTS_FULL && reported.detail == OBJECTS + CAPACITY);
    // Those of a cover in another language.
    trisap_refuse(TRISAP_STATUS_BAD_BOX, 5);
    CHECK(reported.count == 5 && reported.status == TRISAP_STATUS_BAD_BOX && reported.detail == 5);
    trisap_set_report(NULL, NULL);
    CHECK_STATUS(trisap_world_update(world, gone, &aabb), TRISAP_STATUS_STALE_ID);
    CHECK(reported.count == 5);
}

static void regions(void) {
    const trisap_aabb aabb = cube(0.0f);
    const trisap_region good = trisap_region_aabb(&aabb);
    trisap_id out[CAPACITY] = {77};
    size_t count = 77;
    int visits = 0;
    const float center[3] = {0.0f, 0.0f, 0.0f};
    trisap_region bad[7] = {trisap_region_aabb(NULL), trisap_region_point(NULL), trisap_region_sphere(NULL, 1.0f),
                            trisap_region_sphere(center, -1.0f), trisap_region_sphere(center, NAN), good, good};
    bad[5].kind = 7;
    bad[6].min[1] = 2.0f;
    for (int i = 0; i < 7; i++) {
        REFUSED(trisap_world_overlaps(world, &bad[i], NULL, NULL, out, CAPACITY, &count), TRISAP_STATUS_BAD_QUERY);
        REFUSED(trisap_world_visit_overlaps(world, &bad[i], visit_none, &visits), TRISAP_STATUS_BAD_QUERY);
    }
    REFUSED(trisap_world_overlaps(NULL, &good, NULL, NULL, out, CAPACITY, &count), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_overlaps(world, NULL, NULL, NULL, out, CAPACITY, &count), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_overlaps(world, &good, NULL, NULL, NULL, 1, &count), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_overlaps(world, &good, NULL, NULL, out, CAPACITY, NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_overlaps(world, &good, NULL, NULL, (trisap_id *)(void *)world, 1, &count),
            TRISAP_STATUS_OVERLAP);
    REFUSED(trisap_world_overlaps(world, &good, NULL, NULL, out, 1, (size_t *)(void *)world), TRISAP_STATUS_OVERLAP);
    REFUSED(trisap_world_overlaps(world, &good, NULL, NULL, out, SIZE_MAX / 4, &count), TRISAP_STATUS_INVALID_ARGUMENT);
    trisap_id *askew = (trisap_id *)(void *)((char *)out + 4);
    REFUSED(trisap_world_overlaps(world, &good, NULL, NULL, askew, 1, &count), TRISAP_STATUS_MISALIGNED);
    REFUSED(trisap_world_visit_overlaps(world, &good, NULL, &visits), TRISAP_STATUS_NULL_POINTER);
    CHECK(out[0] == 77 && count == 77 && visits == 0);
    // Nothing but the number.
    REFUSED(trisap_world_overlaps(world, &good, NULL, NULL, NULL, 0, &count), TRISAP_STATUS_OUTPUT_FULL);
    CHECK(count == 2 && trisap_world_error_detail(world) == 2);
    REFUSED(trisap_world_visit_overlaps(world, &good, visit_none, &visits), TRISAP_STATUS_OK);
    CHECK(visits == 1);
    REFUSED(trisap_world_visit_overlaps(world, &good, meddle, &visits), TRISAP_STATUS_OK);
    CHECK(visits == 3);
    REFUSED(trisap_world_overlaps(world, &good, meddle, &visits, out, CAPACITY, &count), TRISAP_STATUS_OK);
    CHECK(visits == 5);

    // In a batch the position is told, and what there was to be written is null.
    trisap_region batch[3] = {good, good, good};
    size_t ends[3] = {77, 77, 77};
    const size_t stride = sizeof good;
#define BATCH(...) trisap_world_overlaps_many(world, __VA_ARGS__)
    REFUSED(BATCH(NULL, stride, 3, NULL, NULL, NULL, out, 4, ends), TRISAP_STATUS_NULL_POINTER);
    REFUSED(BATCH(batch, stride, 3, NULL, NULL, NULL, NULL, 4, ends), TRISAP_STATUS_NULL_POINTER);
    REFUSED(BATCH(batch, stride, 3, NULL, NULL, NULL, out, 4, NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(BATCH(batch, 31, 3, NULL, NULL, NULL, out, 4, ends), TRISAP_STATUS_INVALID_ARGUMENT);
    REFUSED(BATCH(batch, 33, 3, NULL, NULL, NULL, out, 4, ends), TRISAP_STATUS_MISALIGNED);
    REFUSED(BATCH(batch, stride, SIZE_MAX / 8, NULL, NULL, NULL, out, 4, ends), TRISAP_STATUS_INVALID_ARGUMENT);
    REFUSED(BATCH(batch, stride, 3, NULL, NULL, NULL, out, SIZE_MAX / 2, ends), TRISAP_STATUS_INVALID_ARGUMENT);
    REFUSED(BATCH((const trisap_region *)(const void *)world, stride, 3, NULL, NULL, NULL, out, 4, ends),
            TRISAP_STATUS_OVERLAP);
    trisap_jobs jobs = trisap_default_jobs();
    jobs.worker_count = 0;
    REFUSED(BATCH(batch, stride, 3, NULL, NULL, &jobs, out, 4, ends), TRISAP_STATUS_INVALID_ARGUMENT);
    CHECK(ends[0] == 77);
    batch[2] = bad[5];
    REFUSED(BATCH(batch, stride, 3, NULL, NULL, NULL, out, 4, ends), TRISAP_STATUS_BAD_QUERY);
    CHECK(trisap_world_error_detail(world) == 2 && ends[0] == 0 && out[0] == TRISAP_NULL_ID);
    batch[2] = bad[4];
    REFUSED(BATCH(batch, stride, 3, NULL, NULL, NULL, out, 4, ends), TRISAP_STATUS_BAD_QUERY);
    CHECK(trisap_world_error_detail(world) == 2);
    REFUSED(BATCH(batch, stride, 2, NULL, NULL, NULL, out, 3, ends), TRISAP_STATUS_OUTPUT_FULL);
    CHECK(trisap_world_error_detail(world) == 4 && ends[0] == 2 && ends[1] == 4);
    REFUSED(BATCH(batch, stride, 2, NULL, NULL, NULL, NULL, 0, ends), TRISAP_STATUS_OUTPUT_FULL);
    REFUSED(BATCH(batch, stride, 2, NULL, NULL, NULL, out, 4, ends), TRISAP_STATUS_OK);
    CHECK(out[0] == ids[0] && out[1] == ids[1] && out[2] == ids[0] && out[3] == ids[1]);
    REFUSED(BATCH(NULL, stride, 0, NULL, NULL, NULL, NULL, 9, NULL), TRISAP_STATUS_OK);
#undef BATCH
}

static int32_t is_across(void *user, const trisap_aabb *aabb) {
    *(int *)user += aabb->min[0] <= aabb->max[0];
    return 0;
}

static void volumes(void) {
    const double planes[4] = {1.0, 0.0, 0.0, -INFINITY};
    trisap_id out[CAPACITY] = {77};
    size_t count = 77;
    int asked = 0, visits = 0;
    const double *inside = (const double *)(const void *)world;
    REFUSED(trisap_world_within(world, NULL, 1, NULL, NULL, out, CAPACITY, &count), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_within(world, planes, 1, NULL, NULL, NULL, CAPACITY, &count), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_within(world, planes, 1, NULL, NULL, out, CAPACITY, NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_within(world, planes, SIZE_MAX / 8, NULL, NULL, out, 1, &count), TRISAP_STATUS_INVALID_ARGUMENT);
    REFUSED(trisap_world_within(world, inside, 1, NULL, NULL, out, 1, &count), TRISAP_STATUS_OVERLAP);
    CHECK(out[0] == 77 && count == 77);
    REFUSED(trisap_world_within(world, NULL, 0, NULL, NULL, out, 3, &count), TRISAP_STATUS_OUTPUT_FULL);
    CHECK(count == OBJECTS && trisap_world_error_detail(world) == OBJECTS);
    REFUSED(trisap_world_within(world, planes, 1, NULL, NULL, NULL, 0, &count), TRISAP_STATUS_OK);
    CHECK(count == 0);

    REFUSED(trisap_world_visit_within(world, NULL, NULL, meddle, &visits), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_visit_within(world, is_across, &asked, NULL, NULL), TRISAP_STATUS_NULL_POINTER);
    CHECK(asked == 0 && visits == 0);
    REFUSED(trisap_world_visit_within(world, is_across, &asked, meddle, &visits), TRISAP_STATUS_OK);
    CHECK(asked >= OBJECTS && visits == OBJECTS);
}

static void nearest_many(void) {
    float points[9] = {-1.0f, 0.5f, 0.5f, 4.0f, 0.5f, 0.5f, NAN, 0.0f, 0.0f};
    const size_t stride = 3 * sizeof(float);
    trisap_hit out[6] = {{77, 7.0}};
#define BATCH(...) trisap_world_nearest_many(world, __VA_ARGS__)
    REFUSED(BATCH(NULL, stride, 2, NULL, NULL, NULL, out, 2), TRISAP_STATUS_NULL_POINTER);
    REFUSED(BATCH(points, stride, 2, NULL, NULL, NULL, NULL, 2), TRISAP_STATUS_NULL_POINTER);
    REFUSED(BATCH(points, 8, 2, NULL, NULL, NULL, out, 2), TRISAP_STATUS_INVALID_ARGUMENT);
    REFUSED(BATCH(points, 14, 2, NULL, NULL, NULL, out, 2), TRISAP_STATUS_MISALIGNED);
    REFUSED(BATCH(points, stride, SIZE_MAX / 8, NULL, NULL, NULL, out, 2), TRISAP_STATUS_INVALID_ARGUMENT);
    REFUSED(BATCH(points, stride, 2, NULL, NULL, NULL, out, SIZE_MAX), TRISAP_STATUS_INVALID_ARGUMENT);
    REFUSED(BATCH(points, stride, 2, NULL, NULL, NULL, (trisap_hit *)(void *)world, 2), TRISAP_STATUS_OVERLAP);
    trisap_jobs jobs = trisap_default_jobs();
    jobs.worker_count = 0;
    REFUSED(BATCH(points, stride, 2, NULL, NULL, &jobs, out, 2), TRISAP_STATUS_INVALID_ARGUMENT);
    CHECK(out[0].id == 77);
    REFUSED(BATCH(points, stride, 3, NULL, NULL, NULL, out, 2), TRISAP_STATUS_BAD_QUERY);
    CHECK(trisap_world_error_detail(world) == 2 && out[0].id == TRISAP_NULL_ID && out[5].id == TRISAP_NULL_ID);
    REFUSED(BATCH(points, stride, 2, NULL, NULL, NULL, out, 2), TRISAP_STATUS_OK);
    CHECK(out[0].id == ids[0] && out[0].distance == 1.0 && out[2].distance == 0.0);
    REFUSED(BATCH(points, stride, 2, NULL, NULL, NULL, NULL, 0), TRISAP_STATUS_OK);
    REFUSED(BATCH(NULL, stride, 0, NULL, NULL, NULL, NULL, 9), TRISAP_STATUS_OK);
#undef BATCH
}

static void casts(void) {
    const float origin[3] = {-1.0f, 0.5f, 0.5f}, direction[3] = {1.0f, 0.0f, 0.0f};
    const trisap_cast good = trisap_cast_ray(origin, direction, INFINITY);
    const trisap_aabb aabb = cube(0.0f);
    trisap_hit out[CAPACITY] = {{77, 7.0}};
    size_t count = 77;
    int visits = 0;
    trisap_cast bad[7] = {trisap_cast_ray(NULL, direction, 1.0f), trisap_cast_ray(origin, NULL, 1.0f),
                          trisap_cast_ray(origin, direction, -1.0f), trisap_cast_ray(origin, direction, NAN),
                          trisap_cast_swept(NULL, direction), trisap_cast_swept(&aabb, NULL), good};
    bad[6].start.min[2] = -INFINITY;
    for (int i = 0; i < 7; i++) {
        REFUSED(trisap_world_first_hit(world, &bad[i], NULL, NULL, out), TRISAP_STATUS_BAD_QUERY);
        REFUSED(trisap_world_hits(world, &bad[i], NULL, NULL, out, CAPACITY, &count), TRISAP_STATUS_BAD_QUERY);
        REFUSED(trisap_world_visit_hits(world, &bad[i], visit_no_hit, &visits), TRISAP_STATUS_BAD_QUERY);
    }
    REFUSED(trisap_world_first_hit(world, NULL, NULL, NULL, out), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_first_hit(world, &good, NULL, NULL, NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_first_hit(world, &good, NULL, NULL, (trisap_hit *)(void *)world), TRISAP_STATUS_OVERLAP);
    REFUSED(trisap_world_hits(world, NULL, NULL, NULL, out, CAPACITY, &count), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_hits(world, &good, NULL, NULL, NULL, CAPACITY, &count), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_hits(world, &good, NULL, NULL, out, CAPACITY, NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_visit_hits(world, &good, NULL, NULL), TRISAP_STATUS_NULL_POINTER);
    CHECK(out[0].id == 77 && count == 77 && visits == 0);
    REFUSED(trisap_world_hits(world, &good, NULL, NULL, out, 3, &count), TRISAP_STATUS_OUTPUT_FULL);
    CHECK(count == OBJECTS);
    REFUSED(trisap_world_visit_hits(world, &good, visit_no_hit, &visits), TRISAP_STATUS_OK);
    CHECK(visits == 1);

    const float nowhere[3] = {NAN, 0.0f, 0.0f}, far_away[3] = {0.0f, INFINITY, 0.0f};
    REFUSED(trisap_world_nearest(world, nowhere, NULL, NULL, out, 1, &count), TRISAP_STATUS_BAD_QUERY);
    REFUSED(trisap_world_nearest(world, far_away, NULL, NULL, out, 1, &count), TRISAP_STATUS_BAD_QUERY);
    REFUSED(trisap_world_nearest(world, NULL, NULL, NULL, out, 1, &count), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_nearest(world, origin, NULL, NULL, NULL, 1, &count), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_nearest(world, origin, NULL, NULL, out, 1, NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_nearest(world, origin, NULL, NULL, (trisap_hit *)(void *)world, 1, &count),
            TRISAP_STATUS_OVERLAP);
    REFUSED(trisap_world_nearest(world, origin, NULL, NULL, NULL, 0, &count), TRISAP_STATUS_OK);
    CHECK(count == 0);
    visits = 0;
    REFUSED(trisap_world_visit_nearest(world, nowhere, 1.0, visit_no_hit, &visits), TRISAP_STATUS_BAD_QUERY);
    REFUSED(trisap_world_visit_nearest(world, origin, NAN, visit_no_hit, &visits), TRISAP_STATUS_BAD_QUERY);
    REFUSED(trisap_world_visit_nearest(world, origin, -1.0, visit_no_hit, &visits), TRISAP_STATUS_BAD_QUERY);
    REFUSED(trisap_world_visit_nearest(world, NULL, 1.0, visit_no_hit, &visits), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_visit_nearest(world, origin, 1.0, NULL, NULL), TRISAP_STATUS_NULL_POINTER);
    CHECK(visits == 0);
    REFUSED(trisap_world_visit_nearest(world, origin, INFINITY, visit_no_hit, &visits), TRISAP_STATUS_OK);
    CHECK(visits == 1);

    trisap_cast batch[3] = {good, good, bad[0]};
    const size_t stride = sizeof good;
    out[0].id = 77;
    REFUSED(trisap_world_first_hits(world, NULL, stride, 3, NULL, NULL, NULL, out), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_first_hits(world, batch, stride, 3, NULL, NULL, NULL, NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_first_hits(world, batch, 36, 3, NULL, NULL, NULL, out), TRISAP_STATUS_INVALID_ARGUMENT);
    REFUSED(trisap_world_first_hits(world, batch, 42, 3, NULL, NULL, NULL, out), TRISAP_STATUS_MISALIGNED);
    REFUSED(trisap_world_first_hits(world, batch, stride, 3, NULL, NULL, NULL, (trisap_hit *)(void *)world),
            TRISAP_STATUS_OVERLAP);
    CHECK(out[0].id == 77);
    REFUSED(trisap_world_first_hits(world, batch, stride, 3, NULL, NULL, NULL, out), TRISAP_STATUS_BAD_QUERY);
    CHECK(trisap_world_error_detail(world) == 2 && out[0].id == TRISAP_NULL_ID && out[1].id == TRISAP_NULL_ID);
    REFUSED(trisap_world_first_hits(world, batch, stride, 2, NULL, NULL, NULL, out), TRISAP_STATUS_OK);
    CHECK(out[1].id == ids[0] && out[1].distance == 1.0);
}

static void resting(void) {
    const trisap_id stale[2] = {ids[0], 5};
    REFUSED(trisap_world_set_resting(world, stale, 2), TRISAP_STATUS_STALE_ID);
    REFUSED(trisap_world_set_enabled(world, stale, 2, 0), TRISAP_STATUS_STALE_ID);
    REFUSED(trisap_world_wake(world, stale, 2), TRISAP_STATUS_STALE_ID);
    const double endless[3] = {0.0, 0.0, (double)INFINITY};
    REFUSED(trisap_world_shift_origin(world, endless, NULL), TRISAP_STATUS_BAD_SHIFT);
    REFUSED(trisap_world_shift_origin(world, NULL, NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_shift_origin(world, endless, (uint32_t *)(void *)world), TRISAP_STATUS_OVERLAP);
    REFUSED(trisap_world_set_resting(world, NULL, 2), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_set_enabled(world, NULL, 2, 0), TRISAP_STATUS_NULL_POINTER);
    CHECK(trisap_world_is_enabled(world, ids[0]) == 1 && trisap_world_is_enabled(world, 5) == 0);
    CHECK(trisap_world_is_enabled(NULL, ids[0]) == 0);
    REFUSED(trisap_world_wake(world, (const trisap_id *)(const void *)world, 2), TRISAP_STATUS_OVERLAP);
    CHECK(trisap_world_is_resting(world, ids[0]) == 0 && trisap_world_is_resting(world, 5) == 0);
    CHECK(trisap_world_is_resting(NULL, ids[0]) == 0);
}

static void views(void) {
    size_t count = 77;
    trisap_leaf leaf;
    REFUSED(trisap_world_leaves(world, NULL, 1, &count), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_leaves(world, &leaf, 1, NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_planes(world, NULL, 1, &count), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_large(world, (trisap_id *)(void *)world, 1, &count), TRISAP_STATUS_OVERLAP);
    CHECK(count == 77);
    // There is no tree.
    REFUSED(trisap_world_leaves(world, NULL, 0, &count), TRISAP_STATUS_OK);
    CHECK(count == 0);
}

static uint64_t mixed(uint64_t sum, uint64_t word) {
    sum = (sum ^ word) * UINT64_C(0x9e3779b97f4a7c15);
    return sum << 29 | sum >> 35;
}

// Gives a snapshot the checksum that it should have: of what follows its header of 24 bytes, the last eight of the header.
static void seal(unsigned char *snapshot, size_t size) {
    const unsigned char *body = snapshot + 24;
    const size_t count = size - 24, whole = count / 32 * 32;
    uint64_t sums[4] = {1, 2, 3, 4}, sum = count;
    for (size_t i = 0; i < whole; i += 8) {
        uint64_t word;
        memcpy(&word, body + i, sizeof word);
        sums[i / 8 % 4] = mixed(sums[i / 8 % 4], word);
    }
    for (size_t i = whole; i < count; i++) {
        sum = mixed(sum, body[i]);
    }
    for (int i = 0; i < 4; i++) {
        sum = mixed(sum, sums[i]);
    }
    memcpy(snapshot + 16, &sum, sizeof sum);
}

// Bytes that are no snapshot of this world, each by itself.
static void snapshots(void) {
    const size_t size = trisap_world_snapshot_size(world);
    unsigned char *snapshot = malloc(size + 1), *broken = malloc(size + 1);
    CHECK(snapshot != NULL && broken != NULL && size > 0);
    size_t count = 77;
    REFUSED(trisap_world_save(world, NULL, size, &count), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_save(world, snapshot, size, NULL), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_save(world, world, size, &count), TRISAP_STATUS_OVERLAP);
    CHECK(count == 77);
    REFUSED(trisap_world_save(world, NULL, 0, &count), TRISAP_STATUS_OUTPUT_FULL);
    CHECK(count == size && trisap_world_error_detail(world) == size);
    REFUSED(trisap_world_save(world, snapshot, size - 1, &count), TRISAP_STATUS_OUTPUT_FULL);
    // No alignment is asked for.
    REFUSED(trisap_world_save(world, snapshot + 1, size, &count), TRISAP_STATUS_OK);
    memmove(snapshot, snapshot + 1, size);

    REFUSED(trisap_world_load(world, NULL, size), TRISAP_STATUS_NULL_POINTER);
    REFUSED(trisap_world_load(world, world, size), TRISAP_STATUS_OVERLAP);
    REFUSED(trisap_world_load(world, snapshot, 0), TRISAP_STATUS_BAD_SNAPSHOT);
    for (size_t i = 0; i < size; i++) {
        REFUSED(trisap_world_load(world, snapshot, i), TRISAP_STATUS_BAD_SNAPSHOT);
        memcpy(broken, snapshot, size);
        broken[i] = (unsigned char)(broken[i] ^ 1u << i % 8);
        REFUSED(trisap_world_load(world, broken, size), TRISAP_STATUS_BAD_SNAPSHOT);
    }
    memset(broken, 0, size);
    REFUSED(trisap_world_load(world, broken, size), TRISAP_STATUS_BAD_SNAPSHOT);

    // Forged with a right checksum: another number of objects, another box, and what stands last.
    memcpy(broken, snapshot, size);
    seal(broken, size);
    CHECK(memcmp(broken, snapshot, size) == 0);
    // Of living objects, of disabled ones, and of slots.
    size_t number = 24;
    const uint32_t objects[3] = {trisap_world_len(world), 0, trisap_world_len(world)};
    while (memcmp(snapshot + number, objects, sizeof objects) != 0) {
        number += sizeof *objects;
        CHECK(number + sizeof objects <= size);
    }
    const size_t forged[3] = {24 + 40, number + 3, size - 1};
    for (int i = 0; i < 3; i++) {
        memcpy(broken, snapshot, size);
        broken[forged[i]] ^= 0x7f;
        seal(broken, size);
        REFUSED(trisap_world_load(world, broken, size), TRISAP_STATUS_BAD_SNAPSHOT);
    }

    // With other events.
    trisap_config config;
    memset(&config, 0, sizeof config);
    config.struct_size = sizeof config;
    CHECK_OK(trisap_world_config(world, &config));
    config.events = !config.events;
    void *memory = aligned_alloc(trisap_world_align(), trisap_world_size(&config));
    trisap_world *foreign = NULL;
    CHECK_OK(trisap_world_init(memory, trisap_world_size(&config), &config, &foreign));
    CHECK_STATUS(trisap_world_load(foreign, snapshot, size), TRISAP_STATUS_OTHER_CONFIG);
    CHECK(trisap_world_len(foreign) == 0);
    free(memory);

    CHECK_OK(trisap_world_load(world, snapshot, size));
    CHECK_OK(trisap_world_validate(world));
    CHECK(trisap_world_len(world) == OBJECTS);
    free(snapshot);
    free(broken);
}

// More pairs than fit: the prefix is there, the world goes on, and the events come when all pairs fit again.
static void full_pairs(void) {
    trisap_result result = trisap_default_result();
    trisap_aabb aabbs[OBJECTS];
    for (int i = 0; i < OBJECTS; i++) {
        aabbs[i] = cube(0.0f);
    }
    trisap_boxes view = trisap_default_boxes(aabbs, OBJECTS);
    CHECK_OK(trisap_world_update_many(world, ids, &view));
    const uint64_t needed = OBJECTS * (OBJECTS - 1) / 2;
    CHECK_STATUS(trisap_world_step(world, NULL, &result), TRISAP_STATUS_PAIRS_FULL);
    CHECK(result.pair_count == PAIRS && result.pairs_needed == needed);
    CHECK(trisap_world_error_detail(world) == needed);
    CHECK(result.found_count == 0 && result.lost_count == 0);
    for (size_t i = 0; i < result.pair_count; i++) {
        CHECK(result.pairs[i].a < result.pairs[i].b && result.pairs[i].b < OBJECTS);
    }
    CHECK_OK(trisap_world_validate(world));
    // As at the last complete step, but for the first, which has gone to its end.
    for (int i = 0; i < OBJECTS; i++) {
        aabbs[i] = cube(0.75f * (float)(i == 0 ? OBJECTS : i));
    }
    CHECK_OK(trisap_world_step_over(world, &view, NULL, &result));
    CHECK(result.pair_count == OBJECTS - 1 && result.found_count == 1 && result.lost_count == 1);
    CHECK(result.found[0].a == 0 && result.found[0].b == OBJECTS - 1);
    CHECK(result.lost[0].a == 0 && result.lost[0].b == 1);
    CHECK_OK(trisap_world_validate(world));
}

int main(void) {
    set_up();
    reports(ids[0], (trisap_id)77);
    worlds();
    configurations();
    boxes();
    stale_ids();
    together();
    steps();
    no_values();
    no_filters();
    filters();
    regions();
    volumes();
    nearest_many();
    casts();
    resting();
    views();
    snapshots();
    full_pairs();
    free(world);
    free(before);
    puts("misuse: all checks passed");
    return 0;
}
