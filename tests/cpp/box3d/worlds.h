#ifndef WORLDS_H
#define WORLDS_H

#ifdef __cplusplus
extern "C" {
#endif

/// Of one step: milliseconds, and what there is after it.
struct worlds_figures {
    double step, pairs;
    int bodies, contacts;
};

/// One world at a time; of its usual size for 0. Whether there is one of this name.
int worlds_begin(const char *name, int size, int workers, int cpu_time);
struct worlds_figures worlds_step(void);
void worlds_end(void);

#ifdef __cplusplus
}
#endif

#endif
