// Worlds that grow at random moments say what a world says that was large from the beginning.

#include "check.h"

#include <algorithm>
#include <cstdio>
#include <random>
#include <trisap.hpp>
#include <vector>

namespace {

using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

Pairs sorted(const trisap::View<const trisap::Pair> &pairs) {
    Pairs copy;
    for (const auto &pair : pairs) {
        copy.emplace_back(pair.a, pair.b);
    }
    std::sort(copy.begin(), copy.end());
    return copy;
}

using IdPairs = std::vector<std::pair<trisap::Id, trisap::Id>>;

IdPairs by_id(const trisap::World &world, std::uint32_t what) {
    std::size_t count = 0;
    const trisap::Status status = world.pair_ids(what, {}, count);
    CHECK(status == (count == 0 ? TRISAP_STATUS_OK : TRISAP_STATUS_OUTPUT_FULL));
    std::vector<trisap_id_pair> pairs(count);
    CHECK_OK(world.pair_ids(what, pairs, count));
    IdPairs copy;
    for (const auto &pair : pairs) {
        copy.emplace_back(pair.a, pair.b);
    }
    std::sort(copy.begin(), copy.end());
    return copy;
}

/// The same by value, where each object has its id for one.
IdPairs by_value(const trisap::World &world, std::uint32_t what) {
    const std::size_t count = world.pair_values(what, {}).needed;
    std::vector<trisap::ValuePair> room(count);
    const trisap::Answers<trisap::ValuePair> pairs = world.pair_values(what, room);
    CHECK(pairs && pairs.size() == count);
    IdPairs copy;
    for (const auto &pair : pairs) {
        copy.emplace_back(pair.a, pair.b);
    }
    std::sort(copy.begin(), copy.end());
    return copy;
}

struct Counts {
    unsigned steps = 0, for_objects = 0, for_pairs = 0, less = 0, refused = 0;
};

class Life {
public:
    Life(unsigned seed, Counts &counts) : random_(seed), counts_(counts) {
        config_ = trisap::config(1 + below(9));
        config_.events = 1;
        config_.filters = below(2);
        config_.values = 1;
        config_.has_margin = below(2);
        config_.margin_max = 0.25f;
        config_.margin_min = 0.0625f;
        config_.mode = config_.has_margin == 1 && below(3) == 0 ? TRISAP_MODE_FAT : TRISAP_MODE_EXACT;
        config_.pairs = 1;
        trisap::Config large = config_;
        large.objects = 256;
        large.pairs = 256 * 256 / 2;
        CHECK_OK(world_.init(config_));
        CHECK_OK(large_.init(large));
    }

    void act() {
        switch (below(8)) {
        case 0:
        case 1: insert(); break;
        case 2: remove(); break;
        case 3: shrink(); break;
        case 4: step(); break;
        default: update(); break;
        }
    }

    void step() {
        const trisap::Step expected = large_.step();
        CHECK_OK(expected.status);
        trisap::Step said = world_.step();
        while (said.status == TRISAP_STATUS_PAIRS_FULL) {
            counts_.for_pairs++;
            config_.pairs = static_cast<std::uint32_t>(world_.error_detail());
            CHECK_OK(world_.move_to(config_));
            said = world_.step();
        }
        CHECK_OK(said.status);
        CHECK(sorted(said.pairs) == sorted(expected.pairs));
        CHECK(sorted(said.found) == sorted(expected.found));
        CHECK(sorted(said.lost) == sorted(expected.lost));
        for (const std::uint32_t what : {TRISAP_PAIRS_ALL, TRISAP_PAIRS_FOUND, TRISAP_PAIRS_LOST}) {
            CHECK(by_id(world_, what) == by_id(large_, what));
            CHECK(by_id(world_, what) == by_value(world_, what));
        }
        // Those that were lost are pairs of the step before, by id.
        for (const auto &pair : by_id(world_, TRISAP_PAIRS_LOST)) {
            CHECK(std::binary_search(last_.begin(), last_.end(), pair));
        }
        last_ = by_id(world_, TRISAP_PAIRS_ALL);
        CHECK(last_.size() == said.pairs.size());
        counts_.steps++;
    }

private:
    unsigned below(unsigned end) { return static_cast<unsigned>(random_() % end); }

    trisap::Aabb box() {
        trisap::Aabb aabb{};
        for (int k = 0; k < 3; k++) {
            aabb.min[k] = static_cast<float>(below(13)) * 0.25f;
            aabb.max[k] = aabb.min[k] + 0.25f + static_cast<float>(below(4)) * 0.25f;
        }
        return aabb;
    }

    void insert() {
        const trisap::Aabb aabb = box();
        trisap::Status status = TRISAP_STATUS_OK;
        trisap::Id id = world_.insert(aabb, &status);
        if (status == TRISAP_STATUS_OBJECTS_FULL) {
            counts_.for_objects++;
            config_.objects = static_cast<std::uint32_t>(world_.error_detail()) + below(4);
            CHECK_OK(world_.move_to(config_));
            id = world_.insert(aabb, &status);
        }
        CHECK_OK(status);
        CHECK(id == large_.insert(aabb));
        ids_.push_back(id);
        CHECK_OK(world_.set_value(id, id));
        if (config_.filters == 1) {
            const trisap::Filter filter{1u << below(2), 3, 0};
            CHECK_OK(world_.set_filter(id, filter));
            CHECK_OK(large_.set_filter(id, filter));
        }
    }

    void remove() {
        if (ids_.empty()) {
            return;
        }
        std::swap(ids_[below(static_cast<unsigned>(ids_.size()))], ids_.back());
        CHECK_OK(world_.remove(ids_.back()));
        CHECK_OK(large_.remove(ids_.back()));
        CHECK(!world_.contains(ids_.back()));
        ids_.pop_back();
    }

    void update() {
        if (ids_.empty()) {
            return;
        }
        const trisap::Id id = ids_[below(static_cast<unsigned>(ids_.size()))];
        const trisap::Aabb aabb = box();
        CHECK_OK(world_.update(id, aabb));
        CHECK_OK(large_.update(id, aabb));
    }

    // To less room; refused where that is too little, with the number that it takes.
    void shrink() {
        trisap::Config less = config_;
        less.objects = less.objects / 2 + below(9);
        less.pairs = less.pairs / 2 + below(5);
        const trisap::Status status = world_.move_to(less);
        if (status == TRISAP_STATUS_OK) {
            counts_.less++;
            config_ = less;
            return;
        }
        counts_.refused++;
        const bool objects = status == TRISAP_STATUS_OBJECTS_FULL;
        CHECK(objects || status == TRISAP_STATUS_PAIRS_FULL);
        CHECK(world_.error_detail() > (objects ? less.objects : less.pairs));
    }

    std::mt19937 random_;
    Counts &counts_;
    trisap::Config config_{};
    trisap::World world_, large_;
    std::vector<trisap::Id> ids_;
    IdPairs last_;
};

void what_cannot_change() {
    trisap::World world;
    const trisap::Config config = trisap::config(8);
    CHECK_OK(world.init(config));
    trisap::Config other = config;
    other.events = 1;
    CHECK(world.move_to(other) == TRISAP_STATUS_OTHER_CONFIG);
    CHECK(world.error_detail() == 3);
    other.events = 0;
    other.workers = 2;
    CHECK_OK(world.move_to(other));
}

} // namespace

int main() {
    Counts counts;
    for (unsigned seed = 0; seed < 10000; seed++) {
        Life life(seed, counts);
        for (int act = 0; act < 30; act++) {
            life.act();
        }
        life.step();
    }
    what_cannot_change();
    std::printf("%u steps, grown for objects %u, for pairs %u, less %u, refused %u\n", counts.steps, counts.for_objects,
                counts.for_pairs, counts.less, counts.refused);
    CHECK(counts.for_objects > 1000 && counts.for_pairs > 500 && counts.less > 1000 && counts.refused > 1000);
    return 0;
}
