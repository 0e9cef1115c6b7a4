// A job system that costs nothing when other programs want the processors: the calling thread waits only for calls that have
// begun, and works alone for a while after such a wait.

#ifndef JOB_SYSTEM_HPP
#define JOB_SYSTEM_HPP

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

/// Threads that run one function at a time, together with the thread that has it.
class JobSystem {
public:
    /// How often others took part, how often the caller worked alone, and how often it had to wait for too long.
    struct Counts {
        std::uint64_t shared, alone, losses;
    };

    /// The calling thread is one of the workers.
    explicit JobSystem(unsigned workers) {
        for (unsigned i = 1; i < workers; i++) {
            threads_.emplace_back([this] { work(); });
        }
    }

    ~JobSystem() {
        {
            const std::lock_guard lock(mutex_);
            stopping_ = true;
        }
        wake_.notify_all();
        std::for_each(threads_.begin(), threads_.end(), [](std::thread &thread) { thread.join(); });
    }

    JobSystem(const JobSystem &) = delete;
    JobSystem &operator=(const JobSystem &) = delete;

    /// Calls the function here, and on up to `count - 1` threads that come before it returns; waits for these.
    void run(unsigned count, void (*function)(void *), void *argument) {
        std::uint32_t nobody = 0;
        if (!state_.compare_exchange_strong(nobody, held, std::memory_order_acquire)) {
            function(argument); // the threads have another caller's function
            alone_++;
            return;
        }
        const Clock::time_point begun = Clock::now();
        if (begun < alone_until_) {
            state_.store(0, std::memory_order_release);
            function(argument);
            alone_++;
            return;
        }
        function_ = function, argument_ = argument, came_ = 0, first_ = never;
        begun_ = begun;
        state_.store(held | seat * std::min(count - 1, max_seats), std::memory_order_seq_cst);
        call_sleepers();
        call();
        state_.fetch_and(~seats, std::memory_order_acq_rel); // nobody begins from here on
        wait();
        note(Clock::now());
        state_.store(0, std::memory_order_release);
    }

    [[nodiscard]] Counts counts() const { return {shared_, alone_, losses_}; }

private:
    using Clock = std::chrono::steady_clock;
    using Time = Clock::duration;
    static constexpr Time spin = std::chrono::microseconds(10), awake = std::chrono::microseconds(50),
                          linger = std::chrono::microseconds(200), skew = std::chrono::microseconds(20),
                          longest = std::chrono::seconds(1);
    static constexpr std::int64_t never = INT64_MAX;
    /// The state: whether a caller has it, how many calls may begin, and how many have begun and not returned.
    static constexpr std::uint32_t held = 1u << 31, seat = 1u << 16, seats = held - seat, running = seat - 1,
                                   max_seats = seats / seat;

    void call() {
        function_(argument_);
        const std::int64_t now = (Clock::now() - begun_).count();
        std::int64_t first = first_.load(std::memory_order_relaxed);
        while (now < first && !first_.compare_exchange_weak(first, now, std::memory_order_relaxed)) {
        }
    }

    bool take_part() {
        std::uint32_t state = state_.load(std::memory_order_relaxed);
        do {
            if ((state & seats) == 0) {
                return false;
            }
        } while (!state_.compare_exchange_weak(state, state - seat + 1, std::memory_order_acquire, std::memory_order_relaxed));
        call();
        came_.store(1, std::memory_order_relaxed);
        // Either this thread sees that the caller sleeps, or the caller sees that the call has ended.
        state_.fetch_sub(1, std::memory_order_seq_cst);
        if (caller_sleeps_.load(std::memory_order_seq_cst)) {
            const std::lock_guard lock(mutex_);
            ended_.notify_all();
        }
        return true;
    }

    /// Either this thread sees who goes to sleep, or who does sees that there are seats.
    void call_sleepers() {
        if (asleep_.load(std::memory_order_seq_cst) > 0) {
            const std::lock_guard lock(mutex_);
            asleep_ = 0, round_++;
            wake_.notify_all();
        }
    }

    [[nodiscard]] bool others_run() const { return (state_.load(std::memory_order_seq_cst) & running) != 0; }

    /// Spins, then lets others run, then sleeps, so that a thread that has lost its processor gets this one.
    void wait() {
        for (const Clock::time_point since = Clock::now(); others_run();) {
            const Time waited = Clock::now() - since;
            if (waited > awake) {
                std::unique_lock lock(mutex_);
                caller_sleeps_.store(true, std::memory_order_seq_cst);
                ended_.wait(lock, [this] { return !others_run(); });
                caller_sleeps_.store(false, std::memory_order_relaxed);
            } else if (waited > spin) {
                std::this_thread::yield();
            }
        }
    }

    /// What waiting has cost is paid back by a time alone: 32 times as long, and longer if it happens again and again.
    void note(Clock::time_point now) {
        if (came_.load(std::memory_order_relaxed) == 0) {
            alone_++;
            return;
        }
        shared_++;
        const Time took = now - begun_, lost = took - Time(first_.load(std::memory_order_relaxed)) * 3 / 2 - skew;
        if (lost > Time::zero()) {
            losses_++;
            rest_ = std::min(std::max(32 * lost, std::min(2 * rest_, 1000 * lost)), longest);
            alone_until_ = now + rest_, calm_ = Time::zero();
        } else if ((calm_ += took) > rest_) {
            rest_ /= 2, calm_ = Time::zero();
        }
    }

    void work() {
        for (;;) {
            {
                std::unique_lock lock(mutex_);
                asleep_++;
                const std::uint64_t seen = round_;
                wake_.wait(lock, [&] { return stopping_ || round_ != seen || (state_.load(std::memory_order_seq_cst) & seats) != 0; });
                if (round_ == seen) {
                    asleep_--;
                }
                if (stopping_) {
                    return;
                }
            }
            // The stages of a step follow each other within microseconds. Who waits longer than a few lets others run.
            Clock::time_point last = Clock::now();
            for (Clock::time_point now = last; now - last < linger; now = Clock::now()) {
                if (take_part()) {
                    last = Clock::now();
                } else if (now - last > spin) {
                    std::this_thread::yield();
                }
            }
        }
    }

    std::atomic<std::uint32_t> state_ = 0;
    /// Written by the caller that has the state, before the seats are there.
    void (*function_)(void *) = nullptr;
    void *argument_ = nullptr;
    Clock::time_point begun_;
    /// The time when the first call ended, since `begun_`, and whether another thread has come.
    std::atomic<std::int64_t> first_ = never;
    std::atomic<int> came_ = 0;
    /// For who has the state.
    Clock::time_point alone_until_;
    Time rest_ = Time::zero(), calm_ = Time::zero();
    std::atomic<std::uint64_t> shared_ = 0, alone_ = 0, losses_ = 0;

    std::atomic<bool> caller_sleeps_ = false;
    std::atomic<unsigned> asleep_ = 0;
    std::mutex mutex_;
    std::condition_variable wake_, ended_;
    bool stopping_ = false;
    std::uint64_t round_ = 0;
    std::vector<std::thread> threads_;
};

#endif
