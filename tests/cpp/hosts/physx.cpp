// trisap on a CPU dispatcher of PhysX, one that starts a thread for every task.

#include "scene.hpp"

#include <atomic>
#include <thread>
#include <trisap_jobs/physx.hpp>

class Dispatcher final : public physx::PxCpuDispatcher {
public:
    ~Dispatcher() override {
        for (std::thread &thread : threads_) {
            thread.join();
        }
    }

    void submitTask(physx::PxBaseTask &task) override {
        CHECK(std::strcmp(task.getName(), "trisap step") == 0);
        threads_.emplace_back([&task] {
            task.run();
            task.release();
        });
    }

    std::uint32_t getWorkerCount() const override { return 3; }

    std::size_t submitted() const { return threads_.size(); }

private:
    std::vector<std::thread> threads_;
};

/// One whose only thread makes the step, as where that is in one of its tasks: others come when it has ended.
class Late final : public physx::PxCpuDispatcher {
public:
    ~Late() override {
        for (physx::PxBaseTask *task : tasks_) {
            task->run();
            task->release();
        }
    }

    void submitTask(physx::PxBaseTask &task) override { tasks_.push_back(&task); }

    std::uint32_t getWorkerCount() const override { return 1; }

private:
    std::vector<physx::PxBaseTask *> tasks_;
};

int main() {
    Dispatcher dispatcher;
    check_same_pairs(trisap::jobs_of(dispatcher));
    CHECK(dispatcher.submitted() > 0);
    Late late;
    check_same_pairs(trisap::jobs_of(late));
    return 0;
}
