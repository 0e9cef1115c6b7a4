// Whom callbacks are called with: those of queries with objects that are there and that the query meets, each of them once; rules with
// such whose boxes overlap and whose groups meet.

#ifndef CALLS_HPP
#define CALLS_HPP

#include "model.hpp"

#include <functional>

class Calls {
public:
    /// Of a query: `meets` says how many of the queries a box meets; there is one, but for a batch.
    Calls(const trisap_world *world, std::uint32_t by, std::function<std::ptrdiff_t(const trisap::Aabb &)> meets)
        : world_(world), by_(by), meets_(std::move(meets)) {}

    void count(trisap::Id id) {
        trisap::Aabb box = {};
        CHECK_OK(trisap_world_aabb(world_, id, &box));
        CHECK(trisap_world_is_enabled(world_, id) != 0);
        CHECK(++calls_[id] <= meets_(box));
    }

    /// A condition: two in three objects may answer.
    static std::uint32_t two_in_three(void *user, trisap::Id id) {
        auto &calls = *static_cast<Calls *>(user);
        calls.count(id);
        return (trisap::slot(id) + calls.by_) % 3 != 0;
    }

private:
    const trisap_world *world_;
    std::uint32_t by_;
    std::function<std::ptrdiff_t(const trisap::Aabb &)> meets_;
    std::map<trisap::Id, std::ptrdiff_t> calls_;
};

class Asked {
public:
    /// `boxes`, where there are any, are given to the step by slot.
    Asked(const trisap_world *world, const trisap::Config &config, const std::vector<std::uint32_t> &opinions,
          const trisap::Boxes *boxes)
        : has_margins_(config.has_margin != 0 || config.predicted_boxes != 0), opinions_(opinions), objects_(config.objects) {
        for (std::uint32_t slot = 0; slot < config.objects; slot++) {
            const trisap::Id id = trisap_world_id_at(world, slot);
            Known &object = objects_[slot];
            if (id == trisap::null_id || trisap_world_is_enabled(world, id) == 0) {
                continue;
            }
            object.is_there = true;
            CHECK_OK(trisap_world_aabb(world, id, &object.box));
            CHECK_OK(trisap_world_filter(world, id, &object.filter));
            if (boxes != nullptr && slot < boxes->count && trisap_world_is_resting(world, id) == 0) {
                const trisap::Aabb &given = static_cast<const trisap::Aabb *>(boxes->first)[slot];
                if (share_a_point(given.min, given.max, given.min, given.max)) {
                    object.box = given;
                }
            }
        }
    }

    static std::uint32_t rule(void *user, std::uint32_t a, std::uint32_t b) {
        const auto &its = *static_cast<const Asked *>(user);
        const Known &one = its.objects_.at(a), &other = its.objects_.at(b);
        CHECK(a < b && one.is_there && other.is_there);
        CHECK(its.has_margins_ || share_a_point(one.box.min, one.box.max, other.box.min, other.box.max));
        CHECK((one.filter.group & other.filter.mask) != 0 && (other.filter.group & one.filter.mask) != 0);
        return opinion(its.opinions_, a, b);
    }

    static std::uint32_t opinion(const std::vector<std::uint32_t> &opinions, std::uint32_t a, std::uint32_t b) {
        return (opinions[a] + opinions[b]) % 3 != 1;
    }

private:
    struct Known {
        bool is_there = false;
        trisap::Aabb box{};
        trisap::Filter filter{};
    };
    bool has_margins_;
    const std::vector<std::uint32_t> &opinions_;
    std::vector<Known> objects_;
};

#endif
