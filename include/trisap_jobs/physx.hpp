// PhysX's CPU dispatchers for trisap. Needs PhysX's own headers.

#ifndef TRISAP_JOBS_PHYSX_HPP
#define TRISAP_JOBS_PHYSX_HPP

#include <foundation/PxPreprocessor.h>

#include <foundation/PxSimpleTypes.h>
#include <task/PxCpuDispatcher.h>
#include <task/PxTask.h>

#include "../trisap.hpp"

#include <condition_variable>
#include <memory>
#include <mutex>
#include <new>

namespace trisap {
namespace detail {

/// How many calls of a job are inside, and whether no more may begin. It is there until the dispatcher has forgotten the last of them.
struct PhysxJob {
    std::mutex mutex;
    std::condition_variable left;
    std::uint32_t inside = 0;
    bool is_over = false;
};

/// A call of a task, as PhysX's dispatchers take it: they run it, and release it when they have forgotten it. A call that comes when
/// the job is over does nothing, so nobody waits for a dispatcher whose threads do something else.
class PhysxCall final : public physx::PxBaseTask {
public:
    PhysxCall(Task task, std::shared_ptr<PhysxJob> job) noexcept : task_(task), job_(std::move(job)) {}

    void run() override {
        {
            const std::lock_guard lock(job_->mutex);
            if (job_->is_over) {
                return;
            }
            job_->inside++;
        }
        task_();
        const std::lock_guard lock(job_->mutex);
        job_->inside--;
        job_->left.notify_one();
    }
    const char *getName() const override { return task_.name(); }
    void addReference() override {}
    void removeReference() override {}
    std::int32_t getReference() const override { return 1; }
    void release() override { delete this; }

private:
    Task task_;
    std::shared_ptr<PhysxJob> job_;
};

} // namespace detail

/// Jobs for `World::step` on a PhysX dispatcher, which must outlive them. The calling thread works, too, and comes on top of
/// the dispatcher's own. Any number of worlds may use one, also from within its tasks.
[[nodiscard]] inline auto jobs_of(physx::PxCpuDispatcher &dispatcher) {
    return jobs(dispatcher.getWorkerCount() + 1, [&dispatcher](std::uint32_t count, Task task) {
        const auto job = std::make_shared<detail::PhysxJob>();
        for (std::uint32_t i = 1; i < count; i++) {
            if (auto *call = new (std::nothrow) detail::PhysxCall(task, job)) {
                dispatcher.submitTask(*call);
            }
        }
        task();
        std::unique_lock lock(job->mutex);
        job->is_over = true;
        job->left.wait(lock, [&job] { return job->inside == 0; });
    });
}

} // namespace trisap

#endif // TRISAP_JOBS_PHYSX_HPP
