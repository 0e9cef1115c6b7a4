// oneTBB's task arenas for trisap. Needs oneTBB's own headers.

#ifndef TRISAP_JOBS_TBB_HPP
#define TRISAP_JOBS_TBB_HPP

#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

#include "../trisap.hpp"

namespace trisap {

/// Jobs for `World::step` in a task arena, which must outlive them. Any number of worlds may use one, also from within its
/// tasks.
[[nodiscard]] inline auto jobs_of(oneapi::tbb::task_arena &arena) {
    return jobs(static_cast<std::uint32_t>(arena.max_concurrency()), [&arena](std::uint32_t count, Task task) {
        arena.execute([&] {
            oneapi::tbb::task_group calls;
            for (std::uint32_t i = 1; i < count; i++) {
                calls.run([task] { task(); });
            }
            task();
            // No work is left for calls that have not begun: this thread makes them in passing.
            calls.wait();
        });
    });
}

} // namespace trisap

#endif // TRISAP_JOBS_TBB_HPP
