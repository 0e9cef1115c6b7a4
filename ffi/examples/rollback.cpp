// Rollback as networked games do it: inputs of other players come late, so the game goes back to the frame that they belong
// to and plays on from there. The last 8 frames are kept as copies of the world, which goes back with the game.
//
// The check at the end: a game whose inputs come in time has found the same pairs in every frame, byte for byte.

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <trisap.hpp>
#include <vector>

constexpr std::uint32_t players = 400;
constexpr int frames = 120, kept = 8;

/// What a player wants in a frame.
static float input(int frame, std::uint32_t player) {
    std::uint32_t bits = static_cast<std::uint32_t>(frame / 4) * 2654435761u + player * 40503u;
    bits ^= bits >> 15;
    return static_cast<float>(bits % 200) / 1000.0f - 0.1f;
}

struct Game {
    std::array<trisap::Aabb, players> bodies;
    trisap::World world;

    bool start() {
        for (std::uint32_t i = 0; i < players; i++) {
            const float x = static_cast<float>(i % 20) * 1.2f, z = static_cast<float>(i / 20) * 1.2f;
            bodies[i] = {{x, 0, z}, {x + 1, 1, z + 1}};
        }
        trisap::Config config = trisap::config(players);
        config.events = 1;
        std::array<trisap::Id, players> ids;
        return world.init(config) == TRISAP_STATUS_OK && world.insert(trisap::boxes(bodies), ids) == TRISAP_STATUS_OK;
    }

    /// A frame; where the input of the last player has not come yet, it is guessed.
    std::vector<trisap::Pair> play(int frame, bool guess) {
        for (std::uint32_t i = 0; i < players; i++) {
            const float step = guess && i == players - 1 ? 0.0f : input(frame, i);
            for (float *x : {&bodies[i].min[0], &bodies[i].max[0]}) {
                *x += step;
            }
        }
        const trisap::Step step = world.step_over(trisap::boxes(bodies));
        std::vector<trisap::Pair> seen(step.pairs.begin(), step.pairs.end());
        seen.insert(seen.end(), step.found.begin(), step.found.end());
        seen.insert(seen.end(), step.lost.begin(), step.lost.end());
        return seen;
    }
};

/// A frame to go back to: a copy of the world, in memory that is used again.
struct Saved {
    trisap::World world;
    std::array<trisap::Aabb, players> bodies;
};

static bool save(const Game &game, Saved &saved) {
    saved.bodies = game.bodies;
    return saved.world.copy_from(game.world) == TRISAP_STATUS_OK;
}

static bool go_back(Game &game, const Saved &saved) {
    game.bodies = saved.bodies;
    return game.world.copy_from(saved.world) == TRISAP_STATUS_OK;
}

static bool same(const std::vector<trisap::Pair> &a, const std::vector<trisap::Pair> &b) {
    bool same = a.size() == b.size();
    for (std::size_t i = 0; same && i < a.size(); i++) {
        same = a[i].a == b[i].a && a[i].b == b[i].b;
    }
    return same;
}

int main() {
    Game late, in_time;
    if (!late.start() || !in_time.start()) {
        return 1;
    }
    std::array<Saved, kept> history;
    std::vector<std::vector<trisap::Pair>> seen(frames);
    std::size_t guessed_wrong = 0;
    for (int frame = 0; frame < frames; frame++) {
        if (!save(late, history[static_cast<std::size_t>(frame % kept)])) {
            return 1;
        }
        const std::vector<trisap::Pair> guess = late.play(frame, true);
        // Every 8th frame the inputs of the last 8 have come.
        if (frame % kept == kept - 1) {
            const int first = frame - kept + 1;
            if (!go_back(late, history[0])) {
                return 1;
            }
            for (int again = first; again <= frame; again++) {
                seen[static_cast<std::size_t>(again)] = late.play(again, false);
            }
            guessed_wrong += !same(guess, seen[static_cast<std::size_t>(frame)]);
        }
    }
    for (int frame = 0; frame < frames; frame++) {
        if (!same(in_time.play(frame, false), seen[static_cast<std::size_t>(frame)])) {
            std::printf("frame %d is another one\n", frame);
            return 1;
        }
    }
    std::printf("%d frames, gone back by %d every %d: the same pairs as in time; %zu guesses were wrong\n", frames, kept,
                kept, guessed_wrong);
    std::printf("a snapshot for a late joiner has %zu bytes an object\n", late.world.snapshot_size() / players);
    return guessed_wrong > 0 ? 0 : 1;
}
