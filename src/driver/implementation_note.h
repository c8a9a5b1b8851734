/* Whose code draws the pictures, for captions. */
#ifndef RK_DRIVER_IMPLEMENTATION_NOTE_H
#define RK_DRIVER_IMPLEMENTATION_NOTE_H

/* Empty where all units are the kit's own; else "units: mine (bvh_median), others: reference". It
 * stands in an object of its own, which drivers that are linked with other units replace. */
extern const char rk_implementation_note[];

#endif
