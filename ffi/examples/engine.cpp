// A minimal engine: bodies in an array of its own, a job system of its own, and trisap between them.

#include "job_system.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <trisap.hpp>
#include <vector>

/// A ball in a room. trisap reads `min` and `max` where they stand.
struct Body {
    float position[3], velocity[3], min[3], max[3];

    void move() {
        constexpr float radius = 0.5f, side = 80.0f, dt = 1.0f / 60.0f;
        velocity[1] -= 9.81f * dt;
        for (int k = 0; k < 3; k++) {
            position[k] = std::clamp(position[k] + velocity[k] * dt, radius, side - radius);
            velocity[k] *= 0.99f;
            min[k] = position[k] - radius;
            max[k] = position[k] + radius;
        }
    }
};

/// Narrow phase and solver: balls that overlap part and share their momentum. Returns whether they overlapped.
static bool collide(Body &a, Body &b) {
    const auto apart = [&](int k) { return b.position[k] - a.position[k]; };
    const float distance = std::hypot(apart(0), apart(1), apart(2));
    for (int k = 0; k < 3 && distance > 0.0f && distance < 1.0f; k++) {
        const float push = 0.5f * (1.0f - distance) * apart(k) / distance;
        a.position[k] -= push, b.position[k] += push;
        a.velocity[k] = b.velocity[k] = 0.5f * (a.velocity[k] + b.velocity[k]);
    }
    return distance < 1.0f;
}

int main() {
    std::vector<Body> bodies(5000);
    for (std::size_t i = 0; i < bodies.size(); i++) { // a tower of layers, each askew
        const auto x = static_cast<float>(i % 50), y = static_cast<float>(i / 2500), z = static_cast<float>(i / 50 % 50);
        bodies[i] = {{5.0f + 1.1f * x + 0.5f * y, 1.0f + 1.5f * y, 7.0f + 1.1f * z}, {}, {}, {}};
        bodies[i].move();
    }

    JobSystem job_system(4);
    auto jobs = trisap::jobs(4, [&](unsigned count, trisap::Task task) {
        job_system.run(count, task.function(), task.argument());
    });
    const trisap::Boxes boxes = trisap::boxes_in(bodies, &Body::min, &Body::max);
    trisap::Config config = trisap::config(5000);
    config.workers = 4;
    trisap::World world;
    std::vector<trisap::Id> ids(bodies.size());
    if (world.init(config) != TRISAP_STATUS_OK || world.insert(boxes, ids) != TRISAP_STATUS_OK) {
        return 1;
    }

    for (int frame = 1; frame <= 120; frame++) {
        std::for_each(bodies.begin(), bodies.end(), [](Body &body) { body.move(); });
        const trisap::Step step = world.step_over(boxes, jobs); // slots are the indices of the array
        if (!step) {
            std::fprintf(stderr, "%s\n", trisap::text(step.status));
            return 1;
        }
        std::size_t contacts = 0;
        for (const auto &[a, b] : step.pairs) {
            contacts += collide(bodies[a], bodies[b]);
        }
        if (frame % 30 == 0) {
            std::printf("frame %d: %zu pairs, %zu contacts\n", frame, step.pairs.size(), contacts);
        }
    }
}
