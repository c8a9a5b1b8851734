/* The mean of pictures that differ in their seed alone, see mean.c. */
#ifndef RK_LIVE_MEAN_H
#define RK_LIVE_MEAN_H

/* What a picture is to the mean. The page has the same numbers (run.js). */
typedef enum rk_mean_part {
    RK_MEAN_BEGINS, /* its first picture */
    RK_MEAN_ADDS,   /* a further one: the mean takes its place */
    RK_MEAN_LEAVES, /* none: it is drawn for another reason */
} rk_mean_part;

/* Of the picture that is drawn next. */
void rk_mean_set_part(rk_mean_part part);

#endif
