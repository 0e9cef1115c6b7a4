// A job system as engines have one, at its smallest: threads that wait for work, and a call that waits for its tasks.

#ifndef POOL_HPP
#define POOL_HPP

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

class Pool {
public:
    /// The calling thread is one of the workers.
    explicit Pool(std::uint32_t workers) {
        for (std::uint32_t i = 1; i < workers; i++) {
            threads_.emplace_back([this] { work(); });
        }
    }

    ~Pool() {
        {
            const std::lock_guard lock(mutex_);
            ending_ = true;
        }
        wake_.notify_all();
        for (std::thread &thread : threads_) {
            thread.join();
        }
    }

    Pool(const Pool &) = delete;
    Pool &operator=(const Pool &) = delete;

    [[nodiscard]] std::uint32_t workers() const { return static_cast<std::uint32_t>(threads_.size()) + 1; }

    /// Calls `task` on the calling thread and up to `count - 1` times on others, and returns when all calls have returned. Calls
    /// that nobody has begun by then are taken back: there is no work left for them.
    template <class Task> void run(std::uint32_t count, Task task) {
        std::unique_lock lock(mutex_);
        std::uint32_t open = count - 1;
        for (std::uint32_t i = 1; i < count; i++) {
            queue_.push_back({&open, [this, task, &open] {
                                  task();
                                  const std::lock_guard done(mutex_);
                                  open--;
                                  done_.notify_all();
                              }});
        }
        wake_.notify_all();
        lock.unlock();
        task();
        lock.lock();
        for (auto call = queue_.begin(); call != queue_.end();) {
            const bool own = call->owner == &open;
            open -= own;
            call = own ? queue_.erase(call) : call + 1;
        }
        done_.wait(lock, [&open] { return open == 0; });
    }

private:
    struct Call {
        std::uint32_t *owner;
        std::function<void()> function;
    };

    void work() {
        std::unique_lock lock(mutex_);
        while (true) {
            wake_.wait(lock, [this] { return ending_ || !queue_.empty(); });
            if (queue_.empty()) {
                return;
            }
            const std::function<void()> job = std::move(queue_.front().function);
            queue_.pop_front();
            lock.unlock();
            job();
            lock.lock();
        }
    }

    std::mutex mutex_;
    std::condition_variable wake_, done_;
    std::deque<Call> queue_;
    bool ending_ = false;
    std::vector<std::thread> threads_;
};

#endif
