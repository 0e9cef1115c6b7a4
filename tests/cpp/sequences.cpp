// Plays the sequences of a file through the C ABI: the calls that `trisap_tests::sequence::play` makes for the same bytes. Prints the
// hash of each and in the end the counts, which must be those of Rust. What is right is decided there, with a model and a twin;
// here the sanitizers watch, each world validates itself after every operation, and it is seen whom rules and queries call.
//
//     sequences FILE    # each sequence after its length, of four bytes

#include "sequence_world.hpp"

#include <cinttypes>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <optional>
#include <utility>

class Sequence : public World {
public:
    Sequence(const std::uint8_t *bytes, Tally &tally) : World(bytes, tally) {
        Rng rng(header_.start());
        std::vector<trisap::Aabb> boxes;
        for (std::uint32_t count = 0; count < header_.start(); count++) {
            boxes.push_back(header_.aabb(rng));
        }
        insert_many(boxes);
    }

    void apply(Operation op) {
        tally_.ran[static_cast<std::size_t>(op.kind)]++;
        const bool asks = op.kind == Kind::overlaps || op.kind == Kind::cast || op.kind == Kind::nearest ||
                          op.kind == Kind::batches || op.kind == Kind::view;
        const bool changes = op.kind == Kind::insert || op.kind == Kind::insert_many || op.kind == Kind::set ||
                             op.kind == Kind::remove;
        if ((asks || changes) && op.argument % 3 == 1) {
            refresh(op);
        }
        switch (op.kind) {
        case Kind::insert: insert(op); break;
        case Kind::insert_many: insert_share(op); break;
        case Kind::set: set(op); break;
        case Kind::update_many: update_many(op); break;
        case Kind::remove: remove(op); break;
        case Kind::remove_many: remove_many(op); break;
        case Kind::set_margin: set_margin(op); break;
        case Kind::set_filter: set_filter(op); break;
        case Kind::set_filter_many: set_filter_many(op); break;
        case Kind::set_value: set_value(op); break;
        case Kind::set_value_many: set_value_many(op); break;
        case Kind::set_classes: set_classes(op); break;
        case Kind::refilter: refilter(op); break;
        case Kind::set_resting:
        case Kind::wake: set_resting(op); break;
        case Kind::set_enabled: set_enabled(op); break;
        case Kind::shift: shift(op); break;
        case Kind::step: step(op, nullptr); break;
        case Kind::step_over: step_over(op); break;
        case Kind::overlaps: overlaps(op); break;
        case Kind::cast: cast(op); break;
        case Kind::nearest: nearest(op); break;
        case Kind::batches: batches(op); break;
        case Kind::view: view(); break;
        case Kind::save: save(op); break;
        case Kind::load: load(op); break;
        case Kind::load_damaged: load_damaged(op); break;
        case Kind::load_forged: load_forged(op); break;
        case Kind::reopen: reopen(); break;
        case Kind::copy: copy(op); break;
        case Kind::clear: clear(); break;
        case Kind::grow: grow(op); break;
        }
        CHECK_OK(trisap_world_validate(world_));
    }

private:
    void insert(Operation &op) {
        const trisap::Aabb aabb = op.argument < 208   ? header_.aabb(op.rng)
                                  : op.argument < 224 ? header_.from_f64(op.rng)
                                  : op.argument < 240 ? header_.from_fixed(op.rng)
                                                      : Header::bad_box(op.rng);
        trisap::Id id = trisap::null_id;
        // In some cases at a slot, which there may not be.
        const bool at = op.argument % 4 == 3;
        const std::uint32_t slot = at ? op.rng.below(objects_ + 1) : 0;
        // One in four that may come anywhere has more than a box.
        const std::uint32_t has = op.argument % 4 == 2 ? op.argument >> 2 : 0;
        const trisap::Filter filter = (has & 1) != 0 ? Header::filter(op.rng) : trisap::filter();
        const std::uint64_t value = (has & 2) != 0 ? op.rng.bits() : 0;
        const float lengths[] = {0.0f, 0.125f, 0.5f, -1.0f};
        const auto insert_with = [&] {
            return trisap_world_insert_with(world_, &aabb, (has & 1) != 0 ? &filter : nullptr, (has & 2) != 0 ? &value : nullptr,
                                            (has & 4) != 0 ? &lengths[op.argument >> 5 & 3] : nullptr, &id);
        };
        if (say_status(at         ? trisap_world_insert_at(world_, slot, &aabb, &id)
                       : has != 0 ? insert_with()
                                  : trisap_world_insert(world_, &aabb, &id))) {
            born(id);
        }
    }

    void insert_share(Operation &op) {
        std::vector<trisap::Aabb> boxes;
        for (std::uint32_t left = share(op); left > 0; left--) {
            boxes.push_back(header_.aabb(op.rng));
        }
        if (op.argument >= 240) {
            boxes.push_back(Header::bad_box(op.rng));
        }
        insert_many(boxes);
    }

    void insert_many(std::vector<trisap::Aabb> &boxes) {
        Ids ids(boxes.size());
        const trisap::Boxes view = trisap_default_boxes(data(boxes), boxes.size());
        if (say_status(trisap_world_insert_many(world_, &view, data(ids)))) {
            std::for_each(ids.begin(), ids.end(), [this](trisap::Id id) { born(id); });
        }
    }

    void set(Operation &op) {
        const trisap::Id id = any(op);
        if (id != trisap::null_id) {
            const trisap::Aabb next = op.argument < 240 ? moved(id, op) : Header::bad_box(op.rng);
            say_status(trisap_world_update(world_, id, &next));
        }
    }

    void update_many(Operation &op) {
        Ids ids = some(op);
        std::vector<trisap::Aabb> boxes;
        for (const trisap::Id id : ids) {
            boxes.push_back(moved(id, op));
        }
        if (op.argument >= 250 && !boxes.empty()) {
            boxes.back() = Header::bad_box(op.rng);
        }
        const trisap::Boxes view = trisap_default_boxes(data(boxes), boxes.size());
        say_status(trisap_world_update_many(world_, data(ids), &view));
    }

    void remove(Operation &op) {
        const trisap::Id id = any(op);
        if (id != trisap::null_id) {
            say_status(trisap_world_remove(world_, id));
        }
    }

    void remove_many(Operation &op) {
        Ids ids = some(op);
        say_status(trisap_world_remove_many(world_, data(ids), ids.size()));
    }

    /// The C ABI has no call for it: all ids, ascending.
    void clear() {
        Ids ids;
        for (std::uint32_t slot = 0; slot < objects_; slot++) {
            const trisap::Id id = id_at(slot);
            if (id != trisap::null_id) {
                ids.push_back(id);
            }
        }
        say_status(trisap_world_remove_many(world_, data(ids), ids.size()));
    }

    void set_margin(Operation &op) {
        const trisap::Id id = any(op);
        if (id != trisap::null_id) {
            const float lengths[] = {0.0f, 0.125f, 0.5f, -1.0f};
            say_status(trisap_world_set_margin(world_, id, lengths[op.argument % 4]));
        }
    }

    void set_filter(Operation &op) {
        const trisap::Id id = any(op);
        if (id != trisap::null_id) {
            const trisap::Filter filter = Header::filter(op.rng);
            if (say_status(trisap_world_set_filter(world_, id, &filter))) {
                check_filter(id, filter);
            }
        }
    }

    void check_filter(trisap::Id id, const trisap::Filter &expected) {
        trisap::Filter filter = {};
        CHECK_OK(trisap_world_filter(world_, id, &filter));
        CHECK(filter.group == expected.group && filter.mask == expected.mask);
        CHECK(filter.object_class == expected.object_class);
    }

    /// The same for all, by a stride of zero, or each its own.
    void set_filter_many(Operation &op) {
        Ids ids = some(op);
        const bool same = (op.argument & 4) == 0;
        std::vector<trisap::Filter> filters(1, Header::filter(op.rng));
        for (std::size_t at = 0; at < ids.size() && !same; at++) {
            filters.push_back(Header::filter(op.rng));
        }
        const std::size_t stride = same ? 0 : sizeof(trisap::Filter);
        if (say_status(trisap_world_set_filter_many(world_, data(ids), filters.data(), stride, ids.size()))) {
            for (std::size_t at = 0; at < ids.size(); at++) {
                // Of one that comes twice the last filter stays.
                if (std::count(ids.begin() + static_cast<std::ptrdiff_t>(at), ids.end(), ids[at]) == 1) {
                    check_filter(ids[at], filters[same ? 0 : at]);
                }
            }
        }
    }

    void set_value(Operation &op) {
        const trisap::Id id = any(op);
        if (id != trisap::null_id) {
            const std::uint64_t value = op.rng.bits();
            if (say_status(trisap_world_set_value(world_, id, value))) {
                CHECK(value_of(id) == value);
            }
        }
    }

    [[nodiscard]] std::uint64_t value_of(trisap::Id id) const {
        std::uint64_t value = 0;
        CHECK_OK(trisap_world_value(world_, id, &value));
        return value;
    }

    /// The same for all, by a stride of zero, or each its own.
    void set_value_many(Operation &op) {
        Ids ids = some(op);
        const bool same = (op.argument & 8) == 0;
        std::vector<std::uint64_t> values(1, op.rng.bits());
        for (std::size_t at = 0; at < ids.size() && !same; at++) {
            values.push_back(op.rng.bits());
        }
        const std::size_t stride = same ? 0 : sizeof(std::uint64_t);
        if (say_status(trisap_world_set_value_many(world_, data(ids), values.data(), stride, ids.size()))) {
            std::vector<std::uint64_t> known(ids.size());
            CHECK_OK(trisap_world_values(world_, data(ids), sizeof(trisap::Id), ids.size(), data(known)));
            for (std::size_t at = 0; at < ids.size(); at++) {
                // Of one that comes twice the last value stays.
                const auto last = std::find(ids.rbegin(), ids.rend(), ids[at]).base() - ids.begin() - 1;
                CHECK(known[at] == values[same ? 0 : static_cast<std::size_t>(last)]);
            }
        }
    }

    void set_classes(Operation &op) {
        std::array<std::uint32_t, TRISAP_CLASSES> meets;
        meets.fill(~0u);
        const auto bits = static_cast<std::uint32_t>(op.rng.bits());
        meets[op.rng.below(3)] = bits;
        say_status(trisap_world_set_classes(world_, meets.data()));
    }

    void refilter(Operation &op) {
        const trisap::Id id = any(op);
        if (id != trisap::null_id && say_status(trisap_world_refilter(world_, id))) {
            opinions_[trisap::slot(id)] = op.argument % 3;
        }
    }

    void set_resting(Operation &op) {
        Ids ids = some(op);
        const auto call = op.kind == Kind::wake ? trisap_world_wake : trisap_world_set_resting;
        if (say_status(call(world_, data(ids), ids.size()))) {
            for (const trisap::Id id : ids) {
                CHECK(trisap_world_is_resting(world_, id) == (op.kind == Kind::set_resting));
            }
        }
    }

    void set_enabled(Operation &op) {
        Ids ids = some(op);
        const std::uint32_t enabled = (op.argument & 2u) / 2;
        if (say_status(trisap_world_set_enabled(world_, data(ids), ids.size(), enabled))) {
            for (const trisap::Id id : ids) {
                CHECK(trisap_world_is_enabled(world_, id) == enabled);
            }
        }
    }

    void shift(Operation &op) {
        const double steps[] = {0.25, 0.1, 1e6, 0.25};
        double by[3];
        for (double &part : by) {
            part = static_cast<double>(static_cast<int>(op.rng.below(65)) - 32) * steps[op.argument % 4];
        }
        if (op.argument >= 250) {
            by[op.rng.below(3)] = std::numeric_limits<double>::quiet_NaN();
        }
        std::uint32_t rounded = 0;
        if (say_status(trisap_world_shift_origin(world_, by, &rounded))) {
            say(std::uint64_t{rounded});
        }
    }

    void step(const Operation &op, const trisap::Boxes *boxes) {
        trisap_result result = trisap_default_result();
        const trisap::Status status = step_with(op, boxes, result);
        say(static_cast<std::uint64_t>(status));
        if (status == TRISAP_STATUS_PAIRS_FULL) {
            tally_.full++;
            say_pairs(result.pairs, result.pair_count);
            say(result.pairs_needed);
            return;
        }
        CHECK_OK(status);
        trisap::Stats stats = trisap_default_stats();
        CHECK_OK(trisap_world_stats(world_, &stats));
        tally_.paths.at(stats.path)++;
        tally_.pairs += stats.pairs;
        tally_.found += stats.found;
        tally_.lost += stats.lost;
        tally_.fine += stats.fine_leaves != 0;
        tally_.large += stats.large > 0;
        say(stats.candidates);
        say(stats.copies);
        say(std::uint64_t{stats.moved});
        say_result(result);
        check_ids(TRISAP_PAIRS_ALL, result.pairs, result.pair_count);
        check_ids(TRISAP_PAIRS_FOUND, result.found, result.found_count);
        check_ids(TRISAP_PAIRS_LOST, result.lost, result.lost_count);
        say_values(TRISAP_PAIRS_ALL, result.pair_count);
        say_values(TRISAP_PAIRS_FOUND, result.found_count);
        say_values(TRISAP_PAIRS_LOST, result.lost_count);
        tally_.rejecting += result.rejected_count > 0;
        say(std::uint64_t{result.rejected_count});
        say(result.first_rejected);
    }

    /// The same pairs in the same order, by id.
    void check_ids(std::uint32_t what, const trisap::Pair *pairs, std::size_t expected) {
        std::vector<trisap_id_pair> ids(expected);
        std::size_t count = 0;
        CHECK_OK(trisap_world_pair_ids(world_, what, data(ids), ids.size(), &count));
        CHECK(count == expected);
        for (std::size_t at = 0; at < count; at++) {
            CHECK(trisap::slot(ids[at].a) == pairs[at].a && trisap::slot(ids[at].b) == pairs[at].b);
        }
    }

    /// As many pairs, by value.
    void say_values(std::uint32_t what, std::size_t expected) {
        std::vector<trisap::ValuePair> values(expected);
        std::size_t count = 0;
        const trisap::Status status = trisap_world_pair_values(world_, what, data(values), values.size(), &count);
        if (config_.values == 0) {
            CHECK(status == TRISAP_STATUS_NO_VALUES);
            return;
        }
        CHECK_OK(status);
        CHECK(count == expected);
        for (const auto &[a, b] : values) {
            say(a ^ (b << 32 | b >> 32));
        }
    }

    void say_result(const trisap_result &result) {
        say_pairs(result.pairs, result.pair_count);
        say_pairs(result.found, result.found_count);
        say_pairs(result.lost, result.lost_count);
    }

    void step_over(Operation &op) {
        const std::uint32_t lengths[] = {objects_, objects_, objects_, objects_ / 2, objects_ + 2};
        const std::uint32_t movers[] = {1, 4, 12, 32};
        const float nan = std::numeric_limits<float>::quiet_NaN();
        const trisap::Aabb none = {{nan, nan, nan}, {nan, nan, nan}};
        std::vector<trisap::Aabb> boxes(lengths[op.argument % 5], none);
        for (std::uint32_t slot = 0; slot < boxes.size(); slot++) {
            const trisap::Id id = id_at(slot);
            if (id == trisap::null_id) {
                continue;
            }
            const std::uint32_t kind = op.rng.below(32);
            if (kind > 0 || (op.argument & 4) == 0) {
                boxes[slot] = kind < movers[op.argument / 64] ? moved(id, op) : box_of(id);
            }
        }
        const trisap::Boxes view = trisap_default_boxes(data(boxes), boxes.size());
        step(op, &view);
    }

    void overlaps(Operation &op) {
        const trisap::Region region = header_.region(op.rng);
        Ids ids(objects_);
        std::size_t count = 0;
        if (say_status(trisap_world_overlaps(world_, &region, nullptr, nullptr, ids.data(), ids.size(), &count))) {
            say_ids(ids, count);
            Visit visit = {calls_of({region}, op), 0.0, {}};
            CHECK_OK(trisap_world_visit_overlaps(world_, &region, tell, &visit));
            CHECK(visit.hits.size() == count);
            tally_.answers += count;
            std::for_each(visit.hits.begin(), visit.hits.end(), [this](const trisap::Hit &hit) { say(hit.id); });
            Calls calls = calls_of({region}, op);
            CHECK_OK(trisap_world_overlaps(world_, &region, Calls::two_in_three, &calls, ids.data(), ids.size(), &count));
            say_ids(ids, count);
            if (region.kind == TRISAP_REGION_AABB) {
                ids.resize(count);
                within(region, visit.hits.size(), ids, op);
            }
        }
    }

    /// A box of planes, and one of a callback, hold what the region holds: all, and those that may answer.
    void within(const trisap::Region &region, std::size_t all, const Ids &some, const Operation &op) {
        double planes[6][4] = {};
        for (std::size_t k = 0; k < 3; k++) {
            if (!std::isfinite(region.min[k]) || !std::isfinite(region.max[k])) {
                return;
            }
            planes[2 * k][k] = 1;
            planes[2 * k][3] = static_cast<double>(region.max[k]);
            planes[2 * k + 1][k] = -1;
            planes[2 * k + 1][3] = -static_cast<double>(region.min[k]);
        }
        Ids ids(objects_);
        std::size_t count = 0;
        Calls calls = calls_of({region}, op);
        CHECK_OK(trisap_world_within(world_, planes[0], 6, Calls::two_in_three, &calls, ids.data(), ids.size(), &count));
        ids.resize(count);
        CHECK(ids == some);
        const auto side = [](void *user, const trisap::Aabb *box) -> std::int32_t {
            const auto &its = *static_cast<const trisap::Region *>(user);
            return share_a_point(its.min, its.max, box->min, box->max) ? 0 : -1;
        };
        Visit visit = {calls_of({region}, op), 0.0, {}};
        trisap::Region asked = region;
        CHECK_OK(trisap_world_visit_within(world_, side, &asked, tell, &visit));
        CHECK(visit.hits.size() == all);
    }

    void say_ids(const Ids &ids, std::size_t count) {
        tally_.answers += count;
        std::for_each(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(count), [this](trisap::Id id) { say(id); });
    }

    [[nodiscard]] Calls calls_of(const std::vector<trisap::Region> &regions, const Operation &op) const {
        return {world_, op.argument, [regions](const trisap::Aabb &box) {
                    return std::count_if(regions.begin(), regions.end(), [&](const auto &region) { return meets(region, box); });
                }};
    }

    [[nodiscard]] Calls calls_of(const std::vector<trisap::Cast> &casts, const Operation &op) const {
        return {world_, op.argument, [casts](const trisap::Aabb &box) {
                    return std::count_if(casts.begin(), casts.end(), [&](const auto &cast) { return touches(cast, box) >= 0; });
                }};
    }

    [[nodiscard]] Calls calls_within(const float (&point)[3], double distance, const Operation &op) const {
        return {world_, op.argument, [&point, distance](const trisap::Aabb &box) {
                    return std::ptrdiff_t{std::sqrt(squared_distance(point, box)) <= distance};
                }};
    }

    void say_hits(const std::vector<trisap::Hit> &hits, std::size_t count) {
        tally_.answers += count;
        for (std::size_t at = 0; at < count; at++) {
            say(hits[at].id);
            say(hits[at].id == trisap::null_id ? 0.0 : hits[at].distance);
        }
    }

    void cast(Operation &op) {
        const trisap::Cast cast = header_.cast(op.rng);
        std::vector<trisap::Hit> hits(objects_);
        std::size_t count = 0;
        if (say_status(trisap_world_hits(world_, &cast, nullptr, nullptr, hits.data(), hits.size(), &count))) {
            say_hits(hits, count);
            visit_hits(op, cast);
            trisap::Hit first = {};
            CHECK_OK(trisap_world_first_hit(world_, &cast, nullptr, nullptr, &first));
            CHECK(first.id == (count == 0 ? trisap::null_id : hits[0].id));
            Calls calls = calls_of({cast}, op);
            CHECK_OK(trisap_world_hits(world_, &cast, Calls::two_in_three, &calls, hits.data(), hits.size(), &count));
            say_hits(hits, count);
            calls = calls_of({cast}, op);
            CHECK_OK(trisap_world_first_hit(world_, &cast, Calls::two_in_three, &calls, &first));
            CHECK(first.id == (count == 0 ? trisap::null_id : hits[0].id));
        }
    }

    struct Visit {
        Calls calls;
        /// How far to look on; less than zero: as far as the last hit.
        double far;
        std::vector<trisap::Hit> hits;
    };

    static double tell_far(void *user, trisap::Hit hit) {
        auto &its = *static_cast<Visit *>(user);
        its.calls.count(hit.id);
        its.hits.push_back(hit);
        return its.far < 0 ? hit.distance : its.far;
    }

    static std::uint32_t tell(void *user, trisap::Id id) { return tell_far(user, {id, 0.0}) >= 0; }

    /// All of them, or only those that are nearer than the last.
    void visit_hits(const Operation &op, const trisap::Cast &cast) {
        Visit visit = {calls_of({cast}, op), op.argument % 2 == 0 ? static_cast<double>(cast.distance) : -1.0, {}};
        CHECK_OK(trisap_world_visit_hits(world_, &cast, tell_far, &visit));
        say_hits(visit.hits, visit.hits.size());
    }

    void nearest(Operation &op) {
        float point[3];
        header_.point(op.rng, point);
        const std::size_t rooms[] = {1, 2, 7, objects_};
        std::vector<trisap::Hit> hits(rooms[op.argument % 4]);
        std::size_t count = 0;
        CHECK_OK(trisap_world_nearest(world_, point, nullptr, nullptr, hits.data(), hits.size(), &count));
        say_hits(hits, count);
        const double infinity = std::numeric_limits<double>::infinity();
        Calls calls = calls_within(point, infinity, op);
        CHECK_OK(trisap_world_nearest(world_, point, Calls::two_in_three, &calls, hits.data(), hits.size(), &count));
        say_hits(hits, count);
        // The same twice over.
        std::vector<trisap::Hit> twice(2 * hits.size());
        Calls both = {world_, op.argument, [](const trisap::Aabb &) { return std::ptrdiff_t{2}; }};
        CHECK_OK(trisap_world_nearest_many(world_, point, 0, 2, Calls::two_in_three, &both, nullptr, twice.data(), hits.size()));
        CHECK(same_hits(trisap::View<trisap::Hit>(twice.data(), count), trisap::View<trisap::Hit>(hits.data(), count)));
        const double distance = count == 0 ? 1.0 : hits[count - 1].distance;
        Visit visit = {calls_within(point, distance, op), op.argument % 2 == 0 ? infinity : -1.0, {}};
        CHECK_OK(trisap_world_visit_nearest(world_, point, distance, tell_far, &visit));
        say_hits(visit.hits, visit.hits.size());
    }

    void batches(Operation &op) {
        std::vector<trisap::Cast> casts;
        std::vector<trisap::Region> regions;
        const std::size_t length = op.argument % 5;
        bool good = true;
        while (casts.size() < length) {
            casts.push_back(header_.cast(op.rng));
        }
        while (regions.size() < length) {
            regions.push_back(header_.region(op.rng));
        }
        std::vector<trisap::Hit> hits(length);
        good &= say_status(first_hits(nullptr, nullptr, casts, hits));
        Ids ids(3 * length);
        std::vector<std::size_t> ends(length);
        const trisap::Status status = overlaps_many(nullptr, nullptr, regions, ids, ends);
        say_status(status);
        if (good && status != TRISAP_STATUS_BAD_QUERY) {
            say_hits(hits, length);
            std::for_each(ends.begin(), ends.end(), [this](std::size_t end) { say(std::uint64_t{end}); });
            Calls calls = calls_of(casts, op);
            CHECK_OK(first_hits(Calls::two_in_three, &calls, casts, hits));
            calls = calls_of(regions, op);
            const trisap::Status full = overlaps_many(Calls::two_in_three, &calls, regions, ids, ends);
            CHECK(full == TRISAP_STATUS_OK || full == TRISAP_STATUS_OUTPUT_FULL);
            say_hits(hits, length);
            std::for_each(ends.begin(), ends.end(), [this](std::size_t end) { say(std::uint64_t{end}); });
        }
    }

    trisap::Status first_hits(trisap_condition condition, Calls *calls, std::vector<trisap::Cast> &casts,
                              std::vector<trisap::Hit> &hits) {
        return trisap_world_first_hits(world_, data(casts), sizeof(trisap::Cast), casts.size(), condition, calls, nullptr,
                                       data(hits));
    }

    trisap::Status overlaps_many(trisap_condition condition, Calls *calls, std::vector<trisap::Region> &regions, Ids &ids,
                                 std::vector<std::size_t> &ends) {
        return trisap_world_overlaps_many(world_, data(regions), sizeof(trisap::Region), regions.size(), condition, calls,
                                          nullptr, data(ids), ids.size(), data(ends));
    }

    void view() {
        std::vector<trisap::Leaf> leaves(2048);
        std::vector<trisap::Plane> planes(2048);
        Ids large(objects_);
        std::size_t counts[3] = {};
        CHECK_OK(trisap_world_leaves(world_, leaves.data(), leaves.size(), &counts[0]));
        CHECK_OK(trisap_world_planes(world_, planes.data(), planes.size(), &counts[1]));
        CHECK_OK(trisap_world_large(world_, large.data(), large.size(), &counts[2]));
        std::for_each(std::begin(counts), std::end(counts), [this](std::size_t count) { say(std::uint64_t{count}); });
        say(std::uint64_t{trisap_world_len(world_)});
        check_config();
        say_contents();
    }

    void check_config() {
        trisap::Config config = trisap::config(0), expected = config_;
        CHECK_OK(trisap_world_config(world_, &config));
        if (expected.has_margin == 0) {
            expected.margin_per_extent = config.margin_per_extent;
            expected.margin_min = config.margin_min;
            expected.margin_max = config.margin_max;
        }
        // Numbers of four bytes each, and nothing between them.
        static_assert(sizeof config == 16 * sizeof(std::uint32_t), "a config with another size");
        CHECK(std::memcmp(&config, &expected, sizeof config) == 0);
        CHECK(trisap_world_bytes(world_) == bytes_);
    }

    /// All that is known of the objects, and the last result.
    void say_contents() {
        for (std::uint32_t slot = 0; slot < objects_; slot++) {
            const trisap::Id id = id_at(slot);
            if (id == trisap::null_id) {
                continue;
            }
            say(id);
            say(std::uint64_t{trisap_world_is_resting(world_, id)} + 2 * std::uint64_t{trisap_world_is_enabled(world_, id)});
            const trisap::Aabb box = box_of(id);
            std::uint32_t bits[6];
            std::memcpy(bits, &box, sizeof bits);
            std::for_each(std::begin(bits), std::end(bits), [this](std::uint32_t part) { say(std::uint64_t{part}); });
            trisap::Filter filter = {};
            const trisap::Status status = trisap_world_filter(world_, id, &filter);
            CHECK(status == (config_.filters ? TRISAP_STATUS_OK : TRISAP_STATUS_NO_FILTERS));
            if (config_.filters) {
                say(std::uint64_t{filter.group});
                say(std::uint64_t{filter.mask});
                say(std::uint64_t{filter.object_class});
            }
            if (config_.values) {
                say(value_of(id));
            }
        }
        trisap_result result = trisap_default_result();
        CHECK_OK(trisap_world_result(world_, &result));
        say_result(result);
    }

    Bytes snapshot() {
        Bytes bytes(trisap_world_snapshot_size(world_));
        std::size_t written = 0;
        CHECK_OK(trisap_world_save(world_, bytes.data(), bytes.size(), &written));
        CHECK(written == bytes.size());
        return bytes;
    }

    void save(const Operation &op) {
        Bytes bytes = snapshot();
        say(std::uint64_t{bytes.size()});
        say(word(bytes.data() + 16));
        saves_[op.argument % 4].emplace(std::move(bytes), opinions_);
    }

    void load(const Operation &op) {
        const auto &save = saves_[op.argument % 4];
        if (save && say_status(trisap_world_load(world_, save->first.data(), save->first.size()))) {
            tally_.loaded++;
            opinions_ = save->second;
            opinions_.resize(std::max<std::size_t>(opinions_.size(), objects_));
        }
    }

    void load_damaged(Operation &op) {
        Bytes bytes = snapshot();
        const std::size_t at = op.rng.below(bytes.size());
        if (op.argument < 64) {
            bytes.resize(at);
        } else {
            bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ 1u << op.argument % 8);
        }
        say_status(trisap_world_load(world_, data(bytes), bytes.size()));
    }

    void load_forged(Operation &op) {
        const Bytes before = snapshot();
        Bytes bytes = before;
        forge(bytes, front(), op.rng);
        if (!say_status(trisap_world_load(world_, bytes.data(), bytes.size()))) {
            tally_.forged_refused++;
            CHECK(snapshot() == before);
            return;
        }
        tally_.forged_loaded++;
        trisap_result result = trisap_default_result();
        if (say_status(step_with(op, nullptr, result, true))) {
            say_result(result);
        }
        CHECK_OK(trisap_world_validate(world_));
        say_status(trisap_world_load(world_, before.data(), before.size()));
    }

    void reopen() { CHECK_OK(trisap_world_open(memory_.get(), bytes_, &world_)); }

    void copy(const Operation &op) {
        Memory other = allocate(bytes_);
        if (op.argument % 4 == 0) {
            std::memcpy(other.get(), memory_.get(), bytes_);
        } else {
            CHECK_OK(trisap_world_move(world_, other.get(), bytes_, &config_, &world_));
        }
        memory_ = std::move(other);
        reopen();
    }

    void grow(const Operation &op) {
        const trisap::Config config = header_.grown(config_, op.argument);
        const std::size_t bytes = trisap_world_size(&config);
        CHECK(bytes > 0);
        Memory other = allocate(bytes);
        trisap_world *there = nullptr;
        trisap::Status status = TRISAP_STATUS_OK;
        const trisap_world *asked = world_;
        if (op.argument / 64 % 2 == 0) {
            status = trisap_world_move(world_, other.get(), bytes, &config, &there);
        } else {
            const Bytes saved = snapshot();
            CHECK_OK(trisap_world_init(other.get(), bytes, &config, &there));
            status = trisap_world_load(there, saved.data(), saved.size());
            asked = there;
        }
        if (!say_status(status, asked)) {
            return;
        }
        memory_ = std::move(other);
        bytes_ = bytes;
        world_ = there;
        config_ = config;
        objects_ = config.objects;
        known_.resize(std::max<std::size_t>(known_.size(), objects_), trisap::null_id);
        opinions_.resize(std::max<std::size_t>(opinions_.size(), objects_));
        tally_.grown++;
    }

    std::array<std::optional<std::pair<Bytes, std::vector<std::uint32_t>>>, 4> saves_;
};

int main(int count, char **arguments) {
    CHECK(count == 2);
    std::ifstream file(arguments[1], std::ios::binary);
    const Bytes bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    Tally tally;
    for (std::size_t at = 0; at + 4 <= bytes.size();) {
        std::uint32_t length = 0;
        std::memcpy(&length, bytes.data() + at, sizeof length);
        at += sizeof length;
        CHECK(length >= Header::size + Operation::size && length <= bytes.size() - at);
        Sequence sequence(bytes.data() + at, tally);
        for (std::size_t op = Header::size; op + Operation::size <= length; op += Operation::size) {
            sequence.apply(Operation(bytes.data() + at + op));
        }
        std::printf("sequence %" PRIu64 "\n", sequence.hash());
        at += length;
    }
    std::printf("counts");
    const auto print = [](std::uint64_t number) { std::printf(" %" PRIu64, number); };
    std::for_each(tally.ran.begin(), tally.ran.end(), print);
    std::for_each(tally.paths.begin(), tally.paths.end(), print);
    for (const std::uint64_t number :
         {tally.refused, tally.full, tally.rejecting, tally.pairs, tally.found, tally.lost, tally.fine, tally.large,
          tally.answers, tally.loaded, tally.forged_refused, tally.forged_loaded, tally.grown, tally.refreshed}) {
        print(number);
    }
    std::printf("\n");
}
