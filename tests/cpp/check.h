// Checks that stay in every build, unlike assert.

#ifndef CHECK_H
#define CHECK_H

#include <stdio.h>
#include <stdlib.h>

// Windows has no aligned_alloc, and what it has instead is freed in another way: here all memory is of that kind.
#if defined(_WIN32) && !defined(__cplusplus)
#include <malloc.h>
#define malloc(bytes) _aligned_malloc(bytes, 16)
#define aligned_alloc(align, bytes) _aligned_malloc(bytes, align)
#define free(memory) _aligned_free(memory)
#endif

#define CHECK(condition)                                                                                             \
    do {                                                                                                             \
        if (!(condition)) {                                                                                          \
            fprintf(stderr, "%s:%d: not true: %s\n", __FILE__, __LINE__, #condition);                                \
            exit(1);                                                                                                 \
        }                                                                                                            \
    } while (0)

// A call's status is what it should be.
#define CHECK_STATUS(call, expected)                                                                                 \
    do {                                                                                                             \
        const trisap_status check_status = (call);                                                                   \
        if (check_status != (expected)) {                                                                            \
            fprintf(stderr, "%s:%d: %s: %s, not %s\n", __FILE__, __LINE__, #call, trisap_status_text(check_status),  \
                    trisap_status_text(expected));                                                                   \
            exit(1);                                                                                                 \
        }                                                                                                            \
    } while (0)

#define CHECK_OK(call) CHECK_STATUS(call, TRISAP_STATUS_OK)

#endif
