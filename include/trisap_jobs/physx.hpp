// PhysX's CPU dispatchers for trisap. Needs PhysX's own headers.

#ifndef TRISAP_JOBS_PHYSX_HPP
#define TRISAP_JOBS_PHYSX_HPP

#include <foundation/PxPreprocessor.h>

#include <foundation/PxSimpleTypes.h>
#include <task/PxCpuDispatcher.h>
#include <task/PxTask.h>

#include "../trisap.hpp"

#include <condition_variable>
#include <mutex>
#include <optional>

namespace trisap {
namespace detail {

/// Counts the calls that are not done.
struct OpenCalls {
    std::mutex mutex;
    std::condition_variable all_done;
    std::uint32_t count;
};

/// A call of a task, as PhysX's dispatchers take it: they run it, and release it when they have forgotten it.
class PhysxCall final : public physx::PxBaseTask {
public:
    PhysxCall(Task task, OpenCalls &open) : task_(task), open_(open) {}

    void run() override { task_(); }
    const char *getName() const override { return task_.name(); }
    void addReference() override {}
    void removeReference() override {}
    std::int32_t getReference() const override { return 1; }
    void release() override {
        const std::lock_guard lock(open_.mutex);
        open_.count--;
        open_.all_done.notify_one();
    }

private:
    Task task_;
    OpenCalls &open_;
};

} // namespace detail

/// Jobs for `World::step` on a PhysX dispatcher, which must outlive them. The calling thread works, too, and comes on top of
/// the dispatcher's own.
[[nodiscard]] inline auto jobs_of(physx::PxCpuDispatcher &dispatcher) {
    return jobs(dispatcher.getWorkerCount() + 1, [&dispatcher](std::uint32_t count, Task task) {
        detail::OpenCalls open{{}, {}, count - 1};
        // No world has more workers than this.
        std::optional<detail::PhysxCall> calls[32];
        for (std::uint32_t i = 1; i < count; i++) {
            dispatcher.submitTask(calls[i].emplace(task, open));
        }
        task();
        std::unique_lock lock(open.mutex);
        open.all_done.wait(lock, [&open] { return open.count == 0; });
    });
}

} // namespace trisap

#endif // TRISAP_JOBS_PHYSX_HPP
