/* Eight vehicles on lanes side by side, in a world of fixed memory, in C without a C library: on a Cortex-M4, by way of
 * trisap's static library and header. `run.sh`, one folder up, builds and runs it. */
#include "trisap.h"

enum { VEHICLES = 8, PAIRS = VEHICLES * (VEHICLES - 1) / 2 };

/* All the memory there is. `trisap_world_size` tells how much a configuration needs: `init` refuses less. */
static _Alignas(64) unsigned char memory[1536];

static trisap_aabb safe_space(int vehicle, int tick)
{
    const float x = (float)tick * (1.0f + 0.25f * (float)vehicle), y = 3.0f * (float)vehicle;
    return (trisap_aabb){{x - 4.0f, y - 2.0f, 0.0f}, {x + 4.0f, y + 2.0f, 2.0f}};
}

/* How many times two have come near each other, and how many times apart; -1 if something was refused. */
static int drive(size_t *near, size_t *apart)
{
    trisap_config config = trisap_default_config(VEHICLES);
    config.pairs = PAIRS;
    config.events = 1;
    struct trisap_world *world;
    if (trisap_world_init(memory, sizeof memory, &config, &world) != TRISAP_STATUS_OK)
        return -1;
    for (int tick = 0; tick < 64; ++tick) {
        trisap_aabb spaces[VEHICLES];
        for (int vehicle = 0; vehicle < VEHICLES; ++vehicle)
            spaces[vehicle] = safe_space(vehicle, tick);
        const trisap_boxes boxes = trisap_default_boxes(spaces, VEHICLES);
        trisap_id ids[VEHICLES];
        if (tick == 0 && trisap_world_insert_many(world, &boxes, ids) != TRISAP_STATUS_OK)
            return -1;
        trisap_result result = trisap_default_result();
        if (trisap_world_step_over(world, &boxes, NULL, &result) != TRISAP_STATUS_OK)
            return -1;
        *near += result.found_count;
        *apart += result.lost_count;
    }
    return 0;
}

/* Arm's semihosting: the debugger, or QEMU, prints a text or ends the program. */
static int semihosting(int operation, const void *argument)
{
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

int main(void)
{
    size_t near = 0, apart = 0;
    const int good = drive(&near, &apart) == 0 && near == VEHICLES - 1 && apart == VEHICLES - 1;
    semihosting(0x04, good ? "7 times near, 7 times apart\n" : "something is wrong\n");
    /* SYS_EXIT: "the application has ended", or "run-time error". */
    semihosting(0x18, good ? (const void *)0x20026 : (const void *)0x20023);
    for (;;) {
    }
}

/* The reset code: `.bss` is zero, and there is no `.data`; the floating-point unit is turned on. */
extern unsigned bss_start[], bss_end[], stack_top[];

_Noreturn void reset(void)
{
    for (volatile unsigned *word = bss_start; word != bss_end; ++word)
        *word = 0;
    *(volatile unsigned *)0xe000ed88 |= 0xfu << 20;
    __asm__ volatile("dsb\n isb");
    main();
    for (;;) {
    }
}

__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {stack_top, (const void *)reset};
