// The first program of someone who has just installed trisap.

#include <cstdio>
#include <cstdlib>
#include <trisap.hpp>

int main() {
    trisap::World world;
    const trisap::Aabb aabbs[] = {{{0, 0, 0}, {1, 1, 1}}, {{1, 0, 0}, {2, 1, 1}}};
    trisap::Id ids[2];
    if (world.init(trisap::config(2)) != TRISAP_STATUS_OK ||
        world.insert(trisap::boxes(aabbs), ids) != TRISAP_STATUS_OK) {
        return EXIT_FAILURE;
    }
    const trisap::Step step = world.step();
    std::printf("trisap %s: %zu pair\n", trisap_version(), step.pairs.size());
    return step && step.pairs.size() == 1 ? EXIT_SUCCESS : EXIT_FAILURE;
}
