// Every function of trisap.h as it is meant to be used, in C11. Memory is exactly as long as asked for, so that the
// sanitizers see every step beyond it.

#include "check.h"
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
    CHECK(strlen(trisap_instruction_set()) > 0 && strcmp(trisap_instruction_set(), "other") != 0);
    for (int32_t status = -2; status <= TRISAP_STATUS_OTHER + 2; status++) {
        const bool known = status >= 0 && status <= TRISAP_STATUS_OTHER;
        CHECK((strcmp(trisap_status_text(status), "not a status") != 0) == known);
    }
}

static void defaults(void) {
    const trisap_config config = trisap_default_config(100);
    CHECK(config.struct_size == sizeof config && config.objects == 100 && config.leaf_refs == 50);
    CHECK(config.pairs == 800 && config.mode == TRISAP_MODE_EXACT && config.workers == 1);
    CHECK(config.events == 0 && config.has_margin == 0);
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

// A copy of the memory goes on as the world does.
static void snapshots(void) {
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
    snapshots();
    statics();
    puts("life: all checks passed");
    return 0;
}
