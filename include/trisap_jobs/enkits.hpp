// enkiTS's task scheduler for trisap. Needs enkiTS's own headers.

#ifndef TRISAP_JOBS_ENKITS_HPP
#define TRISAP_JOBS_ENKITS_HPP

#include <TaskScheduler.h>

#include "../trisap.hpp"

namespace trisap {

/// Jobs for `World::step` on a scheduler, which must outlive them. Any number of worlds may use one. A step is called on the thread
/// that has initialised the scheduler, in a task, or on an external thread that is registered.
[[nodiscard]] inline auto jobs_of(enki::TaskScheduler &scheduler) {
    return jobs(scheduler.GetNumTaskThreads(), [&scheduler](std::uint32_t count, Task task) {
        // By reference, so that the function object allocates nothing.
        enki::TaskSet calls(count - 1, [&task](enki::TaskSetPartition range, std::uint32_t) {
            for (std::uint32_t i = range.start; i < range.end; i++) {
                task();
            }
        });
        scheduler.AddTaskSetToPipe(&calls);
        task();
        // No work is left for calls that have not begun: whoever takes them, perhaps this thread, is done at once.
        scheduler.WaitforTask(&calls, calls.m_Priority);
    });
}

} // namespace trisap

#endif // TRISAP_JOBS_ENKITS_HPP
