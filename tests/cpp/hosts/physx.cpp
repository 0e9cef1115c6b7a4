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

int main() {
    Dispatcher dispatcher;
    check_same_pairs(trisap::jobs_of(dispatcher));
    CHECK(dispatcher.submitted() > 0);
    return 0;
}
