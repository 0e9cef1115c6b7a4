#include "trisap_box3d.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <trisap.hpp>
#include <vector>

namespace {

void expect(trisap::Status status) {
    if (status != TRISAP_STATUS_OK) {
        std::fprintf(stderr, "trisap for Box3D: %s\n", trisap::text(status));
        std::abort();
    }
}

trisap::Aabb aabb_of(const b3AABB &box) {
    return {{box.lowerBound.x, box.lowerBound.y, box.lowerBound.z}, {box.upperBound.x, box.upperBound.y, box.upperBound.z}};
}

/// Lets through what Box3D's own filter does, and more where that has more bits or a group.
trisap::Filter filter_of(b3BodyType type, bool is_sensor, const b3Filter &filter) {
    const auto folded = [](std::uint64_t bits) { return static_cast<std::uint32_t>(bits | bits >> 32); };
    const bool has_group = filter.groupIndex != 0;
    const std::uint32_t sensor = b3_bodyTypeCount;
    return {has_group ? ~0u : folded(filter.categoryBits), has_group ? ~0u : folded(filter.maskBits),
            is_sensor ? sensor : static_cast<std::uint32_t>(type)};
}

} // namespace

struct trisap_box3d {
    trisap::World world;
    // By shape; null where the world does not have it.
    std::vector<trisap::Id> ids;
    // By slot.
    std::vector<int> shapes;
    std::vector<int> added;
    std::vector<trisap::Id> moved;
    std::vector<trisap::Aabb> boxes;
    std::vector<trisap::IdPair> kept;
    std::vector<trisap_box3d_pair> pairs;

    int shape_of(trisap::Id id) const {
        const int shape = shapes[trisap::slot(id)];
        return shape >= 0 && ids[shape] == id ? shape : -1;
    }
};

trisap_box3d *trisap_box3d_create() {
    auto *self = new trisap_box3d;
    trisap::Config config = trisap::config(1024);
    config.events = 1;
    config.filters = 1;
    expect(self->world.init(config));
    self->world.set_growing(true);
    std::uint32_t meets[TRISAP_CLASSES] = {};
    meets[b3_staticBody] = meets[b3_kinematicBody] = 1u << b3_dynamicBody;
    meets[b3_dynamicBody] = 1u << b3_staticBody | 1u << b3_kinematicBody | 1u << b3_dynamicBody;
    expect(self->world.set_classes(meets));
    return self;
}

void trisap_box3d_destroy(trisap_box3d *self) { delete self; }

void trisap_box3d_add(trisap_box3d *self, int shape) { self->added.push_back(shape); }

const int *trisap_box3d_added(trisap_box3d *self, int *count) {
    *count = static_cast<int>(self->added.size());
    return self->added.data();
}

void trisap_box3d_insert(trisap_box3d *self, int shape, b3BodyType type, bool is_sensor, b3Filter filter, b3AABB box) {
    if (static_cast<std::size_t>(shape) >= self->ids.size()) {
        self->ids.resize(shape + 1, trisap::null_id);
    }
    if (self->ids[shape] != trisap::null_id) {
        return;
    }
    trisap::Status status = TRISAP_STATUS_OK;
    const trisap::Id id = self->world.insert(aabb_of(box), filter_of(type, is_sensor, filter), &status);
    expect(status);
    const std::uint32_t slot = trisap::slot(id);
    if (slot >= self->shapes.size()) {
        self->shapes.resize(slot + 1, -1);
    }
    self->shapes[slot] = shape;
    self->ids[shape] = id;
}

void trisap_box3d_remove(trisap_box3d *self, int shape) {
    if (static_cast<std::size_t>(shape) < self->ids.size() && self->ids[shape] != trisap::null_id) {
        expect(self->world.remove(self->ids[shape]));
        self->ids[shape] = trisap::null_id;
    }
}

void trisap_box3d_move(trisap_box3d *self, int shape, b3AABB box) {
    self->moved.push_back(self->ids[shape]);
    self->boxes.push_back(aabb_of(box));
}

const trisap_box3d_pair *trisap_box3d_step(trisap_box3d *self, int workers, trisap_box3d_fork_join *fork_join, void *user, int *count) {
    self->added.clear();
    expect(self->world.update(trisap::View<const trisap::Id>(self->moved), trisap::boxes(self->boxes)));
    self->moved.clear();
    self->boxes.clear();
    auto jobs = trisap::jobs(static_cast<std::uint32_t>(workers), [=](std::uint32_t calls, trisap::Task task) {
        fork_join(user, task.function(), task.argument(), calls);
    });
    const trisap::Step step = self->world.step(jobs);
    expect(step.status);
    self->pairs.clear();
    for (const auto &[a, b] : self->kept) {
        const trisap_box3d_pair pair = {self->shape_of(a), self->shape_of(b)};
        // Those that are gone were found anew if they came again.
        if (pair.a >= 0 && pair.b >= 0) {
            self->pairs.push_back(pair);
        }
    }
    self->kept.clear();
    for (const auto &[a, b] : step.found) {
        self->pairs.push_back({self->shapes[a], self->shapes[b]});
    }
    // The order of contacts is part of what Box3D repeats exactly, also from a snapshot of its own.
    for (trisap_box3d_pair &pair : self->pairs) {
        pair = {std::min(pair.a, pair.b), std::max(pair.a, pair.b)};
    }
    std::sort(self->pairs.begin(), self->pairs.end(), [](const auto &x, const auto &y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
    const auto same = [](const auto &x, const auto &y) { return x.a == y.a && x.b == y.b; };
    self->pairs.erase(std::unique(self->pairs.begin(), self->pairs.end(), same), self->pairs.end());
    *count = static_cast<int>(self->pairs.size());
    return self->pairs.data();
}

void trisap_box3d_keep(trisap_box3d *self, int shape_a, int shape_b) {
    const std::size_t count = self->ids.size();
    const trisap::Id a = static_cast<std::size_t>(shape_a) < count ? self->ids[shape_a] : trisap::null_id;
    const trisap::Id b = static_cast<std::size_t>(shape_b) < count ? self->ids[shape_b] : trisap::null_id;
    if (a != trisap::null_id && b != trisap::null_id) {
        self->kept.push_back({a, b});
    }
}

void trisap_box3d_compare(uint64_t *ours, int count, uint64_t *theirs, int their_count) {
    std::sort(ours, ours + count);
    std::sort(theirs, theirs + their_count);
    if (count != their_count || !std::equal(ours, ours + count, theirs)) {
        std::fprintf(stderr, "trisap for Box3D: %d pairs, where Box3D has found %d\n", count, their_count);
        std::abort();
    }
}
