// Proof that the sanitizers see what they are there for: breaks what its argument names, and must be stopped.

#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <trisap.h>

int main(int argc, char **argv) {
    const trisap_config config = trisap_default_config(4);
    const size_t bytes = trisap_world_size(&config);
    volatile unsigned char *memory = aligned_alloc(trisap_world_align(), bytes);
    if (argc < 2 || memory == NULL) {
        free((void *)memory);
        return 0;
    }
    if (strcmp(argv[1], "address") == 0) {
        memory[bytes] = 1;
    }
    if (strcmp(argv[1], "undefined") == 0) {
        volatile int number = INT_MAX - 2 + argc;
        number++;
    }
    if (strcmp(argv[1], "leak") == 0) {
        memory = NULL;
        return 0;
    }
    free((void *)memory);
    return 0;
}
