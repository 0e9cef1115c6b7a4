// Every function of trisap.h as it is meant to be used, in C11. Memory is exactly as long as asked for, so that the
// sanitizers see every step beyond it.

#include "check.h"
#include <math.h>
#include <stdalign.h>
#include <stdbool.h>
#include <string.h>
#include <trisap.h>

static trisap_aabb cube(float x) {
    const trisap_aabb aabb = {{x, 0.0f, 0.0f}, {x + 1.0f, 1.0f, 1.0f}};
    return aabb;
}

static trisap_world *make(const trisap_config *config) {
    const size_t bytes = trisap_world_size(config);
    CHECK(bytes > 0 && bytes % trisap_world_align() == 0);
    void *memory = aligned_alloc(trisap_world_align(), bytes);
    CHECK(memory != NULL);
    trisap_world *world = NULL;
    CHECK_OK(trisap_world_init(memory, bytes, config, &world));
    CHECK((void *)world == memory);
    return world;
}

static void versions(void) {
    CHECK(trisap_abi_version() == TRISAP_ABI_VERSION);
    char version[32];
    snprintf(version, sizeof version, "%d.%d.%d", TRISAP_VERSION_MAJOR, TRISAP_VERSION_MINOR, TRISAP_VERSION_PATCH);
    CHECK(strcmp(version, trisap_version()) == 0);
    CHECK(strlen(trisap_instruction_set()) > 0);
    for (int32_t status = -2; status <= TRISAP_STATUS_SLOT_TAKEN + 2; status++) {
        const bool known = status >= 0 && status <= TRISAP_STATUS_SLOT_TAKEN;
        CHECK((strcmp(trisap_status_text(status), "not a status") != 0) == known);
    }
}

static void defaults(void) {
    const trisap_config config = trisap_default_config(100);
    CHECK(config.struct_size == sizeof config && config.objects == 100 && config.leaf_refs == 50);
    CHECK(config.pairs == 800 && config.mode == TRISAP_MODE_EXACT && config.workers == 1);
    CHECK(config.events == 0 && config.filters == 0 && config.has_margin == 0);
    const trisap_filter filter = trisap_default_filter();
    CHECK(filter.group == UINT32_MAX && filter.mask == UINT32_MAX && filter.object_class == 0);
    const trisap_aabb aabb = cube(0.0f);
    const trisap_boxes boxes = trisap_default_boxes(&aabb, 1);
    CHECK(boxes.struct_size == sizeof boxes && boxes.first == &aabb && boxes.count == 1);
    CHECK(boxes.stride == sizeof aabb && boxes.max_offset == 12);
    const trisap_jobs jobs = trisap_default_jobs();
    CHECK(jobs.struct_size == sizeof jobs && jobs.worker_count == 1);
    const trisap_result result = trisap_default_result();
    CHECK(result.struct_size == sizeof result && result.pair_count == 0);
    const trisap_stats stats = trisap_default_stats();
    CHECK(stats.struct_size == sizeof stats && stats.objects == 0);
}

// One at a time.
static void singles(void) {
    trisap_config config = trisap_default_config(4);
    config.events = 1;
    trisap_world *world = make(&config);
    trisap_config known = trisap_default_config(0);
    CHECK_OK(trisap_world_config(world, &known));
    CHECK(memcmp(&known, &config, sizeof config) == 0);

    trisap_id left = TRISAP_NULL_ID, right = TRISAP_NULL_ID;
    trisap_aabb aabb = cube(0.0f);
    CHECK_OK(trisap_world_insert(world, &aabb, &left));
    aabb = cube(1.0f); // touching counts
    CHECK_OK(trisap_world_insert(world, &aabb, &right));
    CHECK(trisap_id_slot(left) == 0 && trisap_id_slot(right) == 1);
    CHECK(trisap_world_id_at(world, 1) == right && trisap_world_id_at(world, 2) == TRISAP_NULL_ID);
    CHECK(trisap_world_len(world) == 2);

    trisap_result result = trisap_default_result();
    CHECK_OK(trisap_world_step(world, NULL, &result));
    CHECK(result.pair_count == 1 && result.pairs[0].a == 0 && result.pairs[0].b == 1);
    CHECK(result.found_count == 1 && result.found[0].a == 0 && result.found[0].b == 1);
    CHECK(result.lost_count == 0 && result.lost != NULL && result.pairs_needed == 1);

    aabb = cube(3.0f);
    CHECK_OK(trisap_world_update(world, right, &aabb));
    trisap_aabb read = cube(0.0f);
    CHECK_OK(trisap_world_aabb(world, right, &read));
    CHECK(memcmp(&read, &aabb, sizeof read) == 0);
    // The old result stays until the next step.
    CHECK(result.pairs[0].b == 1);
    CHECK_OK(trisap_world_step(world, NULL, &result));
    CHECK(result.pair_count == 0 && result.found_count == 0);
    CHECK(result.lost_count == 1 && result.lost[0].a == 0 && result.lost[0].b == 1);

    trisap_stats stats = trisap_default_stats();
    CHECK_OK(trisap_world_stats(world, &stats));
    CHECK(stats.objects == 2 && stats.lost == 1 && stats.moved == 1 && stats.path == TRISAP_PATH_LISTS);
    CHECK_OK(trisap_world_validate(world));

    CHECK_OK(trisap_world_contains(world, left));
    CHECK_OK(trisap_world_remove(world, left));
    CHECK_STATUS(trisap_world_contains(world, left), TRISAP_STATUS_STALE_ID);
    // The slot is used again, the id is not.
    trisap_id next = TRISAP_NULL_ID;
    CHECK_OK(trisap_world_insert(world, &aabb, &next));
    CHECK(trisap_id_slot(next) == 0 && next != left);
    // Or a slot that is named.
    trisap_id at = TRISAP_NULL_ID;
    CHECK_STATUS(trisap_world_insert_at(world, 0, &aabb, &at), TRISAP_STATUS_SLOT_TAKEN);
    CHECK(trisap_world_error_detail(world) == next && at == TRISAP_NULL_ID);
    CHECK_STATUS(trisap_world_insert_at(world, config.objects, &aabb, &at), TRISAP_STATUS_OBJECTS_FULL);
    CHECK_STATUS(trisap_world_insert_at(world, 3, &aabb, NULL), TRISAP_STATUS_NULL_POINTER);
    CHECK_OK(trisap_world_insert_at(world, 3, &aabb, &at));
    CHECK(trisap_id_slot(at) == 3 && trisap_world_len(world) == 3);
    CHECK_OK(trisap_world_validate(world));
    free(world);
}

// Boxes where the caller has them.
typedef struct body {
    uint64_t name;
    float min[3];
    float mass;
    float max[3];
    // Not a multiple of a float's size follows.
    char tail[3];
} body;

static void batches(void) {
    enum { COUNT = 100 };
    trisap_config config = trisap_default_config(COUNT);
    config.has_margin = 1;
    config.margin_per_extent = 0.1f;
    config.pairs = COUNT * COUNT;
    trisap_world *world = make(&config);
    // As long as the last maximum, not as the last item.
    const size_t bytes = sizeof(body) * (COUNT - 1) + offsetof(body, max) + 12;
    body *bodies = malloc(bytes);
    CHECK(bodies != NULL);
    for (int i = 0; i < COUNT; i++) {
        const trisap_aabb aabb = cube(0.75f * (float)i);
        memcpy(bodies[i].min, aabb.min, sizeof aabb.min);
        memcpy(bodies[i].max, aabb.max, sizeof aabb.max);
    }
    trisap_boxes boxes = trisap_default_boxes(NULL, COUNT);
    boxes.first = bodies[0].min;
    boxes.stride = sizeof(body);
    boxes.max_offset = offsetof(body, max) - offsetof(body, min);
    trisap_id *ids = malloc(sizeof(trisap_id) * COUNT);
    CHECK(ids != NULL);
    CHECK_OK(trisap_world_insert_many(world, &boxes, ids));
    trisap_result result = trisap_default_result();
    CHECK_OK(trisap_world_step(world, NULL, &result));
    CHECK(result.pair_count == COUNT - 1);

    for (int i = 0; i < COUNT; i++) {
        bodies[i].min[0] *= 2.0f;
        bodies[i].max[0] = bodies[i].min[0] + 1.0f;
    }
    CHECK_OK(trisap_world_update_many(world, ids, &boxes));
    CHECK_OK(trisap_world_step(world, NULL, &result));
    CHECK(result.pair_count == 0);
    CHECK_OK(trisap_world_set_margin(world, ids[7], 2.0f));

    // The same through the caller's array; a bad box harms only itself.
    for (int i = 0; i < COUNT; i++) {
        bodies[i].min[0] = 0.0f;
        bodies[i].max[0] = 1.0f;
    }
    bodies[3].min[0] = 2.0f;
    CHECK_OK(trisap_world_step_over(world, &boxes, NULL, &result));
    CHECK(result.pair_count == (COUNT - 1) * (COUNT - 2) / 2);
    CHECK(result.rejected_count == 1 && result.first_rejected == ids[3]);

    CHECK_OK(trisap_world_remove_many(world, ids, COUNT));
    CHECK(trisap_world_len(world) == 0);
    // Nothing to do is no mistake.
    CHECK_OK(trisap_world_remove_many(world, NULL, 0));
    boxes = trisap_default_boxes(NULL, 0);
    CHECK_OK(trisap_world_insert_many(world, &boxes, NULL));
    CHECK_OK(trisap_world_update_many(world, NULL, &boxes));
    free(ids);
    free(bodies);
    free(world);
}

// Who meets whom: by groups, by classes, by a rule of the caller's own.
static uint32_t not_both_even(void *user, uint32_t a, uint32_t b) {
    *(int *)user += 1;
    return a % 2 != 0 || b % 2 != 0;
}

static void filters(void) {
    trisap_config config = trisap_default_config(4);
    config.filters = 1;
    config.events = 1;
    trisap_world *world = make(&config);
    trisap_id ids[4];
    trisap_aabb aabbs[4] = {cube(0.0f), cube(0.0f), cube(0.0f), cube(0.0f)};
    const trisap_boxes boxes = trisap_default_boxes(aabbs, 4);
    CHECK_OK(trisap_world_insert_many(world, &boxes, ids));
    trisap_result result = trisap_default_result();
    CHECK_OK(trisap_world_step(world, NULL, &result));
    CHECK(result.pair_count == 6);

    // The first meets nobody, the last two are of classes that do not meet.
    trisap_filter filter = trisap_default_filter();
    filter.mask = 0;
    CHECK_OK(trisap_world_set_filter(world, ids[0], &filter));
    struct {
        double friction;
        trisap_filter filter;
    } materials[2] = {{1.0, trisap_default_filter()}, {2.0, trisap_default_filter()}};
    materials[0].filter.object_class = 1;
    materials[1].filter.object_class = 2;
    CHECK_OK(trisap_world_set_filter_many(world, ids + 2, &materials[0].filter, sizeof materials[0], 2));
    uint32_t meets[TRISAP_CLASSES];
    memset(meets, 0xff, sizeof meets);
    meets[1] &= ~(1u << 2);
    CHECK_OK(trisap_world_set_classes(world, meets));
    CHECK_OK(trisap_world_step(world, NULL, &result));
    CHECK(result.pair_count == 2 && result.lost_count == 4 && result.found_count == 0);
    CHECK_OK(trisap_world_filter(world, ids[3], &filter));
    CHECK(filter.object_class == 2 && filter.group == UINT32_MAX);

    // All the same again, but for the rule.
    filter = trisap_default_filter();
    CHECK_OK(trisap_world_set_filter_many(world, ids, &filter, 0, 4));
    for (int i = 0; i < 4; i++) {
        CHECK_OK(trisap_world_refilter(world, ids[i]));
    }
    int asked = 0;
    CHECK_OK(trisap_world_step_with_rule(world, &boxes, not_both_even, &asked, NULL, &result));
    CHECK(result.pair_count == 5 && result.found_count == 3 && result.lost_count == 0 && asked == 6);
    // Nothing has changed: nobody is asked.
    CHECK_OK(trisap_world_step_with_rule(world, NULL, not_both_even, &asked, NULL, &result));
    CHECK(result.pair_count == 5 && asked == 6);
    free(world);
}

static uint32_t note(void *user, trisap_id id) {
    *(uint32_t *)user |= 1u << trisap_id_slot(id);
    return 1;
}

static double farthest(void *user, trisap_hit hit) {
    double *far = user;
    *far = hit.distance > *far ? hit.distance : *far;
    return 100.0;
}

// Where x is 1 at most.
static int32_t beyond_one(void *user, const trisap_aabb *aabb) {
    (void)user;
    return aabb->min[0] > 1.0f ? -1 : aabb->max[0] <= 1.0f ? 1 : 0;
}

static uint32_t count_up(void *user, trisap_id id) {
    (void)id;
    return ++*(uint32_t *)user;
}

static uint32_t is_not(void *user, trisap_id id) { return id != *(const trisap_id *)user; }

// Values follow their objects, also where others have got the slots; queries leave out whom a condition refuses.
static void values(void) {
    trisap_config config = trisap_default_config(4);
    config.events = config.values = 1;
    trisap_world *world = make(&config);
    trisap_id ids[3];
    const trisap_aabb aabbs[3] = {cube(0.0f), cube(0.5f), cube(1.25f)};
    const trisap_boxes boxes = trisap_default_boxes(aabbs, 3);
    CHECK_OK(trisap_world_insert_many(world, &boxes, ids));
    struct {
        double mass;
        uint64_t key;
    } bodies[3] = {{1.0, 7}, {2.0, UINT64_MAX}, {3.0, 9}};
    CHECK_OK(trisap_world_set_value_many(world, ids, &bodies[0].key, sizeof bodies[0], 3));
    CHECK_OK(trisap_world_set_value(world, ids[2], 8));
    trisap_result result = trisap_default_result();
    CHECK_OK(trisap_world_step(world, NULL, &result));
    trisap_value_pair pairs[3];
    size_t count = 0;
    CHECK_OK(trisap_world_pair_values(world, TRISAP_PAIRS_ALL, pairs, 3, &count));
    CHECK(count == 2 && result.pair_count == 2);
    CHECK_OK(trisap_world_pair_values(world, TRISAP_PAIRS_FOUND, pairs, 3, &count));
    CHECK(count == 2);
    CHECK_STATUS(trisap_world_pair_values(world, TRISAP_PAIRS_FOUND, pairs, 1, &count), TRISAP_STATUS_OUTPUT_FULL);
    CHECK_OK(trisap_world_remove(world, ids[0]));
    trisap_id other = TRISAP_NULL_ID;
    const trisap_aabb far = cube(9.0f);
    CHECK_OK(trisap_world_insert(world, &far, &other));
    CHECK(trisap_id_slot(other) == trisap_id_slot(ids[0]));
    CHECK_OK(trisap_world_step(world, NULL, &result));
    CHECK_OK(trisap_world_pair_values(world, TRISAP_PAIRS_LOST, pairs, 3, &count));
    CHECK(count == 1 && pairs[0].a == 7 && pairs[0].b == UINT64_MAX);
    uint64_t value = 1;
    CHECK_OK(trisap_world_value(world, other, &value));
    CHECK(value == 0);

    const float left[3] = {-1.0f, 0.5f, 0.5f}, right[3] = {1.0f, 0.0f, 0.0f};
    const trisap_cast ray = trisap_cast_ray(left, right, 100.0f);
    trisap_hit hits[4];
    uint64_t told[4];
    CHECK_OK(trisap_world_hits(world, &ray, NULL, NULL, hits, 4, &count));
    CHECK_OK(trisap_world_values(world, &hits[0].id, sizeof hits[0], count, told));
    CHECK(count == 3 && told[0] == UINT64_MAX && told[1] == 8 && told[2] == 0);
    CHECK_OK(trisap_world_first_hit(world, &ray, is_not, &ids[1], hits));
    CHECK(hits[0].id == ids[2]);
    CHECK_OK(trisap_world_hits(world, &ray, is_not, &ids[1], hits, 4, &count));
    CHECK(count == 2 && hits[0].id == ids[2] && hits[1].id == other);
    CHECK_OK(trisap_world_nearest(world, left, is_not, &ids[1], hits, 1, &count));
    CHECK(count == 1 && hits[0].id == ids[2]);
    const trisap_region region = trisap_region_aabb(&aabbs[1]);
    trisap_id found[4];
    CHECK_OK(trisap_world_overlaps(world, &region, is_not, &ids[1], found, 4, &count));
    CHECK(count == 1 && found[0] == ids[2]);
    const trisap_cast rays[2] = {ray, ray};
    CHECK_OK(trisap_world_first_hits(world, rays, sizeof rays[0], 2, is_not, &ids[1], NULL, hits));
    CHECK(hits[0].id == ids[2] && hits[1].id == ids[2]);
    size_t ends[2];
    CHECK_OK(trisap_world_overlaps_many(world, &region, 0, 2, is_not, &ids[1], NULL, found, 2, ends));
    CHECK(ends[0] == 1 && ends[1] == 2 && found[0] == ids[2] && found[1] == ids[2]);
    // In a world without filters all are in all groups and meet all.
    trisap_filter filter = trisap_default_filter();
    CHECK(trisap_world_meets(world, other, &filter) == 1 && trisap_world_meets(world, ids[0], &filter) == 0);
    filter.mask = 0;
    CHECK(trisap_world_meets(world, other, &filter) == 0 && trisap_world_meets(world, other, NULL) == 0);
    free(world);
}

static uint32_t all_meet(void *user, uint32_t a, uint32_t b) {
    *(uint32_t *)user += a == 1 || b == 1;
    return 1;
}

// An object whose slot was another's has none of its pairs, by ids and by values, is asked about where it is, and the contact ends.
// Few in lists, many in a tree.
static void newcomer(uint32_t objects) {
    enum { ROOM = 16 };
    trisap_config config = trisap_default_config(objects);
    config.events = config.values = config.filters = 1;
    trisap_world *world = make(&config);
    trisap_id *ids = malloc(sizeof *ids * objects);
    trisap_aabb *aabbs = malloc(sizeof *aabbs * objects);
    const size_t bytes = trisap_contacts_size(objects, ROOM);
    void *memory = malloc(bytes);
    CHECK(ids != NULL && aabbs != NULL && memory != NULL);
    // The first three overlap, all others are alone.
    for (uint32_t i = 0; i < objects; i++) {
        aabbs[i] = cube(i < 3 ? 0.25f * (float)i : 4.0f * (float)i);
    }
    const trisap_boxes boxes = trisap_default_boxes(aabbs, objects);
    CHECK_OK(trisap_world_insert_many(world, &boxes, ids));
    for (uint32_t i = 0; i < 3; i++) {
        CHECK_OK(trisap_world_set_value(world, ids[i], 100 + i));
    }
    trisap_contacts *contacts = NULL;
    CHECK_OK(trisap_contacts_init(memory, bytes, objects, ROOM, &contacts));
    uint32_t numbers[ROOM], ended[ROOM], asked = 0;
    trisap_result result = trisap_default_result();
    CHECK_OK(trisap_world_step_with_rule(world, NULL, all_meet, &asked, NULL, &result));
    CHECK(result.pair_count == 3 && result.found_count == 3 && asked == 2);
    CHECK_OK(trisap_contacts_update(contacts, NULL, 0, NULL, result.found, 3, numbers, NULL));
    const uint32_t staying = trisap_contacts_get(contacts, 0, 2);

    // Another one in its slot, in the place of the old one at first and then far away: between the steps it is in no pair.
    CHECK_OK(trisap_world_remove(world, ids[1]));
    trisap_id other = TRISAP_NULL_ID;
    CHECK_OK(trisap_world_insert(world, &aabbs[1], &other));
    CHECK(other != ids[1] && trisap_id_slot(other) == 1);
    CHECK_OK(trisap_world_set_value(world, other, 7));
    const trisap_aabb far = cube(-9.0f);
    for (int place = 0; place < 2; place++) {
        for (uint32_t what = TRISAP_PAIRS_ALL; what <= TRISAP_PAIRS_FOUND; what++) {
            trisap_id_pair named[3];
            trisap_value_pair valued[3];
            size_t count = 0, value_count = 0;
            CHECK_OK(trisap_world_pair_ids(world, what, named, 3, &count));
            CHECK_OK(trisap_world_pair_values(world, what, valued, 3, &value_count));
            CHECK(count == 1 && named[0].a == ids[0] && named[0].b == ids[2]);
            CHECK(value_count == 1 && valued[0].a == 100 && valued[0].b == 102);
        }
        CHECK_OK(trisap_world_update(world, other, &far));
    }

    // The next step loses the pairs of the old one, by its id and its value, asks about nobody far away, and ends two contacts.
    asked = 0;
    CHECK_OK(trisap_world_step_with_rule(world, NULL, all_meet, &asked, NULL, &result));
    CHECK(result.pair_count == 1 && result.found_count == 0 && result.lost_count == 2 && asked == 0);
    trisap_id_pair lost[2];
    trisap_value_pair values_of_lost[2];
    size_t count = 0;
    CHECK_OK(trisap_world_pair_ids(world, TRISAP_PAIRS_LOST, lost, 2, &count));
    CHECK_OK(trisap_world_pair_values(world, TRISAP_PAIRS_LOST, values_of_lost, 2, &count));
    CHECK(count == 2);
    for (int i = 0; i < 2; i++) {
        CHECK((lost[i].a == ids[1]) + (lost[i].b == ids[1]) == 1);
        CHECK((values_of_lost[i].a == 101) + (values_of_lost[i].b == 101) == 1);
    }
    CHECK_OK(trisap_contacts_update(contacts, result.lost, 2, ended, NULL, 0, NULL, NULL));
    CHECK(trisap_contacts_count(contacts) == 1 && trisap_contacts_get(contacts, 0, 2) == staying);
    CHECK(ended[0] != staying && ended[1] != staying && trisap_contacts_get(contacts, 0, 1) == TRISAP_NO_CONTACT);

    // In the slot and in the place of one that is gone, one is found and the other lost: the contact is a new one.
    CHECK_OK(trisap_world_remove(world, ids[2]));
    trisap_id third = TRISAP_NULL_ID;
    CHECK_OK(trisap_world_insert(world, &aabbs[2], &third));
    CHECK(trisap_id_slot(third) == 2);
    CHECK_OK(trisap_world_step_with_rule(world, NULL, all_meet, &asked, NULL, &result));
    CHECK(result.pair_count == 1 && result.found_count == 1 && result.lost_count == 1);
    CHECK_OK(trisap_world_pair_ids(world, TRISAP_PAIRS_FOUND, lost, 2, &count));
    CHECK(count == 1 && lost[0].a == ids[0] && lost[0].b == third);
    CHECK_OK(trisap_world_pair_ids(world, TRISAP_PAIRS_LOST, lost, 2, &count));
    CHECK(count == 1 && lost[0].a == ids[0] && lost[0].b == ids[2]);
    CHECK_OK(trisap_contacts_update(contacts, result.lost, 1, ended, result.found, 1, numbers, NULL));
    CHECK(ended[0] == staying && trisap_contacts_count(contacts) == 1 && trisap_contacts_get(contacts, 2, 0) == numbers[0]);
    CHECK_OK(trisap_world_validate(world));
    free(memory);
    free(aabbs);
    free(ids);
    free(world);
}

// No world: a first call tells how much memory the pairs take.
static void once(void) {
    trisap_aabb aabbs[40];
    for (int i = 0; i < 40; i++) {
        aabbs[i] = cube(i < 30 ? 0.0f : 3.0f * (float)i);
    }
    const trisap_boxes all = trisap_default_boxes(aabbs, 40);
    const trisap_boxes first = trisap_default_boxes(aabbs, 10), others = trisap_default_boxes(aabbs + 10, 30);
    for (int between = 0; between < 2; between++) {
        const trisap_pair *pairs = NULL;
        size_t bytes = 0, count = 0;
        void *memory = NULL;
        int calls = 1;
        while (trisap_pairs(between ? &first : &all, between ? &others : NULL, NULL, memory, &bytes, &pairs, &count) ==
               TRISAP_STATUS_MEMORY_TOO_SMALL) {
            free(memory);
            bytes = (bytes + 63) / 64 * 64;
            memory = aligned_alloc(64, bytes);
            calls++;
        }
        CHECK(calls <= 3 && count == (between ? 200 : 435));
        for (size_t k = 0; k < count; k++) {
            CHECK(between ? pairs[k].a < 10 && pairs[k].b < 20 : pairs[k].a < pairs[k].b && pairs[k].b < 30);
        }
        CHECK(trisap_pairs(&all, NULL, NULL, (char *)memory + 8, &bytes, &pairs, &count) == TRISAP_STATUS_MISALIGNED);
        aabbs[33].max[1] = NAN;
        CHECK(trisap_pairs(&first, &others, NULL, memory, &bytes, &pairs, &count) == TRISAP_STATUS_BAD_BOX && count == 33);
        aabbs[33] = cube(99.0f);
        CHECK(trisap_pairs(NULL, NULL, NULL, memory, &bytes, &pairs, &count) == TRISAP_STATUS_NULL_POINTER);
        CHECK(trisap_pairs(&all, NULL, NULL, memory, NULL, &pairs, &count) == TRISAP_STATUS_NULL_POINTER);
        CHECK(trisap_pairs(&all, NULL, NULL, memory, &bytes, NULL, &count) == TRISAP_STATUS_NULL_POINTER);
        free(memory);
    }
}

// Answers before the first step; the same after it.
static void queries(void) {
    const trisap_config config = trisap_default_config(8);
    trisap_world *world = make(&config);
    trisap_id ids[8];
    trisap_aabb aabbs[8];
    for (int i = 0; i < 8; i++) {
        aabbs[i] = cube(2.0f * (float)i);
    }
    const trisap_boxes boxes = trisap_default_boxes(aabbs, 8);
    CHECK_OK(trisap_world_insert_many(world, &boxes, ids));
    for (int round = 0; round < 2; round++) {
        trisap_id found[8];
        size_t count = 0;
        const trisap_aabb wide = {{3.0f, 0.0f, 0.0f}, {6.0f, 1.0f, 1.0f}};
        const trisap_region region = trisap_region_aabb(&wide);
        CHECK_OK(trisap_world_overlaps(world, &region, NULL, NULL, found, 8, &count));
        CHECK(count == 3 && found[0] == ids[1] && found[1] == ids[2] && found[2] == ids[3]);
        uint32_t slots = 0;
        CHECK_OK(trisap_world_visit_overlaps(world, &region, note, &slots));
        CHECK(slots == 0xe);
        const float corner[3] = {4.0f, 1.0f, 1.0f};
        const trisap_region point = trisap_region_point(corner);
        CHECK_OK(trisap_world_overlaps(world, &point, NULL, NULL, found, 8, &count));
        CHECK(count == 1 && found[0] == ids[2]);
        const trisap_region both[2] = {point, trisap_region_sphere(corner, 1.0f)};
        size_t ends[2] = {0};
        CHECK_OK(trisap_world_overlaps_many(world, both, sizeof both[0], 2, NULL, NULL, NULL, found, 4, ends));
        CHECK(ends[0] == 1 && ends[1] == 3 && found[0] == ids[2] && found[1] == ids[1] && found[2] == ids[2]);

        const float left[3] = {-1.0f, 0.5f, 0.5f}, right[3] = {0.5f, 0.0f, 0.0f};
        const trisap_cast ray = trisap_cast_ray(left, right, 8.0f);
        trisap_hit hits[8];
        CHECK_OK(trisap_world_first_hit(world, &ray, NULL, NULL, hits));
        CHECK(hits[0].id == ids[0] && hits[0].distance == 2.0);
        CHECK_OK(trisap_world_hits(world, &ray, NULL, NULL, hits, 8, &count));
        CHECK(count == 2 && hits[1].id == ids[1] && hits[1].distance == 6.0);
        double far = 0.0;
        CHECK_OK(trisap_world_visit_hits(world, &ray, farthest, &far));
        CHECK(far == 6.0);
        const trisap_aabb start = {{-1.0f, 3.0f, 0.0f}, {-0.5f, 4.0f, 1.0f}};
        const float down[3] = {2.0f, -4.0f, 0.0f};
        const trisap_cast casts[2] = {ray, trisap_cast_swept(&start, down)};
        CHECK_OK(trisap_world_first_hits(world, casts, sizeof casts[0], 2, NULL, NULL, NULL, hits));
        CHECK(hits[0].id == ids[0] && hits[1].id == ids[0] && hits[1].distance == 0.5);
        CHECK_OK(trisap_world_nearest(world, left, NULL, NULL, hits, 3, &count));
        CHECK(count == 3 && hits[0].id == ids[0] && hits[2].id == ids[2] && hits[2].distance == 5.0);
        far = 0.0;
        CHECK_OK(trisap_world_visit_nearest(world, left, 4.0, farthest, &far));
        CHECK(far == hits[1].distance);
        const float points[6] = {left[0], left[1], left[2], right[0], right[1], right[2]};
        CHECK_OK(trisap_world_nearest_many(world, points, 3 * sizeof(float), 2, NULL, NULL, NULL, hits, 4));
        CHECK(hits[0].id == ids[0] && hits[3].id == ids[3] && hits[4].id == ids[0] && hits[4].distance == 0.0);
        // Two planes along x that part the first object from the others, and a part of space that says the same.
        const double planes[8] = {1.0, 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 100.0};
        trisap_id inside[3];
        CHECK_OK(trisap_world_within(world, planes, 2, NULL, NULL, inside, 3, &count));
        CHECK(count == 1 && inside[0] == ids[0]);
        uint32_t visited = 0;
        CHECK_OK(trisap_world_visit_within(world, beyond_one, NULL, count_up, &visited));
        CHECK(visited == count);
        trisap_result result = trisap_default_result();
        CHECK_OK(trisap_world_step(world, NULL, &result));
    }
    free(world);
}

// What rests does not look at the caller's array; another box wakes it.
static void resting(void) {
    const trisap_config config = trisap_default_config(2);
    trisap_world *world = make(&config);
    trisap_id ids[2];
    trisap_aabb aabbs[2] = {cube(0.0f), cube(0.5f)};
    const trisap_boxes boxes = trisap_default_boxes(aabbs, 2);
    CHECK_OK(trisap_world_insert_many(world, &boxes, ids));
    CHECK_OK(trisap_world_set_resting(world, ids, 2));
    CHECK(trisap_world_is_resting(world, ids[0]) == 1 && trisap_world_is_resting(world, ids[1]) == 1);
    aabbs[0] = aabbs[1] = cube(9.0f);
    trisap_result result = trisap_default_result();
    CHECK_OK(trisap_world_step_over(world, &boxes, NULL, &result));
    trisap_pair awake[1];
    size_t awake_count = 1;
    CHECK_OK(trisap_world_awake_pairs(world, awake, 1, &awake_count));
    CHECK(awake_count == 0);
    trisap_aabb known = cube(9.0f);
    CHECK_OK(trisap_world_aabb(world, ids[0], &known));
    CHECK(result.pair_count == 1 && known.min[0] == 0.0f);
    CHECK_OK(trisap_world_wake(world, ids, 1));
    CHECK_OK(trisap_world_step_over(world, &boxes, NULL, &result));
    CHECK(result.pair_count == 0 && trisap_world_is_resting(world, ids[0]) == 0);
    CHECK_OK(trisap_world_update(world, ids[1], &aabbs[1]));
    CHECK(trisap_world_is_resting(world, ids[1]) == 0);
    CHECK_OK(trisap_world_step(world, NULL, &result));
    CHECK(result.pair_count == 1);
    CHECK_OK(trisap_world_awake_pairs(world, awake, 1, &awake_count));
    CHECK(awake_count == 1 && awake[0].a == 0 && awake[0].b == 1);
    // A disabled object has no pairs, and keeps its box.
    CHECK_OK(trisap_world_set_enabled(world, ids, 1, 0));
    CHECK(trisap_world_is_enabled(world, ids[0]) == 0 && trisap_world_is_enabled(world, ids[1]) == 1);
    CHECK_OK(trisap_world_step(world, NULL, &result));
    CHECK_OK(trisap_world_aabb(world, ids[0], &known));
    CHECK(result.pair_count == 0 && known.min[0] == 9.0f && trisap_world_len(world) == 2);
    CHECK_OK(trisap_world_set_enabled(world, ids, 2, 1));
    CHECK_OK(trisap_world_step(world, NULL, &result));
    CHECK(result.pair_count == 1 && trisap_world_is_enabled(world, ids[0]) == 1);
    free(world);
}

// A world that is only asked has room for no pairs, and a tree without a step.
static void questions(void) {
    enum { COUNT = 2000 };
    trisap_config config = trisap_default_config(COUNT);
    config.pairs = 0;
    trisap_world *world = make(&config);
    static trisap_aabb aabbs[COUNT];
    static trisap_id ids[COUNT];
    for (int i = 0; i < COUNT; i++) {
        aabbs[i] = cube((float)i * 0.5f);
    }
    const trisap_boxes boxes = trisap_default_boxes(aabbs, COUNT);
    CHECK_OK(trisap_world_insert_many(world, &boxes, ids));
    trisap_jobs none = trisap_default_jobs();
    none.worker_count = 0;
    CHECK_STATUS(trisap_world_refresh(world, &none), TRISAP_STATUS_INVALID_ARGUMENT);
    CHECK_OK(trisap_world_refresh(world, NULL));
    trisap_leaf leaves[64];
    size_t leaf_count = 0, members = 0;
    CHECK_OK(trisap_world_leaves(world, leaves, 64, &leaf_count));
    for (size_t i = 0; i < leaf_count; i++) {
        members += leaves[i].objects;
    }
    CHECK(leaf_count > 1 && members == COUNT);
    const trisap_region region = trisap_region_aabb(&aabbs[1000]);
    trisap_id found[8];
    size_t count = 0;
    CHECK_OK(trisap_world_overlaps(world, &region, NULL, NULL, found, 8, &count));
    CHECK(count == 5 && found[2] == ids[1000]);
    trisap_result result = trisap_default_result();
    CHECK_STATUS(trisap_world_step(world, NULL, &result), TRISAP_STATUS_PAIRS_FULL);
    CHECK(result.pairs_needed == 2 * COUNT - 3);
    free(world);
}

// The tree, leaf by leaf, of a world that is large enough to have one.
static void tree(void) {
    enum { COUNT = 4000 };
    const trisap_config config = trisap_default_config(COUNT);
    trisap_world *world = make(&config);
    trisap_aabb aabb = {{0}, {0}};
    trisap_id id = TRISAP_NULL_ID;
    for (int i = 0; i < COUNT; i++) {
        for (int k = 0; k < 3; k++) {
            aabb.min[k] = 1.5f * (float)(k == 0 ? i % 20 : k == 1 ? i / 20 % 20 : i / 400);
            aabb.max[k] = aabb.min[k] + (i == 0 ? 1000.0f : 1.0f);
        }
        CHECK_OK(trisap_world_insert(world, &aabb, &id));
    }
    trisap_result result = trisap_default_result();
    CHECK_OK(trisap_world_step(world, NULL, &result));
    size_t count = 0, planes = 0, large = 0;
    CHECK_STATUS(trisap_world_leaves(world, NULL, 0, &count), TRISAP_STATUS_OUTPUT_FULL);
    CHECK(count > 4 && count < COUNT);
    trisap_leaf *leaves = malloc(count * sizeof *leaves);
    trisap_plane *all = malloc(count * sizeof *all);
    CHECK(leaves != NULL && all != NULL);
    CHECK_OK(trisap_world_leaves(world, leaves, count, &count));
    CHECK_OK(trisap_world_planes(world, all, count, &planes));
    CHECK_OK(trisap_world_large(world, &id, 1, &large));
    CHECK(large == 1 && trisap_id_slot(id) == 0);
    size_t objects = large;
    for (size_t i = 0; i < count; i++) {
        objects += leaves[i].objects;
        for (int k = 0; k < 3; k++) {
            CHECK(leaves[i].cell.min[k] <= leaves[i].cell.max[k]);
        }
    }
    CHECK(objects == COUNT);
    CHECK(planes > 0 && planes < count && all[0].depth == 0);
    for (size_t i = 0; i < planes; i++) {
        const uint32_t axis = all[i].axis;
        CHECK(axis < 3 && all[i].cell.min[axis] <= all[i].position && all[i].position <= all[i].cell.max[axis]);
    }
    free(leaves);
    free(all);
    free(world);
}

// Far from the origin, nearest rounding would lose the pair.
static void doubles(void) {
    const double min[3] = {1e8, 0.0, -1.0}, max[3] = {1e8 + 1.0, 0.1, 1.0}, none[3] = {0.0, 0.0, 0.0};
    trisap_aabb aabb = trisap_aabb_from_f64(min, max, none);
    CHECK(aabb.min[0] <= min[0] && aabb.max[0] >= max[0] && aabb.max[1] >= max[1] && aabb.max[2] == 1.0f);
    CHECK((double)aabb.max[0] > max[0]);
    aabb = trisap_aabb_from_f64(min, max, min);
    CHECK(aabb.min[0] == 0.0f && aabb.max[0] == 1.0f && aabb.max[2] == 2.0f);
    aabb = trisap_aabb_from_f64(NULL, max, none);
    CHECK(aabb.min[0] != aabb.min[0]);
}

// The same numbers in fixed point, and an origin that moves with them.
static void fixed_and_shifted(void) {
    const int32_t low[3] = {256, -128, 0}, high[3] = {512, 128, 64};
    const trisap_aabb aabb = trisap_aabb_from_fixed(low, high, 8);
    CHECK(aabb.min[0] == 1.0f && aabb.min[1] == -0.5f && aabb.max[0] == 2.0f && aabb.max[2] == 0.25f);
    CHECK(trisap_aabb_from_fixed(NULL, high, 8).min[0] != trisap_aabb_from_fixed(NULL, high, 8).min[0]);

    trisap_config config = trisap_default_config(16);
    config.events = 1;
    trisap_world *world = make(&config);
    trisap_id ids[2];
    CHECK(trisap_world_insert(world, &aabb, &ids[0]) == TRISAP_STATUS_OK);
    CHECK(trisap_world_insert(world, &aabb, &ids[1]) == TRISAP_STATUS_OK);
    trisap_result result = trisap_default_result();
    CHECK(trisap_world_step(world, NULL, &result) == TRISAP_STATUS_OK && result.found_count == 1);
    const double by[3] = {1.0, -2.0, 0.0};
    uint32_t rounded = 7;
    CHECK(trisap_world_shift_origin(world, by, &rounded) == TRISAP_STATUS_OK && rounded == 0);
    trisap_aabb now;
    CHECK(trisap_world_aabb(world, ids[0], &now) == TRISAP_STATUS_OK && now.min[0] == 0.0f && now.min[1] == 1.5f);
    CHECK(trisap_world_step(world, NULL, &result) == TRISAP_STATUS_OK);
    CHECK(result.pair_count == 1 && result.found_count == 0 && result.lost_count == 0);
    const double far[3] = {1e9, 0.0, 0.0};
    CHECK(trisap_world_shift_origin(world, far, &rounded) == TRISAP_STATUS_OK && rounded == 2);
    CHECK(trisap_world_shift_origin(world, by, NULL) == TRISAP_STATUS_OK);
    free(world);
}

// With planes and without leaves, as after a shift of the origin, a world comes back too.
static void saved_after_a_shift(void) {
    enum { OBJECTS = 600 };
    trisap_config config = trisap_default_config(OBJECTS);
    trisap_world *world = make(&config);
    static trisap_aabb aabbs[OBJECTS];
    static trisap_id ids[OBJECTS];
    for (int i = 0; i < OBJECTS; i++) {
        aabbs[i] = cube(0.75f * (float)i);
    }
    const trisap_boxes boxes = trisap_default_boxes(aabbs, OBJECTS);
    CHECK_OK(trisap_world_insert_many(world, &boxes, ids));
    trisap_result result = trisap_default_result();
    CHECK_OK(trisap_world_step(world, NULL, &result));
    const double by[3] = {1.0, 2.0, 3.0};
    CHECK_OK(trisap_world_shift_origin(world, by, NULL));
    const size_t room = trisap_world_snapshot_size(world);
    void *snapshot = malloc(room);
    size_t size = 0;
    CHECK_OK(trisap_world_save(world, snapshot, room, &size));
    CHECK_OK(trisap_world_load(world, snapshot, size));
    CHECK_OK(trisap_world_validate(world));
    CHECK(trisap_world_len(world) == OBJECTS);
    CHECK_OK(trisap_world_step(world, NULL, &result));
    CHECK(result.pair_count == OBJECTS - 1);
    free(snapshot);
    free(world);
}

// A world comes back as it was, and goes on as it would have.
static void saved(void) {
    trisap_config config = trisap_default_config(16);
    config.events = 1;
    trisap_world *world = make(&config), *other = make(&config);
    trisap_aabb aabb = cube(0.0f);
    trisap_id first = TRISAP_NULL_ID, second = TRISAP_NULL_ID;
    CHECK_OK(trisap_world_insert(world, &aabb, &first));
    CHECK_OK(trisap_world_insert(world, &aabb, &second));
    trisap_result result = trisap_default_result();
    CHECK_OK(trisap_world_step(world, NULL, &result));
    const size_t room = trisap_world_snapshot_size(world);
    CHECK(room > 0 && room < trisap_world_bytes(world));
    void *snapshot = malloc(room);
    size_t size = 0;
    CHECK_OK(trisap_world_save(world, snapshot, room, &size));
    CHECK(size == room);
    CHECK_OK(trisap_world_remove(world, first));
    CHECK_OK(trisap_world_load(other, snapshot, size));
    CHECK_OK(trisap_world_load(world, snapshot, size));
    CHECK_OK(trisap_world_contains(world, first));
    CHECK_OK(trisap_world_result(other, &result));
    CHECK(result.pair_count == 1 && result.found_count == 1);
    CHECK_OK(trisap_world_remove(other, second));
    CHECK_OK(trisap_world_step(other, NULL, &result));
    CHECK(result.pair_count == 0 && result.lost_count == 1);
    free(snapshot);
    free(other);
    free(world);
}

// Sorted results are the same in a world of other room, which has loaded a snapshot.
static void sorted(void) {
    trisap_config config = trisap_default_config(700);
    config.events = 1;
    trisap_world *world = make(&config);
    config = trisap_default_config(2000);
    config.events = 1;
    trisap_world *other = make(&config);
    trisap_id ids[600];
    trisap_result results[2] = {trisap_default_result(), trisap_default_result()};
    for (uint32_t i = 0; i < 600; i++) {
        const trisap_aabb aabb = cube((float)(i * 7 % 600) * 0.4f);
        CHECK_OK(trisap_world_insert(world, &aabb, &ids[i]));
    }
    CHECK_OK(trisap_world_step(world, NULL, &results[0]));
    CHECK_OK(trisap_world_remove(world, ids[9]));
    CHECK_OK(trisap_world_step(world, NULL, &results[0]));
    const size_t room = trisap_world_snapshot_size(world);
    void *snapshot = malloc(room);
    size_t size = 0;
    CHECK_OK(trisap_world_save(world, snapshot, room, &size));
    CHECK_OK(trisap_world_load(other, snapshot, size));
    free(snapshot);
    const trisap_aabb moved = cube(100.0f);
    trisap_world *const worlds[] = {world, other};
    for (size_t i = 0; i < 2; i++) {
        CHECK_OK(trisap_world_update(worlds[i], ids[3], &moved));
        CHECK_OK(trisap_world_step(worlds[i], NULL, &results[i]));
        CHECK_OK(trisap_world_sort_results(worlds[i], &results[i]));
        CHECK(results[i].found_count > 0 && results[i].lost_count > 0);
    }
    CHECK(results[0].pair_count == results[1].pair_count && results[0].pair_count > 1000);
    CHECK(memcmp(results[0].pairs, results[1].pairs, results[0].pair_count * sizeof(trisap_pair)) == 0);
    CHECK(memcmp(results[0].found, results[1].found, results[0].found_count * sizeof(trisap_pair)) == 0);
    CHECK(memcmp(results[0].lost, results[1].lost, results[0].lost_count * sizeof(trisap_pair)) == 0);
    free(other);
    free(world);
}

// A copy of the memory goes on as the world does.
static void copies(void) {
    const trisap_config config = trisap_default_config(16);
    trisap_world *world = make(&config);
    trisap_id ids[8];
    trisap_aabb aabbs[8];
    for (int i = 0; i < 8; i++) {
        aabbs[i] = cube(0.5f * (float)i);
    }
    const trisap_boxes boxes = trisap_default_boxes(aabbs, 8);
    CHECK_OK(trisap_world_insert_many(world, &boxes, ids));
    trisap_result result = trisap_default_result();
    CHECK_OK(trisap_world_step(world, NULL, &result));

    const size_t bytes = trisap_world_bytes(world);
    CHECK(bytes == trisap_world_size(&config));
    void *memory = aligned_alloc(trisap_world_align(), bytes);
    CHECK(memory != NULL);
    memcpy(memory, world, bytes);
    trisap_world *copy = NULL;
    CHECK_OK(trisap_world_open(memory, bytes, &copy));
    trisap_result again = trisap_default_result();
    CHECK_OK(trisap_world_result(copy, &again));
    CHECK(again.pairs != result.pairs && again.pair_count == result.pair_count);
    CHECK(memcmp(again.pairs, result.pairs, result.pair_count * sizeof(trisap_pair)) == 0);
    CHECK_OK(trisap_world_update(world, ids[2], &aabbs[6]));
    CHECK_OK(trisap_world_update(copy, ids[2], &aabbs[6]));
    CHECK_OK(trisap_world_step(world, NULL, &result));
    CHECK_OK(trisap_world_step(copy, NULL, &again));
    CHECK(memcmp(world, copy, bytes) == 0);
    free(copy);
    free(world);
}

// Without any allocation at all.
static void statics(void) {
    static alignas(64) unsigned char memory[16384];
    const trisap_config config = trisap_default_config(10);
    CHECK(trisap_world_size(&config) <= sizeof memory);
    trisap_world *world = NULL;
    CHECK_OK(trisap_world_init(memory, sizeof memory, &config, &world));
    CHECK(trisap_world_len(world) == 0);
}

int main(void) {
    versions();
    defaults();
    singles();
    batches();
    filters();
    once();
    queries();
    values();
    newcomer(4);
    newcomer(2000);
    resting();
    questions();
    tree();
    doubles();
    fixed_and_shifted();
    saved();
    sorted();
    saved_after_a_shift();
    copies();
    statics();
    puts("life: all checks passed");
    return 0;
}
