// Jolt's job system for trisap. Needs Jolt's own headers.

#ifndef TRISAP_JOBS_JOLT_HPP
#define TRISAP_JOBS_JOLT_HPP

#include <Jolt/Jolt.h>

#include <Jolt/Core/Color.h>
#include <Jolt/Core/JobSystem.h>

#include "../trisap.hpp"

namespace trisap {

/// Jobs for `World::step` on a Jolt job system, which must outlive them. Takes a barrier and as many jobs as the world has
/// workers, less one, for the time of each stage of a step: make the job system with that much to spare.
[[nodiscard]] inline auto jobs_of(JPH::JobSystem &system) {
    const auto workers = static_cast<std::uint32_t>(system.GetMaxConcurrency());
    return jobs(workers, [&system](std::uint32_t count, Task task) {
        JPH::JobSystem::Barrier *barrier = system.CreateBarrier();
        for (std::uint32_t i = 1; i < count && barrier != nullptr; i++) {
            barrier->AddJob(system.CreateJob(task.name(), JPH::Color::sGrey, [task] { task(); }));
        }
        task();
        // Where Jolt has no barrier left, the calling thread has done it all.
        if (barrier != nullptr) {
            system.WaitForJobs(barrier);
            system.DestroyBarrier(barrier);
        }
    });
}

} // namespace trisap

#endif // TRISAP_JOBS_JOLT_HPP
