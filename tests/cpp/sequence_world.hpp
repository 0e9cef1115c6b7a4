// A world behind the C ABI, what has been said of it, and how an operation chooses objects and job systems.

#ifndef SEQUENCE_WORLD_HPP
#define SEQUENCE_WORLD_HPP

#include "calls.hpp"
#include "sequence.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <thread>

struct Tally {
    std::array<std::uint64_t, kinds> ran{};
    std::array<std::uint64_t, 6> paths{};
    std::uint64_t refused = 0, full = 0, rejecting = 0, pairs = 0, found = 0, lost = 0, fine = 0, large = 0, answers = 0,
                  loaded = 0, forged_refused = 0, forged_loaded = 0, grown = 0, refreshed = 0;
};

struct Free {
    void operator()(void *memory) const { ::operator delete(memory, std::align_val_t(trisap_world_align())); }
};
using Memory = std::unique_ptr<void, Free>;

inline Memory allocate(std::size_t bytes) {
    return Memory(::operator new(bytes, std::align_val_t(trisap_world_align())));
}

/// Where the state ends in snapshots, which comes first: there is nothing else in that of a world without objects.
inline std::size_t front() {
    static const std::size_t bytes = [] {
        const trisap::Config config = trisap::config(1);
        const std::size_t size = trisap_world_size(&config);
        const Memory memory = allocate(size);
        trisap_world *world = nullptr;
        CHECK_OK(trisap_world_init(memory.get(), size, &config, &world));
        return trisap_world_snapshot_size(world);
    }();
    return bytes;
}

class World {
public:
    World(const std::uint8_t *bytes, Tally &tally)
        : header_(bytes), tally_(tally), config_(header_.config()), objects_(config_.objects), known_(objects_),
          opinions_(objects_) {
        bytes_ = trisap_world_size(&config_);
        memory_ = allocate(bytes_);
        CHECK_OK(trisap_world_init(memory_.get(), bytes_, &config_, &world_));
    }

    [[nodiscard]] std::uint64_t hash() const { return hash_; }

protected:
    using Ids = std::vector<trisap::Id>;

    void say(std::uint64_t number) { hash_ = mix(hash_, number); }

    void say(double number) {
        std::uint64_t bits = 0;
        std::memcpy(&bits, &number, sizeof bits);
        say(bits);
    }

    bool say_status(trisap::Status status) { return say_status(status, world_); }

    /// And what the world that was asked says of it.
    bool say_status(trisap::Status status, const trisap_world *asked) {
        say(static_cast<std::uint64_t>(status));
        if (status != TRISAP_STATUS_OK) {
            tally_.refused++;
            say(trisap_world_error_detail(asked));
        }
        return status == TRISAP_STATUS_OK;
    }

    void say_pairs(const trisap::Pair *pairs, std::size_t count) {
        say(std::uint64_t{count});
        for (std::size_t at = 0; at < count; at++) {
            say(std::uint64_t{pairs[at].a} << 32 | pairs[at].b);
        }
    }

    /// Never null, also where there is nothing.
    template <class T> static T *data(std::vector<T> &items) {
        items.reserve(1);
        return items.data();
    }

    [[nodiscard]] trisap::Id id_at(std::uint32_t slot) const { return trisap_world_id_at(world_, slot); }

    [[nodiscard]] bool contains(trisap::Id id) const { return trisap_world_contains(world_, id) == TRISAP_STATUS_OK; }

    /// Zero for an id that is stale.
    [[nodiscard]] trisap::Aabb box_of(trisap::Id id) const {
        trisap::Aabb aabb = {};
        return trisap_world_aabb(world_, id, &aabb) == TRISAP_STATUS_OK ? aabb : trisap::Aabb{};
    }

    trisap::Aabb moved(trisap::Id id, Operation &op) const { return header_.moved(box_of(id), op.argument, op.rng); }

    [[nodiscard]] std::uint32_t share(const Operation &op) const {
        const std::uint32_t shares[] = {1, 2, objects_ / 9 + 1, objects_ / 3 + 1, objects_};
        return shares[op.argument % 5];
    }

    trisap::Id any(Operation &op) const {
        trisap::Id id = trisap::null_id;
        for (int tries = 0; tries < 3; tries++) {
            const std::uint32_t slot = op.rng.below(objects_);
            const trisap::Id there = id_at(slot);
            if (there != trisap::null_id) {
                return there;
            }
            id = known_[slot];
        }
        return id;
    }

    Ids some(Operation &op) const {
        std::vector<bool> taken(objects_);
        Ids ids;
        for (std::uint32_t left = share(op); left > 0; left--) {
            const std::uint32_t slot = op.rng.below(objects_);
            const trisap::Id id = id_at(slot);
            if (id != trisap::null_id && !taken[slot]) {
                taken[slot] = true;
                ids.push_back(id);
            }
        }
        if (op.argument >= 240) {
            const trisap::Id known = known_[op.rng.below(objects_)];
            if (known != trisap::null_id && !contains(known)) {
                ids.push_back(known);
            } else if (!ids.empty()) {
                ids.push_back(ids[0]);
            }
        }
        return ids;
    }

    void born(trisap::Id id) {
        say(id);
        known_[trisap::slot(id)] = id;
        opinions_[trisap::slot(id)] = 0;
        if (config_.values != 0 && trisap::slot(id) % 4 != 3) {
            CHECK(say_status(trisap_world_set_value(world_, id, ~id)));
        }
    }

    static void fork_join(void *user, void (*run)(void *), void *task, std::uint32_t count, const char *) {
        switch (*static_cast<const std::uint32_t *>(user)) {
        case 0: break;
        case 1:
            run(task);
            run(task);
            break;
        case 2:
            for (std::uint32_t left = 5 * count + 5; left > 0; left--) {
                run(task);
            }
            break;
        default: {
            std::vector<std::thread> threads;
            for (std::uint32_t left = count; left > 0; left--) {
                threads.emplace_back(run, task);
            }
            std::for_each(threads.begin(), threads.end(), [](std::thread &thread) { thread.join(); });
        }
        }
    }

    /// The tree is brought up to date, on the same as a step.
    void refresh(const Operation &op) {
        std::uint32_t how = op.argument < 4 ? 4 : op.argument / 8 % 4;
        const trisap_jobs jobs = jobs_of(how);
        CHECK_OK(trisap_world_refresh(world_, how == 3 ? nullptr : &jobs));
        CHECK_OK(trisap_world_validate(world_));
        tally_.refreshed++;
    }

    static trisap_jobs jobs_of(std::uint32_t &how) {
        trisap_jobs jobs = trisap_default_jobs();
        jobs.worker_count = 3;
        jobs.user = &how;
        jobs.fork_join = fork_join;
        return jobs;
    }

    /// What a forged world asks is not looked at.
    trisap::Status step_with(const Operation &op, const trisap::Boxes *boxes, trisap_result &result, bool forged = false) {
        std::uint32_t how = op.argument < 4 ? 4 : op.argument / 8 % 4;
        const trisap_jobs jobs = jobs_of(how);
        const trisap_jobs *given = how == 3 ? nullptr : &jobs;
        if (header_.rule()) {
            const auto rule = [](void *user, std::uint32_t a, std::uint32_t b) {
                return Asked::opinion(*static_cast<const std::vector<std::uint32_t> *>(user), a, b);
            };
            if (forged) {
                return trisap_world_step_with_rule(world_, boxes, rule, &opinions_, given, &result);
            }
            Asked asked(world_, config_, opinions_, boxes);
            return trisap_world_step_with_rule(world_, boxes, Asked::rule, &asked, given, &result);
        }
        return boxes == nullptr ? trisap_world_step(world_, given, &result)
                                : trisap_world_step_over(world_, boxes, given, &result);
    }

    Header header_;
    Tally &tally_;
    std::uint64_t hash_ = 0;
    trisap::Config config_;
    std::uint32_t objects_;
    std::size_t bytes_ = 0;
    Memory memory_;
    trisap_world *world_ = nullptr;
    Ids known_;
    std::vector<std::uint32_t> opinions_;
};

#endif
