// A step with the help of a host's job system gives what a step without it gives.

#ifndef SCENE_HPP
#define SCENE_HPP

#include "../check.h"

#include <cstring>
#include <random>
#include <trisap.hpp>
#include <vector>

template <class Jobs> void check_same_pairs(Jobs jobs) {
    std::vector<trisap::Aabb> boxes(5000);
    std::mt19937 random(1);
    for (trisap::Aabb &aabb : boxes) {
        for (int k = 0; k < 3; k++) {
            aabb.min[k] = static_cast<float>(random() % 4096) / 256.0f;
            aabb.max[k] = aabb.min[k] + 1.0f;
        }
    }
    trisap::Config config = trisap::config(5000);
    config.pairs = 40 * 5000;
    config.workers = 4;
    std::vector<trisap::Id> ids(boxes.size());
    trisap::World alone, helped;
    for (trisap::World *world : {&alone, &helped}) {
        CHECK_OK(world->init(config));
        CHECK_OK(world->insert(trisap::boxes(boxes), ids));
    }
    const trisap::Step expected = alone.step(), step = helped.step(jobs);
    CHECK_OK(step.status);
    CHECK(step.pairs.size() == expected.pairs.size() && step.pairs.size() > 1000);
    CHECK(std::memcmp(step.pairs.data(), expected.pairs.data(), step.pairs.size() * sizeof(trisap::Pair)) == 0);
}

#endif
