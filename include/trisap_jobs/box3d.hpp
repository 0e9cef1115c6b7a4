// The task callbacks that Box3D is given, for trisap. Needs Box3D's own headers.

#ifndef TRISAP_JOBS_BOX3D_HPP
#define TRISAP_JOBS_BOX3D_HPP

#include <box3d/types.h>

#include "../trisap.hpp"

namespace trisap {

/// Jobs for `World::step` on the task system that a `b3WorldDef` names by its `workerCount`, `enqueueTask`, `finishTask` and
/// context.
[[nodiscard]] inline auto jobs_of(std::uint32_t workers, b3EnqueueTaskCallback *enqueue, b3FinishTaskCallback *finish,
                                  void *context) {
    return jobs(workers, [=](std::uint32_t count, Task task) {
        // No world has more workers than this.
        void *tasks[32] = {};
        for (std::uint32_t i = 1; i < count; i++) {
            tasks[i] = enqueue(task.function(), task.argument(), context, task.name());
        }
        task();
        for (std::uint32_t i = 1; i < count; i++) {
            // Null: it has run in the call.
            if (tasks[i] != nullptr) {
                finish(tasks[i], context);
            }
        }
    });
}

} // namespace trisap

#endif // TRISAP_JOBS_BOX3D_HPP
