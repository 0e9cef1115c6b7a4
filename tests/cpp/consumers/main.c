// The first program of someone who has just installed trisap.

#include <stdio.h>
#include <stdlib.h>
#include <trisap.h>

int main(void) {
    if (trisap_abi_version() != TRISAP_ABI_VERSION) {
        return EXIT_FAILURE;
    }
    const trisap_config config = trisap_default_config(2);
    const size_t bytes = trisap_world_size(&config);
    void *memory = aligned_alloc(trisap_world_align(), bytes);
    trisap_world *world = NULL;
    if (memory == NULL || trisap_world_init(memory, bytes, &config, &world) != TRISAP_STATUS_OK) {
        return EXIT_FAILURE;
    }
    const trisap_aabb aabbs[2] = {{{0, 0, 0}, {1, 1, 1}}, {{1, 0, 0}, {2, 1, 1}}};
    const trisap_boxes boxes = trisap_default_boxes(aabbs, 2);
    trisap_id ids[2];
    trisap_result result = trisap_default_result();
    if (trisap_world_insert_many(world, &boxes, ids) != TRISAP_STATUS_OK ||
        trisap_world_step(world, NULL, &result) != TRISAP_STATUS_OK) {
        return EXIT_FAILURE;
    }
    printf("trisap %s: %zu pair\n", trisap_version(), result.pair_count);
    free(memory);
    return result.pair_count == 1 ? EXIT_SUCCESS : EXIT_FAILURE;
}
