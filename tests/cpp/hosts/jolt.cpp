// trisap on Jolt's job system. Compiled only: Jolt's own sources would be needed to run it.

#include <trisap_jobs/jolt.hpp>

trisap::Step step(trisap::World &world, JPH::JobSystem &system) {
    auto jobs = trisap::jobs_of(system);
    return world.step(jobs);
}
