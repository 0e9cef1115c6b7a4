// Random sequences of everything that a world can do, through the wrapper, compared with brute force after each operation.
//
//     operations SEQUENCES [FIRST_SEED]

#include "model.hpp"
#include "pool.hpp"

#include <cstdio>
#include <limits>
#include <random>
#include <string>

/// What happened in all sequences: a test that never came to something has not tested it.
struct Tally {
    std::size_t steps = 0, pairs = 0, found = 0, lost = 0, full = 0, rejected = 0, answers = 0,
                loads = 0, followed = 0, resting = 0, with_tree = 0, large = 0, surplus = 0;
};

class Sequence {
public:
    Sequence(unsigned seed, Pool &pool, Tally &tally) : random_(seed), pool_(pool), tally_(tally) {
        // The last two have a tree.
        const std::uint32_t capacities[] = {6, 40, 150, 700, 1500};
        config_ = trisap::config(capacities[below(5)]);
        config_.pairs = below(4) == 0 ? config_.objects : 20 * config_.objects;
        config_.events = below(4) != 0;
        config_.filters = below(4) != 0;
        config_.lean = below(4) == 0 && config_.objects <= 256;
        config_.has_margin = below(2);
        config_.margin_per_extent = 0.2f;
        config_.fixed_margins = below(2);
        config_.predicted_boxes = below(2);
        config_.mode = config_.has_margin != 0 && below(3) == 0 ? TRISAP_MODE_FAT : TRISAP_MODE_EXACT;
        config_.workers = 1 + below(4);
        model_.has_filters = config_.filters != 0;
        model_.has_rule = config_.filters != 0 && below(2) == 0;
        side_ = std::cbrt(static_cast<float>(config_.objects)) * 1.1f;
        CHECK_OK(world_.init(config_));
        trisap::Config other = config_;
        other.workers = 1 + below(4);
        CHECK_OK(twin_.init(other));
    }

    void play() {
        for (int count = 0; count < 60; count++) {
            // Worlds fill up first.
            operate(count < 4 ? 0 : below(16));
            if (below(3) == 0) {
                query();
            }
            if (below(2) == 0) {
                step();
            }
        }
    }

private:
    std::uint32_t below(std::uint32_t end) { return static_cast<std::uint32_t>(random_() % end); }
    float within(float end) { return static_cast<float>(below(1 << 16)) * (end / 65536.0f); }

    trisap::Aabb box() {
        trisap::Aabb aabb = {};
        const std::uint32_t kind = below(40);
        for (int k = 0; k < 3; k++) {
            // On a grid, so that boxes touch now and then.
            aabb.min[k] = std::round(within(side_) * 8.0f) / 8.0f;
            aabb.max[k] = aabb.min[k] + (kind < 3 ? within(side_) : std::round(1.0f + within(8.0f)) / 8.0f);
        }
        if (kind == 0) {
            aabb.min[below(3)] = -std::numeric_limits<float>::infinity();
        } else if (kind == 1) {
            aabb.max[below(3)] = std::numeric_limits<float>::infinity();
        }
        return aabb;
    }

    trisap::Filter filter() {
        const auto bits = [this] { return below(3) == 0 ? ~0u : 1u << below(4) | 1u << below(4); };
        const std::uint32_t group = bits(), mask = bits();
        return {group, mask, below(4)};
    }

    std::vector<trisap::Id> some(std::uint32_t most) {
        std::vector<trisap::Id> ids;
        const auto size = static_cast<std::uint32_t>(model_.objects.size());
        for (std::uint32_t count = below(most) + 1; size > 0 && count > 0; count--) {
            const trisap::Id id = std::next(model_.objects.begin(), below(size))->second.id;
            if (std::find(ids.begin(), ids.end(), id) == ids.end()) {
                ids.push_back(id);
            }
        }
        return ids;
    }

    Object &object(trisap::Id id) { return model_.objects.at(trisap::slot(id)); }

    void operate(std::uint32_t kind) {
        twin_follows_ = false;
        switch (kind) {
        case 0:
        case 1:
        case 2:
            return insert();
        case 3:
        case 4:
            return update();
        case 5:
            return remove();
        case 6:
            return set_filters();
        case 7:
            return set_classes();
        case 8:
            return change_temper();
        case 9:
        case 10:
            return rest();
        case 11:
            return wake();
        case 12:
        case 13:
            return save();
        case 14:
            return load();
        default:
            return disturb();
        }
    }

    void insert() {
        std::vector<trisap::Aabb> boxes(below(1 + config_.objects / 3) + 1);
        for (trisap::Aabb &aabb : boxes) {
            aabb = box();
        }
        std::vector<trisap::Id> ids(boxes.size());
        const std::size_t needed = model_.objects.size() + boxes.size();
        const trisap::Status status = world_.insert(trisap::boxes(boxes), ids);
        if (needed > config_.objects) {
            CHECK_STATUS(status, TRISAP_STATUS_OBJECTS_FULL);
            CHECK(world_.error_detail() == needed);
            return;
        }
        CHECK_OK(status);
        for (std::size_t i = 0; i < ids.size(); i++) {
            const bool fresh =
                model_.objects.try_emplace(trisap::slot(ids[i]), Object{ids[i], boxes[i], trisap::filter(), below(3), false})
                    .second;
            CHECK(fresh);
        }
    }

    void update() {
        const std::vector<trisap::Id> ids = some(below(2) == 0 ? 3 : config_.objects);
        std::vector<trisap::Aabb> boxes;
        for (const trisap::Id id : ids) {
            boxes.push_back(below(4) == 0 ? object(id).box : box());
        }
        CHECK_OK(world_.update(ids, trisap::boxes(boxes)));
        for (std::size_t i = 0; i < ids.size(); i++) {
            object(ids[i]).box = boxes[i];
            object(ids[i]).resting = false;
        }
        if (config_.has_margin != 0 && !ids.empty()) {
            CHECK_OK(world_.set_margin(ids[0], within(0.5f)));
        }
    }

    void remove() {
        const std::vector<trisap::Id> ids = some(1 + config_.objects / 4);
        CHECK_OK(world_.remove(ids));
        for (const trisap::Id id : ids) {
            model_.objects.erase(trisap::slot(id));
            CHECK(!world_.contains(id) && !world_.is_resting(id));
            CHECK_STATUS(world_.refilter(id), TRISAP_STATUS_STALE_ID);
        }
    }

    void set_filters() {
        const std::vector<trisap::Id> ids = some(config_.objects);
        std::vector<trisap::Filter> filters;
        for (std::size_t i = 0; i < ids.size(); i++) {
            filters.push_back(filter());
        }
        if (!model_.has_filters) {
            CHECK_STATUS(ids.empty() ? TRISAP_STATUS_NO_FILTERS : world_.set_filter(ids, filters),
                         TRISAP_STATUS_NO_FILTERS);
            return;
        }
        CHECK_OK(world_.set_filter(ids, filters));
        for (std::size_t i = 0; i < ids.size(); i++) {
            object(ids[i]).filter = filters[i];
            trisap::Filter known = {};
            CHECK_OK(world_.filter(ids[i], known));
            CHECK(std::memcmp(&known, &filters[i], sizeof known) == 0);
        }
    }

    void set_classes() {
        std::uint32_t meets[TRISAP_CLASSES];
        for (std::uint32_t &row : meets) {
            row = below(3) == 0 ? static_cast<std::uint32_t>(random_()) : ~0u;
        }
        CHECK_STATUS(world_.set_classes(meets), model_.has_filters ? TRISAP_STATUS_OK : TRISAP_STATUS_NO_FILTERS);
        std::copy(std::begin(meets), std::end(meets), std::begin(model_.classes));
    }

    void change_temper() {
        for (const trisap::Id id : some(10)) {
            if (model_.has_rule) {
                object(id).temper = below(3);
                CHECK_OK(world_.refilter(id));
            }
        }
    }

    void rest() {
        const std::vector<trisap::Id> ids = some(2 * config_.objects);
        CHECK_OK(world_.set_resting(ids));
        for (const trisap::Id id : ids) {
            object(id).resting = true;
        }
        tally_.resting += ids.size();
    }

    void wake() {
        const std::vector<trisap::Id> ids = some(config_.objects);
        CHECK_OK(world_.wake(ids));
        for (const trisap::Id id : ids) {
            object(id).resting = false;
        }
    }

    std::vector<std::byte> snapshot() {
        std::vector<std::byte> bytes(world_.snapshot_size());
        const trisap::Answers<std::byte> saved = world_.save(bytes);
        CHECK_OK(saved.status);
        CHECK(saved.size() == bytes.size() && saved.needed == bytes.size() && !bytes.empty());
        return bytes;
    }

    void save() {
        std::vector<std::byte> small(world_.snapshot_size() - 1);
        const trisap::Answers<std::byte> refused = world_.save(small);
        CHECK(refused.status == TRISAP_STATUS_OUTPUT_FULL && refused.needed == small.size() + 1 && refused.size() == 0);
        saved_.push_back({snapshot(), model_, last_});
        if (saved_.size() > 3) {
            saved_.erase(saved_.begin());
        }
        // Another world goes on as this one does, byte for byte.
        CHECK_OK(twin_.copy_from(world_));
        CHECK_OK(twin_.validate());
        CHECK(twin_.size() == model_.objects.size());
        twin_follows_ = true;
    }

    void load() {
        if (saved_.empty()) {
            return;
        }
        const Saved &saved = saved_[below(static_cast<std::uint32_t>(saved_.size()))];
        CHECK_OK(world_.load(saved.bytes));
        model_ = saved.model;
        last_ = saved.last;
        CHECK_OK(world_.validate());
        check_last(world_.result());
        tally_.loads++;
    }

    /// Bytes that were changed, and bytes of another world, are an error and change nothing.
    void disturb() {
        const std::vector<std::byte> before = snapshot();
        std::vector<std::byte> broken = before;
        switch (below(4)) {
        case 0:
            broken[below(static_cast<std::uint32_t>(broken.size()))] ^= std::byte(1u << below(8));
            break;
        case 1:
            broken.resize(below(static_cast<std::uint32_t>(broken.size())));
            break;
        case 2:
            for (std::byte &byte : broken) {
                byte = std::byte(below(256));
            }
            break;
        default: {
            trisap::World foreign;
            trisap::Config other = config_;
            other.events = 1 - other.events;
            CHECK_OK(foreign.init(other));
            broken.resize(foreign.snapshot_size());
            CHECK_OK(foreign.save(broken).status);
            CHECK_STATUS(world_.load(broken), TRISAP_STATUS_OTHER_CONFIG);
            broken.clear();
        }
        }
        if (!broken.empty()) {
            CHECK_STATUS(world_.load(broken), TRISAP_STATUS_BAD_SNAPSHOT);
        }
        CHECK(snapshot() == before);
        CHECK_OK(world_.validate());
        check_last(world_.result());
    }

    struct Last {
        std::vector<SlotPair> pairs, found, lost;
    };

    void check_last(const trisap::Step &step) {
        CHECK_OK(step.status);
        CHECK(sorted(step.pairs) == last_.pairs);
        CHECK(sorted(step.found) == last_.found);
        CHECK(sorted(step.lost) == last_.lost);
    }

    trisap::Step advance(trisap::World &world, const trisap::Boxes *boxes) {
        auto jobs = trisap::jobs(pool_.workers(), [this](std::uint32_t count, trisap::Task task) { pool_.run(count, task); });
        const auto rule = [this](std::uint32_t a, std::uint32_t b) {
            // Both live, or `at` finds nobody.
            const Object &first = model_.objects.at(a), &second = model_.objects.at(b);
            CHECK(a < b && model_.filters_meet(first, second));
            const bool overlap = share_a_point(first.box.min, first.box.max, second.box.min, second.box.max);
            CHECK(overlap || config_.has_margin != 0 || config_.predicted_boxes != 0);
            return model_.rule(a, b);
        };
        if (model_.has_rule) {
            return boxes != nullptr ? world.step_over_with_rule(*boxes, rule, jobs) : world.step_with_rule(rule, jobs);
        }
        return boxes != nullptr ? world.step_over(*boxes, jobs) : world.step(jobs);
    }

    void step() {
        std::vector<trisap::Aabb> boxes;
        std::uint32_t rejected = 0;
        trisap::Id first_rejected = trisap::null_id;
        const bool over = below(2) == 0;
        if (over) {
            const std::uint32_t moving = below(4) == 0 ? 1 : 20;
            boxes.resize(below(8) == 0 ? below(config_.objects) : config_.objects);
            for (trisap::Aabb &aabb : boxes) {
                aabb = box();
            }
            for (auto &[slot, object] : model_.objects) {
                if (slot >= boxes.size() || object.resting) {
                    continue;
                }
                if (below(moving) != 0) {
                    boxes[slot] = object.box;
                } else if (below(30) == 0) {
                    boxes[slot].max[1] = std::numeric_limits<float>::quiet_NaN();
                    first_rejected = rejected++ == 0 ? object.id : first_rejected;
                } else {
                    object.box = boxes[slot];
                }
            }
        }
        const trisap::Boxes view = trisap::boxes(boxes);
        const trisap::Step step = advance(world_, over ? &view : nullptr);
        if (twin_follows_) {
            follow(over ? &view : nullptr, step);
        }
        const std::vector<IdPair> expected = model_.pairs();
        std::vector<IdPair> seen;
        for (const auto &[a, b] : step.pairs) {
            CHECK(a < b);
            const Object &first = model_.objects.at(a), &second = model_.objects.at(b);
            CHECK(model_.wanted(first, second));
            seen.emplace_back(first.id, second.id);
        }
        std::sort(seen.begin(), seen.end());
        CHECK(std::adjacent_find(seen.begin(), seen.end()) == seen.end());
        tally_.steps++;
        if (step.status == TRISAP_STATUS_PAIRS_FULL) {
            full(step, expected, seen);
        } else {
            CHECK_OK(step.status);
            CHECK(step.rejected == rejected && step.first_rejected == first_rejected);
            complete(step, expected, seen);
        }
        const trisap::Stats stats = world_.stats();
        tally_.with_tree += stats.leaves > 1;
        tally_.rejected += rejected;
        last_ = {sorted(step.pairs), sorted(step.found), sorted(step.lost)};
        CHECK_OK(world_.validate());
        look_at_the_tree(stats, step.status == TRISAP_STATUS_OK);
    }

    void follow(const trisap::Boxes *boxes, const trisap::Step &step) {
        twin_follows_ = false;
        const trisap::Step other = advance(twin_, boxes);
        CHECK_STATUS(other.status, step.status);
        const auto same_bytes = [](trisap::View<const trisap::Pair> a, trisap::View<const trisap::Pair> b) {
            return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(trisap::Pair)) == 0;
        };
        CHECK(same_bytes(step.pairs, other.pairs) && same_bytes(step.found, other.found) &&
              same_bytes(step.lost, other.lost));
        tally_.followed++;
    }

    void full(const trisap::Step &step, const std::vector<IdPair> &expected, const std::vector<IdPair> &seen) {
        CHECK(step.pairs_needed > config_.pairs && step.pairs_needed >= expected.size());
        CHECK(config_.has_margin != 0 || step.pairs_needed == expected.size());
        CHECK(world_.error_detail() == step.pairs_needed);
        CHECK(config_.mode == TRISAP_MODE_FAT || difference(seen, expected).empty());
        CHECK(step.found.empty() && step.lost.empty());
        tally_.full++;
    }

    void complete(const trisap::Step &step, const std::vector<IdPair> &expected, const std::vector<IdPair> &seen) {
        if (config_.mode == TRISAP_MODE_FAT) {
            CHECK(difference(expected, seen).empty());
            tally_.surplus += seen.size() - expected.size();
        } else {
            CHECK(seen == expected);
        }
        CHECK(step.pairs_needed == seen.size());
        if (config_.events != 0) {
            CHECK(sorted(step.found) == by_slot(difference(seen, model_.reported)));
            CHECK(sorted(step.lost) == by_slot(difference(model_.reported, seen)));
        } else {
            CHECK(step.found.empty() && step.lost.empty());
        }
        model_.reported = seen;
        tally_.pairs += seen.size();
        tally_.found += step.found.size();
        tally_.lost += step.lost.size();
    }

    void look_at_the_tree(const trisap::Stats &stats, bool complete) {
        std::vector<trisap::Leaf> leaf_room(8192);
        std::vector<trisap::Plane> plane_room(8192);
        std::vector<trisap::Id> large_room(config_.objects);
        const trisap::Answers<trisap::Leaf> leaves = world_.leaves(leaf_room);
        const trisap::Answers<trisap::Plane> planes = world_.planes(plane_room);
        const trisap::Answers<trisap::Id> large = world_.large(large_room);
        CHECK(leaves && planes && large);
        for (const trisap::Id id : large) {
            CHECK(world_.contains(id));
        }
        // After a step with too many pairs, those that moved still count as moved, and are in no list.
        if (leaves.size() > 0 && complete) {
            std::size_t members = large.size();
            for (const trisap::Leaf &leaf : leaves) {
                members += leaf.objects;
            }
            CHECK(members == model_.objects.size() && planes.size() < leaves.size() && large.size() == stats.large);
        }
        tally_.large += large.size();
    }

    void query() {
        const trisap::Aabb aabb = box(), start = box();
        const float at[3] = {within(side_), within(side_), within(side_)};
        const auto direction_of = [this] { return below(4) == 0 ? 0.0f : (static_cast<float>(below(9)) - 4.0f) / 3.0f; };
        const float direction[3] = {direction_of(), direction_of(), direction_of()};
        const float distance = below(3) == 0 ? std::numeric_limits<float>::infinity() : within(side_);
        const std::vector<trisap::Region> regions = {trisap::region(aabb), trisap::point(at),
                                                     trisap::sphere(at, within(side_ / 2))};
        std::vector<trisap::Cast> casts = {trisap::ray(at, direction, distance)};
        if (std::isfinite(start.min[0] + start.min[1] + start.min[2] + start.max[0] + start.max[1] + start.max[2])) {
            casts.push_back(trisap::swept(start, direction));
        }
        for (const trisap::Region &region : regions) {
            check_region(region);
        }
        for (const trisap::Cast &cast : casts) {
            check_cast(cast);
        }
        check_nearest(at);
        check_batches(regions, casts);
    }

    void check_region(const trisap::Region &region) {
        const std::vector<trisap::Id> expected = model_.overlaps(region);
        std::vector<trisap::Id> room(config_.objects);
        const trisap::Answers<trisap::Id> answers = world_.overlaps(region, room);
        CHECK_OK(answers.status);
        CHECK(same(answers, expected) && answers.needed == expected.size());
        std::vector<trisap::Id> visited;
        CHECK_OK(world_.visit_overlaps(region, [&](trisap::Id id) { visited.push_back(id); }));
        std::vector<trisap::Id> again;
        const std::size_t most = 1 + below(5);
        CHECK_OK(world_.visit_overlaps(region, [&](trisap::Id id) {
            again.push_back(id);
            return again.size() < most;
        }));
        CHECK(again.size() == std::min(most, visited.size()) && std::equal(again.begin(), again.end(), visited.begin()));
        std::sort(visited.begin(), visited.end(),
                  [](trisap::Id a, trisap::Id b) { return trisap::slot(a) < trisap::slot(b); });
        CHECK(visited == expected);
        if (!expected.empty()) {
            room.resize(expected.size() - 1);
            const trisap::Answers<trisap::Id> some = world_.overlaps(region, room);
            CHECK(some.status == TRISAP_STATUS_OUTPUT_FULL && some.needed == expected.size() && some.size() == room.size());
            CHECK(world_.error_detail() == expected.size());
            for (const trisap::Id id : some) {
                CHECK(std::count(expected.begin(), expected.end(), id) == 1);
            }
        }
        tally_.answers += expected.size();
    }

    void check_cast(const trisap::Cast &cast) {
        const std::vector<trisap::Hit> expected = model_.hits(cast);
        std::vector<trisap::Hit> room(config_.objects);
        const trisap::Answers<trisap::Hit> answers = world_.hits(cast, room);
        CHECK_OK(answers.status);
        CHECK(same_hits(answers, expected));
        const trisap::FirstHit first = world_.first_hit(cast);
        CHECK_OK(first.status);
        CHECK(expected.empty() ? first.id == trisap::null_id
                               : first.id == expected[0].id && first.distance == expected[0].distance);
        // A visitor that wants the nearest one gets it, too.
        double nearest = std::numeric_limits<double>::infinity();
        CHECK_OK(world_.visit_hits(cast, [&](trisap::Hit hit) { return nearest = std::min(nearest, hit.distance); }));
        CHECK(expected.empty() ? std::isinf(nearest) : nearest == expected[0].distance);
        std::size_t visits = 0;
        CHECK_OK(world_.visit_hits(cast, [&](trisap::Hit) { return visits++, -1.0; }));
        CHECK(visits == (expected.empty() ? 0 : 1));
        if (!expected.empty()) {
            room.resize(expected.size() - 1);
            const trisap::Answers<trisap::Hit> some = world_.hits(cast, room);
            CHECK(some.status == TRISAP_STATUS_OUTPUT_FULL && some.needed == expected.size());
        }
        tally_.answers += expected.size();
    }

    void check_nearest(const float *at) {
        std::vector<trisap::Hit> room(below(2) == 0 ? below(8) : config_.objects + 3);
        const trisap::Answers<trisap::Hit> answers = world_.nearest(at, room);
        CHECK_OK(answers.status);
        const std::vector<trisap::Hit> expected = model_.nearest(at, room.size());
        CHECK(same_hits(answers, expected));
        // A visitor that refuses every second slot gets the nearest of the others, and of as near ones all.
        const auto refused = [](const trisap::Hit &hit) { return trisap::slot(hit.id) % 2 != 0; };
        double nearest = std::numeric_limits<double>::infinity();
        CHECK_OK(world_.visit_nearest(at, nearest, [&](const trisap::Hit &hit) {
            return refused(hit) ? std::numeric_limits<double>::infinity() : nearest = std::min(nearest, hit.distance);
        }));
        const auto all = model_.nearest(at, config_.objects);
        const auto first = std::find_if_not(all.begin(), all.end(), refused);
        CHECK(first == all.end() ? std::isinf(nearest) : nearest == first->distance);
        if (!expected.empty()) {
            std::size_t visits = 0;
            const double distance = expected.back().distance;
            CHECK_OK(world_.visit_nearest(at, distance, [&](const trisap::Hit &) { visits++; }));
            CHECK(static_cast<std::ptrdiff_t>(visits) ==
                  std::count_if(all.begin(), all.end(), [&](const trisap::Hit &hit) { return hit.distance <= distance; }));
        }
    }

    void check_batches(const std::vector<trisap::Region> &regions, const std::vector<trisap::Cast> &casts) {
        std::vector<trisap::Hit> hits(casts.size());
        CHECK_OK(world_.first_hits(casts, hits));
        for (std::size_t i = 0; i < casts.size(); i++) {
            const trisap::Hit hit = world_.first_hit(casts[i]);
            CHECK(hits[i].id == hit.id && hits[i].distance == hit.distance);
        }
        const std::size_t room = regions.size() * (below(2) == 0 ? config_.objects : 2);
        std::vector<trisap::Id> ids(room);
        std::vector<std::size_t> ends(regions.size());
        const trisap::Status status = world_.overlaps_many(regions, ids, ends);
        std::size_t total = 0;
        for (std::size_t i = 0; i < regions.size(); i++) {
            const std::vector<trisap::Id> expected = model_.overlaps(regions[i]);
            const std::size_t start = total;
            total += expected.size();
            CHECK(ends[i] == total);
            CHECK(total > room || std::equal(expected.begin(), expected.end(), ids.begin() + long(start)));
        }
        CHECK_STATUS(status, total > room ? TRISAP_STATUS_OUTPUT_FULL : TRISAP_STATUS_OK);
        CHECK(total <= room || world_.error_detail() == total);
    }

    std::mt19937 random_;
    Pool &pool_;
    Tally &tally_;
    trisap::Config config_;
    float side_;
    trisap::World world_, twin_;
    Model model_;
    Last last_;
    struct Saved {
        std::vector<std::byte> bytes;
        Model model;
        Last last;
    };
    std::vector<Saved> saved_;
    bool twin_follows_ = false;
};

int main(int argc, char **argv) {
    CHECK(argc >= 2);
    const unsigned sequences = static_cast<unsigned>(std::stoul(argv[1]));
    const unsigned first = argc > 2 ? static_cast<unsigned>(std::stoul(argv[2])) : 1;
    Pool pool(3);
    Tally tally;
    for (unsigned seed = first; seed < first + sequences; seed++) {
        // In case that it ends here.
        std::fprintf(stderr, "sequence %u\r", seed);
        Sequence(seed, pool, tally).play();
    }
    const struct {
        const char *what;
        std::size_t count;
    } counts[] = {
        {"steps", tally.steps},          {"with a tree", tally.with_tree}, {"full", tally.full},
        {"pairs", tally.pairs},          {"found", tally.found},           {"lost", tally.lost},
        {"surplus", tally.surplus},      {"rejected", tally.rejected},     {"put to rest", tally.resting},
        {"loads", tally.loads},          {"steps of twins", tally.followed}, {"large", tally.large},
        {"answers", tally.answers},
    };
    std::printf("operations: %u sequences as brute force:", sequences);
    for (const auto &[what, count] : counts) {
        CHECK(sequences < 10 || count > 0);
        std::printf(" %s %zu", what, count);
    }
    std::printf("\n");
    return 0;
}
