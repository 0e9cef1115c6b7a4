// Recorded scenes through the C++ wrapper: every frame's pairs, found and lost pairs equal brute force, however the boxes
// come in and whoever does the work; and all ways give the same bytes.
//
//     recordings FILE [FRAMES]

#include "pool.hpp"
#include "recording.hpp"

#include <cstdio>
#include <memory>
#include <string>
#include <trisap.hpp>

using Frame = std::vector<PaddedBox>;

static trisap::Boxes view(const Frame &frame) {
    return trisap::boxes_in(frame.data(), frame.size(), frame[0].min, frame[0].max);
}

/// A world that is stepped through a recording in one of the ways.
struct Player {
    bool over;
    bool threads;
    trisap::World world;
    std::vector<trisap::Id> ids;

    trisap::Step step(const Frame &frame, Pool &pool) {
        auto jobs = trisap::jobs(pool.workers(), [&pool](std::uint32_t count, trisap::Task task) {
            CHECK(std::string(task.name()) == "trisap step");
            pool.run(count, task);
        });
        if (over) {
            return threads ? world.step_over(view(frame), jobs) : world.step_over(view(frame));
        }
        CHECK_OK(world.update(ids, view(frame)));
        return threads ? world.step(jobs) : world.step();
    }
};

static bool same_bytes(trisap::View<const trisap::Pair> a, trisap::View<const trisap::Pair> b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(trisap::Pair)) == 0;
}

int main(int argc, char **argv) {
    CHECK(argc >= 2);
    const Recording recording = read_recording(argv[1]);
    const std::size_t frames = std::min<std::size_t>(recording.frames.size(), argc > 2 ? std::stoul(argv[2]) : 1000);
    const auto objects = static_cast<std::uint32_t>(recording.frames[0].size());
    Pool pool(4);

    std::vector<Player> players;
    for (int way = 0; way < 4; way++) {
        Player &player = players.emplace_back(Player{way % 2 == 1, way / 2 == 1, {}, {}});
        trisap::Config config = trisap::config(objects);
        config.pairs = 16 * objects;
        config.events = 1;
        // The same for all, or else the memory is not the same.
        config.workers = pool.workers();
        CHECK_OK(player.world.init(config));
        player.ids.resize(objects);
        CHECK_OK(player.world.insert(view(recording.frames[0]), player.ids));
    }

    std::size_t total = 0, events = 0;
    std::vector<SlotPair> before;
    for (std::size_t i = 0; i < frames; i++) {
        const Frame &frame = recording.frames[i];
        const std::vector<SlotPair> expected = brute_force(frame);
        const trisap::Step first = players[0].step(frame, pool);
        CHECK_OK(first.status);
        CHECK(sorted(first.pairs) == expected);
        CHECK(sorted(first.found) == without(expected, before));
        CHECK(sorted(first.lost) == without(before, expected));
        CHECK(first.rejected == 0 && first.pairs_needed == expected.size());
        std::vector<trisap::Step> steps{first};
        for (std::size_t way = 1; way < players.size(); way++) {
            const trisap::Step step = players[way].step(frame, pool);
            CHECK_OK(step.status);
            // In an order that may depend on how the boxes were given, and on nothing else.
            CHECK(sorted(step.pairs) == expected);
            CHECK(sorted(step.found) == sorted(first.found) && sorted(step.lost) == sorted(first.lost));
            for (std::size_t other = 0; other < way; other++) {
                if (players[other].over == players[way].over) {
                    CHECK(same_bytes(step.pairs, steps[other].pairs));
                    CHECK(same_bytes(step.found, steps[other].found));
                    CHECK(same_bytes(step.lost, steps[other].lost));
                }
            }
            steps.push_back(step);
        }
        total += expected.size();
        events += first.found.size() + first.lost.size();
        before = expected;
    }
    CHECK(total > 0 && events > 0);
    for (Player &player : players) {
        CHECK_OK(player.world.validate());
    }
    std::printf("recordings: %zu frames of %u objects, %zu pairs, %zu events: all as brute force\n", frames, objects,
                total, events);
    return 0;
}
