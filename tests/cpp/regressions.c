// Faults that were found and mended, as a C program met them.

#include "check.h"
#include <string.h>
#include <trisap.h>
#ifdef __SSE__
#include <xmmintrin.h>
#endif

static trisap_aabb on_x(float min, float max) {
    const trisap_aabb aabb = {{min, 0.0f, 0.0f}, {max, 1.0f, 1.0f}};
    return aabb;
}

static trisap_world *make(const trisap_config *config, const trisap_aabb *aabbs, uint32_t count, trisap_id *ids) {
    const size_t bytes = trisap_world_size(config);
    CHECK(bytes > 0);
    void *memory = aligned_alloc(trisap_world_align(), bytes);
    CHECK(memory != NULL);
    trisap_world *world = NULL;
    CHECK_OK(trisap_world_init(memory, bytes, config, &world));
    const trisap_boxes boxes = trisap_default_boxes(aabbs, count);
    CHECK_OK(trisap_world_insert_many(world, &boxes, ids));
    return world;
}

// The mark of an id that comes twice was a bit that an id can have itself.
static void forged_generation(void) {
    const trisap_config config = trisap_default_config(4);
    const trisap_aabb aabbs[2] = {on_x(0.0f, 1.0f), on_x(0.5f, 2.0f)};
    trisap_id ids[2];
    trisap_world *world = make(&config, aabbs, 2, ids);
    const trisap_id forged[2] = {ids[0], ids[0] ^ 1ull << 63};
    CHECK_STATUS(trisap_world_remove_many(world, forged, 2), TRISAP_STATUS_STALE_ID);
    CHECK(trisap_world_error_detail(world) == forged[1]);
    CHECK(trisap_world_len(world) == 2);
    CHECK_OK(trisap_world_contains(world, ids[0]));
    CHECK_OK(trisap_world_remove_many(world, ids, 2));
    trisap_id again[2];
    for (int i = 0; i < 2; i++) {
        CHECK_OK(trisap_world_insert(world, &aabbs[i], &again[i]));
    }
    CHECK((uint32_t)again[0] != (uint32_t)again[1]);
    CHECK_OK(trisap_world_validate(world));
    free(world);
}

// Overlaps of fat boxes that are no pairs do not take the room of pairs.
static void margins_without_room(void) {
    trisap_config config = trisap_default_config(3);
    config.pairs = 1;
    config.events = 1;
    config.has_margin = 1;
    config.margin_per_extent = 0.0f;
    config.margin_min = 1.0f;
    config.margin_max = 1.0f;
    trisap_aabb aabbs[3] = {on_x(0.0f, 1.0f), on_x(1.5f, 2.5f), on_x(3.0f, 4.0f)};
    trisap_id ids[3];
    trisap_world *world = make(&config, aabbs, 3, ids);
    const trisap_boxes boxes = trisap_default_boxes(aabbs, 3);
    trisap_result result = trisap_default_result();
    CHECK_OK(trisap_world_step_over(world, &boxes, NULL, &result));
    CHECK(result.pair_count == 0 && result.found_count == 0);
    aabbs[0] = on_x(0.75f, 1.75f);
    CHECK_OK(trisap_world_step_over(world, &boxes, NULL, &result));
    CHECK(result.pair_count == 1 && result.found_count == 1 && result.lost_count == 0);
    CHECK(result.pairs[0].a == 0 && result.pairs[0].b == 1);
    aabbs[0] = on_x(0.25f, 1.25f);
    aabbs[1] = on_x(2.25f, 3.25f);
    CHECK_OK(trisap_world_step_over(world, &boxes, NULL, &result));
    CHECK(result.pair_count == 1 && result.found_count == 1 && result.lost_count == 1);
    CHECK(result.pairs[0].a == 1 && result.lost[0].a == 0);
    aabbs[0] = on_x(0.75f, 2.75f);
    CHECK_STATUS(trisap_world_step_over(world, &boxes, NULL, &result), TRISAP_STATUS_PAIRS_FULL);
    CHECK(result.pairs_needed == 2 && trisap_world_error_detail(world) == 2);
    CHECK_OK(trisap_world_validate(world));
    free(world);
}

// A box holds what it was made of, though the program has the CPU take the least numbers for zero.
static void flushed_denormals(void) {
    const double numbers[] = {-1e-40, 1e-40, -1e-300, 1e-300, 5e-324, -1.5e-45};
    const double none[3] = {0.0, 0.0, 0.0};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        const double corner[3] = {numbers[i], numbers[i], numbers[i]};
        const trisap_aabb plain = trisap_aabb_from_f64(corner, corner, none);
        CHECK((double)plain.min[0] <= corner[0] && (double)plain.max[0] >= corner[0]);
        CHECK(plain.min[0] < plain.max[0]);
#ifdef __SSE__
        const unsigned before = _mm_getcsr();
        _mm_setcsr(before | 0x8040); // Flush to zero, denormals are zero.
        const trisap_aabb flushed = trisap_aabb_from_f64(corner, corner, none);
        _mm_setcsr(before);
        CHECK(memcmp(&plain, &flushed, sizeof plain) == 0);
#endif
    }
}

// Memory that others wrote to, word by word: each step ends with a status, and an index that leads nowhere is told of.
static void damaged_memory(void) {
    // The header and the world's numbers, which decide how much there is to do.
    enum { OBJECTS = 40, FIRST = 512 };
    const trisap_config config = trisap_default_config(OBJECTS);
    trisap_aabb aabbs[OBJECTS];
    trisap_id ids[OBJECTS];
    for (int i = 0; i < OBJECTS; i++) {
        aabbs[i] = on_x(0.75f * (float)i, 0.75f * (float)i + 1.0f);
    }
    trisap_world *world = make(&config, aabbs, OBJECTS, ids);
    trisap_result result = trisap_default_result();
    CHECK_OK(trisap_world_step(world, NULL, &result));
    const size_t bytes = trisap_world_size(&config);
    unsigned char *good = malloc(bytes);
    CHECK(good != NULL);
    memcpy(good, world, bytes);
    unsigned told = 0;
    for (size_t at = FIRST; at + 4 <= bytes; at += 4) {
        memcpy(world, good, bytes);
        memset((unsigned char *)world + at, 0xff, 4);
        if (trisap_world_update(world, ids[3], &aabbs[7]) != TRISAP_STATUS_OK) {
            continue; // It was the id's own generation.
        }
        const trisap_status status = trisap_world_step(world, NULL, &result);
        CHECK(status == TRISAP_STATUS_OK || status == TRISAP_STATUS_CORRUPT || status == TRISAP_STATUS_PAIRS_FULL);
        told += status == TRISAP_STATUS_CORRUPT;
    }
    // At least the places of the objects in the list that is swept.
    CHECK(told >= OBJECTS / 2);
    memcpy(world, good, bytes);
    // A fault is a matter of the step that has it: what is whole again is right at once.
    CHECK_OK(trisap_world_step(world, NULL, &result));
    CHECK(result.pair_count == OBJECTS - 1);
    free(good);
    free(world);
}

struct asked {
    const trisap_aabb *aabbs;
    uint32_t gone, times;
};

static uint32_t look(void *user, uint32_t a, uint32_t b) {
    struct asked *asked = user;
    asked->times++;
    CHECK(a != asked->gone && b != asked->gone);
    for (int k = 0; k < 3; k++) {
        CHECK(asked->aabbs[a].min[k] <= asked->aabbs[b].max[k] && asked->aabbs[b].min[k] <= asked->aabbs[a].max[k]);
    }
    return 1;
}

// The first step after a load asked the rule about objects that had been removed since, and about pairs that did not overlap.
static void rule_after_load(void) {
    enum { OBJECTS = 1000 };
    trisap_config config = trisap_default_config(OBJECTS);
    config.filters = 1;
    config.pairs = 20 * OBJECTS;
    static trisap_aabb aabbs[OBJECTS];
    static trisap_id ids[OBJECTS];
    for (int i = 0; i < OBJECTS; i++) {
        const float corner[3] = {(float)(i * 37 % 101) * 0.1f, (float)(i * 53 % 103) * 0.1f, (float)(i * 71 % 107) * 0.1f};
        for (int k = 0; k < 3; k++) {
            aabbs[i].min[k] = corner[k];
            aabbs[i].max[k] = corner[k] + 1.0f;
        }
    }
    trisap_world *world = make(&config, aabbs, OBJECTS, ids);
    struct asked asked = {aabbs, UINT32_MAX, 0};
    trisap_result result = trisap_default_result();
    CHECK_OK(trisap_world_step_with_rule(world, NULL, look, &asked, NULL, &result));
    CHECK(asked.times == result.pair_count && asked.times > OBJECTS);
    const size_t room = trisap_world_snapshot_size(world);
    void *snapshot = malloc(room);
    CHECK(snapshot != NULL);
    size_t size = 0;
    CHECK_OK(trisap_world_save(world, snapshot, room, &size));
    for (uint32_t gone = 0; gone < OBJECTS; gone += 30) {
        CHECK_OK(trisap_world_load(world, snapshot, size));
        asked.gone = gone;
        CHECK_OK(trisap_world_remove(world, ids[gone]));
        CHECK_OK(trisap_world_step_with_rule(world, NULL, look, &asked, NULL, &result));
        CHECK(result.pair_count > OBJECTS);
    }
    free(snapshot);
    free(world);
}

int main(void) {
    forged_generation();
    margins_without_room();
    flushed_denormals();
    damaged_memory();
    rule_after_load();
    puts("regressions: all checks passed");
    return 0;
}
