/* Declarations for the files of this driver. */
#ifndef RK_14_ADAPTIVE_SAMPLING_DRIVER_H
#define RK_14_ADAPTIVE_SAMPLING_DRIVER_H

#include "driver/driver_main.h"

typedef struct choices {
    bool efficiency;
    const char *effect; /* its name in the table */
    uint32_t seeds, reference;
} choices;

/* Writes the table of --efficiency. */
bool put_efficiency(rk_driver *driver, rk_error *error);

#endif
