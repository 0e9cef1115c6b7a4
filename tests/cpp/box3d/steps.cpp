// Steps a benchmark world with Box3D as it is and with trisap in it, in turns, and prints medians, and what all steps take together:
//
//     steps own.so trisap.so WORLD [SIZE STEPS THREADS [wall]]
//
// Milliseconds are processor time, of all threads together; with `wall` those of the clock. With one library, steps it alone, and prints
// means of each 50 steps, too.

#include "worlds.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <numeric>
#include <vector>

struct Side {
    decltype(&worlds_begin) begin;
    decltype(&worlds_step) step;
    decltype(&worlds_end) end;
    worlds_figures last;
    std::vector<double> whole, pairs;
};

template <class Function> static void find(void *library, const char *name, Function &function) {
    function = reinterpret_cast<Function>(dlsym(library, name));
}

static double median(std::vector<double> times) {
    std::sort(times.begin(), times.end());
    return times[times.size() / 2];
}

static double sum(const std::vector<double> &times, std::size_t last = ~std::size_t{0}) {
    return std::accumulate(times.end() - std::ptrdiff_t(std::min(last, times.size())), times.end(), 0.0);
}

int main(int count, char **words) {
    int libraries = 1;
    while (libraries < count && std::strstr(words[libraries], ".so") != nullptr) {
        libraries++;
    }
    const auto number = [&](int i, int otherwise) { return libraries + i < count ? std::atoi(words[libraries + i]) : otherwise; };
    const int size = number(1, 0), steps = number(2, 300), threads = number(3, 1);
    const bool wall = libraries + 4 < count;
    if (libraries == 1 || libraries >= count) {
        std::fprintf(stderr, "steps LIBRARY.so... WORLD [SIZE STEPS THREADS [wall]]\n");
        return 2;
    }
    std::vector<Side> sides;
    for (int i = 1; i < libraries; i++) {
        void *library = dlopen(words[i], RTLD_NOW | RTLD_LOCAL);
        if (library == nullptr) {
            std::fprintf(stderr, "%s\n", dlerror());
            return 1;
        }
        Side side = {};
        find(library, "worlds_begin", side.begin);
        find(library, "worlds_step", side.step);
        find(library, "worlds_end", side.end);
        if (!side.begin(words[libraries], size, threads, !wall)) {
            std::fprintf(stderr, "there is no world %s\n", words[libraries]);
            return 1;
        }
        sides.push_back(side);
    }
    for (int step = 0; step < steps; step++) {
        for (Side &side : sides) {
            side.last = side.step();
            side.whole.push_back(side.last.step);
            side.pairs.push_back(side.last.pairs);
        }
        if (sides.size() == 1 && step % 50 == 49) {
            std::printf("%-14s %d steps to %4d: %6d contacts, step %8.3f, pairs %7.3f\n", words[libraries], threads, step + 1,
                        sides[0].last.contacts, sum(sides[0].whole, 50) / 50, sum(sides[0].pairs, 50) / 50);
        }
    }
    for (Side &side : sides) {
        std::printf("%-14s %d %6d bodies %6d contacts, step %8.3f, pairs %7.3f, of all steps %4.1f %%\n", words[libraries], threads,
                    side.last.bodies, side.last.contacts, median(side.whole), median(side.pairs), 100 * sum(side.pairs) / sum(side.whole));
        side.end();
    }
    if (sides.size() > 1) {
        std::printf("%-14s %d whole steps %.2f times as fast, all together %.2f, pairs %.1f times\n", words[libraries], threads,
                    median(sides[0].whole) / median(sides[1].whole), sum(sides[0].whole) / sum(sides[1].whole),
                    median(sides[0].pairs) / median(sides[1].pairs));
    }
    return 0;
}
